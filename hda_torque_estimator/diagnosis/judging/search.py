"""
Look for the causes: accept the best hypothesis, simulate with it, look again.

What a cause must do to be accepted stands in `selection_criteria`. Where the way that was best at
every step ends with a rest, it weighs the laws of each cause again beside all others. Then it goes
back to where another cause was nearly as good.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from .forward_selection import (best_small, cost_formed, exact, look, place_of, Reason, refits,
                                Round, SmallCause)
from .law_forms import reformed
from .model_comparison import leading
from .selection_criteria import (accepted, confirmed, floor, freedom, material, open_rest,
                                 threshold)
from ..fitting.derivatives import IMPOSSIBLE
from ..fitting.fit import Fit, Fitter
from ..fitting.hypotheses import HYPOTHESES, terms_of
from ..fitting.steps import acts_apart
from ...least_squares.term import Place, Term
from ...significance import HARDLY, MANY, MOSTLY, SCORE_BAR

# Numerics; choices unless stated otherwise.
_TURNS = 2              # other ways that are tried


@dataclass(frozen=True, eq=False)
class SearchResult:
    """
    The outcome of a search: the first and the last fit, and the evidence of every cause.

    Where it was asked, it says by how much the size of each varies (`unsteady_shares`). Of what is
    there and less than what is worth a cause, it has the best.
    """

    first: Fit
    last: Fit
    evidence: tuple[Reason, ...]        # one for each accepted term
    steady: Mapping[Place, float] | None = None
    small: SmallCause | None = None
    names: tuple[str, ...] = ()         # of all effects that were looked for

    def with_only(self, fitter: Fitter, kept: Sequence[Term]) -> Fit:
        """
        Return the fit of the accepted terms that are kept.

        One that is not has bent the others to fit, so they are fitted again without it.
        """
        if len(kept) == len(self.last.accepted):
            return self.last
        return fitter.fit(kept, self.first.nuisance) if kept else self.first

    def keeping(self, fitter: Fitter, kept: Sequence[Term]) -> 'SearchResult':
        """Return what was found with some terms alone, fitted again and as steady as before."""
        reasons, places = self.reasons(), {term.place for term in kept}
        steady = None if self.steady is None else {
            place: share for place, share in self.steady.items() if place in places}
        return replace(self, last=self.with_only(fitter, kept), steady=steady,
                       evidence=tuple(reasons[term.place] for term in kept))

    def refitted(self, fitter: Fitter) -> 'SearchResult':
        """Return what was found, fitted again by a fitter with another noise."""
        first, last = fitter.fit(()), self.last
        return replace(self, first=first, last=(
            fitter.fit(last.accepted, last.nuisance) if last.accepted else first))

    def reasons(self) -> dict[Place, Reason]:
        """Return the evidence by the places of the accepted terms."""
        return {term.place: reason for term, reason in zip(self.last.accepted, self.evidence)}


def search(fitter: Fitter, names: Sequence[str], begun: SearchResult | None = None,
           notify: Callable[[str], None] = lambda text: None) -> SearchResult:
    """
    Return the causes that explain a measurement, among the effects of these names.

    A search that was `begun` with another noise goes on from what it had found. `notify` hears
    what is being done.
    """
    names = [name for name in names if name in HYPOTHESES]
    notify('fitting the arm as it is known')
    if begun is None:
        first = fitter.fit(())
        found = SearchResult(first, first, ())
    else:
        found = begun.refitted(fitter)
    found = _extended(fitter, names, found, notify)
    turns = _turns(fitter, found)
    while found.last.accepted and is_stuck(fitter, found):      # asked first: a way is a search
        start = next(turns, None)
        if start is None:
            break
        other = _extended(fitter, names, start, notify)
        if _better(fitter, other.last, found.last):
            found = other
    return replace(_weighed_again(fitter, found), small=found.small, names=tuple(names))


def without_noise(fitter: Fitter, found: SearchResult) -> SearchResult:
    """Return what was found without causes that do not stand out of noise as it is known now."""
    kept = confirmed(fitter, found.first, found.last)
    quiet = [SmallCause(found.last, term, reason)
             for term, reason in zip(found.last.accepted, found.evidence) if term not in kept]
    largest = max(quiet, key=lambda one: one.reason.improvement, default=found.small)
    return replace(found.keeping(fitter, kept), small=largest)


def _extended(fitter: Fitter, names: Sequence[str], found: SearchResult,
              notify: Callable[[str], None]) -> SearchResult:
    """Return what was found with further causes, the best at every step."""
    first, evidence = found.first, found.reasons()
    fit = _simplified(fitter, without_unneeded(fitter, first, found.last), names,
                      evidence)                                 # it may begin with another law
    small = None
    while open_rest(fitter, fit):
        notify(f'looking for cause {len(fit.accepted) + 1}')
        seen, taken = _next(fitter, first, fit, names, evidence)
        if taken is None:
            small = best_small(fitter, seen)
            break
        fit = taken
    return SearchResult(first, fit, tuple(evidence[term.place] for term in fit.accepted),
                        small=small)


def with_one_more(fitter: Fitter, found: SearchResult,
                  names: Sequence[str]) -> SearchResult | None:
    """Return what was found with the best further cause of these names, None without one."""
    evidence = found.reasons()
    _, taken = _next(fitter, found.first, found.last, names, evidence)
    return None if taken is None else replace(found, last=taken, evidence=tuple(
        evidence[term.place] for term in taken.accepted))


def _next(fitter: Fitter, first: Fit, fit: Fit, names: Sequence[str],
          evidence: dict[Place, Reason]) -> tuple[Round, Fit | None]:
    """Return what a look for one more cause finds, and a fit with it, None without one."""
    seen = look(fitter, first, fit, names)
    return seen, None if seen.step is None else with_cause(
        fitter, first, fit, seen.step, names, evidence)


def with_cause(fitter: Fitter, first: Fit, fit: Fit, step: tuple[Fit, Reason],
               names: Sequence[str], evidence: dict[Place, Reason]) -> Fit | None:
    """
    Return a fit with one cause more, simplified; None if it improves nothing in the end.

    The `step` is the best one (`next_cause`). What it rests on is added to the `evidence`.
    """
    extended, reason = step
    evidence[place_of(extended)] = reason
    extended = without_unneeded(fitter, first, extended)
    if fit.score - extended.score < SCORE_BAR:
        return None
    return _simplified(fitter, extended, names, evidence)


def is_stuck(fitter: Fitter, found: SearchResult) -> bool:
    """
    Return whether more is left than noise, and than the laws that were found may leave.

    Where none of them acts, no other law or cause in their place would leave less. There it must
    be as far above noise as what asks for a further cause (`open_rest`).
    """
    left = reformed(fitter, found.last).variance - fitter.noise ** 2
    least = material(fitter, found.first, found.last)
    acting = np.zeros(len(left), bool)
    for term in found.last.accepted:
        acting[fitter.channels_of(term) if acts_apart(term) else slice(None)] = True
    return bool((left > np.where(acting, least, np.maximum(least, floor(fitter)))).any())


def _turns(fitter: Fitter, found: SearchResult) -> Iterator[SearchResult]:
    """
    Yield where a search may begin again.

    With another law of a cause, which was chosen before the others and its form were known; or
    with a cause that was nearly as good as another.
    """
    terms = found.last.accepted
    if len(terms) > MANY:
        return
    for term in terms:
        if HYPOTHESES[term.name].grid or HYPOTHESES[term.name].more:
            yield from _other_law(fitter, found, term)
    near = sorted((reason.runner_up_gap / reason.improvement, place)
                  for place, reason in enumerate(found.evidence) if reason.runner_up is not None
                  and reason.runner_up.name != HYPOTHESES[terms[place].name].twin)
    for share, place in near[:_TURNS]:
        reason = found.evidence[place]
        assert reason.runner_up is not None
        if share > MOSTLY:
            return
        before = fitter.fit(terms[:place], found.first.nuisance) if place else found.first
        fit = fitter.fit([*terms[:place], reason.runner_up], before.nuisance)
        if accepted(fitter, found.first, before, fit, fit.accepted[-1]):
            taken = Reason(before.score - fit.score, threshold(fitter, reason.runner_up),
                           terms[place], SCORE_BAR)           # by which it must win
            yield SearchResult(found.first, fit, (*found.evidence[:place], taken))


def _other_law(fitter: Fitter, found: SearchResult, term: Term) -> Iterator[SearchResult]:
    """Yield what was found with the law of a cause that fits best beside all others."""
    others = found.last.causes_beside(term)
    without = fitter.fit(others, found.last.nuisance)
    laws = _starts(fitter, others, term.name, term.joint)
    best = exact(fitter, refits(fitter, without, laws))
    if best and _better(fitter, best[0], found.last):
        reasons = found.reasons()
        yield SearchResult(found.first, best[0],
                           tuple(reasons[other.place] for other in (*others, term)))


def _weighed_again(fitter: Fitter, found: SearchResult) -> SearchResult:
    """Return what was found with each cause compared to its near runner-up beside all others."""
    for place in [term.place for term in found.last.accepted]:
        fit, reasons = found.last, found.reasons()
        taken, reason = {term.place for term in fit.accepted}, reasons[place]
        rival = reason.runner_up
        if (rival is None or rival.place in taken or len(taken) < 2
                or reason.runner_up_gap > HARDLY * reason.improvement):
            continue
        own, = (term for term in fit.accepted if term.place == place)
        others = fit.causes_beside(own)
        fits = [fitter.fit([*others, term], fit.nuisance) for term in (own, rival)]
        if not all(map(fitter.can_lack_each, fits)):
            continue
        best, other, gap, more = leading(fitter, found.first, fits, ())
        if place_of(best) != place and not accepted(
                fitter, found.first, fitter.fit(others, fit.nuisance), best, best.accepted[-1]):
            continue
        found = SearchResult(found.first, best, (
            *(reasons[term.place] for term in others),
            reason._replace(runner_up=other, runner_up_gap=gap, runner_up_more=more)))
    return found


def _better(fitter: Fitter, fit: Fit, than: Fit) -> bool:
    """Return whether a fit, in its best form, costs so much less that it is worth a change."""
    return cost_formed(fitter, fit) < cost_formed(fitter, than) - SCORE_BAR


def _starts(fitter: Fitter, others: Sequence[Term], name: str, joint: str | None) -> list[Term]:
    """
    Return every start of one hypothesis at one joint, or of the whole arm, beside other causes.

    There is none where no arm has these alone, as a base that swings more than the links weigh.
    """
    try:
        arm = fitter.on(others)
    except IMPOSSIBLE:
        return []
    return [start for start in terms_of(arm, name) if start.joint == joint]


def without_unneeded(fitter: Fitter, first: Fit, fit: Fit) -> Fit:
    """
    Return the fit without the causes that later ones have made superfluous.

    That may be the latest itself: others may have gone on only because it gave way to them.
    """
    for term in fit.accepted:
        if accepted(fitter, first, fitter.without(fit, term), fit, term):
            continue                    # the others give way as far as slopes at hand show
        fewer = fitter.fit(fit.causes_beside(term), fit.nuisance)
        if not accepted(fitter, first, fewer, fit, term):
            return without_unneeded(fitter, first, fewer)
    return fit


def _simplified(fitter: Fitter, fit: Fit, names: Sequence[str],
                evidence: dict[Place, Reason]) -> Fit:
    """
    Return the fit in which causes give way to those of fewer numbers that explain as well.

    One that was taken early may have stood for a part of what was found since. The `evidence` of
    one that takes its place is added.
    """
    for term in fit.accepted[:-1]:
        others = fit.causes_beside(term)
        for start in _simpler(fitter, others, term, names):
            trial = fitter.fit([*others, start], fit.nuisance)
            gap = fit.score - trial.score + freedom(fitter, term) - freedom(fitter, start)
            if gap > 0.0:
                before = evidence[term.place]
                evidence[start.place] = before._replace(
                    improvement=before.improvement + gap, runner_up=term, runner_up_gap=gap,
                    runner_up_more=-gap)
                return _simplified(fitter, trial, names, evidence)
    return fit


def _simpler(fitter: Fitter, others: Sequence[Term], term: Term,
             names: Sequence[str]) -> Iterator[Term]:
    """Yield what a cause is confused with that has fewer numbers, all of which fits reach."""
    for name in HYPOTHESES[term.name].alike:
        if name in names and not HYPOTHESES[name].grid:
            yield from (start for start in _starts(fitter, others, name, term.joint)
                        if start.freedom < term.freedom)
