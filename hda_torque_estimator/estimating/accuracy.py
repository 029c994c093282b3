"""Errors of estimates against what was true or measured by another sensor."""

from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
import numpy as np
from numpy.typing import NDArray

Stamps = NDArray[np.int64]


class EstimateErrors(NamedTuple):
    """How far an estimate is from a reference; without common times all are NaN."""

    rms: float
    rms_without_mean: float         # with the mean error removed
    mean_absolute: float
    largest: float


def errors(stamps: Stamps, estimate: Array, reference_stamps: Stamps,
           reference: Array) -> EstimateErrors:
    """
    Return the errors of an estimate (k,) against a reference (m,) at any rate.

    The reference is joined by straight lines and compared where both are known.
    """
    known = np.isfinite(reference)
    times, values = reference_stamps[known], reference[known]
    inside = np.isfinite(estimate)
    if len(times):
        inside &= (stamps >= times[0]) & (stamps <= times[-1])
    if not len(times) or not inside.any():
        return EstimateErrors(np.nan, np.nan, np.nan, np.nan)
    start = times[0]
    error = estimate[inside] - np.interp(stamps[inside] - start, times - start, values)
    return EstimateErrors(float(np.sqrt(np.mean(error ** 2))), float(error.std()),
                          float(np.abs(error).mean()), float(np.abs(error).max()))
