"""
What chance buys: how much the same law improves the score of a healthy arm's recording.

A law can follow noise. A lag of the current follows a command that was recorded with noise which
the motor never felt. A rate of the torque is made of the same readings as the residual. How
much that is worth depends on arm, motion and rate. So a healthy twin, recorded with as much noise,
is fitted as well: nothing of what is found there is there (eq:chance).
"""

from collections.abc import MutableMapping
from weakref import WeakKeyDictionary

from ..fitting.fit import Fitter, IMPOSSIBLE
from ..fitting.hypotheses import variant_of
from ...least_squares.term import Term

_KNOWN: MutableMapping[Fitter, dict[object, float]] = WeakKeyDictionary()


def by_chance(fitter: Fitter, term: Term) -> float:
    """Return by how much a term improves the score of the twin, at least 0."""
    healthy = fitter.healthy
    if healthy is None:
        return 0.0
    known = _KNOWN.setdefault(healthy, {})
    law = (term.place, *variant_of(term))
    if law not in known:
        known[law] = _improvement(healthy, term)
    return known[law]


def _improvement(healthy: Fitter, term: Term) -> float:
    try:
        found = healthy.refit(healthy.first, term)
    except IMPOSSIBLE:
        return 0.0
    return max(healthy.first.score - found.score, 0.0)
