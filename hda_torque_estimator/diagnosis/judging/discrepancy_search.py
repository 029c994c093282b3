"""
Look for causes beside what has no name: where names alone leave a rest, curves compete with them.

A search that ends with a rest which takes names back, or leaves one unsure, goes on with further
names. What no catalogue lists makes it take whatever stands for that a little. So where such a
rest stays, all is done anew with causes that have no name (`discrepancy_terms`). At every step one
of them is taken if it explains more than the best of the catalogue. What it does is taken out of
all balances (eq:beside). In the end each cause of the catalogue must explain more than the best
without a name in its place. It must be the best of the catalogue there as well. And it must
explain more than what has no name at its own site: nobody knows that law, which may do more.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from hda_arm_sim.model.effects import effect_named

from .discrepancy_terms import DiscrepancyTerm, DiscrepancyTerms
from .forward_selection import next_cause, Reason
from .goodness_of_fit import goodness_of_fit
from .parameter_constancy import only_steady
from .search import SearchResult, with_cause, with_one_more, without_unneeded
from .selection_criteria import freedom, open_rest
from .site_pattern import is_one_link_torque, not_of_link
from ..findings.rest import GEAR
from ..fitting.fit import Fit, Fitter
from ..fitting.hypotheses import HYPOTHESES
from ...least_squares.term import Place, Term
from ...significance import CERTAIN, NEARLY_ALL, SCORE_BAR

# Numerics; choices unless stated otherwise.
_MOST = 6               # causes without a name: more are a rest that none describes


class BesideDiscrepancy(NamedTuple):
    """What was found of the catalogue, beside what has no name."""

    fitter: Fitter                          # of balances without what has no name
    found: SearchResult
    nameless: tuple[DiscrepancyTerm, ...]

    @property
    def channels(self) -> list[int]:
        """Return the channels in which something has no name."""
        return sorted({channel for cause in self.nameless for channel in cause.channels})


def search_beside_discrepancy(fitter: Fitter, found: SearchResult, names: Sequence[str],
                              notify: Callable[[str],
                                               None] = lambda text: None) -> BesideDiscrepancy:
    """
    Return what stays of the catalogue beside causes without a name, what was `found` without any.

    Where that left a rest which takes names back, or makes one unsure, the search goes on among
    effects of these names. Where it still does, all is looked for anew. `notify` hears what is
    being done.
    """
    names = [name for name in names if name in HYPOTHESES]
    found = gone_on(fitter, found, names, notify)
    if goodness_of_fit(fitter, found).is_clear:
        return BesideDiscrepancy(fitter, found, ())
    notify('looking which causes are steady beside the rest')
    steady = only_steady(fitter, found, names)
    if steady is not None:              # what is left are small imperfections, one after another
        return BesideDiscrepancy(fitter, steady, ())
    notify('looking for causes beside what has no name')
    other = _Search(fitter, names).run()
    if not other.nameless:
        return BesideDiscrepancy(fitter, found, ())
    # What has no name was taken out of each balance on its own: these do not show it any more.
    misplaced = [term for label in fitter.arm.labels
                 if (here := not_of_link(other.found.last, label))
                 and is_one_link_torque(fitter, found, label) for term in here]
    return other._replace(found=other.found.keeping(other.fitter, [
        term for term, reason in zip(other.found.last.accepted, other.found.evidence)
        if term not in misplaced and not is_outdone(term, reason, other.nameless)]))


def is_outdone(term: Term, reason: Reason, nameless: Sequence[DiscrepancyTerm]) -> bool:
    """Return whether something without a name explains more at the very site of a cause."""
    sites = (GEAR, effect_named(term.name).site.value)
    return any(one.joint == term.joint and one.site in sites
               and one.improvement > reason.improvement for one in nameless)


def gone_on(fitter: Fitter, found: SearchResult, names: Sequence[str],
            notify: Callable[[str], None]) -> SearchResult:
    """
    Return what was found with further causes, as long as what is left makes a name unsure.

    A search ends where less is left than is worth a cause. A curve may explain that for certain
    still, and it is a cause of these names that was not asked.
    """
    while not goodness_of_fit(fitter, found).is_clear:
        notify(f'looking for cause {len(found.last.accepted) + 1}')
        more = with_one_more(fitter, found, names)
        if more is None:
            break
        found = more
    return found


@dataclass(eq=False)
class _Search:
    """A search on its way."""

    _plain: Fitter
    _names: Sequence[str]
    _nameless: list[DiscrepancyTerm] = field(default_factory=list)
    _reasons: dict[Place, Reason] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Begin with an arm as it is known."""
        self._all = DiscrepancyTerms.along(self._plain)
        self._fitter, self._fit = self._plain, self._plain.first

    def run(self) -> BesideDiscrepancy:
        """Return what is found in the end."""
        while self._is_open() and self._extended():
            pass
        if self._nameless:
            while self._replaced():
                pass
            self._weigh()
        return BesideDiscrepancy(self._fitter, self._found(), tuple(self._nameless))

    def _found(self) -> SearchResult:
        """Return what is found of the catalogue by now."""
        evidence = tuple(self._reasons[term.place] for term in self._fit.accepted)
        return SearchResult(self._fitter.first, self._fit, evidence)

    def _is_open(self) -> bool:
        """Return whether what is left is worth a cause, or leaves a name unsure."""
        return (open_rest(self._fitter, self._fit)
                or not goodness_of_fit(self._fitter, self._found()).is_clear)

    def _extended(self) -> bool:
        """Take the best cause, with a name or without; return whether there was one."""
        fitter, fit = self._fitter, self._fit
        step = next_cause(fitter, fitter.first, fit, self._names)
        curve = self._all.best(fitter, fit, fitter.arm.labels)
        # A law and its curve explain nearly the same, and then the law has the name.
        if self._is_room and curve.improvement > max(CERTAIN, (
                fit.score - step[0].score if step else 0.0) / NEARLY_ALL):
            self._take(curve, fit.accepted)
            return True
        taken = None if step is None else with_cause(
            fitter, fitter.first, fit, step, self._names, self._reasons)
        self._fit = taken or fit
        return taken is not None

    @property
    def _is_room(self) -> bool:
        return len(self._nameless) < _MOST

    def _take(self, cause: DiscrepancyTerm, beside: Sequence[Term]) -> None:
        """Take out of all balances what a cause without a name does, beside some others."""
        self._nameless.append(cause)
        plain = self._plain
        shapes = [shape for one in self._nameless
                  for shape in one.shapes(plain.first.balance.valid)]
        self._fitter = replace(plain, balancer=plain.balancer.beside(shapes),
                               twin=plain.twin and plain.twin.beside(shapes))
        self._fit = without_unneeded(self._fitter, self._fitter.first, self._fitter.fit(
            beside, self._fit.nuisance))

    def _replaced(self) -> bool:
        """
        Take a cause without a name for one with a name that explains no more, if there is one.

        A law of one number is a curve, and may explain as much as that.
        """
        for term in self._fit.accepted if self._is_room else ():
            without, others = self._without(term), self._fit.causes_beside(term)
            own = without.score - self._fit.score - freedom(self._fitter, term)
            curve = self._all.best(self._fitter, without, (
                self._fitter.arm.labels if term.joint is None else (term.joint,)))
            lead = SCORE_BAR if len(term.sought) > 1 else -SCORE_BAR
            if curve.improvement > max(CERTAIN, own - lead):
                self._take(curve, others)
                return True
        return False

    def _weigh(self) -> None:
        """Drop causes that are not the best of the catalogue beside all others; note why not."""
        for term in self._fit.accepted:
            step = next_cause(self._fitter, self._fitter.first, self._without(term), self._names)
            if step is None or step[0].accepted[-1].place != term.place:
                self._fit = self._fitter.fit(self._fit.causes_beside(term), self._fit.nuisance)
                self._weigh()
                return
            self._reasons[term.place] = step[1]

    def _without(self, term: Term) -> Fit:
        """Return the fit without a cause."""
        return self._fitter.without(self._fit, term)
