"""
Upsample a slow recording: the motion between its samples, and the command that acted there.

Laws switch and filters settle within milliseconds. Between samples that are further apart, angles
follow a cubic spline, which passes the samples. The command is either that of a loop of
the recording's own rate, which held it. Or the recording has every so many samples of a faster
loop. Then it is known at the samples alone, and joined by a spline as well; what it did in between
is noise.
"""

from collections.abc import MutableMapping
from dataclasses import replace
import math
from weakref import WeakKeyDictionary

from hda_arm_sim.foundation.arrays import Array
import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from .measurement import Measurement, without_gaps

# Choices unless stated otherwise.
# (source: bus cycles of robot drives are 1 ms and shorter)
FINE = 1e-3             # longest period of the grid [s]
_SAME_RATE = 0.02       # share by which clocks of one rate differ: 1.000002 ms is 1 ms
# (measured: 3.3e-3 to 0.2 with every 2nd to 20th sample of a loop, with all at most 6e-6 of
# healthy arms and 9e-4 of others; the bar is the geometric mean)
_HELD_LEFT = 1.7e-3     # of a command, that its loop's own readings and clock leave unexplained,
# (measured: up to 0.1 with all samples, so the motor is asked as well, `balances/commands.py`)
_CLOCKLESS = 0.05       # likewise of a log of 1 kHz, where nothing shows the clock
_READINGS, _COMMANDS = 8, 3     # before a command, that its loop may remember [samples]
_USUAL, _PASSES = 4.0, 4        # medians within which what is left is usual, and rounds to find it
_FAST = 3               # differences that leave of a motion what its loop answers at once

_KNOWN: MutableMapping[Measurement, bool] = WeakKeyDictionary()     # which were held


def parts_of(dt: float) -> int:
    """Return how many samples of the finer grid one of a period dt [s] has."""
    return max(1, math.ceil(dt / FINE - _SAME_RATE))


def finer(measurement: Measurement) -> Measurement:
    """Return one recording on a grid of at most a millisecond, as it is where that is its own."""
    parts = parts_of(measurement.dt)
    if parts == 1:
        return measurement
    held = is_held(measurement)
    command = (np.repeat(measurement.command, parts, axis=0) if held else
               between(measurement.command, parts))
    return replace(measurement, dt=measurement.dt / parts, parts=parts, command=command,
                   reading=between(measurement.reading, parts), absent=(),
                   past=np.repeat(measurement.past, parts), held=held,
                   reference=_finer_reference(measurement.reference, parts),
                   blind=tuple(part for place in measurement.blind
                               for part in range(parts * place, parts * (place + 1))))


def _finer_reference(reference: Array, parts: int) -> Array:
    """Return reference torques with so many samples for each, unknown ones as they are."""
    if not reference.size:
        return reference
    known = np.isfinite(reference)
    filled = np.stack([without_gaps(column) for column in reference.T], axis=1)
    return np.where(np.repeat(known, parts, axis=0), between(filled, parts), np.nan)


def between(values: Array, parts: int) -> Array:
    """Return values (k, ...) with so many samples for each (k parts, ...), along a spline."""
    if parts == 1:
        return values
    grid = np.arange(len(values) * parts) / parts
    return np.ascontiguousarray(CubicSpline(np.arange(float(len(values))), values)(grid))


def is_held(measurement: Measurement) -> bool:
    """
    Return whether commands were held from sample to sample: those of a loop of this rate.

    Such a loop answers the noise of readings that were recorded, and of no others. So what it
    recorded shows its quick commands. A clock that jitters moves readings, but not the speed that
    a loop takes from them. So stamps that know the jitter are part of what was recorded. Without
    them commands are known less well, and of a log that needs no finer grid more may be left. On a
    finer grid commands that are wrongly held act half a sample late. Those that are not known to
    be held are joined there, until motors show them held. What was asked before is known.
    """
    if measurement.held is not None:
        return measurement.held
    if measurement not in _KNOWN:
        _KNOWN[measurement] = _seems_held(measurement)
    return _KNOWN[measurement]


def _seems_held(measurement: Measurement) -> bool:
    """Return whether readings and clock leave next to nothing of quick commands unexplained."""
    quick = np.diff(measurement.command, _FAST, axis=0)
    seen = np.diff(_recorded(measurement), _FAST, axis=0)
    first = max(_READINGS, _COMMANDS)
    least = 2 * (seen.shape[2] * (_READINGS + 1) + _COMMANDS)
    if len(quick) <= least + first:
        return False
    free = _answered(measurement.command, first)
    left = []
    for joint in range(quick.shape[1]):
        columns = np.concatenate([
            *(seen[first - late:len(seen) - late, joint] for late in range(_READINGS + 1)),
            *(quick[first - late:len(quick) - late, joint, None]
              for late in range(1, _COMMANDS + 1))], axis=1)
        rows = free[:, joint] if free[:, joint].sum() > least else slice(None)
        left.append(_unexplained(quick[first:, joint][rows], columns[rows]))
    loose = not len(measurement.past) and parts_of(measurement.dt) == 1
    return min(left) < (_CLOCKLESS if loose else _HELD_LEFT)


def _answered(command: Array, first: int) -> NDArray[np.bool_]:
    """
    Return whether quick commands (k, n) and those before them answered readings.

    One that is as the last answers nothing: it is at its limit, or its sample was lost.
    """
    repeated = np.diff(command, axis=0) == 0.0
    near = sliding_window_view(repeated, first + _FAST, axis=0).any(axis=2)
    return np.asarray(~near)


def _recorded(measurement: Measurement) -> Array:
    """Return readings (k, n, c) of each joint and, if stamps show it, what jitter made of them."""
    reading, past = measurement.reading, measurement.past
    if not len(past):
        return reading
    speed = np.gradient(reading[:, :, 0], measurement.dt, axis=0)
    moved = past[:, None, None] * np.stack([speed, np.gradient(speed, axis=0)], axis=2)
    return np.concatenate([reading, moved], axis=2)


def _unexplained(values: Array, columns: Array) -> float:
    """Return the share of usual values (k,) that columns (k, p) do not explain, 0 of nothing."""
    scaled = columns / np.maximum(np.sqrt((columns ** 2).mean(axis=0)), 1e-300)
    left, kept = values, np.ones(len(values), bool)
    for _ in range(_PASSES):                    # lost samples and readings beside them are others
        left = values - scaled @ np.linalg.lstsq(scaled[kept], values[kept], rcond=None)[0]
        kept = np.abs(left) <= _USUAL * np.median(np.abs(left))
    return float(np.sum(left[kept] ** 2) / max(float(np.sum(values[kept] ** 2)), 1e-300))
