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
from typing import NamedTuple
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
# (measured: at most 0.010 of 69 of 72 loops of the log's rate, with every 2nd to 20th sample of a
# loop at least 0.19 of 144, and 0.036 of one more; the bar is between)
_ANSWERED = 0.017       # of what readings after a command leave of it, that those before it leave
# (measured: with every 2nd sample at least 4.9e-3, as what was read then may be from after it)
_AT_ONCE = 2e-3         # likewise with those that were read with the command
# (measured: up to 0.1 with all samples, so the motor is asked as well, `balances/commands.py`)
_CLOCKLESS = 0.05       # of a command, that its readings leave in a log of 1 kHz without clock
_READINGS, _COMMANDS = 8, 3     # before a command, that its loop may remember [samples]
_USUAL, _PASSES = 4.0, 4        # medians within which what is left is usual, and rounds to find it
_FAST = 3               # differences that leave of a motion what its loop answers at once
_ENOUGH = 20_000        # samples that suffice, evenly over a recording

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

    Such a loop answers the noise of readings that were recorded, and of no others. So its quick
    commands follow from what was read before them, and not after (eq:answered-before). What is
    quick in a smooth motion follows from both, whoever held it. A clock that jitters moves
    readings, but not the speed that a loop takes from them. So stamps that know the jitter are
    part of what was recorded. Without them commands are known less well, and of a log that needs
    no finer grid more may be left. On a finer grid commands that are wrongly held act half a
    sample late. Those that are not known to be held are joined there, until motors show them held.
    What was asked before is known.
    """
    if measurement.held is not None:
        return measurement.held
    if measurement not in _KNOWN:
        _KNOWN[measurement] = _seems_held(measurement)
    return _KNOWN[measurement]


def _seems_held(measurement: Measurement) -> bool:
    """Return whether what was read before quick commands of a joint explains them."""
    asked = (_QuickCommands.of(measurement, joint) for joint in range(len(measurement.labels)))
    if not len(measurement.past) and parts_of(measurement.dt) == 1:
        return any(one.left(0) < _CLOCKLESS for one in asked if one)
    return any(one.answer_readings() for one in asked if one)


class _QuickCommands(NamedTuple):
    """What is quick in the commands of a joint, and in what was read of it."""

    command: Array              # (k,)
    reading: Array              # (k, c)
    rows: NDArray[np.int64]     # of commands that answered something, away from the ends

    @classmethod
    def of(cls, measurement: Measurement, joint: int) -> '_QuickCommands | None':
        """Return what is quick at a joint, None where a recording is too short for that."""
        command = np.diff(measurement.command[:, joint], _FAST)
        reading = np.diff(_recorded(measurement, joint), _FAST, axis=0)
        first = max(_READINGS + 1, _COMMANDS)
        least = 2 * (reading.shape[1] * (_READINGS + 1) + _COMMANDS)
        if len(command) <= least + 2 * first:
            return None
        free = _answered(measurement.command[:, joint], first)[:-first]
        rows = first + np.flatnonzero(free if free.sum() > least else np.ones_like(free))
        return cls(command, reading, rows[::math.ceil(len(rows) / _ENOUGH)])

    def answer_readings(self) -> bool:
        """Return whether readings before commands explain them, and those after do not."""
        after = self.left(1, -1)
        return self.left(1) < _ANSWERED * after or self.left(0) < _AT_ONCE * after

    def left(self, since: int, sense: int = 1) -> float:
        """Return the share that readings leave, since so many samples before, or after (-1)."""
        return _unexplained(self.command[self.rows], np.concatenate([
            *(self.reading[self.rows - sense * late]
              for late in range(since, since + _READINGS + 1)),
            *(self.command[self.rows - sense * late, None]
              for late in range(1, _COMMANDS + 1))], axis=1))


def _answered(command: Array, first: int) -> NDArray[np.bool_]:
    """
    Return whether quick commands of a joint (k,) and those before them answered readings.

    One that is as the last answers nothing: it is at its limit, or its sample was lost.
    """
    repeated = np.diff(command) == 0.0
    return np.asarray(~sliding_window_view(repeated, first + _FAST).any(axis=1))


def _recorded(measurement: Measurement, joint: int) -> Array:
    """Return readings (k, c) of a joint and, if stamps show it, what jitter made of them."""
    reading, past = measurement.reading[:, joint], measurement.past
    if not len(past):
        return reading
    speed = np.gradient(reading[:, 0], measurement.dt)
    return np.column_stack([reading, past * speed, past * np.gradient(speed)])


def _unexplained(values: Array, columns: Array) -> float:
    """Return the share of usual values (k,) that columns (k, p) do not explain, 0 of nothing."""
    scaled = columns / np.maximum(np.sqrt((columns ** 2).mean(axis=0)), 1e-300)
    left, kept = values, np.ones(len(values), bool)
    for _ in range(_PASSES):                    # lost samples and readings beside them are others
        left = values - scaled @ np.linalg.lstsq(scaled[kept], values[kept], rcond=None)[0]
        kept = np.abs(left) <= _USUAL * np.median(np.abs(left))
    return float(np.sum(left[kept] ** 2) / max(float(np.sum(values[kept] ** 2)), 1e-300))
