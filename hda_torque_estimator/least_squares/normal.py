"""
Normal equations of a fit with priors: the step to the most likely unknowns within bounds.

Every fit of an arm ends here, whatever its likelihood. Columns of very different sizes are scaled
to one.
"""

import math

from hda_arm_sim.foundation.compiled import compiled
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
# Choices unless stated otherwise.
TINY = 1e-300           # least that is divided by: a column of zeros stays one
RIDGE = 1e-10           # of scaled columns, so that those that are alike share what they explain
_ON_BOUND = 1e-9        # of half the way between two bounds, by which rounding may pass one


def within(normal: Floats, right: Floats, now: Floats, bounds: tuple[Floats, Floats],
           ridge: float = 0.0) -> Floats:
    """
    Return the step (p,) that solves `normal` (p, p) times step = `right` (p,) within bounds.

    Unknowns are `now` (p,), and now + step stays between both `bounds` (p,), which may be
    infinite. What would pass its bound by most is held there, and the others step again. A
    `ridge` is added to the scaled equations where columns may be alike or zero.
    """
    scale = 1.0 / np.sqrt(np.maximum(normal.diagonal(), TINY))
    normal, right = normal * (scale[:, None] * scale), right * scale
    step, half = np.linalg.solve(raised(normal, ridge), right), _half(*bounds)
    if _beyond(now + step * scale, *bounds, half).max(initial=0.0) <= _ON_BOUND:
        return step * scale                             # as nearly always
    spread: Floats = np.asarray(np.linalg.inv(raised(normal, ridge)), np.float64)
    fixed = _stopped(spread, step.copy(), now, *bounds, scale, half)
    for _ in range(len(now) + 1):
        free = np.isnan(fixed)
        held = np.where(free, 0.0, fixed) / scale
        step = held.copy()
        step[free] = np.linalg.solve(raised(normal[np.ix_(free, free)], ridge),
                                     (right - normal @ held)[free])
        over = np.where(free, _beyond(now + step * scale, *bounds, half), 0.0)
        if over.max(initial=0.0) <= _ON_BOUND:
            break
        worst = np.argmax(over)
        fixed[worst] = np.clip(now + step * scale, *bounds)[worst] - now[worst]
    return step * scale


def raised(normal: Floats, more: Floats | float) -> Floats:
    """Return equations (p, p) with more on their diagonal: a ridge, or priors (p,)."""
    made = normal.copy()
    np.einsum('ii->i', made)[:] += more         # a view of the diagonal
    return made


@compiled
def _stopped(spread: Floats, step: Floats, now: Floats, low: Floats, high: Floats,
             scale: Floats, half: Floats) -> Floats:
    """
    Return the steps (p,) of those that stop at a bound, NaN for the others.

    `spread` (p, p) is the inverse of the scaled equations, `step` (p,) the free one; both are
    used up. Who stops leaves the inverse by one outer product: solving anew for each took half of
    the time of an arm with many numbers far off.
    """
    stopped = np.full(len(now), np.nan)
    for _ in range(len(now)):
        worst, most = -1, _ON_BOUND
        for k in range(len(now)):
            at = now[k] + step[k] * scale[k]
            over = max(low[k] - at, at - high[k]) / half[k]
            if math.isnan(stopped[k]) and over > most:
                worst, most = k, over
        if worst < 0 or not spread[worst, worst] > 0.0:
            break
        bound = low[worst] if now[worst] + step[worst] * scale[worst] < low[worst] else high[worst]
        stopped[worst] = bound - now[worst]
        row = spread[worst] / spread[worst, worst]
        step += row * (stopped[worst] / scale[worst] - step[worst])
        for k in range(len(now)):
            spread[k] -= spread[k, worst] * row
    return stopped


def _beyond(unknowns: Floats, low: Floats, high: Floats, half: Floats) -> Floats:
    """Return by how much unknowns (p,) pass a bound, over `half` the way between both."""
    return np.asarray(np.maximum(low - unknowns, unknowns - high) / half)


def _half(low: Floats, high: Floats) -> Floats:
    """Return half the way (p,) between two bounds, 1 where it is not finite."""
    half = 0.5 * (high - low)
    return np.where(np.isfinite(half) & (half > 0.0), half, 1.0)
