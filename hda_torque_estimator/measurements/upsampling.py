"""
Upsample a slow recording: the motion between its samples, and the command that acted there.

Laws switch and filters settle within milliseconds. Between samples that are further apart, angles
follow a cubic spline, which passes what the samples tell. The command is either that of a loop of
the recording's own rate, which held it. Or the recording has every so many samples of a faster
loop. Then it is known at the samples alone, and joined by a spline as well; what it did in between
is noise.
"""

from dataclasses import replace
import math

from hda_arm_sim.foundation.arrays import Array
import numpy as np
from scipy.interpolate import CubicSpline

from .measurement import Measurement

# Choices unless told otherwise.
# (source: bus cycles of robot drives are 1 ms and shorter)
FINE = 1e-3             # longest period of the grid [s]
_SAME_RATE = 0.02       # share by which clocks of one rate differ: 1.000002 ms is 1 ms
_HELD_LEFT = 0.05       # of a command, that its loop's own readings leave untold
# (measured: 0.13 to 0.23 with every 4th to 8th sample of a loop, 0.000 to 0.003 with all)
_READINGS, _COMMANDS = 4, 3     # before a command, that its loop may remember [samples]
_USUAL, _PASSES = 4.0, 4        # medians within which what is left is usual, and rounds to find it
_FAST = 3               # differences that leave of a motion what its loop answers at once


def parts_of(dt: float) -> int:
    """Return how many samples of the finer grid one of a period dt [s] has."""
    return max(1, math.ceil(dt / FINE - _SAME_RATE))


def finer(measurement: Measurement) -> Measurement:
    """Return one recording on a grid of at most a millisecond, as it is where that is its own."""
    parts = parts_of(measurement.dt)
    if parts == 1:
        return measurement
    command = (np.repeat(measurement.command, parts, axis=0) if is_held(measurement) else
               between(measurement.command, parts))
    return replace(measurement, dt=measurement.dt / parts, parts=parts, command=command,
                   reading=between(measurement.reading, parts), absent=(), past=np.zeros(0))


def between(values: Array, parts: int) -> Array:
    """Return values (k, ...) with so many samples for each (k parts, ...), along a spline."""
    if parts == 1:
        return values
    grid = np.arange(len(values) * parts) / parts
    return np.ascontiguousarray(CubicSpline(np.arange(float(len(values))), values)(grid))


def is_held(measurement: Measurement) -> bool:
    """
    Tell whether commands were held from sample to sample: those of a loop of this rate.

    Such a loop answers the noise of readings that were recorded, and of no others. So what it
    recorded tells its quick commands.
    """
    quick = np.diff(measurement.command, _FAST, axis=0)
    seen = np.diff(measurement.reading, _FAST, axis=0)
    first = max(_READINGS, _COMMANDS)
    if len(quick) <= 2 * (2 * (_READINGS + 1) + _COMMANDS) + first:
        return False
    left = [_untold(quick[first:, joint], np.concatenate([
        *(seen[first - late:len(seen) - late, joint] for late in range(_READINGS + 1)),
        *(quick[first - late:len(quick) - late, joint, None]
          for late in range(1, _COMMANDS + 1))], axis=1)) for joint in range(quick.shape[1])]
    return min(left) < _HELD_LEFT


def _untold(values: Array, columns: Array) -> float:
    """Return the share of usual values (k,) that columns (k, p) do not tell, 0 of nothing."""
    scaled = columns / np.maximum(np.sqrt((columns ** 2).mean(axis=0)), 1e-300)
    left, kept = values, np.ones(len(values), bool)
    for _ in range(_PASSES):                    # lost samples and readings beside them are others
        left = values - scaled @ np.linalg.lstsq(scaled[kept], values[kept], rcond=None)[0]
        kept = np.abs(left) <= _USUAL * np.median(np.abs(left))
    return float(np.sum(left[kept] ** 2) / max(float(np.sum(values[kept] ** 2)), 1e-300))
