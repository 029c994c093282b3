"""How large each of several causes would be that explain a recording equally well."""

from collections.abc import Sequence
from dataclasses import replace

from .verdict import numbers_of
from ..findings.report import Alike, Candidate
from ..fitting.derivatives import IMPOSSIBLE
from ..fitting.fit import Fit, Fitter
from ..fitting.hypotheses import HYPOTHESES, terms_of
from ...least_squares.term import Place, Term


def with_sizes(fitter: Fitter, fit: Fit, pairs: Sequence[Alike]) -> tuple[Alike, ...]:
    """Return pairs with the size of each cause: as a fit has it, or fitted in its stead."""
    return tuple(replace(pair, candidates=tuple(_sized(fitter, fit, pair))) for pair in pairs)


def _sized(fitter: Fitter, fit: Fit, pair: Alike) -> list[Candidate]:
    """Return the cause of a pair that a fit holds, and the others in its place."""
    holder = next((term for term in fit.accepted if term.place in pair.effects), None)
    if holder is None:
        return []
    sized = [_candidate(fitter, fit, holder, pair, True)]
    without = fitter.fit([term for term in fit.accepted if term is not holder], fit.nuisance)
    for place in pair.effects:
        if place == holder.place or place[0] not in HYPOTHESES:
            continue
        other = instead(fitter, without, place)
        if other is not None:
            sized.append(_candidate(fitter, other, other.accepted[-1], pair, False))
    return sized


def instead(fitter: Fitter, without: Fit, place: Place) -> Fit | None:
    """Return a fit with the effect of a place in its best law, None if no arm can have it."""
    trials = []
    for start in terms_of(fitter.on(without.accepted), place[0]):
        if start.joint == place[1]:
            try:
                trials.append(fitter.refit(without, start))
            except IMPOSSIBLE:
                continue
    if not trials:
        return None
    return fitter.refined(min(trials, key=lambda trial: trial.score))


def _candidate(fitter: Fitter, fit: Fit, term: Term, pair: Alike, in_model: bool) -> Candidate:
    """Return a cause of a pair with its numbers in a fit."""
    own = fit.own(term)
    return Candidate(term.name, term.joint,
                     numbers_of(fitter, term, fitter.covariance(fit)[own][:, own]), in_model,
                     pair.share(term.place))
