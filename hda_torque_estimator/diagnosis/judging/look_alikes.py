"""
All laws of one curve that look alike, not the first two alone.

Gears twist by several laws of one torque, and drag by several of one speed. Where a law ties with
another along the same coordinate, a third may explain as much: the true one may be that.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

from .candidates import instead
from .model_comparison import fair_costs
from .search import SearchResult
from .selection_criteria import accepted
from .verdict import of_one_curve, tied
from ..findings.report import Alike
from ..fitting.fit import Fit, Fitter
from ...least_squares.term import Place, Term


def with_all_alike(fitter: Fitter, found: SearchResult,
                   pairs: Sequence[Alike]) -> tuple[Alike, ...]:
    """Return pairs of causes that look alike with all other laws of their curve that do."""
    return tuple(replace(pair, effects=(*pair.effects, *_others(fitter, found, pair)))
                 for pair in pairs)


def _others(fitter: Fitter, found: SearchResult, pair: Alike) -> Iterator[Place]:
    """Yield the places of further laws that tie with the first cause of a pair."""
    own = next(term for term in found.last.accepted if term.place == pair.effects[0])
    reason = found.reasons()[own.place]
    rival = None if reason.runner_up is None else reason.runner_up.place
    if rival not in pair.effects or not of_one_curve(own.place, rival):
        return
    before = fitter.fit(found.last.causes_beside(own), found.last.nuisance)
    trials = list(_instead_of(fitter, found, before, pair, own))
    own_cost, *costs = fair_costs(fitter, before, [found.last, *trials])
    for trial, cost in zip(trials, costs):
        if cost - own_cost < tied(reason, own):
            yield trial.accepted[-1].place


def _instead_of(fitter: Fitter, found: SearchResult, before: Fit, pair: Alike,
                own: Term) -> Iterator[Fit]:
    """Yield fits with other laws of its curve, of no more numbers, in the place of a cause."""
    taken = {*pair.effects, *(term.place for term in found.last.accepted)}
    for name in found.names:
        place = (name, own.joint)
        if place in taken or not of_one_curve(own.place, place):
            continue
        trial = instead(fitter, before, place)
        if (trial is not None and trial.accepted[-1].freedom <= own.freedom
                and accepted(fitter, found.first, before, trial, trial.accepted[-1])):
            yield trial
