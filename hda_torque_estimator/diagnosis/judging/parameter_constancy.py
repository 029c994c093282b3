"""
Causes that are as large in every stretch of a recording, whatever else is left.

An arm may have so many small imperfections that no search finds the last of them. Their rest is
held against no cause beside it that is steady. Fitted again in each stretch alone, beside all else
that is free, such a cause has the same size (eq:steady). One that stands in for another follows
that more here and less there. So it goes, unless others are less steady without it. Only where
many causes are steady a rest is one imperfection more. Each must also be the best of those that it
is confused with, beside all others.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from hda_arm_sim.foundation.arrays import Array
import numpy as np

from .forward_selection import next_cause
from .law_forms import reformed
from .search import SearchResult
from ..fitting.fit import Fit, Fitter
from ..fitting.hypotheses import HYPOTHESES
from ..fitting.solve import condense, prior_weights, step_of
from ...least_squares.normal import TINY
from ...least_squares.term import Place, Term
from ...significance import HARDLY, MANY

# Numerics; choices unless stated otherwise.
_STRETCHES = 12         # parts of a recording in which sizes are compared

# Share of its size that a cause varies by, from which it is not steady: it is sure to be at half
# of it, where it hardly varies. Of two arms with fifteen, 11 of 14 right causes varied by less
# than that half, and stand-ins by more, up to 8, but for a kinematic error in place of an
# eccentric encoder.
_VARIES = 2.0 * HARDLY


def unsteady_shares(fitter: Fitter, fit: Fit) -> dict[Place, float]:
    """Return by how much the size of each cause of a fit varies, over what is not steady."""
    return {term.place: _variation(fitter, fit, term) / _VARIES for term in fit.accepted}


def steady_shares(fitter: Fitter, fit: Fit,
                  known: Mapping[Place, float] | None = None) -> Mapping[Place, float]:
    """
    Return the shares of the causes of a fit that are steady, none where these are not many.

    What is `known` by `only_steady` is not asked again: there were many. The others are no less
    steady where one of them is gone.
    """
    if known is None and len(fit.accepted) < MANY:
        return {}
    shares = unsteady_shares(fitter, fit) if known is None else known
    steady = {place: share for place, share in shares.items() if share <= 1.0}
    return steady if known is not None or len(steady) >= MANY else {}


def only_steady(fitter: Fitter, found: SearchResult, names: Sequence[str]) -> SearchResult | None:
    """
    Return what was found without causes in whose place others are steady; None where few are.

    Each that is steady is the best, beside all others, of those effects of these `names` that it
    is confused with.
    """
    kept = _steady(fitter, found)
    if kept is None:
        return None
    for place, share in dict(kept.steady or {}).items():
        if share <= 1.0:
            kept = _best_of_alike(fitter, kept, place, names)
    return _steady(fitter, kept)


def _steady(fitter: Fitter, found: SearchResult) -> SearchResult | None:
    """
    Return what was found without what is not steady, None where few are steady beside each other.

    The least steady goes first: what leant on it may stand by itself without it. What others are
    less steady without is no stand-in, and stays.
    """
    everywhere = fitter.everywhere()
    best: SearchResult | None = None
    while len(found.last.accepted) >= MANY:
        shares = unsteady_shares(everywhere, everywhere.settled(found.last))
        found = replace(found, steady=shares)
        if _count(found) < _count(best):
            break
        best, worst = found, max(shares, key=shares.__getitem__)
        if shares[worst] <= 1.0:
            break
        found = found.keeping(fitter, [term for term in found.last.accepted
                                       if term.place != worst])
    return best if _count(best) >= MANY else None


def _count(found: SearchResult | None) -> int:
    """Return how many of the causes that were found are steady, as far as that was asked."""
    shares = found.steady if found else None
    return sum(share <= 1.0 for share in (shares or {}).values())


def _best_of_alike(fitter: Fitter, found: SearchResult, place: Place,
                   names: Sequence[str]) -> SearchResult:
    """Return what was found with the best of what the cause at a place is confused with there."""
    fit, reasons = found.last, found.reasons()
    own, = (term for term in fit.accepted if term.place == place)
    others = fit.causes_beside(own)
    step = next_cause(fitter, found.first, fitter.without(fit, own), _alike(own.name, names))
    if step is None:
        return found.keeping(fitter, others)
    best, reason = step
    if best.accepted[-1].place == place:
        return replace(found, evidence=tuple(
            reason if term is own else reasons[term.place] for term in fit.accepted))
    return SearchResult(found.first, best, (*(reasons[term.place] for term in others), reason),
                        names=found.names)


def _alike(name: str, names: Sequence[str]) -> list[str]:
    """Return which of these effects one is confused with, and itself."""
    return [other for other in names if other == name or other in HYPOTHESES[name].alike
            or name in HYPOTHESES[other].alike]


def _variation(fitter: Fitter, fit: Fit, term: Term) -> float:
    """
    Return by which share the size of a cause varies from stretch to stretch (eq:steady).

    All causes have the forms of their laws that fit best: one that warms is as large as it is.
    """
    best = reformed(fitter, fit)
    weight = np.where(fitter.valid(fit.balance), 1.0 / best.variance, 0.0)
    lacking = fitter.residual(fitter.terms_without(fit, term), fit.slopes.noise)
    own = _alone(fitter, fit, term, fit.balance.residual - lacking)
    starts = np.linspace(0, len(own), _STRETCHES, endpoint=False).astype(int)
    power, against = (np.add.reduceat((own * weight * other).sum(axis=1), starts)
                      for other in (own, best.balance.residual))
    varies = (against ** 2 / np.maximum(power, TINY)).sum() / max(power.sum(), TINY)
    return float(np.sqrt(varies))


def _alone(fitter: Fitter, fit: Fit, term: Term, does: Array) -> Array:
    """Return what a cause `does` (m, c) that nothing else in the fit does."""
    keep = ~fit.own(term)
    columns = fit.columns[:, :, keep]
    free = np.full(columns.shape[2], np.inf)
    step = step_of(condense(does, columns, fitter.valid(fit.balance)),
                   fitter.effective / fit.variance, prior_weights(fit.deviations[keep]),
                   np.zeros_like(free), (-free, free))
    return np.asarray(does + columns @ step)
