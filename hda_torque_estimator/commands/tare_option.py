"""`hda estimate --tare A:B`: the zero of the torsion, taken from a stretch of a recording."""

import argparse
import math
from typing import Any, NamedTuple

from hda_arm_sim.model.arm import Arm
from hda_msgs_json.errors import HdaError
import numpy as np
from numpy.typing import NDArray

from ..estimating.estimates import Estimates
from ..estimating.estimator import Estimator
from ..measurements.recorded_readings import RecordedReadings
from ..samples.readings import LINK_READING, MOTOR_READING

REST = 1e-3             # angle at the output by which an arm at rest may sway (choice) [rad]
COUNTS = 4.0            # and counts of its encoders (choice)


class TareError(HdaError):
    """A stretch from which no zero can be taken."""


class TareStretch(NamedTuple):
    """A part of a recording, from its start [s]."""

    begin: float
    end: float

    def __str__(self) -> str:
        """Return the stretch in words."""
        return f'{self.begin:g} to {self.end:g} s'


def stretch(text: str) -> TareStretch:
    """Return the stretch that an option names; raises ArgumentTypeError."""
    try:
        begin, end = (float(part) for part in text.split(':'))
    except ValueError:
        begin = end = math.nan
    if not 0.0 <= begin < end < math.inf:
        raise argparse.ArgumentTypeError(
            f'it must be A:B with 0 <= A < B in seconds from the start, got {text!r:.60}')
    return TareStretch(begin, end)


def tare_stamps(asked: TareStretch | None, stamps: NDArray[np.int64]) -> tuple[int, int]:
    """Return the stamps between which a zero is taken [ns]; raises TareError."""
    if asked is None or not len(stamps):
        return 0, 0
    first = int(stamps[0])
    duration = (int(stamps[-1]) - first) * 1e-9
    if asked.end > duration * len(stamps) / max(len(stamps) - 1, 1):    # with the last period
        raise TareError(f'--tare {asked} lies outside the recording, which lasts {duration:.3f} s')
    return first + round(asked.begin * 1e9), first + round(asked.end * 1e9)


def check_rest(asked: TareStretch, arm: Arm, tare: tuple[int, int],
               found: RecordedReadings) -> None:
    """Raise TareError unless the arm rests between two stamps [ns]."""
    rows = (found.stamps >= tare[0]) & (found.stamps < tare[1])
    angles = found.reading[rows][:, :, (MOTOR_READING, LINK_READING)]
    angles = angles[np.isfinite(angles).all(axis=(1, 2))]
    if not len(angles):
        raise TareError(f'--tare {asked} holds no sample that can be used')
    for joint, motor, link in zip(arm.joints, *np.ptp(angles, axis=0).T):
        for side, sway, step in (('motor', motor / joint.ratio,
                                  joint.motor_encoder.step / joint.ratio),
                                 ('link', link, joint.link_encoder.step)):
            if sway > REST + COUNTS * step:
                raise TareError(f'--tare {asked}: {joint.label} moves by {sway:.3g} rad ({side} '
                                'side, at the output); take a stretch in which the arm rests')


def taken_zero(asked: TareStretch | None, estimator: Estimator, estimates: Estimates,
               tare: tuple[int, int]) -> dict[str, Any]:
    """Return the zero of each joint [rad at the output], if it was taken; raises TareError."""
    if asked is None:
        return {}
    rows = slice(*np.searchsorted(estimates.stamps, tare).tolist())
    believed = np.isfinite(estimates.torque[rows]).all(axis=1)
    if not believed.any():
        raise TareError(f'--tare {asked} holds no sample that can be believed')
    return {'begin': asked.begin, 'end': asked.end, 'samples': int(believed.sum()),
            'zero': dict(zip(estimator.arm.labels, estimator.zero.tolist()))}


def tare_words(taken: dict[str, Any]) -> str:
    """Return one line on a zero that was taken."""
    zeros = ', '.join(f'{label} {value:.3g} rad' for label, value in taken['zero'].items())
    return (f'zero of the torsion from {taken["samples"]} samples, '
            f'{TareStretch(taken["begin"], taken["end"])}: {zeros}')
