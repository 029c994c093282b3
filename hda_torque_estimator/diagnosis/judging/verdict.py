"""From fits to findings: causes with intervals, runners-up, gains, and what is left."""

from collections.abc import Collection, Mapping, Sequence
from itertools import product

from hda_arm_sim.model.effects import effect_named
from hda_arm_sim.model.effects.hypothesis import Hypothesis
import numpy as np
from numpy.typing import NDArray

from .forward_selection import Reason
from .goodness_of_fit import GoodnessOfFit
from .held_out_gain import held_out_gain
from .search import SearchResult
from .selection_criteria import LOOKED_AT
from ..balances.balance import Balancer
from ..findings.certainty import probability
from ..findings.report import (
    Alike, Evidence, Finding, FittedNumber, OwnGain, Residual, RunnerUp, with_gain)
from ..findings.rest import SENSOR
from ..findings.smallest import size_numbers
from ..fitting.fit import Fit, Fitter
from ..fitting.hypotheses import HYPOTHESES
from ...least_squares.term import Place, Term
from ...measurements.running_clock import Spans
from ...significance import CERTAIN, DEVIATIONS, NORMAL_90

Array = NDArray[np.float64]
TIED = DEVIATIONS ** 2  # difference of scores below which two causes explain equally well
NO_MOTION = ('none that moves the arm, as no motion separates them; read the torque of the drive '
             'in a dwell at zero command')


def findings(fitter: Fitter, fit: Fit, reasons: Mapping[Place, Reason], nameable: Sequence[Term],
             twin: Balancer, spans: Spans) -> tuple[Finding, ...]:
    """
    Return the causes of a fit that may be named, with numbers, evidence and own gain.

    A cause that does not gain on the held-out stretches, or no more there than its placebo, is
    not named. Nor is one that has vanished without others. The largest comes first.
    """
    covariance, gaining = fitter.covariance(fit), []
    for term in fit.accepted:
        if term not in nameable or _vanished(term):
            continue
        own = fit.own(term)
        part = covariance[own][:, own]
        gain = held_out_gain(fitter, fit, term, twin, spans)
        if gain is not None:
            reason = reasons[term.place]
            gaining.append(_finding(fitter, term, part, reason, gain, rival_of(reason, term, fit)))
    return tuple(sorted(with_gain(gaining), key=lambda finding: -finding.evidence.score))


def _vanished(term: Term) -> bool:
    """Return whether nothing is left of an effect but its shape."""
    kind, others = type(term.effect), HYPOTHESES[term.name].instead
    return all(getattr(term.effect, number) == kind.declaration(number).default
               for number in (*size_numbers(term.name), *others))


def _finding(fitter: Fitter, term: Term, covariance: Array, reason: Reason,
             gain: OwnGain, rival: RunnerUp | None) -> Finding:
    kind = effect_named(term.name)
    name = None if reason.runner_up is None else reason.runner_up.name
    odds = float(np.exp(min(0.5 * reason.runner_up_gap, 700.0)))
    return Finding(
        term.name, term.joint, kind.site.value, kind.cause, numbers_of(fitter, term, covariance),
        Evidence(reason.improvement, reason.threshold, name, odds, rival), gain)


def rival_of(reason: Reason, term: Term, fit: Fit) -> RunnerUp | None:
    """
    Return the runner-up as it was fitted in the place of a cause, None without one.

    One that was found beside the cause is no runner-up of it.
    """
    rival = reason.runner_up
    if rival is None or rival.place in {beside.place for beside in fit.accepted}:
        return None
    named = [*rival.sought, *(name for wave in rival.waves for name in wave)]
    numbers = {} if _vanished(rival) else {
        name: _number(rival, name, np.nan) for name in
        dict.fromkeys([*HYPOTHESES[rival.name].chosen, *named]) if getattr(rival.effect, name)}
    return RunnerUp(rival.joint, numbers, 1.0 - probability(lead_of(reason, term)))


def numbers_of(fitter: Fitter, term: Term, covariance: Array) -> dict[str, FittedNumber]:
    """Return the numbers of a term with 90 % intervals; waves as order, amplitude and phase."""
    reach = NORMAL_90 * np.sqrt(np.maximum(np.diag(covariance), 0.0))
    unsure = term.deviations_of_free(covariance)
    numbers = {name: _number(term, name, 0.0) for name in HYPOTHESES[term.name].chosen
               if getattr(term.effect, name)}
    for name in term.sought:
        numbers[name] = _number(term, name, float(np.hypot(NORMAL_90 * unsure[name], _doubt(
            fitter, term, name))))
    for place, (amplitude, phase) in enumerate(term.waves):
        size = getattr(term.effect, amplitude)
        wide = float(reach[len(term.free) + 2 * place:][:2].mean())
        numbers[amplitude] = _number(term, amplitude, wide)
        numbers[phase] = _number(term, phase, wide / max(size, 1e-300))
    return numbers


def _doubt(fitter: Fitter, term: Term, name: str) -> float:
    """Return by how much a number is in doubt because its law has several forms."""
    sought = HYPOTHESES[term.name]
    if name in sought.doubts:
        share, whole = sought.doubts[name]
        return share * (abs(getattr(term.effect, whole)) if whole else 1.0)
    if sought.form_share <= Hypothesis().form_share:
        return 0.0
    nominal = getattr(fitter.arm.effect(*term.place), name)
    return float(np.sqrt(sought.form_error)) * abs(getattr(term.effect, name) - nominal)


def _number(term: Term, name: str, reach: float) -> FittedNumber:
    """Return a number within a reach, NaN where that is not known."""
    value, rule = getattr(term.effect, name), type(term.effect).declaration(name)
    low, high = term.interval(name, reach) if name in term.free else (value - reach, value + reach)
    return FittedNumber(value, rule.unit, max(low, rule.low), min(high, rule.high))


def alike(found: SearchResult, judged: GoodnessOfFit) -> tuple[Alike, ...]:
    """Return the backed causes that a runner-up, or a twin by nature, explains as well."""
    pairs, taken = [], {term.place for term in found.last.accepted}
    for term, reason in zip(found.last.accepted, found.evidence):
        if term not in judged.backed:
            continue
        rival, sought = reason.runner_up, HYPOTHESES[term.name]
        unclear = judged.powers[term.place].max() < sought.clear
        twin = sought.alike[0] if unclear else sought.twin
        other: Place | None = (twin, term.joint) if twin else None
        contender = _contender(reason, term, taken)
        if contender is not None and reason.runner_up_gap < tied(reason, term):
            other = contender.place
        if other is not None:
            by_nature = sought.twin and other == (sought.twin, term.joint)
            near = rival is not None and rival.place == other and not by_nature
            pairs.append(Alike(
                (term.place, other), NO_MOTION if by_nature else sought.experiment,
                probability=probability(min(judged.margins[term.place],
                                            reason.improvement / reason.threshold)),
                lead=probability(lead_of(reason, term)) if near else 0.5))
    return tuple(pairs)


def _contender(reason: Reason, term: Term, taken: Collection[Place]) -> Term | None:
    """
    Return the runner-up that could be meant in the place of a cause, None without one.

    One with more numbers does not count: one that contains the cause always explains as well. But
    where it is worth more than they cost, only another form of the cause explains as much. Nor
    does one count that was found beside it, at a place that is `taken`.
    """
    rival = reason.runner_up
    if rival is None or rival.place in taken:
        return None
    is_richer = rival.freedom > term.freedom and reason.runner_up_more < TIED
    return None if is_richer else rival


def certain(judged: GoodnessOfFit, reason: Reason, term: Term, taken: Collection[Place]) -> float:
    """Return the probability of a cause beside those `taken`: that of its weakest support."""
    lead = np.inf if _contender(reason, term, taken) is None else lead_of(reason, term)
    return probability(min(judged.margins[term.place], reason.improvement / reason.threshold,
                           lead))


def lead_of(reason: Reason, term: Term) -> float:
    """Return the margin by which a cause leads its runner-up, in differences that tie."""
    if reason.runner_up is None:
        return np.inf
    return reason.runner_up_gap / tied(reason, term)


def tied(reason: Reason, term: Term) -> float:
    """
    Return the difference of scores below which a cause and its runner-up tie.

    No law is better than its form. Of two laws of one curve (`of_one_curve`), others may explain
    as much more as both state, and no more than those of a usual one. Up to `lead_share` they may
    do so unless that is surely worth a cause. A disc must lead the straight line that it is
    confused with by what a bend must show.
    """
    share, rival, unsure = Hypothesis.form_error, reason.runner_up, 0.0
    if rival is not None and rival.joint == term.joint:
        one, other = HYPOTHESES[term.name], HYPOTHESES[rival.name]
        if of_one_curve(term.place, rival.place):
            share = min(one.form_share + other.form_share, Hypothesis.form_share)
            unsure = min(Hypothesis.lead_share * reason.improvement, LOOKED_AT)
        if one.bends and rival.name in one.alike:
            unsure = CERTAIN
    return max(TIED, unsure, share * reason.improvement)


def of_one_curve(one: Place, other: Place) -> bool:
    """Return whether the laws of two places act at one joint along the same coordinate."""
    along, of_other = (HYPOTHESES[name].varies for name, _ in (one, other))
    return one[1] == other[1] and bool(set(along) & set(of_other))


def residuals(fitter: Fitter, first: Fit, last: Fit,
              held_out: NDArray[np.bool_]) -> tuple[Residual, ...]:
    """Return what each balance misses on held-out rows, rms [N*m at the output]."""
    rows = []
    third = fitter.balancer.measurement.thrice_witnessed
    sites = ('motor', 'torsion', *([SENSOR] if third.any() else []))
    for place, (site, label) in enumerate(product(sites, fitter.arm.labels)):
        if site == SENSOR and not third[fitter.arm.labels.index(label)]:
            continue
        left = []
        for fit in (first, last):
            valid = fit.balance.valid[:, place] & held_out
            left.append(float(np.sqrt(np.mean(fit.balance.residual[valid, place] ** 2)))
                        if valid.any() else np.nan)
        rows.append(Residual(site, label, left[0], left[1], float(fitter.noise[place])
                             if last.balance.valid[:, place].any() else np.nan, 'N*m'))
    return tuple(rows)
