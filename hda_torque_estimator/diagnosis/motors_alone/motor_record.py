"""A recording of motors alone: shaft angles and torques on a time grid, and what moves in them."""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array, Mask
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.parts import Joint
from hda_msgs_json.samples import JointSamples
from hda_msgs_json.topics import motor_name
import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_coeffs, savgol_filter

from ...measurements.recording_checks import check_duration, check_torque
from ...significance import DEVIATIONS

# Numerics; choices unless stated otherwise.
SHORTEST = 2.0          # recording of a sweep from which friction and ripple are observable [s]
_WINDOW, _DEGREE = 0.041, 3     # of the polynomials that give speeds [s]
_SLOW = 0.3             # shaft speed below which dry friction is not known [rad/s]
_BLOCKS = 12            # stretches of the motion of a sweep,
HELD = 3               # of so many of which one is held out
_WINDOWS = 2              # windows of the polynomials in a stretch that suffices


class Sweep(NamedTuple):
    """
    The shaft of one joint where it moves, all (k,): rad, rad/s, rad/s^2, N*m at the shaft.

    Angle and speed are those of when the torque of a row acts, (eq:effort-lag).
    """

    joint: Joint
    dt: float
    time: Array
    angle: Array
    speed: Array
    acceleration: Array
    torque: Array
    moving: Mask
    since: Array            # time since its own recording began [s]

    @property
    def held_out(self) -> Mask:
        """Return the rows that no fit sees (k,)."""
        return self.block % HELD == HELD - 1

    @property
    def block(self) -> NDArray[np.int64]:
        """
        Return the stretch of each row (k,): all have as much of the motion, so none is empty.

        A joint may move in a small part of a recording alone.
        """
        moved: NDArray[np.int64] = np.cumsum(self.moving) - self.moving
        return np.minimum(moved * _BLOCKS // max(int(self.moving.sum()), 1), _BLOCKS - 1)

    @property
    def both_ways(self) -> bool:
        """Return whether it moves in both directions."""
        ways = np.sign(self.speed[self.moving])
        return bool((ways > 0.0).any() and (ways < 0.0).any())


def is_motor_side(samples: JointSamples, arm: Arm) -> bool:
    """Return whether a recording has the motor side alone: no link angle of any joint."""
    links = [label for label in arm.labels if label in samples.names]
    motors = [label for label in arm.labels if motor_name(label) in samples.names]
    return bool(motors) and not np.isfinite(samples.select(links).position).any()


def sweeps_of(samples: JointSamples, arm: Arm, source: str,
              period: float | None = None) -> list[Sweep]:
    """
    Return the joints that move in a recording, sampled every `period` [s] or as recorded.

    Raises GateError if it cannot be used.
    """
    return [sweep for joint in arm.joints if motor_name(joint.label) in samples.names
            for sweep in _sweep(samples, joint, source, period)]


def sweeps_together(recordings: Mapping[str, JointSamples], arm: Arm) -> list[Sweep]:
    """
    Return the joints that move in several recordings of one arm, by their names.

    A joint that moves in several has them one after another, with the angles as they are. Its
    motor encoder is taken to keep its zero. All are sampled as the slowest was recorded. Raises
    GateError where one cannot be used.
    """
    slowest = max(period_of(samples) for samples in recordings.values())
    found: dict[str, Sweep] = {}
    begin = 0.0
    for source, samples in recordings.items():
        for sweep in sweeps_of(samples, arm, source, slowest):
            later = sweep._replace(time=sweep.time + begin)
            label = sweep.joint.label
            found[label] = _after(found[label], later) if label in found else later
        begin += length_of(samples)
    return [found[joint.label] for joint in arm.joints if joint.label in found]


def period_of(samples: JointSamples) -> float:
    """Return the usual period of a recording [s]."""
    return float(np.median(np.diff(samples.stamps))) * 1e-9


def length_of(samples: JointSamples) -> float:
    """Return how long a recording lasts, up to where a next one may begin [s]."""
    return float(samples.stamps[-1] - samples.stamps[0]) * 1e-9 + period_of(samples)


def _after(first: Sweep, second: Sweep) -> Sweep:
    """Return two sweeps of one joint as one."""
    return Sweep(first.joint, first.dt, *(np.concatenate(pair)
                                          for pair in zip(first[2:], second[2:])))


def _sweep(samples: JointSamples, joint: Joint, source: str,
           period: float | None) -> Iterator[Sweep]:
    """Yield the sweep of a joint, none where it was held still or hardly moved."""
    motor = samples.select([motor_name(joint.label)])
    angle, torque = motor.position[:, 0], motor.effort[:, 0]
    good = np.isfinite(angle) & np.isfinite(torque)
    check_torque(torque, joint.label, source)
    if good.sum() < 100:
        return
    since = (samples.stamps[good] - samples.stamps[good][0]) * 1e-9
    dt = float(np.median(np.diff(since))) if period is None else period
    check_duration(float(since[-1]), SHORTEST, source)
    time = dt * np.arange(int(since[-1] / dt) + 1, dtype=np.float64)
    acts = time + joint.effort_lag * period_of(samples)     # the angle is smooth, the torque not
    angle, torque = np.interp(acts, since, angle[good]), np.interp(time, since, torque[good])
    window = max(_DEGREE + 2, 2 * round(0.5 * _WINDOW / dt) + 1)
    speed, acceleration = (savgol_filter(angle, window, _DEGREE, deriv=order, delta=dt)
                           for order in (1, 2))
    unsure = DEVIATIONS * _speed_noise(motor.position[good, 0], window, dt)
    moving = np.abs(speed) > max(_SLOW, unsure)
    moving[:window], moving[-window:] = False, False
    if moving.sum() >= _BLOCKS * _WINDOWS * window:
        yield Sweep(joint, dt, time, angle, speed, acceleration, torque, moving, time)


def _speed_noise(angle: Array, window: int, dt: float) -> float:
    """Return the deviation [rad/s] that the steps of an encoder give to a speed."""
    steps = np.abs(np.diff(angle))
    finest = float(np.min(steps, initial=np.inf, where=steps > 0.0))
    gain = float(np.linalg.norm(savgol_coeffs(window, _DEGREE, deriv=1, delta=dt)))
    return finest / np.sqrt(12.0) * gain if np.isfinite(finest) else 0.0
