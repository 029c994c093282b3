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
    others = [term for term in fit.accepted if term is not holder]
    for place in pair.effects:
        if place == holder.place or place[0] not in HYPOTHESES:
            continue
        instead = _instead(fitter, fit, others, place)
        if instead is not None:
            sized.append(_candidate(fitter, instead, instead.accepted[-1], pair, False))
    return sized


def _instead(fitter: Fitter, fit: Fit, others: Sequence[Term], place: Place) -> Fit | None:
    """Return the best fit with the effect of a place beside others, None if no arm can have it."""
    without, trials = fitter.fit(others, fit.nuisance), []
    for start in terms_of(fitter.on(others), place[0]):
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
