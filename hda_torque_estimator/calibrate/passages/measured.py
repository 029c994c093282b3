"""What a calibration reads of one recording, joint by joint."""

from typing import NamedTuple

from hda_msgs_json.errors import HdaError
from hda_msgs_json.samples import JointSamples, WrenchSamples
import numpy as np
from numpy.typing import NDArray

from ...samples.readings import reading_names, readings, SIDES

Floats = NDArray[np.float64]

# Choices unless told otherwise.
FEWEST = 20         # samples of a joint, fewer say nothing about any parameter


class CalibrationError(HdaError):
    """Recordings from which nothing can be calibrated."""


class Measured(NamedTuple):
    """One joint in one recording, k samples."""

    recording: str
    stamps: NDArray[np.int64]       # (k,) [ns]
    readings: Floats                # (k, 1, READINGS)
    reference: Floats               # (k,) [N*m]

    def varies(self) -> float:
        """Return the deviation of the reference torque from its mean [N*m rms]."""
        return float(self.reference.std())


def measured(recording: str, joint: str, states: JointSamples,
             reference: WrenchSamples) -> Measured | None:
    """
    Return a joint where both its angles and its reference torque are known, None if nowhere.

    The reference may come at any rate: it is interpolated between its stamps, never beyond them.
    """
    if not {*reading_names([joint])} <= {*states.names} or len(reference) < 2:
        return None
    found = readings([joint], states)
    torque = np.interp(states.stamps, reference.stamps, reference.torque[:, 2], np.nan, np.nan)
    later = np.diff(states.stamps, prepend=np.iinfo(np.int64).min // 2) > 0
    used = np.isfinite(found[:, 0, :SIDES]).all(axis=1) & np.isfinite(torque) & later
    if used.sum() < FEWEST:
        return None
    return Measured(recording, states.stamps[used], found[used], torque[used])
