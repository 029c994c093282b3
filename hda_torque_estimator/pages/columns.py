"""Columns of numbers as a page holds them: long ones packed, as digits take thrice the room."""

import base64
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Column = float | list[float | None] | dict[str, Any]
# Choices unless stated otherwise.
_FEW = 64               # numbers that are written, not packed: their digits take less room
_FIGURES = 5            # of a number that is written


def column(values: Array, *, is_axis: bool = False, is_log: bool = False) -> Column:
    """
    Return numbers (k,) as the script of a page reads them, NaN as a gap.

    A constant is one number. A long column is packed into 65535 levels from its least to its
    largest number, and an axis into 2^32 - 1. One that is shown by decades is written, as levels
    would lose what is small.
    """
    if len(values) and np.isfinite(values[0]) and bool((values == values[0]).all()):
        return float(values[0])
    if len(values) <= _FEW or is_log:
        return written(values)
    return _packed(values, '<u4' if is_axis else '<u2')


def _packed(values: Array, kind: str) -> dict[str, Any]:
    """Return the levels of a column, the last of them a gap, as text of 6 bits a letter."""
    known = np.isfinite(values)
    last = np.iinfo(kind).max
    low, high = (float(f(values[known])) if known.any() else 0.0 for f in (np.min, np.max))
    step = (high - low) / (last - 1)
    places = np.rint((values[known] - low) / step) if step > 0.0 else 0.0
    levels = np.full(len(values), last, np.dtype(kind))
    levels[known] = places
    return {'low': low, 'step': step, 'bytes': levels.itemsize,
            'data': base64.b64encode(levels.tobytes()).decode()}


def written(values: Array) -> list[float | None]:
    """Return numbers to be written, with five figures each; NaN is None."""
    return [float(f'{value:.{_FIGURES}g}') if math.isfinite(value) else None
            for value in values.tolist()]
