"""
Look for the causes: accept the best hypothesis, simulate with it, look again.

A cause must explain much more than its freedom buys (the score), be material (well above what a
healthy arm and the causes beside it leave), and its rivals must be clearly worse. The first may
be less than noise if it is certain: one that is quick enough passes for noise until it is known,
and must stand out of what is noise then.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from hda_arm_sim.model.arm import Arm
import numpy as np
from numpy.typing import NDArray

from .fit import Fit, Fitter, IMPOSSIBLE
from .hypotheses import HYPOTHESES, terms_of
from .nameless import best_curves, plain_score
from .rivals import leading
from .screen import Prospect, screen
from .term import Place, Term

Array = NDArray[np.float64]
THRESHOLD = 60.0        # improvement of the score beyond what its freedom costs
MATERIAL = 0.7          # least explained rms, in rms that a healthy arm leaves
CERTAIN = 200.0         # improvement of the score that may pass for noise at first
MOST = 5                # causes in one recording
_CANDIDATES = 6         # fitted in every round, with two steps,
_FINALISTS = 3          # and the best places of them to the end


class Evidence(NamedTuple):
    """Why a cause was accepted."""

    improvement: float          # of the score
    threshold: float
    runner_up: Term | None
    runner_up_gap: float        # score of the runner-up above the accepted one


@dataclass(frozen=True, eq=False)
class Found:
    """The outcome of a search: the first and the last fit, and the evidence of every cause."""

    first: Fit
    last: Fit
    evidence: tuple[Evidence, ...]      # one for each accepted term

    def with_only(self, fitter: Fitter, kept: Sequence[Term]) -> Fit:
        """
        Return the fit of the accepted terms that are kept.

        One that is not has bent the others to fit, so they are fitted again without it.
        """
        if len(kept) == len(self.last.accepted):
            return self.last
        return fitter.fit(kept, self.first.nuisance) if kept else self.first

    def reasons(self) -> dict[Place, Evidence]:
        """Return the evidence by the places of the accepted terms."""
        return {term.place: reason for term, reason in zip(self.last.accepted, self.evidence)}


def search(fitter: Fitter, names: Sequence[str], begun: Found | None = None) -> Found:
    """
    Return the causes that explain a measurement, among the effects of these names.

    A search that was `begun` with another noise goes on from what it had found.
    """
    names = [name for name in names if name in HYPOTHESES]
    first = fit = fitter.fit(())
    evidence: dict[Place, Evidence] = {}
    if begun is not None and begun.last.accepted:
        fit, evidence = fitter.fit(begun.last.accepted, begun.last.nuisance), begun.reasons()
    while len(fit.accepted) < MOST and _worthwhile(fitter, first, fit):
        found = _next(fitter, first, fit, names)
        if found is None:
            break
        extended, reason = found
        evidence[_place(extended)] = reason
        extended = _without_unneeded(fitter, first, extended)
        if fit.score - extended.score < THRESHOLD:
            break
        fit = _simplified(fitter, extended, names, evidence)
    return Found(first, fit, tuple(evidence[term.place] for term in fit.accepted))


def confirmed(fitter: Fitter, found: Found) -> Found:
    """
    Return what was found, nothing if it is one cause that is less than noise even now.

    One that passed for noise makes the noise less once it is known, and then stands out of it.
    """
    if len(found.last.accepted) != 1:
        return found
    first = fitter.at(found.first.terms, 0, found.first.columns)
    last = fitter.at(found.last.terms, 1, found.last.columns)
    if (first.variance - last.variance > material(fitter, first, ())).any():
        return found
    return Found(found.first, found.first, ())


def _worthwhile(fitter: Fitter, first: Fit, fit: Fit) -> bool:
    """Tell whether more is left than noise, or less that a simple curve tells for certain."""
    if (fit.variance - fitter.noise ** 2 > material(fitter, first, fit.accepted)).any():
        return True
    if fit is not first:
        return False
    told = min(curve.score for curve in best_curves(fitter, fit, fitter.arm.labels).values())
    return plain_score(fitter, fit) - told > CERTAIN


def _next(fitter: Fitter, first: Fit, fit: Fit,
          names: Sequence[str]) -> tuple[Fit, Evidence] | None:
    """Return the fit with the best further cause, or None if there is no further cause."""
    taken = {term.place for term in fit.accepted}
    prospects = [prospect for prospect in screen(fitter, fit, names)
                 if prospect.term.place not in taken]
    promising = [prospect for prospect in _first_places(prospects)
                 if fit.score - prospect.score > threshold(fitter, prospect.term)]
    if not promising:
        return None
    exact = _exact(fitter, list(_refits(fitter, fit, promising)))
    while exact and not accepted(fitter, first, fit, exact[0]):
        exact.pop(0)                # it tells more, but of what is immaterial
    if not exact:
        return None
    best, other, gap = leading(fitter, exact, prospects)
    settled = fitter.fit(best.accepted, best.nuisance)
    return settled, Evidence(fit.score - best.score, threshold(fitter, best.accepted[-1]), other,
                             gap)


def _first_places(prospects: list[Prospect]) -> list[Prospect]:
    """Return the prospects of the most promising causes, all laws of each."""
    places = list(dict.fromkeys(each.term.place for each in prospects))
    first = set(places[:_CANDIDATES])
    return [each for each in prospects if each.term.place in first]


def _place(trial: Fit) -> Place:
    """Return the place of the last cause of a fit."""
    return trial.accepted[-1].place


def _cost(fitter: Fitter, trial: Fit) -> float:
    """Return the score of a fit with what the freedom of its last cause costs."""
    return trial.score + freedom(fitter, trial.accepted[-1])


def _refits(fitter: Fitter, fit: Fit, prospects: list[Prospect]) -> Iterator[Fit]:
    """Return the fits of prospects, but for those that no arm can have."""
    for prospect in prospects:
        try:
            yield fitter.refit(fit, prospect.term)
        except IMPOSSIBLE:
            continue


def _exact(fitter: Fitter, tried: list[Fit]) -> list[Fit]:
    """
    Return the fits of the most promising places to the end, the best first.

    A place may have several laws, and two steps do not tell which of them will fit.
    """
    tried = sorted(tried, key=lambda trial: _cost(fitter, trial))
    finalists = list(dict.fromkeys(map(_place, tried)))[:_FINALISTS]
    best: dict[Place, Fit] = {}
    for trial in sorted((fitter.refined(trial) for trial in tried if _place(trial) in finalists),
                        key=lambda trial: _cost(fitter, trial)):
        best.setdefault(_place(trial), trial)
    return list(best.values())


def _without_unneeded(fitter: Fitter, first: Fit, fit: Fit) -> Fit:
    """
    Return the fit without the causes that later ones have made superfluous.

    That may be the latest itself: others may have gone on only because it gave way to them.
    """
    for term in fit.accepted:
        fewer = fitter.fit([other for other in fit.accepted if other is not term], fit.nuisance)
        if not accepted(fitter, first, fewer, fit):
            return _without_unneeded(fitter, first, fewer)
    return fit


def _simplified(fitter: Fitter, fit: Fit, names: Sequence[str],
                evidence: dict[Place, Evidence]) -> Fit:
    """
    Return the fit in which causes give way to those of fewer numbers that explain as well.

    One that was taken early may have stood for a part of what was found since; the `evidence` of
    one that takes its place is added.
    """
    for term in fit.accepted[:-1]:
        others = [other for other in fit.accepted if other is not term]
        for start in _simpler(fitter.on(others), term, names):
            trial = fitter.fit([*others, start], fit.nuisance)
            gap = fit.score - trial.score + freedom(fitter, term) - freedom(fitter, start)
            if gap > 0.0:
                before = evidence[term.place]
                evidence[start.place] = before._replace(
                    improvement=before.improvement + gap, runner_up=term, runner_up_gap=gap)
                return _simplified(fitter, trial, names, evidence)
    return fit


def _simpler(arm: Arm, term: Term, names: Sequence[str]) -> Iterator[Term]:
    """Yield what a cause is confused with that has fewer numbers, all of which fits reach."""
    for name in HYPOTHESES[term.name].alike:
        if name in names and not HYPOTHESES[name].grid:
            yield from (start for start in terms_of(arm, name)
                        if start.joint == term.joint and start.size < term.size)


def freedom(fitter: Fitter, term: Term) -> float:
    """Return what the freedom of a term costs: ln(samples) for each number (BIC)."""
    return term.size * float(np.log(max(fitter.rows.sum() * fitter.effective, 2.0)))


def threshold(fitter: Fitter, term: Term) -> float:
    """Return the improvement of the score that a term must reach."""
    return THRESHOLD + freedom(fitter, term)


def accepted(fitter: Fitter, first: Fit, without: Fit, extended: Fit) -> bool:
    """Tell whether the last term of a fit earns its place: by its score, and materially."""
    *beside, term = extended.accepted
    improvement = without.score - extended.score
    if improvement < threshold(fitter, term):
        return False
    certain = not beside and improvement > CERTAIN
    return certain or bool((without.variance - extended.variance
                            > material(fitter, first, beside)).any())


def material(fitter: Fitter, first: Fit, beside: Sequence[Term]) -> Array:
    """
    Return the power (c,) [N^2*m^2] in one of the channels that is worth a cause beside others.

    It is far above noise, and above what the others may leave as one form of several.
    """
    excess = np.maximum(first.variance - fitter.noise ** 2, 0.0)
    blurred = np.zeros_like(excess)
    for term in beside:
        own = fitter.channels_of(term)
        blurred[own] = np.maximum(blurred[own], HYPOTHESES[term.name].form_error)
    return np.maximum((MATERIAL * fitter.noise) ** 2, blurred * excess)
