"""
Judge by one window whether two witnesses can both be right, and free the zero where they cannot.

A contradiction that no tolerance explains is most often a zero: nothing else has no bound of its
own. So the zero's variance grows by what is not explained, and the zero is learnt anew. It grows
at once while little is known of it, later only where the contradiction lasts. What then still
contradicts is no zero, and is reported. Equations: docs/estimation.md.
"""

from math import erf, sqrt
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.compiled import compiled, inlined
import numpy as np

from .fusion_memory import (AGAINST, AGREED, APART, CHANGED, DIFFERENCE, doubt_zero,
                            errors_learnt, EXCESS, FREED, gained, HEARD, IMPOSSIBLE, LASTING,
                            LONG, MISFIT, share, shift_apart, SLIPPED, UNEXPLAINED, usual_misfit)
from .route_errors import ERRORS, ZERO

# Choices unless stated otherwise.
_WORST = 1e4            # misfit that a single window may show
_PATIENCE = 1.0         # over which misfits are averaged, and contradictions endured [s]
_FAR = 10.0             # deviations of all errors, beyond which neither way corrects the other
_SUDDEN = 8.0           # deviations of what is known now; healthy arms: docs/estimation.md
_FRICTION = 2.0         # times the dry friction known, that a motor may have at most
_CERTAIN = 4.0          # deviations beyond what the motor can give
_EXPLAINED = 3.0        # deviations at which a difference is cut off, as in `learning.py`
_UNKNOWN = 0.5          # of its first variance: above that little is known of the zero


class AgreementWindow(NamedTuple):
    """One window's difference of both witnesses, and what is known of it."""

    difference: float           # [N*m]
    effect: Array               # of a sigma of each error on it (ERRORS,) [N*m]
    noise: float                # variance by readings [N^2*m^2]
    lawless: float              # variance of what no law describes [N^2*m^2]
    friction: float             # the dry friction known, at the link [N*m]
    settled: bool               # the motor turned one way long enough
    goes_on: bool               # and did not slow to less than half
    time: float                 # of its last half [s]
    lasting: float              # for which what no law describes is one error [s]


class Expected(NamedTuple):
    """A window's difference as before anything was learnt but a freed zero, and its variances."""

    alone: float                # [N*m]
    now: float                  # by what is known now [N^2*m^2]
    before: float               # and before [N^2*m^2]


@inlined
def expected(memory: Array, window: AgreementWindow) -> Expected:
    """Return what a window's difference was before, and how large its square may be."""
    learnt, effect = errors_learnt(memory), window.effect
    freed = memory[FREED] * effect[ZERO] * learnt[ZERO]
    first = np.dot(effect, effect) + window.noise + window.lawless
    return Expected(window.difference + np.dot(effect, learnt) - freed,
                    first + effect @ (gained(memory) @ effect), first)


@compiled
def hold_against(memory: Array, window: AgreementWindow) -> None:
    """
    Judge a window, and free the zero if its difference is not to be explained.

    The dry friction is taken for unknown: only what a motor cannot give, with no friction or
    twice as much, is impossible. Standing still it holds either way.
    """
    known = expected(memory, window)
    likely = max(known.now, known.before)
    slack = window.friction * (_FRICTION - 1.0 if window.settled else _FRICTION + 1.0)
    excess = max(abs(known.alone) - slack - _CERTAIN * np.sqrt(likely), 0.0)
    memory[AGAINST] = memory[AGAINST] + window.time if excess > 0.0 else 0.0
    unknown = 1.0 + gained(memory)[ZERO, ZERO] > _UNKNOWN
    fresh = unknown and memory[HEARD] < _PATIENCE       # a zero that agreed before did not jump
    if not window.settled and unknown and window.effect[ZERO] != 0.0 and (
            likely > slack ** 2 if excess == 0.0 else fresh):
        _confine(memory, window, slack, excess)
        return
    counts = window.settled and window.goes_on
    if counts and excess > 0.0 and (fresh or memory[AGAINST] >= _PATIENCE):
        if not fresh:
            memory[CHANGED] = LONG                      # whether a zero explains it, shows later
        _free(memory, known.alone ** 2 - likely, window.effect[ZERO])
        return
    memory[EXCESS] = excess
    memory[IMPOSSIBLE] = _left(memory[IMPOSSIBLE], excess > 0.0, window.time)
    if counts:
        far = known.alone ** 2 > _FAR ** 2 * likely
        memory[APART] = _left(memory[APART], far, window.time)
        _compare(memory, window, known)


@inlined
def _left(time: float, contradicts: bool, passed: float) -> float:
    """Return the time for which the two ways must still agree [s]."""
    return max(time - passed, AGREED if contradicts else 0.0)


@inlined
def _free(memory: Array, unexplained: float, effect: float) -> None:
    """Let the zero's variance explain a difference, and judge anew what comes, (eq:free-zero)."""
    if effect == 0.0:
        return
    doubt_zero(memory, unexplained / effect ** 2)
    memory[AGAINST] = memory[MISFIT] = memory[LASTING] = memory[HEARD] = 0.0
    memory[EXCESS] = 0.0
    memory[FREED] = 1.0


@compiled
def _confine(memory: Array, window: AgreementWindow, slack: float, excess: float) -> None:
    """
    Learn at rest that the difference lies within a slack either way [N*m], (eq:confined).

    The normal distribution of the difference, cut off at both ends, has another mean and variance.
    The errors take their part in that by what they contribute.
    """
    if excess > 0.0:
        _free(memory, (abs(window.difference) - slack) ** 2, window.effect[ZERO])
    gain, learnt = gained(memory), errors_learnt(memory)
    spread = window.effect + gain @ window.effect
    variance = window.effect @ spread + window.noise + window.lawless
    mean, left = cut_off(window.difference, sqrt(variance), slack)
    change = spread * ((window.difference - mean) / variance)
    learnt += change
    for i in range(ERRORS):
        for k in range(ERRORS):
            gain[i, k] -= spread[i] * spread[k] / variance * (1.0 - left)
    shift_apart(memory, np.dot(window.effect, change))


@compiled
def cut_off(mean: float, deviation: float, most: float) -> tuple[float, float]:
    """Return mean and share of variance left of a normal distribution cut off at +-`most`."""
    low, high = (-most - mean) / deviation, (most - mean) / deviation
    inside = 0.5 * (erf(high / np.sqrt(2.0)) - erf(low / np.sqrt(2.0)))
    if inside < 1e-12:
        return min(max(mean, -most), most), 0.0
    at_low, at_high = _density(low), _density(high)
    shift = (at_low - at_high) / inside
    left = 1.0 + (low * at_low - high * at_high) / inside - shift ** 2
    return mean + deviation * shift, min(max(left, 0.0), 1.0)


@inlined
def _density(x: float) -> float:
    return np.exp(-0.5 * x * x) / np.sqrt(2.0 * np.pi)


@compiled
def _compare(memory: Array, window: AgreementWindow, known: Expected) -> None:
    """Follow how much larger differences are than expected, (eq:misfit)."""
    square = window.difference ** 2
    misfit = square / known.now
    sudden = (misfit > _SUDDEN ** 2 * max(usual_misfit(memory), 1.0)
              and square > _CERTAIN ** 2 * known.before)
    memory[CHANGED] = _left(memory[CHANGED], sudden, window.time)
    if misfit <= 1.0:
        memory[SLIPPED] = max(memory[SLIPPED] - window.time, 0.0)
    if np.isfinite(misfit):
        part, long = share(window.time, _PATIENCE), share(window.time, LONG)
        memory[MISFIT] += part * (min(misfit, _WORST) - memory[MISFIT])
        memory[LASTING] += long * (min(misfit, _WORST) - memory[LASTING])
        memory[HEARD] += window.time
        memory[DIFFERENCE] += part * (window.difference - memory[DIFFERENCE])
        beyond = max(square - _EXPLAINED ** 2 * known.now, 0.0)
        memory[UNEXPLAINED] += part * (beyond - memory[UNEXPLAINED])
