"""
Measure how well a calibrated arm estimates its joint torques, on an arm that hides what is wrong.

    torque.py [--chain] [--arms N] [--first SEED] [--quick]

Each arm is one of `torque_arm.py`: it is recorded free, on a wedge and pulled at the tip, then
calibrated by `hda calibrate` from these bags, then judged on other motions: its torques under
load, the force at a tip that is pushed while it moves, and its silence while nothing pushes. The
paper's method (polynomial of degree 5, its equations as corrected) is fitted to the same bags.
With --chain it is an arm of seven joints, not calibrated (`torque_chain.py`).
"""

from collections.abc import Iterator, Sequence
import math
from pathlib import Path
import tempfile
import time
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import motion
from hda_msgs_json.bag import BagWriter, open_recording
from hda_msgs_json.samples import JointSamples
from hda_msgs_json.topics import BASE_FRAME, JOINT_STATES, REFERENCE_TIP_WRENCH
from hda_torque_estimator.calibrate.calibration import one_joint
from hda_torque_estimator.calibrate.fitting.polynomial import polynomial_method, PolynomialMethod
from hda_torque_estimator.calibrate.passages.calibration_recording import heard
from hda_torque_estimator.calibrate.passages.stated_conditions import stated
from hda_torque_estimator.calibrate.run import known_wrenches, run_calibration, Sources
from hda_torque_estimator.estimating.estimates import Estimates
from hda_torque_estimator.estimating.estimator import Estimator, EstimatorSettings
from hda_torque_estimator.simulating.recorded import joint_samples, on_tip
from hidden_truth import TruthRecord
import numpy as np
from numpy.typing import NDArray
from pushes import alarms, BEGUN, delays, force_error, PUSH, SOON, sudden, WITHIN
from size import parser
from tolerated import pushed, reading
from torque_arm import calibration, DT, JOINTS, moved, Recorded, recorded, standing, turning
import torque_chain

GIVEN = 'hda_arm.yaml'
BAGS = ('free', 'wedge', 'pulled')
FELT = 2.7                      # `contact_deviations` of a calibrated arm, see docs/calibration.md
TORSION_ALONE = EstimatorSettings(fusion=0.0, contact_deviations=FELT)
WAYS = {'torsion alone': TORSION_ALONE, 'both ways': EstimatorSettings(contact_deviations=FELT)}
HIGH = (12.0, 27.0)             # torques beyond the bars in N*m [N*m]
MOTIONS = ('rich', 'sine', 'turn')
SOFT = 15.0                     # largest of the soft pushes [N]


class Lengths(NamedTuple):
    """How long the recordings last [s]."""

    calibration: float
    turning: float
    standing: float
    pushed: float


WHOLE, TINY = Lengths(60.0, 60.0, 40.0, 60.0), Lengths(12.0, 4.0, 4.0, 6.0)


class Errors(NamedTuple):
    """Errors over one test motion, both joints together."""

    mean: float                 # absolute [N*m]
    worst: float                # [N*m]
    relative: float             # mean of those from 12 to 27 N*m, NaN without such torques


class Row(NamedTuple):
    """A row of the table: what is asked, and how it is read from the errors of both methods."""

    meaning: str
    unit: str
    bar: float
    motion: str
    column: str


class Pushed(NamedTuple):
    """What the estimator says of pushes at the tip while it moves."""

    force: float                # rms error of a component [N]
    delays: list[float]         # of sudden pushes of 5 N, inf where one was not felt [ms]
    alarms: int                 # contacts that were none
    minutes: float              # of free motion
    held: float                 # share of free torques within their 90 % intervals
    mean: float                 # absolute error of these torques [N*m]


ROWS = (Row('turning under steps and waves up to 12 N*m (Fig. 11), mean', 'N*m', 0.12, 'turning',
            'mean'),
        Row('the same, worst', 'N*m', 0.6, 'turning', 'worst'),
        Row('standing under steps and waves up to 12 N*m (Fig. 9), mean', 'N*m', 0.08,
            'standing', 'mean'),
        Row('12 to 27 N*m, mean relative', '', 0.03, 'high', 'relative'))


def main() -> None:
    """Print the table."""
    known = parser(__doc__)
    known.add_argument('--arms', type=int, default=3, help='arms that are measured')
    known.add_argument('--first', type=int, default=200, help='seed of the first one')
    known.add_argument('--chain', action='store_true', help='an arm of seven joints instead')
    asked = known.parse_args()
    if asked.chain:
        torque_chain.main(1 if asked.quick else asked.arms, asked.first,
                          6.0 if asked.quick else WHOLE.pushed)
        return
    lengths, arms = (TINY, 1) if asked.quick else (WHOLE, asked.arms)
    found, pushes = [], list[list[Pushed]]()
    for seed in range(asked.first, asked.first + arms):
        begin = time.monotonic()
        with tempfile.TemporaryDirectory() as folder:
            calibrated, methods = _calibrated(seed, Path(folder), lengths)
        found.append(measured(seed, calibrated, methods, lengths))
        pushes.append(pushed_tip(seed, calibrated, lengths))
        print(f'arm {seed}: {time.monotonic() - begin:.0f} s', flush=True)
    print('\n'.join([table(found), *(line for name, each in zip(WAYS, zip(*pushes))
                                     for line in of_pushes(name, each))]))


def measured(seed: int, calibrated: Arm, methods: Sequence[PolynomialMethod],
             lengths: Lengths) -> dict[str, tuple[Errors, Errors]]:
    """Return the errors of the calibrated arm of a seed and of the paper's method, by motion."""
    tests = {'turning': turning(12.0, lengths.turning),
             'standing': standing(0.0, 12.0, lengths.standing),
             'high': standing(19.5, 7.5, lengths.standing)}
    return {name: _judged(recorded(seed, loaded, 10 * seed + place), calibrated, methods)
            for place, (name, loaded) in enumerate(tests.items(), start=5)}


def pushed_tip(seed: int, calibrated: Arm, lengths: Lengths) -> list[Pushed]:
    """Return what the calibrated arm of a seed says of pushes and of free motion, by `WAYS`."""
    seen = [(soft, begins, [moved(seed, angle, force, own + k)
                            for k, force in enumerate((soft, hard, np.zeros_like(soft)))])
            for own, angle, soft, begins, hard in _drawn(seed, lengths.pushed)]
    return [_pushed(Estimator(calibrated, settings), seen) for settings in WAYS.values()]


def _drawn(seed: int, seconds: float
           ) -> Iterator[tuple[int, Array, Array, NDArray[np.int64], Array]]:
    """Yield seed, angles, soft pushes, moments of the hard ones and these, for each motion."""
    for place, path in enumerate(MOTIONS):
        random, own = np.random.default_rng([seed, place]), 10_000 * seed + 10 * place
        angle = motion(path, len(JOINTS), seconds, DT, own).angle
        soft = pushed(len(angle), SOFT, random)
        yield own, angle, soft, *sudden(len(angle), random)


def _pushed(estimator: Estimator,
            seen: Sequence[tuple[Array, NDArray[np.int64], list[TruthRecord]]]) -> Pushed:
    """Return what an estimator says of recordings with soft pushes, hard ones and none."""
    off, felt, raised, held, wrong, free_time = [], list[float](), 0, [], [], 0.0
    for force, begins, (soft, hard, free) in seen:
        off.append(force_error(_estimates(estimator, soft), soft, force))
        felt += delays(_estimates(estimator, hard), hard, begins)
        estimated = _estimates(estimator, free)
        raised += alarms(estimated)[0]
        free_time += DT * len(free.stamps)
        error = np.abs(estimated.torque - free.joint_torque)[BEGUN:]
        held.append((error < WITHIN * estimated.torque_deviation[BEGUN:]).mean())
        wrong.append(error.mean())
    return Pushed(float(np.mean(off)), felt, raised, free_time / 60.0,
                  float(np.mean(held)), float(np.mean(wrong)))


def _estimates(estimator: Estimator, seen: TruthRecord) -> Estimates:
    """Return the estimates of a recording, as if it were the first."""
    estimator.reset()
    return estimator.run(seen.stamps, reading(seen), seen.command)


def _calibrated(seed: int, folder: Path,
                lengths: Lengths) -> tuple[Arm, list[PolynomialMethod]]:
    """Return the calibrated arm of a seed and the paper's method, both from the same bags."""
    bags, tilts = [], []
    for place, (name, loaded) in enumerate(zip(BAGS, calibration(lengths.calibration))):
        bags.append(written(folder / name, recorded(seed, loaded, 10 * seed + place)))
        if loaded.tilt:
            tilts.append((name, f'{math.degrees(loaded.tilt):.12g}', '0'))
    run_calibration(Sources(bags, tilts), GIVEN, folder / 'calibrated.yaml')
    given, known = read_arm(GIVEN), stated(bags, tilts, ())
    opened = [open_recording(bag) for bag in bags]
    seen = [heard(bag.joint_states(), known_wrenches(bag, given), name, given, one).passages
            for name, bag, one in zip(BAGS, opened, known)]
    methods = [polynomial_method(one_joint(given, label), [one[label] for one in seen])
               for label in JOINTS]
    return read_arm(folder / 'calibrated.yaml'), methods


def written(path: Path, made: Recorded) -> Path:
    """Write a bag of what a driver and, where something pulls, a force sensor would record."""
    with BagWriter(path, {}) as bag:
        bag.write_joint_states(JOINT_STATES, states(made))
        if made.force.any():
            bag.write_wrenches(REFERENCE_TIP_WRENCH,
                               on_tip(made.seen.stamps, BASE_FRAME, made.force))
    return path


def states(made: Recorded) -> JointSamples:
    """Return the joint states of a recording."""
    seen = made.seen
    return joint_samples(read_arm(GIVEN), seen.stamps, reading(seen), seen.command)


def _judged(made: Recorded, calibrated: Arm,
            methods: Sequence[PolynomialMethod]) -> tuple[Errors, Errors]:
    """Return the errors of the calibrated arm and of the paper's method over a recording."""
    seen, angles = made.seen, reading(made.seen)
    ours = Estimator(calibrated, TORSION_ALONE).run(seen.stamps, angles).torque
    papers = np.stack([method.torque(seen.stamps, angles[:, j:j + 1])
                       for j, method in enumerate(methods)], axis=1)
    return errors(ours, seen.joint_torque), errors(papers, seen.joint_torque)


def errors(torque: Array, true: Array) -> Errors:
    """Return the errors of torques (k, n)."""
    off, size = np.abs(torque - true), np.abs(true)
    high = (size >= HIGH[0]) & (size <= HIGH[1])
    return Errors(float(off.mean()), float(off.max()),
                  float((off[high] / size[high]).mean()) if high.any() else math.nan)


def table(found: Sequence[dict[str, tuple[Errors, Errors]]]) -> str:
    """Return the table: over all arms the mean, of worst values the worst."""
    lines = ['| | at most | reached | method of the paper | times better |',
             '|---|---|---|---|---|']
    for row in ROWS:
        take = max if row.column == 'worst' else np.mean
        ours, papers = (float(take([getattr(one[row.motion][who], row.column) for one in found]))
                        for who in (0, 1))
        scale, unit = (1.0, f' {row.unit}') if row.unit else (100.0, ' %')
        lines.append(f'| {row.meaning} | {scale * row.bar:g}{unit} | {scale * ours:.3f}{unit} | '
                     f'{scale * papers:.2f}{unit} | {papers / ours:.0f} |')
    return '\n'.join(lines)


def of_pushes(way: str, found: Sequence[Pushed]) -> list[str]:
    """Return the rows of the tip: force, contacts, alarms."""
    felt = [delay for one in found for delay in one.delays]
    soon = sum(delay <= SOON for delay in felt)
    return [f'| tip force while moving, {way}, rms of a component | 1.5 N | '
            f'{np.mean([one.force for one in found]):.2f} N | - | - |',
            f'| a push of {PUSH:g} N is felt, {way} | {SOON:g} ms | {soon} of {len(felt)} so '
            f'soon, median {np.median(felt):.0f} ms, last {max(felt):.0f} ms | - | - |',
            f'| contacts in {sum(one.minutes for one in found):.3g} min of free motion, {way} | 0 '
            f'| {sum(one.alarms for one in found)} | - | - |',
            f'| 90 % intervals of these torques hold, {way} | 85 to 95 % | '
            f'{100.0 * np.mean([one.held for one in found]):.0f} % | - | - |',
            f'| mean error of these torques, {way} | - | '
            f'{np.mean([one.mean for one in found]):.3f} N*m | - | - |']


if __name__ == '__main__':
    main()
