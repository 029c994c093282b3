"""
The motor as a witness: its torque less friction and inertia, where the shaft slides one way.

At rest friction takes any value up to its level, and the motor determines no torque. A joint
may rest for most of the time, or bear one load. Then that may still be more than sliding shows.
The torque is in the middle of what friction allows.
"""

from collections.abc import Sequence
from functools import lru_cache

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.compiled import compiled, Record
from hda_arm_sim.model.arm import Arm
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d, minimum_filter1d

from .witness import blocks_of, Flags, LAGS, per_recording
from ..passages.joint_recording import Measured, ShaftMotion
from ..passages.thinning import row_means
from ...estimating.laws import route_errors
from ...estimating.laws.motor_witness import turns
from ...samples.readings import LINK_READING, MOTOR_READING

Floats = NDArray[np.float64]
# Choices unless stated otherwise.
SLOWEST = 1.0           # shaft speed from which friction slides for certain [rad/s]
FEWEST_ROWS = 50        # in which a motor slides
STANDS = 1e-9           # speed of a shaft whose sign is one of rounding [rad/s]
# Columns of what a motor's torque follows from.
COMMAND, ANGLE, RATE, LOAD, LINK, TIME = range(6)


@compiled
def motor_torques(joint: Record, seen: Array, period: float, torque: Array) -> None:
    """Fill the torques (k,) of a motor without inertia, from its columns (k, 6)."""
    for k in range(seen.shape[0]):
        slides = abs(seen[k, RATE]) > SLOWEST or turns(joint, seen[k, RATE], period)
        at = route_errors.ShaftState(seen[k, ANGLE], seen[k, RATE],
                                     np.sign(seen[k, RATE]) if slides else 0.0, seen[k, LINK])
        torque[k] = route_errors.motor_torque(joint, seen[k, COMMAND], at, seen[k, LOAD],
                                              seen[k, TIME])


class MotorWitness:
    """The rows of the motor's torque; its zero is a torque at the output [N*m]."""

    def __init__(self, recordings: Sequence[Measured], *, resting: bool = False) -> None:
        """Take recordings that all have motor torques; rows at rest count where asked for."""
        self.recordings = recordings
        self.dt = max(one.dt for one in recordings)
        self._turning = [one.turning() for one in recordings]
        self._seen = [_columns(*each) for each in zip(recordings, self._turning)]
        self._used = [(_known if resting else _slides)(*each)
                      for each in zip(recordings, self._turning, self._seen)]
        self.blocks = blocks_of(recordings, self._used)
        self.usual_zero = float(np.mean([one.varies() for one in recordings]))
        self.reference = lru_cache(LAGS)(self._reference)

    @property
    def fastest(self) -> float:
        """Return the speed that the shaft had at most, but for outliers [rad/s]."""
        return float(np.percentile(np.abs(np.concatenate(
            [turned.rate for turned in self._turning])), 95.0))

    @property
    def angle(self) -> Floats:
        """Return the angle of the shaft (m,) [rad]."""
        return self._rows([seen[:, ANGLE] for seen in self._seen])

    @property
    def sense(self) -> Floats:
        """Return the sense in which the shaft turns (m,)."""
        return np.sign(self._rows([seen[:, RATE] for seen in self._seen]))

    @property
    def rests(self) -> Flags:
        """Return the rows in which the shaft does not slide for certain (m,)."""
        return np.asarray(np.abs(self._rows([seen[:, RATE] for seen in self._seen])) <= SLOWEST)

    @property
    def command(self) -> Floats:
        """Return the motor torque (m,) [N*m motor]."""
        return self._rows([seen[:, COMMAND] for seen in self._seen])

    def waves(self, order: float) -> Floats:
        """Return sine and cosine of an order of the shaft, as rows see them (m, 2)."""
        return np.stack([self._rows([turned.alike(wave(order * seen[:, ANGLE])) for seen, turned
                                     in zip(self._seen, self._turning)])
                         for wave in (np.sin, np.cos)], axis=1)

    def dry_friction(self, arm: Arm) -> Floats:
        """Return the most that dry friction opposes in the rows (m,) [N*m]."""
        joint, stands = arm.record().joints[0], route_errors.ShaftState(0.0, 0.0, 0.0, 0.0)
        return self._rows([np.array([route_errors.dry_friction(joint, stands, load)
                                     for load in seen[:, LOAD]]) for seen in self._seen])

    def torque(self, arm: Arm, zeros: Floats) -> Floats:
        """Return the torque of the rows (m,) [N*m], by (r,) more than that of the motor."""
        joint, found = arm.joints[0], []
        inertia = joint.ratio * float(arm.record().joints['motor_inertia'][0])
        for one, seen, turned, zero in zip(self.recordings, self._seen, self._turning,
                                           per_recording(zeros, self.recordings)):
            torque = np.empty(len(seen))
            motor_torques(arm.record().joints[0], seen, one.dt, torque)
            found.append(turned.alike(torque) - inertia * turned.acceleration + zero)
        return self._rows(found)

    def _reference(self, lag: float) -> Floats:
        """Return the reference of the rows (m,) [N*m]."""
        return self._rows([turned.alike(one.later(lag)) for one, turned
                           in zip(self.recordings, self._turning)])

    def _rows(self, columns: Sequence[Floats]) -> Floats:
        return np.concatenate([row_means(column, one.dt)[used] for column, one, used
                               in zip(columns, self.recordings, self._used)])


def sliding(recordings: Sequence[Measured]) -> list[Measured]:
    """Return the recordings in which a shaft slides, none if all rows of these are few."""
    rows = [int(_slides(one, turned := one.turning(), _columns(one, turned)).sum())
            for one in recordings]
    found = [one for one, count in zip(recordings, rows) if count > 0]
    return found if sum(rows) >= FEWEST_ROWS else []


def _columns(one: Measured, turned: ShaftMotion) -> Floats:
    """Return what the motor's torque follows from (k, 6)."""
    link = np.nan_to_num(one.readings[:, 0, LINK_READING])
    return np.stack([one.acting, one.readings[:, 0, MOTOR_READING], turned.rate,
                     one.reference, link, one.time], axis=1)


def _slides(one: Measured, turned: ShaftMotion, seen: Floats) -> Flags:
    """Return the rows in which the shaft slides one way, all known, as far as derivatives see."""
    reach = 1 + 2 * turned.reach
    slides = ((minimum_filter1d(turned.rate, reach, mode='constant') > SLOWEST)
              | (maximum_filter1d(turned.rate, reach, mode='constant') < -SLOWEST))
    return (one.thinned(slides.astype(float)) == 1.0) & _known(one, turned, seen)


def _known(one: Measured, turned: ShaftMotion, seen: Floats) -> Flags:
    """Return the rows in which all is known, as far as derivatives see."""
    known = np.isfinite(seen).all(axis=1).astype(float)
    known = minimum_filter1d(known, 1 + 2 * turned.reach, mode='nearest')
    return one.thinned(known) == 1.0
