"""
Judge what was found, and prove it on stretches that no fit has seen, until nothing more goes.

What a dropped cause explained is a rest without a name. So where one goes, the others are fitted
again and judged by what is left without it. Verdict and names beside it are those of any rest.
"""

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from typing import NamedTuple

from hda_arm_sim.model.arm import Arm

from .balances.balance import Balancer
from .findings.gains import gains
from .findings.report import Alike, at_place, Finding
from .fitting.fit import Fit, Fitter
from .fitting.instruments import unbiased
from .fitting.nuisance import is_of_log
from .judging.curvature import straight
from .judging.goodness_of_fit import goodness_of_fit, GoodnessOfFit
from .judging.held_out_gain import held_out_gain
from .judging.look_alikes import with_all_alike
from .judging.other_laws import of_other_laws
from .judging.search import SearchResult
from .judging.selection_criteria import accepted
from .judging.sensor_scale import in_place_of_gain
from .judging.site_pattern import misplaced
from .judging.verdict import alike, certain, findings
from ..least_squares.term import Place, Term, with_terms
from ..measurements.running_clock import Spans


class Grounds(NamedTuple):
    """What a conclusion rests on, for those who show it."""

    fitter: Fitter
    fit: Fit                    # of the backed causes alone
    twin: Balancer              # a healthy recording of the extended arm
    before: Arm                 # as given, with the encoders' zeros of this recording
    extended: Arm               # likewise
    held_out: Spans

    def as_measured(self, fitter: Fitter) -> 'Grounds':
        """Return the same with all that was measured, what has no name as well, as it is left."""
        fit = self.fit
        return self._replace(fitter=fitter, fit=fitter.at(fit.terms, len(fit.accepted),
                                                          fit.slopes))

    def without(self, places: Collection[Place]) -> 'Grounds':
        """Return the same without causes at some places, all others as they are."""
        fit = self.fit
        for term in fit.accepted:
            if term.place in places:
                fit = self.fitter.lacking(fit, term)
        return self._replace(fit=fit, extended=self.fitter.on(fit.terms))


class Proven(NamedTuple):
    """What remains of what was found, each cause judged and proven beside all others."""

    found: SearchResult                    # without the causes that were dropped
    judged: GoodnessOfFit
    kept: Fit                       # of the backed causes, before the last step of their numbers
    evidence: Grounds
    pairs: tuple[Alike, ...]        # of which one gains
    findings: tuple[Finding, ...]
    remarks: tuple[str, ...] = ()   # on dropped causes that explained what has no name now


def proven(fitter: Fitter, found: SearchResult, twin: Balancer, given: Arm, held_out: Spans,
           notify: Callable[[str], None]) -> Proven:
    """
    Return what remains when causes that gain nothing on held-out stretches are gone.

    `twin` is a healthy recording of the arm with all that was found, `given` the arm as it is
    stated. `notify` hears what is being done.
    """
    nameless: list[Term] = []
    while True:
        notify('judging the causes')
        doubted = (*misplaced(fitter, found), *straight(fitter, found),
                   *in_place_of_gain(fitter, found), *of_other_laws(fitter, found))
        judged = goodness_of_fit(fitter, found, doubted)
        notify('measuring the gain on held-out stretches')
        kept = found.with_only(fitter, judged.backed)
        left = _tried(found, judged, kept, _evidence(fitter, kept, twin, given, held_out))
        dropped = _dropped(left)
        if not dropped:
            rest = [channel for term in nameless for channel in fitter.channels_of(term)]
            return left._replace(judged=judged.with_rest(rest),
                                 pairs=with_all_alike(fitter, found, left.pairs),
                                 remarks=tuple(map(_unproven, nameless)))
        nameless += [term for term in dropped if _is_worth_a_cause(fitter, found, term)]
        found = found.keeping(fitter, [term for term in found.last.accepted
                                       if term not in dropped])


def _evidence(fitter: Fitter, kept: Fit, twin: Balancer, given: Arm,
              held_out: Spans) -> Grounds:
    """Return what a conclusion from a fit rests on, with numbers that no noise has moved."""
    stands = unbiased(fitter, kept, twin)
    of_log = filter(is_of_log, stands.nuisance)
    return Grounds(fitter, stands, twin, with_terms(given, of_log), fitter.on(stands.terms),
                   held_out)


def _tried(found: SearchResult, judged: GoodnessOfFit, kept: Fit, evidence: Grounds) -> Proven:
    """Return what was found with the gains of its backed causes on held-out stretches."""
    pairs = tuple(pair for pair in alike(found, judged) if _gains(evidence, pair))
    return Proven(found, judged, kept, evidence, pairs,
                  _findings(evidence, found, pairs, judged))


def _dropped(left: Proven) -> list[Term]:
    """Return the backed causes that are neither found to gain nor one of two that do."""
    named = {(one.effect, one.joint) for one in left.findings}
    named.update(place for pair in left.pairs for place in pair.effects)
    return [term for term in left.judged.backed if term.place not in named]


def _is_worth_a_cause(fitter: Fitter, found: SearchResult, term: Term) -> bool:
    """
    Return whether what a cause explains would still be accepted, on held-out stretches as well.

    What chance explained on the others alone is no rest.
    """
    everywhere = fitter.everywhere()
    fit = everywhere.settled(found.last)
    own, = (other for other in fit.accepted if other.place == term.place)
    return accepted(everywhere, found.first, everywhere.without(fit, own), fit, own)


def _unproven(term: Term) -> str:
    return (f'{at_place(term.name, term.joint)} is not named: it gains nothing on '
            'stretches that no fit has seen, so what it explained has no name')


def _findings(evidence: Grounds, found: SearchResult, pairs: Sequence[Alike],
              judged: GoodnessOfFit) -> tuple[Finding, ...]:
    """Return the backed causes that no runner-up ties with, as findings."""
    tied = {place for pair in pairs for place in pair.effects}
    nameable = [term for term in evidence.fit.accepted if term.place not in tied]
    reasons = found.reasons()
    terms = {term.place: term for term in nameable}
    taken = {term.place for term in evidence.fit.accepted}
    return tuple(
        replace(one, probability=certain(judged, reasons[one.effect, one.joint],
                                         terms[one.effect, one.joint], taken))
        for one in findings(evidence.fitter, evidence.fit, reasons, nameable, evidence.twin,
                            evidence.held_out))


def _gains(evidence: Grounds, pair: Alike) -> bool:
    """Return whether one of two causes gains on held-out data: that of them which a fit holds."""
    fitter, fit = evidence.fitter, evidence.fit
    own = [term for term in fit.accepted if term.place in pair.effects]
    return (any(gains(fitter.balancer, evidence.twin, fitter.on(fitter.terms_without(fit, term)),
                      fitter.on(fit.terms), evidence.held_out).removed() > 0.0 for term in own)
            or any(held_out_gain(fitter, fit, term, evidence.twin, evidence.held_out)
                   for term in own))
