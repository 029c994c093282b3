"""
Normal equations of a fit with priors: the step to the most likely unknowns within bounds.

Every fit of an arm ends here, whatever its likelihood. Columns of very different sizes are scaled
to one.
"""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
# Choices unless told otherwise.
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
    scale = 1.0 / np.sqrt(np.maximum(np.diag(normal), TINY))
    normal, right = normal * np.outer(scale, scale), right * scale
    step = np.linalg.solve(normal + ridge * np.eye(len(now)), right)
    if _beyond(now + step * scale, *bounds).max(initial=0.0) <= _ON_BOUND:
        return step * scale                             # as nearly always
    fixed = np.full(len(now), np.nan)
    for _ in range(len(now) + 1):
        free = np.isnan(fixed)
        held = np.where(free, 0.0, fixed) / scale
        firm = normal[np.ix_(free, free)] + ridge * np.eye(free.sum())
        step = held.copy()
        step[free] = np.linalg.solve(firm, (right - normal @ held)[free])
        over = np.where(free, _beyond(now + step * scale, *bounds), 0.0)
        if over.max(initial=0.0) <= _ON_BOUND:
            break
        worst = np.argmax(over)
        fixed[worst] = np.clip(now + step * scale, *bounds)[worst] - now[worst]
    return step * scale


def _beyond(unknowns: Floats, low: Floats, high: Floats) -> Floats:
    """Return by how much unknowns (p,) pass a bound, over half the way between both if finite."""
    half = 0.5 * (high - low)
    return np.asarray(np.maximum(low - unknowns, unknowns - high)
                      / np.where(np.isfinite(half) & (half > 0.0), half, 1.0))
