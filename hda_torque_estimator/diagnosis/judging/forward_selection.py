"""
One step of forward selection: the best further cause of all hypotheses, if one is worth it.

All are weighed to first order. The most promising are fitted with two steps, and the best of those
to the end, each with all of its laws.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

from .bounds_reached import ends_at_limit, takes_gear_away
from .equal_noise import equal_noise_score, noise_in
from .law_forms import formed_gain
from .model_comparison import cost, Lead, leading
from .screening import Prospect, screen
from .selection_criteria import Standing, standing, threshold
from ..fitting.derivatives import IMPOSSIBLE
from ..fitting.fit import CLOSE, Fit, Fitter
from ..fitting.hypotheses import is_richer
from ...least_squares.term import Place, Term
from ...significance import MANY, SCORE_BAR

# Numerics; choices unless stated otherwise.
_CANDIDATES = 6         # fitted in every round, with two steps,
_FINALISTS = 3          # and the best places of them to the end


class Reason(NamedTuple):
    """Why a cause was accepted."""

    improvement: float          # of the score
    threshold: float
    runner_up: Term | None
    runner_up_gap: float        # score of the runner-up above the accepted one
    runner_up_more: float = 0.0     # score by which it costs less, if both laws are as they are


class Round(NamedTuple):
    """What one look for a further cause found."""

    fit: Fit                            # what was known before
    step: tuple[Fit, Reason] | None     # with the best further cause, None if there is none
    small: tuple[Fit, ...] = ()         # with what is there and less than a cause


class SmallCause(NamedTuple):
    """What is there and less than what is worth a cause: a term of a fit."""

    fit: Fit
    term: Term
    reason: Reason


def next_cause(fitter: Fitter, first: Fit, fit: Fit,
               names: Sequence[str]) -> tuple[Fit, Reason] | None:
    """Return the fit with the best further cause, or None if there is no further cause."""
    return look(fitter, first, fit, names).step


def look(fitter: Fitter, first: Fit, fit: Fit, names: Sequence[str]) -> Round:
    """Return what a look for one more cause beside those of a fit finds."""
    taken = {term.place for term in fit.accepted}
    prospects = [prospect for prospect in screen(fitter, fit, names)
                 if prospect.term.place not in taken]
    promising = [prospect for prospect in prospects
                 if fit.score - prospect.score > threshold(fitter, prospect.term)]
    refused, small = set[Place](), list[Fit]()
    for tried, noisy in _in_turn(fitter, fit, promising):
        are = [standing(fitter, first, fit, trial, trial.accepted[-1]) for trial in tried]
        causes = [trial for trial, is_ in zip(tried, are) if is_ is Standing.CAUSE]
        refused |= {place_of(trial) for trial in tried} - {place_of(trial) for trial in causes}
        if causes:
            lead = leading(fitter, fit, causes, [
                prospect for prospect in prospects if prospect.term.place not in refused
                and prospect.term.joint not in noisy])
            settled = fitter.fit(lead.fit.accepted, lead.fit.nuisance)
            return Round(fit, (settled, _reason(fitter, fit, lead)))
        small += [trial for trial, is_ in zip(tried, are) if is_ is Standing.SMALL]
    return Round(fit, None, tuple(small))


def _in_turn(fitter: Fitter, fit: Fit,
             promising: list[Prospect]) -> Iterator[tuple[list[Fit], set[str | None]]]:
    """
    Yield the fits of the most promising causes to the end, and then those of the next ones.

    What explains most may be none: many small imperfections together look like a large one. So
    beside many causes all that were fitted with two steps are asked, until one is. A law that
    takes a gear away explains whatever is wrong there: the next ones are asked then. Where noise
    is all that a joint seems to have, it says nothing of others: the best of those are asked next.
    The joints that have only noise so far go with each.
    """
    noisy = set[str | None]()
    while promising:
        first = [each.term for each in _first_places(promising)]
        trials = sorted(refits(fitter, fit, first), key=lambda trial: cost(fitter, trial))
        places = _fairest(fitter, fit, trials)
        if len(fit.accepted) < MANY:            # what is left of few is no sum of many others
            places = places[:_FINALISTS]
        is_gone = False
        for begin in range(0, len(places), _FINALISTS):
            some = places[begin:begin + _FINALISTS]
            tried = exact(fitter, [trial for trial in trials if place_of(trial) in some])
            yield tried, noisy
            is_gone |= any(takes_gear_away(fitter, one, one.accepted[-1]) for one in tried)
        if is_gone:
            promising = [each for each in promising if each.term.place not in places]
        else:
            noisy = noisy | {None, *(term.joint for term in first)}
            promising = [each for each in promising if each.term.joint not in noisy]


def _fairest(fitter: Fitter, fit: Fit, trials: Sequence[Fit]) -> list[Place]:
    """
    Return the places of sorted trials, that first which explains most at an equal noise.

    An arm that makes less noise leaves less as well, and is no cause by that (`equal_noise`). It
    must not take the place of one that is.
    """
    best = {place_of(trial): trial for trial in reversed(trials)}
    if len(best) <= _FINALISTS:
        return list(best)                       # all of them are asked
    usual = noise_in(fitter, fit)

    def fair_cost(place: Place) -> float:
        trial = best[place]
        less_noise = equal_noise_score(fitter, trial, usual) - trial.score
        return cost(fitter, trial) + max(less_noise, 0.0)
    return sorted(best, key=fair_cost)


def _reason(fitter: Fitter, fit: Fit, lead: Lead) -> Reason:
    """Return why a fit that leads is better than another that lacks its last cause."""
    best, other, gap, more = lead
    return Reason(fit.score - best.score, threshold(fitter, best.accepted[-1]), other, gap, more)


def best_small(fitter: Fitter, seen: Round) -> SmallCause | None:
    """Return the best of what is there and less than a cause, None where nothing is."""
    if not seen.small:
        return None
    lead = leading(fitter, seen.fit, seen.small, ())
    return SmallCause(lead.fit, lead.fit.accepted[-1], _reason(fitter, seen.fit, lead))


def _first_places(prospects: list[Prospect]) -> list[Prospect]:
    """Return the prospects of the most promising causes, all laws of each."""
    places = list(dict.fromkeys(each.term.place for each in prospects))
    first = set(places[:_CANDIDATES])
    return [each for each in prospects if each.term.place in first]


def place_of(trial: Fit) -> Place:
    """Return the place of the last cause of a fit."""
    return trial.accepted[-1].place


def cost_formed(fitter: Fitter, fit: Fit) -> float:
    """Return what a fit costs with its causes in the forms that fit best."""
    return cost(fitter, fit) - formed_gain(fitter, fit)


def refits(fitter: Fitter, fit: Fit, terms: Sequence[Term]) -> Iterator[Fit]:
    """Return the fits with one more of these terms, but for those that no arm can have."""
    for term in terms:
        try:
            yield fitter.refit(fit, term)
        except IMPOSSIBLE:
            continue


def exact(fitter: Fitter, trials: Iterable[Fit]) -> list[Fit]:
    """
    Return the fits of the most promising places to the end, the best first.

    A place may have several laws, and two steps do not show which of them will fit. Of two that
    fit alike the one with fewer numbers is taken, those with a tolerance too. None fits worse than
    a law that it contains: it begins there once more if it did.
    """
    tried = sorted(trials, key=lambda trial: cost(fitter, trial))
    finalists = list(dict.fromkeys(map(place_of, tried)))[:_FINALISTS]
    best: dict[Place, Fit] = {}
    refined = [fitter.refined(trial) for trial in tried if place_of(trial) in finalists]
    settled = (_from_contained(fitter, trial, refined) for trial in refined)
    for trial in sorted((trial for trial in settled if _may_be(fitter, trial)),
                        key=lambda trial: cost_formed(fitter, trial)):
        known = best.setdefault(place_of(trial), trial)
        if cost_formed(fitter, trial) - cost_formed(fitter, known) < _may_cost_more(trial, known):
            best[place_of(trial)] = trial
    return list(best.values())


def _may_cost_more(trial: Fit, known: Fit) -> float:
    """
    Return by how much more a trial with another law of the last cause may cost than a known fit.

    A law with fewer free numbers gives way to one that contains it for what is worth a change.
    """
    law, other = trial.accepted[-1], known.accepted[-1]
    if law.freedom < other.freedom and set(law.free) < set(other.free):
        return SCORE_BAR
    return CLOSE if law.size < other.size else 0.0


def _from_contained(fitter: Fitter, trial: Fit, others: Sequence[Fit]) -> Fit:
    """
    Return a fit that is no worse than the best of those whose law its last law contains.

    Numbers of a tolerance are none of a law: it does not contain one that seeks them.
    """
    term = trial.accepted[-1]
    best = min((other for other in others if place_of(other) == term.place
                and set(other.accepted[-1].free) < set(term.free)
                and set(other.accepted[-1].free) <= set(term.sought)),
               key=lambda other: other.score, default=trial)
    if best.score >= trial.score:
        return trial
    begun = replace(term, effect=best.accepted[-1].effect)
    return min(trial, fitter.fit([*best.accepted[:-1], begun], best.nuisance),
               key=lambda fit: fit.score)


def _may_be(fitter: Fitter, fit: Fit) -> bool:
    """Return if a fit may be accepted: no cause is needed for another, nor does a law do less."""
    if is_richer(fit.accepted[-1]) and ends_at_limit(fitter, fit, fit.accepted[-1]):
        return False
    return fitter.can_lack_each(fit)
