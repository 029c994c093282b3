"""A recording of an arm that has more in it than its nominal model knows."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import encoders, layout
from .drive import JITTER, SLOWING
from .effect import Hidden, TruthError
from .loop import blank, FRESH, Log, LOST, Plan, run, STALE
from .plant import at_rest, plant

Array = NDArray[np.float64]

STEP = 40e-6                    # longest integration step on a regular clock [s]
SETTLING = 0.5                  # time at the first angle before the recording begins [s]
START = 1_000_000_000           # first stamp, nominally [ns]
CLOCK_JITTER = 2e-6             # one sigma of the sampling times; the stamps know it [s]
LATE = (0.3, 0.9)               # how late a late sample is, in samples
BURST = 8                       # samples of a burst of mishaps
BURSTS, RIGHT_STAMPS = 1, 2     # forms of dropped_samples (`forms.py`)
SAMPLED, BUSY = 1, 2            # forms of clock_jitter
HALF_NORMAL = np.sqrt(1.0 - 2.0 / np.pi)        # deviation of the size of a normal number
MOST_UNEVEN = 0.4               # of a sample, by which one may be early or late and in order
AT_ONCE, BUSY_SHARE = 30, 0.3   # samples for which a host is busy or not, and how often it is
IDLE = 0.2                      # share of a wait that is left while it is not
OF_THE_ARM = 2                  # streams of chance that belong to the arm: scatter and mounting


class TruthRecord(NamedTuple):
    """What a driver would record of the arm (k samples), and behind it what was true."""

    stamps: NDArray[np.int64]   # (k,) [ns]
    motor_angle: Array          # (k, 2) shaft, as the encoders show it [rad]
    link_angle: Array           # (k, 2) as the encoders show it [rad]
    command: Array              # (k, 2) motor torque in force until the next sample [N*m]
    joint_torque: Array         # (k, 2) true, through the gear [N*m]
    external: Array             # (k, 2) true joint torques of the force on the tip [N*m]
    states: Array               # (k, 2, 4) true motor angle and rate, link angle and rate


class Built(NamedTuple):
    """The numbers of an arm as its file states them, nothing hidden and nothing scattered."""

    joints: NDArray[np.void]    # (2,)
    arm: NDArray[np.void]       # (1,)


class Reference(NamedTuple):
    """What an arm is to follow, and what pushes it meanwhile."""

    angle: Array                # (k, 2) of the links [rad]
    rate: Array                 # (k, 2) [rad/s]
    dt: float                   # between samples [s]
    force: Array | None = None  # (k, 2) on the tip, in the base frame [N]

    def check(self) -> None:
        """Raise TruthError if an arm cannot follow."""
        angle, rate, dt, force = self
        if angle.ndim != 2 or angle.shape[1] != 2 or angle.shape != rate.shape or len(angle) < 2:
            raise TruthError(f'a motion is two arrays (k, 2), got {angle.shape} and {rate.shape}')
        if force is not None and force.shape != angle.shape:
            raise TruthError(f'a tip force has the shape of the motion, {angle.shape}, '
                             f'got {force.shape}')
        if not 1e-4 <= dt <= 0.01:
            raise TruthError(f'dt must lie in [0.0001, 0.01] s, got {dt:g}')


class Device(NamedTuple):
    """Which arm is recorded, of all that are built alike."""

    seed: int | None = None     # of its scatter and its encoders' zeros; that of the recording
    scatter: bool = True        # whether its numbers differ from the nominal ones
    counts: tuple[float, float] = (16384, 4e6)      # per turn of its encoders: motor, link
    built: Built | None = None  # its nominal numbers, where they are others


class _Chance(NamedTuple):
    """Everything random in a recording, drawn whether it is needed or not: paired by the seed."""

    scatter: np.random.Generator
    mounting: np.random.Generator
    clock: np.random.Generator
    torque: np.random.Generator
    reading: np.random.Generator
    form: np.random.Generator
    stamp: np.random.Generator


def record(hidden: Sequence[Hidden], reference: Reference, seed: int, *, noise: float = 1.0,
           device: Device = Device(), settling: float = SETTLING, part: int = 0) -> TruthRecord:
    """
    Let an arm with hidden effects follow a motion, and record it.

    `noise` multiplies the noise of motor torque, encoders and clock. The arm stands still for
    `settling` [s] before the recording begins. `part` counts recordings of one arm that differ in
    chance. Raises TruthError for effects that cannot be hidden or a motion that cannot be
    followed.
    """
    reference.check()
    angle, rate, dt, force = reference
    body = seed if device.seed is None else device.seed
    chance = _Chance(*(np.random.default_rng(
        [body, stream] if stream < OF_THE_ARM else [seed, stream, *([part] if part else [])])
        for stream in range(7)))
    given = device.built or Built(layout.nominal_joints(), layout.nominal_arm())
    joints, arm = given.joints.copy(), given.arm.copy()
    if device.scatter:
        layout.scatter(joints, arm, chance.scatter)
    layout.hide(hidden, joints, arm)
    encoders.mount(joints, device.counts, chance.mounting)
    joints['reference_power'] = usual_loss(
        rate, given.joints, 0.25 * joints['thermal_viscosity_amplitude'])
    lead = round(settling / dt)
    plan, stamps = _plan(_led(angle, rate, force, lead), dt, lead, chance, arm[0], noise)
    _put_off(plan, joints, chance.form)
    jitter = encoders.JITTER * noise * chance.reading.standard_normal((2, len(stamps), 2))
    plan.noise[:] = (arm[0]['powered'] * (joints['noise'] * noise)
                     * chance.torque.standard_normal(plan.noise.shape))
    plan.jitter[:] = 2.0 * np.pi / device.counts[0] * jitter[0]
    log = blank(len(stamps))
    run(plant(arm, joints), at_rest(joints['ratio'] * angle[0], angle[0]), plan,
        max(1, round(dt / STEP)), log)
    seen = log.link[:-1]
    if joints['clock_skew_form'].any():
        seen = encoders.unsteady(joints, seen, log.state[:, :, 3], plan.instant[:-1],
                                 chance.form.standard_normal(seen.shape))
    shown = encoders.link_reading(arm[0], joints, seen, plan.instant[:-1],
                                  2.0 * np.pi / device.counts[1] * jitter[1])
    if joints['coarse_quantisation_form'].any():
        shown = encoders.missing(joints, shown, 'link')
        log.motor[:] = encoders.missing(joints, log.motor, 'motor')
    return _seen(plan, stamps, log, shown, lead)


def usual_loss(rate: Array, joints: NDArray[np.void], more: Array) -> Array:
    """Return the mean friction loss (2,) in a motion, with more viscosity; at least 50 mW [W]."""
    motor = joints['ratio'] * np.abs(rate)
    least = 0.05 * joints['size']
    return np.maximum((joints['dry'] * motor + (joints['viscous'] + more) * motor ** 2
                       ).mean(axis=0), least)


def _put_off(plan: Plan, joints: NDArray[np.void], rng: np.random.Generator) -> None:
    """Write when commands arrive where the delay of a joint is not constant."""
    for j, joint in enumerate(joints):
        first, span = joint['command_delay_first'], plan.instant[-1] - plan.instant[0]
        if joint['command_delay_form'] == JITTER:
            waits = first * np.diff(plan.instant).min() * rng.random(len(plan.arrival))
        elif joint['command_delay_form'] == SLOWING:
            waits = first * joint['command_delay_delay'] * (plan.instant > 0.5 * span)
        else:
            continue
        plan.arrival[:, j] += waits


def _led(angle: Array, rate: Array, force: Array | None, lead: int) -> tuple[Array, Array, Array]:
    """Return motion and force with `lead` samples of standstill before them."""
    push = np.zeros_like(angle) if force is None else force
    still = np.zeros((lead, 2))
    return (np.concatenate([np.repeat(angle[:1], lead, axis=0), angle]),
            np.concatenate([still, rate]), np.concatenate([still, push, push[-1:]]))


def _plan(motion: tuple[Array, Array, Array], dt: float, lead: int, chance: _Chance,
          arm: np.void, noise: float) -> tuple[Plan, NDArray[np.int64]]:
    """Return what is given for each sample, and the stamps that go with them."""
    angle, angle_rate, force = motion
    samples, rng = len(angle), chance.clock
    instant = dt * np.arange(-lead, samples - lead + 1, dtype=np.float64)
    instant += CLOCK_JITTER * noise * layout.truncated(rng, samples + 1)
    stamps = START + np.rint(1e9 * instant[:-1]).astype(np.int64)
    fate, late = _mishaps(rng, samples, lead, arm)
    instant[:-1] += dt * late
    stamps = _stamped(stamps, instant, dt, arm, chance.stamp)
    plan = Plan(np.ascontiguousarray(angle), np.ascontiguousarray(angle_rate), force, instant,
                np.repeat(instant[:, None], 2, axis=1), fate, np.zeros((samples, 2)),
                np.zeros((samples, 2)))
    return plan, stamps


def _stamped(stamps: NDArray[np.int64], instant: Array, dt: float, arm: np.void,
             rng: np.random.Generator) -> NDArray[np.int64]:
    """Return stamps of a host, in their order, or move the sampling under even ones."""
    jitter, form = arm['clock_jitter_jitter'], arm['clock_jitter_form']
    if jitter == 0.0:
        return stamps
    drawn = rng.standard_normal(len(stamps))
    if form == SAMPLED:
        instant[:-1] += np.clip(jitter * drawn, -MOST_UNEVEN * dt, MOST_UNEVEN * dt)
        return stamps
    waits = np.abs(drawn) / HALF_NORMAL
    if form == BUSY:
        at_work = rng.random(len(stamps) // AT_ONCE + 1) < BUSY_SHARE
        waits *= np.repeat(np.where(at_work, 1.0, IDLE), AT_ONCE)[:len(stamps)]
        waits /= waits.std()
    late, order = jitter * waits, np.arange(len(stamps))
    return np.maximum.accumulate(stamps + np.rint(1e9 * late).astype(np.int64) - order) + order


def _mishaps(rng: np.random.Generator, samples: int, lead: int,
             arm: np.void) -> tuple[NDArray[np.int64], Array]:
    """Return the fate of every sample, and by how many samples it is late."""
    chance, kind = rng.random(samples), rng.integers(3, size=samples)
    rate, form = arm['dropped_samples_rate'], arm['dropped_samples_form']
    hit = chance < rate / (BURST if form == BURSTS else 1)
    if form == BURSTS:
        hit = np.convolve(hit, np.ones(BURST))[:samples] > 0.0
    hit &= np.arange(samples) > lead
    if form == RIGHT_STAMPS:
        kind = np.zeros_like(kind)
    fate = np.where(hit, np.array([LOST, STALE, FRESH])[kind], FRESH)
    return fate, np.where(hit & (kind == 2), rng.uniform(*LATE, samples), 0.0)


def _seen(plan: Plan, stamps: NDArray[np.int64], log: Log, shown: Array,
          lead: int) -> TruthRecord:
    """Return what reached the recorder: nothing of lost samples, old readings of stale ones."""
    kept = np.flatnonzero(plan.fate != LOST)
    for last, k in zip(kept[:-1], kept[1:]):
        if plan.fate[k] == STALE:
            shown[k] = shown[last]
    kept = kept[kept >= lead]
    return TruthRecord(stamps[kept], log.motor[kept], shown[kept], log.command[kept],
                       log.torque[kept], log.external[kept], log.state[kept])
