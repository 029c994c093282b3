"""
The estimator's state as messages, at a steady rate that the stamps of the samples decide.

The node and the offline command choose the same samples and write the same texts.
"""

import math

from hda_arm_sim.model.arm import Arm
from hda_msgs_json.messages import EstimatorState, to_json
from hda_msgs_json.samples import TextSamples
import numpy as np
from numpy.typing import NDArray

from . import estimate
from .estimator import Estimates

Array = NDArray[np.float64]
STATE_RATE = 50.0               # default [Hz]


class Pacer:
    """Choose samples at a steady rate: the first one in every period of the stamps."""

    def __init__(self, rate: float) -> None:
        """Choose at most `rate` samples per second [Hz]."""
        self.period = max(1, round(1e9 / rate))
        self._last: int | None = None

    def due(self, stamp: int) -> bool:
        """Tell whether a sample is chosen, by its stamp [ns]."""
        before, self._last = self._last, stamp // self.period
        return self._last != before


def due_rows(stamps: NDArray[np.int64], rate: float) -> NDArray[np.intp]:
    """Return the indices of the samples that a `Pacer` of this rate [Hz] chooses."""
    periods = stamps // Pacer(rate).period
    return np.flatnonzero(np.diff(periods, prepend=periods[:1] - 1))


def estimator_state(arm: Arm, stamp: int, joints: Array, tip: Array, *,
                    taring: bool = False) -> EstimatorState:
    """Return the state after one sample from its results (n, RESULTS) and (TIP_RESULTS,)."""
    beyond = joints[:, estimate.BEYOND_RANGE] > 0.0
    singular = bool(tip[estimate.SINGULAR] > 0.0)

    def column(index: int) -> tuple[float, ...]:
        return _numbers(joints[:, index])

    return EstimatorState(
        stamp, arm.labels, column(estimate.TORSION), column(estimate.KINEMATIC_TORSION),
        column(estimate.TORQUE), column(estimate.TORQUE_DEVIATION),
        column(estimate.EXTERNAL_TORQUE), column(estimate.EXTERNAL_DEVIATION),
        tuple((~beyond).tolist()), _flags(arm, beyond, singular, taring),
        _numbers(tip[estimate.BASE_X:estimate.BASE_X + 2]),
        _numbers(tip[estimate.BASE_COVARIANCE:estimate.BASE_COVARIANCE + 4]),
        singular, *_numbers(tip[estimate.CONDITIONING:estimate.CONDITIONING + 1]))


def state_text(arm: Arm, stamp: int, joints: Array, tip: Array, *, taring: bool = False) -> str:
    """Return the state after one sample as the text of its message."""
    return to_json(estimator_state(arm, stamp, joints, tip, taring=taring))


def state_samples(arm: Arm, estimates: Estimates, rate: float = STATE_RATE) -> TextSamples:
    """Return the states of a recording at a rate [Hz]."""
    rows = due_rows(estimates.stamps, rate)
    stamps = estimates.stamps[rows]
    texts = (state_text(arm, stamp, estimates.joints[row], estimates.tip[row])
             for stamp, row in zip(stamps.tolist(), rows))
    return TextSamples(stamps, tuple(texts))


def _numbers(values: Array) -> tuple[float, ...]:
    """Return floats, NaN for what overflowed: a message has no infinity."""
    return tuple(value if math.isfinite(value) else math.nan for value in values.tolist())


def _flags(arm: Arm, beyond: NDArray[np.bool_], singular: bool, taring: bool) -> tuple[str, ...]:
    flags = [f'{label}: the torque exceeds the valid range of the torsion law'
             for label, too_far in zip(arm.labels, beyond) if too_far]
    if singular:
        flags.append('tip: the force along the last link cannot be observed in this posture')
    if taring:
        flags.append('a tare is under way')
    return tuple(flags)
