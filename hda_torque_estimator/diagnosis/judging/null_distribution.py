"""
What chance buys: how much the same law improves the score of a healthy arm's recording.

A law can follow noise. A lag of the current follows a command that was recorded with noise which
the motor never felt. A rate of the torque is made of the same readings as the residual. How
much that is worth depends on arm, motion and rate. So a healthy twin, recorded with as much noise,
is fitted as well: nothing of what is found there is there (eq:chance).
"""

from collections.abc import MutableMapping, Sequence
from dataclasses import replace
from weakref import WeakKeyDictionary

import numpy as np

from .screening import shifts, solved
from ..fitting.derivatives import IMPOSSIBLE
from ..fitting.fit import Fit, Fitter
from ..fitting.hypotheses import variant_of
from ..fitting.solve import Columns, condense
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


class Chances:
    """What chance buys of many laws, to first order."""

    def __init__(self, healthy: Fitter | None) -> None:
        """Prepare the twin that `healthy` fits; without one, chance buys nothing."""
        self._fitter: Fitter | None = None
        if healthy is not None:
            first = healthy.first
            self._fitter = replace(healthy, balancer=healthy.balancer.thinned)
            self._fit: Fit = self._fitter.at(first.terms, 0, first.slopes)
            self._known: Columns = condense(self._fit.balance.residual, self._fit.columns,
                                            self._fitter.valid(self._fit.balance))

    def of(self, starts: Sequence[Term]) -> list[float]:
        """Return by how much each start of one effect improves the score of the twin."""
        if self._fitter is None:
            return [0.0] * len(starts)
        fitter, fit, known = self._fitter, self._fit, self._known
        nothing = np.zeros((*fit.balance.residual.shape, 0))
        before = solved(fitter, fit, known, nothing).score
        gains = {id(start): before - solved(fitter, fit, known, shift).score
                 for start, shift in shifts(fitter, fit, starts)}
        return [max(gains[id(start)], 0.0) for start in starts]
