"""What a calibration reads of one recording, joint by joint."""

from typing import NamedTuple

from hda_msgs_json.samples import JointSamples, WrenchSamples
from hda_msgs_json.topics import motor_name
import numpy as np
from numpy.typing import NDArray

from .. import estimate

Floats = NDArray[np.float64]

FEWEST = 20         # samples of a joint, fewer say nothing about any parameter


class CalibrationError(ValueError):
    """Recordings from which nothing can be calibrated."""


class Measured(NamedTuple):
    """One joint in one recording: stamps [ns] (k,), readings (k, 1, READINGS), torque [N*m] (k,)."""

    recording: str
    stamps: NDArray[np.int64]
    readings: Floats
    reference: Floats

    def varies(self) -> float:
        """Return the deviation of the reference torque from its mean [N*m rms]."""
        return float(self.reference.std())


def measured(recording: str, joint: str, states: JointSamples,
             reference: WrenchSamples) -> Measured | None:
    """
    Return a joint where both its angles and its reference torque are known, None if nowhere.

    The reference may come at any rate: it is interpolated between its stamps, never beyond them.
    """
    names = (motor_name(joint), joint)
    if not {*names} <= {*states.names} or len(reference) < 2:
        return None
    both = states.select(names)
    readings = np.empty((len(both), 1, estimate.READINGS))
    readings[:, 0, [estimate.MOTOR_READING, estimate.LINK_READING]] = both.position
    readings[:, 0, [estimate.MOTOR_RATE, estimate.LINK_RATE]] = both.velocity
    torque = np.interp(both.stamps, reference.stamps, reference.torque[:, 2], np.nan, np.nan)
    later = np.diff(both.stamps, prepend=np.iinfo(np.int64).min // 2) > 0
    used = np.isfinite(both.position).all(axis=1) & np.isfinite(torque) & later
    if used.sum() < FEWEST:
        return None
    return Measured(recording, both.stamps[used], readings[used], torque[used])
