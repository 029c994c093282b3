"""One joint in one recording whose torque follows from its links: all that a calibration reads."""

from typing import NamedTuple

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.kernel import LINK_ANGLE, LINK_VELOCITY, MOTOR_VELOCITY
import numpy as np
from numpy.typing import NDArray

from .loads import DOUBTS, loads
from .thinning import row_means, samples_of_row
from ...measurements.effort import acting
from ...measurements.measurement import Measurement
from ...measurements.motion import MeasuredMotion, motion_of, smoothed
from ...samples.readings import READINGS

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
# Choices unless stated otherwise.
SLOWEST = 0.004         # period in which an estimator still follows all that a joint does [s]
EDGE = 0.25             # time at the end, and about lost samples, that is not used [s]
BEGIN = 1.0             # time at the beginning, until a loop has forgotten where it began [s]


class Passage(NamedTuple):
    """One joint in one recording, k evenly spaced samples."""

    recording: str
    dt: float                   # [s]
    readings: Floats            # (k, 1, READINGS)
    reference: Floats           # (k,) torque through the gear [N*m]
    doubt: Floats               # (k, DOUBTS) what a known torque may be off by, one sigma each
    usable: Flags               # (k,)
    command: Floats             # (k,) motor torque about the sample, as smooth as rates [N*m]
    link_angle: Floats          # (k,) without delay [rad]
    link_rate: Floats           # (k,) without delay [rad/s]
    motor_rate: Floats          # (k,) without delay [rad/s]
    motor_acceleration: Floats  # (k,) without delay [rad/s^2]

    @property
    def stamps(self) -> NDArray[np.int64]:
        """Return the stamps of the samples (k,) [ns]."""
        return 1 + np.round(np.arange(len(self.reference)) * self.dt * 1e9).astype(np.int64)

    @property
    def every(self) -> int:
        """Return how many samples make a row."""
        return samples_of_row(self.dt)

    def thinned(self, values: Floats) -> Floats:
        """Return the means of values (k, ...) over the samples of each row."""
        return row_means(values, self.dt)

    def rows_used(self) -> Flags:
        """Return which rows hold usable samples only."""
        return self.thinned(self.usable.astype(float)) == 1.0


def passages(name: str, arm: Arm, seen: Measurement, wrench: Floats,
             sensed: dict[str, Floats]) -> dict[str, Passage]:
    """
    Return each joint's passage through a recording of an arm that stands as `arm` says.

    `wrench` (k, 6) is known on the tip [N, N*m, base]. `sensed` are torques of sensors (k,), NaN
    where they show none. For joints without a sensor the links' own torque is taken.
    """
    motion, about = motion_of(seen, arm), _about(seen, arm)
    known = None if arm.links is None else loads(arm, motion, wrench)
    found = {}
    for j, label in enumerate(arm.labels):
        if label in sensed:
            torque, doubt = sensed[label], np.zeros((len(seen.command), DOUBTS))
        elif known is not None:
            torque, doubt = known.torque[:, j], known.doubt[:, j]
        else:
            continue
        found[label] = _passage(name, seen, motion, about, j, torque, doubt)
    return found


def _passage(name: str, seen: Measurement, motion: MeasuredMotion, about: Floats, j: int,
             torque: Floats, doubt: Floats) -> Passage:
    readings = np.full((len(torque), 1, READINGS), np.nan)
    readings[:, 0, :2] = seen.reading[:, j]
    usable = np.isfinite(torque) & ~seen.put_in
    reach = round(EDGE / seen.dt)
    near = np.convolve(~usable, np.ones(2 * reach // 10 + 1), 'same') > 0.5
    usable &= ~near
    usable[:round(BEGIN / seen.dt)] = usable[-reach:] = False
    few = slice(None, None, max(1, round(SLOWEST / seen.dt)))
    return Passage(name, seen.dt * (few.step or 1), readings[few],
                   np.where(usable, torque, 0.0)[few], doubt[few], usable[few],
                   about[few, j], motion.state[few, j, LINK_ANGLE],
                   motion.state[few, j, LINK_VELOCITY], motion.state[few, j, MOTOR_VELOCITY],
                   motion.acceleration[few, j, 0])


def _about(seen: Measurement, arm: Arm) -> Floats:
    """
    Return the motor torques about each sample (k, n) [N*m].

    They are as smooth as the accelerations beside them, before samples are left out.
    """
    return smoothed(np.stack([acting(column, joint.effort_lag) for column, joint
                              in zip(seen.command.T, arm.joints)], axis=1), seen.dt)
