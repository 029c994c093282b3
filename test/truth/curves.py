"""Curves that are drawn through points, as a table of measured friction is."""

import math

import numba


@numba.njit(cache=True, error_model='numpy')
def drawn_line(x: float, x1: float, y1: float, x2: float, y2: float, x3: float,
               y3: float) -> float:
    """Return straight lines from (0, 1) through three points, constant beyond the last."""
    if x < x1:
        return 1.0 + (y1 - 1.0) * x / x1
    if x < x2:
        return y1 + (y2 - y1) * (x - x1) / (x2 - x1)
    return y2 + (y3 - y2) * min(x - x2, x3 - x2) / (x3 - x2)


@numba.njit(cache=True, error_model='numpy')
def tabulated(x: float, x1: float, y1: float, x2: float, y2: float, x3: float,
              y3: float) -> float:
    """Return straight lines from the origin through three points and on, odd in x."""
    size = abs(x)
    if size < x1:
        y = y1 * size / x1
    elif size < x2:
        y = y1 + (y2 - y1) * (size - x1) / (x2 - x1)
    else:
        y = y2 + (y3 - y2) * (size - x2) / (x3 - x2)
    return math.copysign(y, x)
