"""
Measure the torque of a simulated knee: coarse encoders, a rippling current, a zero that moves.

    knee.py [--first SEED] [--recordings N] [--quick]

One joint of the independent truth, without links: 12 bits at motor and link, 100 Hz, stamps of a
host. A hand pushes, and the zero of the link encoder is another in every recording. The ten lines
of numpy that people write stand beside the estimator (`by_hand`). They are fitted to a recording
whose reference lags by 40 ms. From the same recording, and from the nominal arm, `hda calibrate`
makes the arm file of the estimator.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.model.parts import Encoder, Tolerances
from hda_torque_estimator.calibrate.passages.joint_recording import CalibrationError, Measured
from hda_torque_estimator.calibrate.referenced import calibrate
from hda_torque_estimator.estimating.estimator import Estimator
from hidden_truth import Device, record, Reference
import numpy as np
from numpy.typing import NDArray
from pushes import WITHIN
from size import parser, verdict
from torque_arm import hidden, tip_force, wander

Array = NDArray[np.float64]
KNEE, LABEL = 1, 'joint2'       # the joint of the truth that is the knee
DT, EVERY = 1e-3, 10            # of the truth, and its samples from one reading to the next [s]
COUNTS = 4096                   # of both encoders per turn
ZERO = 6e-3                     # by which the zero moves from recording to recording [rad]
LATE = 1e-3                     # one sigma of the stamps of a host [s]
LAG = 4                         # samples by which the reference of the fit lags: 40 ms
SECONDS, TINY = 40.0, 6.0       # of a recording
BAR, BESIDE = 0.15, 1.0         # rms over the torque's deviation, and over that of `by_hand`
HELD = (0.80, 0.97)             # share of torques within their 90 % intervals
BEGUN = 50                      # samples that both may take to find the zero: half a second

# What the arm hides, and what its file says of how well it is known.
SIZES = {'torque_ripple': {'amplitude_4': 0.008}, 'stiffness_error': {'relative_error': -0.06},
         'asymmetric_friction': {'asymmetry': 0.08},
         'load_dependent_friction': {'coefficient': 0.04},
         'kinematic_error': {'amplitude_2': 1.3e-4},
         'link_encoder_eccentricity': {'amplitude_1': 4e-4}}
KNOWN = Tolerances(stiffness=0.1, torque_constant=0.02, dry_friction=0.15, viscous_friction=0.3,
                   torsion_zero=ZERO, kinematic_error=1e-4, eccentricity=3e-4,
                   torque_ripple=0.006, drive_offset=3e-3)


class Seen(NamedTuple):
    """A recording: stamps (k,) ns, angles of shaft and link, motor torque, true torque (k,)."""

    stamps: NDArray[np.int64]
    motor: Array
    link: Array
    command: Array
    torque: Array


class Found(NamedTuple):
    """Errors of one recording."""

    ours: float                 # rms [N*m]
    by_hand: float
    spread: float               # of the torque [N*m]
    held: float                 # share of torques within their 90 % intervals


def knee() -> Arm:
    """Return the knee as its arm file states it: the nominal joint with coarse encoders."""
    whole = read_arm('hda_arm.yaml')
    joint = replace(whole.joints[KNEE], motor_encoder=Encoder(counts=COUNTS),
                    link_encoder=Encoder(counts=COUNTS))
    return replace(whole, joints=(joint,), links=None, tolerances=KNOWN)


def recorded(arm_seed: int, seed: int, seconds: float) -> Seen:
    """Record the knee of a seed while a hand pushes it."""
    random = np.random.default_rng([seed, 3])
    time = DT * np.arange(round(seconds / DT))
    angle = wander(time, (0.7, 0.6), (random.uniform(9.0, 12.0), random.uniform(5.0, 8.0)), 0.1)
    pull = np.stack([_hand(time, random), _hand(time, random)], axis=1)
    chance = np.random.default_rng([arm_seed, 77])
    effects = [hidden(name, LABEL, sizes, chance) for name, sizes in SIZES.items()]
    seen = record(effects,
                  Reference(angle, np.gradient(angle, DT, axis=0), DT, tip_force(angle, pull)),
                  seed=seed, device=Device(seed=arm_seed, counts=(COUNTS, COUNTS)))
    rows = slice(None, None, EVERY)
    late = np.abs(LATE * random.standard_normal(len(seen.stamps[rows])))
    return Seen(seen.stamps[rows] + (1e9 * late).astype(np.int64), seen.motor_angle[rows, KNEE],
                seen.link_angle[rows, KNEE] + ZERO * random.choice((-1.0, 1.0)),
                _held(seen.command[:, KNEE]), seen.joint_torque[rows, KNEE])


def _held(command: Array) -> Array:
    """Return the mean motor torque from each reading to the next: a drive logs no less."""
    padded = np.concatenate([command, np.full(-len(command) % EVERY, command[-1])])
    means: Array = padded.reshape(-1, EVERY).mean(axis=1)
    return means


def _hand(time: Array, random: np.random.Generator) -> Array:
    """Return a torque as of a hand: waves of a few seconds, deviation about 10 N*m."""
    waves = [np.sin(2.0 * np.pi * time * random.uniform(0.1, 0.8) + random.uniform(0.0, 6.3))
             for _ in range(5)]
    return 6.3 * np.sum(waves, axis=0) * np.minimum(time, 1.0)


def parts_by_hand(seen: Seen, ratio: float, inertia: float) -> tuple[Array, Array, Array, Array]:
    """Return torsion, motor torque less inertia, and speed with its sign, of ten lines."""
    time = (seen.stamps - seen.stamps[0]) * 1e-9
    speed = np.convolve(np.gradient(seen.motor, time), np.ones(5) / 5.0, 'same')
    current = ratio * (seen.command - inertia * np.gradient(speed, time))
    return seen.motor / ratio - seen.link, current, speed, np.sign(speed)


def by_hand(seen: Seen, fitted: tuple[Array, float, int, float], ratio: float,
            inertia: float) -> Array:
    """Return the torque of the ten-line filter (k,) [N*m]."""
    factors, stiffness, span, weight = fitted
    torsion, current, speed, sign = parts_by_hand(seen, ratio, inertia)
    motor = np.stack([current, speed, sign, np.ones_like(sign)], axis=1) @ factors
    apart = stiffness * torsion - motor
    counts = np.minimum(np.arange(1, len(apart) + 1), span)
    sums = np.concatenate([[0.0], np.cumsum(apart)])
    zero = (sums[1:] - sums[np.arange(1, len(sums)) - counts]) / counts
    return weight * (stiffness * torsion - zero) + (1.0 - weight) * motor


def fitted_by_hand(seen: Seen, ratio: float,
                   inertia: float) -> tuple[Array, float, int, float]:
    """Return factors of the motor's parts, stiffness, span of the mean and weight of torsion."""
    reference = late(seen)
    torsion, current, speed, sign = parts_by_hand(seen, ratio, inertia)
    columns = np.stack([current, speed, sign, np.ones_like(sign)], axis=1)
    fits = [(np.linalg.lstsq(columns[:-lag or None], reference[lag:], rcond=None)[0], lag)
            for lag in range(10)]
    factors, lag = min(fits, key=lambda fit: float(np.std(
        reference[fit[1]:] - columns[:len(columns) - fit[1]] @ fit[0])))
    aligned = np.concatenate([reference[lag:], reference[len(reference) - lag:]])
    stiffness = float(np.polyfit(torsion, aligned, 1)[0])
    tried = [(factors, stiffness, span, weight) for span in (50, 100, 200, 500, 1000)
             for weight in np.linspace(0.0, 1.0, 11)]
    return min(tried, key=lambda one: float(np.std(
        by_hand(seen, one, ratio, inertia) - aligned)))


def late(seen: Seen) -> Array:
    """Return the torque of a recording as a reference that lags shows it (k,) [N*m]."""
    return np.concatenate([np.full(LAG, seen.torque[0]), seen.torque[:-LAG]])


def calibrated(arm: Arm, seen: Seen) -> Arm:
    """Return the arm as a recording with a reference calibrates it, as it was if that is worse."""
    one = Measured('first', seen.stamps, readings(seen), seen.command, late(seen))
    try:
        return calibrate(arm, {LABEL: [one]}).arm
    except CalibrationError as refused:
        print(f'{LABEL} stays as it was: {refused}', flush=True)
        return arm


def readings(seen: Seen) -> Array:
    """Return both angles of a recording as the estimator reads them (k, 1, READINGS)."""
    unknown = np.full_like(seen.motor, np.nan)
    return np.stack([seen.motor, seen.link, unknown, unknown], axis=1)[:, None, :]


def judged(seen: Seen, arm: Arm, fitted: tuple[Array, float, int, float]) -> Found:
    """Return the errors over a recording."""
    estimated = Estimator(arm).run(seen.stamps, readings(seen), seen.command[:, None])
    joint = arm.joints[0]
    other = by_hand(seen, fitted, joint.ratio, joint.motor_inertia)
    used = np.delete(np.arange(len(seen.stamps)), estimated.refused)
    true = seen.torque[used]
    error = (estimated.torque[:, 0] - true)[BEGUN:]
    deviation = estimated.torque_deviation[BEGUN:, 0]
    return Found(_rms(error), _rms((other[used] - true)[BEGUN:]), float(np.std(true)),
                 float((np.abs(error) < WITHIN * deviation).mean()))


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values ** 2)))


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the table, and return 1 where a bar was missed."""
    known = parser(__doc__)
    known.add_argument('--first', type=int, default=40, metavar='SEED', help='of the arms')
    known.add_argument('--recordings', type=int, default=6)
    chosen = known.parse_args(arguments)
    seconds, count = (TINY, 1) if chosen.quick else (SECONDS, chosen.recordings)
    arm, kept = knee(), True
    print('| knee | torque varies by | rms | ten-line filter | 90 % intervals hold |')
    print('|---|---|---|---|---|')
    joint = arm.joints[0]
    for seed in range(chosen.first, chosen.first + count):
        first = recorded(seed, 1000 + seed, seconds)
        fitted = fitted_by_hand(first, joint.ratio, joint.motor_inertia)
        found = judged(recorded(seed, seed, seconds), calibrated(arm, first), fitted)
        kept &= (found.ours <= BAR * found.spread and found.ours <= BESIDE * found.by_hand
                 and HELD[0] <= found.held <= HELD[1])
        print(f'| {seed} | {found.spread:.1f} N*m | {found.ours:.2f} N*m '
              f'({100.0 * found.ours / found.spread:.0f} %) | {found.by_hand:.2f} N*m | '
              f'{100.0 * found.held:.0f} % |', flush=True)
    return verdict('all bars kept', kept, quick=chosen.quick)


if __name__ == '__main__':
    raise SystemExit(main())
