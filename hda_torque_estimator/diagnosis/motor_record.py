"""A recording of motors alone: shaft angles and torques on a time grid, and what moves in them."""

from collections.abc import Sequence
from typing import NamedTuple

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.parts import Joint
from hda_msgs_json.samples import JointSamples
from hda_msgs_json.topics import motor_name
import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from .gate import GateError

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
SHORTEST = 2.0          # recording of a sweep from which friction and ripple can be told [s]
_WINDOW, _DEGREE = 0.041, 3     # of the polynomials that give speeds [s]
_TRAVEL = 0.02          # link travel below which a joint was held still [rad]
_SLOW = 0.3             # shaft speed below which dry friction is not known [rad/s]
_BLOCKS = 12            # stretches of a sweep,
HELD = 3               # of so many of which one is held out


class Sweep(NamedTuple):
    """The shaft of one joint where it moves, all (k,): rad, rad/s, rad/s^2, N*m at the shaft."""

    joint: Joint
    dt: float
    time: Array
    angle: Array
    speed: Array
    acceleration: Array
    torque: Array
    moving: Mask

    @property
    def held_out(self) -> Mask:
        """Return the rows that no fit sees (k,)."""
        return self.block % HELD == HELD - 1

    @property
    def block(self) -> NDArray[np.int64]:
        """Return the stretch of each row (k,)."""
        length = self.time[-1] - self.time[0] + self.dt
        return np.asarray((self.time - self.time[0]) / length * _BLOCKS, np.int64)

    @property
    def both_ways(self) -> bool:
        """Tell whether it moves in both directions."""
        ways = np.sign(self.speed[self.moving])
        return bool((ways > 0.0).any() and (ways < 0.0).any())


def is_motor_side(samples: JointSamples, arm: Arm) -> bool:
    """Tell whether a recording has the motor side alone: no link angle of any joint."""
    links = [label for label in arm.labels if label in samples.names]
    motors = [label for label in arm.labels if motor_name(label) in samples.names]
    return bool(motors) and not np.isfinite(samples.select(links).position).any()


def sweeps_of(samples: JointSamples, arm: Arm, source: str) -> list[Sweep]:
    """Return the joints that move in a recording; raises GateError if it cannot be used."""
    found = [sweep for joint in arm.joints if motor_name(joint.label) in samples.names
             for sweep in _sweep(samples, joint, source)]
    if found and found[0].time[-1] - found[0].time[0] < SHORTEST:
        raise GateError(f'{source}: {found[0].time[-1] - found[0].time[0]:.2g} s are too short; '
                        f'record at least {SHORTEST:g} s')
    return found


def _sweep(samples: JointSamples, joint: Joint, source: str) -> Sequence[Sweep]:
    """Return the sweep of a joint, none where it was held still."""
    name = motor_name(joint.label)
    motor = samples.select([name])
    angle, torque = motor.position[:, 0], motor.effort[:, 0]
    good = np.isfinite(angle) & np.isfinite(torque)
    if not np.isfinite(torque).any():
        raise GateError(f'{source}: no motor torque of {joint.label}; record the commanded torque '
                        f'as the effort of {name}')
    if good.sum() < 100 or np.ptp(angle[good]) < _TRAVEL * joint.ratio:
        return ()
    since = (samples.stamps[good] - samples.stamps[good][0]) * 1e-9
    dt = float(np.median(np.diff(since)))
    time = dt * np.arange(int(since[-1] / dt) + 1, dtype=np.float64)
    angle, torque = (np.interp(time, since, values[good]) for values in (angle, torque))
    window = max(_DEGREE + 2, 2 * round(0.5 * _WINDOW / dt) + 1)
    speed, acceleration = (savgol_filter(angle, window, _DEGREE, deriv=order, delta=dt)
                           for order in (1, 2))
    moving = np.abs(speed) > _SLOW
    moving[:window], moving[-window:] = False, False
    return (Sweep(joint, dt, time, angle, speed, acceleration, torque, moving),)
