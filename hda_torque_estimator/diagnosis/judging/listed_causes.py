"""
Which causes are told, and which are listed: there, but not sure enough, at a bound, or too small.

A wrong name is worse than none. So what is listed has its size and its probability, and is neither
part of the verdict nor of the extended arm.
"""

from collections.abc import Collection, Sequence

from .bounds_reached import limited
from .search import SearchResult
from .verdict import lead_of, numbers_of
from ..findings.certainty import probability, unsure
from ..findings.report import at_place, Finding, Listed
from ..fitting.fit import Fitter
from ...least_squares.term import Place


def told(fitted: Sequence[Finding]) -> tuple[tuple[Finding, ...], tuple[Listed, ...]]:
    """Return which of the causes that were fitted are told, and the others."""
    named, others = [], []
    for one in fitted:
        at_bound = limited(one)
        why = at_bound or unsure(one)
        if why is None:
            named.append(one)
        else:
            others.append(Listed(one.effect, one.joint, one.parameters, one.probability,
                                 'at_bound' if at_bound else 'unsure', why))
    return tuple(named), tuple(others)


def too_small(fitter: Fitter, found: SearchResult, known: Collection[Place]) -> tuple[Listed, ...]:
    """
    Return what a search found that is less than what is worth a cause, if not `known` by then.

    It is as sure as its score and its lead over the next best make it.
    """
    small = found.small
    if small is None or small.term.place in known:
        return ()
    own, place = small.fit.own(small.term), small.term.place
    numbers = numbers_of(fitter, small.term, fitter.covariance(small.fit)[own][:, own])
    sure = probability(min(small.reason.improvement / small.reason.threshold,
                           lead_of(small.reason, small.term)))
    return (Listed(*place, numbers, sure, 'small',
                   f'{at_place(*place)} is not named: it explains less than noise makes'),)
