"""
Whether the causes that were found are backed: nothing is named on a rest that none explains.

A wrong cause takes the place of the right one and leaves a part of what it cannot describe. So a
joint takes back every cause that rests on it where much more is left than noise. It must also be
more than the accepted laws may leave as one form of several (`Hypothesis.form_error`). And so does
a rest of any size that a simple curve explains (`discrepancy_curves`), or a number of the arm
beyond its tolerance (`tolerances_reached`). What a simulated arm with the same causes leaves as
well, where none of them acts, is no rest.
"""

from collections.abc import Mapping, MutableMapping, Sequence
import math
from typing import NamedTuple
from weakref import WeakKeyDictionary

from hda_arm_sim.model.effects import effect_named
from hda_arm_sim.model.effects.hypothesis import Hypothesis
import numpy as np
from numpy.typing import NDArray

from .blamed_causes import acts_in, blamed_by, may_leave_across, of_joints, shown_by
from .discrepancy_curves import best_curves, Curve, improvement_of, sites, Usual, usual_curves
from .law_forms import evidence, left_by_forms, reformed
from .parameter_constancy import steady_shares
from .screening import one_more
from .search import SearchResult
from .tolerances_reached import beyond_tolerance
from ..balances.balance import Balancer, RATE
from ..balances.healthy_twin import healthy_twin, noise_of, torque_noise_of, TorqueNoise
from ..findings.certainty import margin_of_rest, margin_of_share
from ..findings.rest import GEAR, SENSOR
from ..fitting.fit import Fit, Fitter
from ..fitting.hypotheses import HYPOTHESES
from ...least_squares.term import Place, Term
from ...significance import CERTAIN, IMMATERIAL, MANY, MATERIAL, MOSTLY, NEARLY_ALL, SCORE_BAR

Array = NDArray[np.float64]
# Judgement; choices unless stated otherwise.
# (null: over ten seconds the noise is known to 40 %; one healthy arm in two left more)
_ENOUGH = 40.0          # of motion; over less, the level of noise is known less well [s]

# Sites of a curve and of a cause that show in other balances each.
_APART = ({'motor', 'torsion'}, {'motor', SENSOR})
# Numerics; choices unless stated otherwise.
_NOISE = 2              # seed of the noise of an arm that is simulated here; any other will do


class GoodnessOfFit(NamedTuple):
    """What was found, judged by what it leaves."""

    backed: tuple[Term, ...]            # accepted causes that may be named
    unexplained: NDArray[np.bool_]      # (c,) channels in which something has no name
    powers: Mapping[Place, Array]       # (c,) of what each accepted cause explains, over noise
    margins: Mapping[Place, float]      # by which each is no stand-in for what has no name
    nothing_left: float                 # margin by which all else is noise

    @property
    def is_clear(self) -> bool:
        """Return whether all has a name, and what is left leaves no name unsure."""
        return not self.unexplained.any() and min(self.margins.values(), default=1.0) >= 1.0

    def with_rest(self, channels: Sequence[int]) -> 'GoodnessOfFit':
        """Return the judgement where something in these channels has no name, for certain."""
        if not channels:
            return self
        unexplained = self.unexplained.copy()
        unexplained[list(channels)] = True
        return self._replace(unexplained=unexplained, nothing_left=min(self.nothing_left, -1.0))


# What is remembered must not hold what it is of: neither would ever be forgotten.
_KNOWN: MutableMapping[Fitter, MutableMapping[SearchResult, GoodnessOfFit]] = WeakKeyDictionary()


def goodness_of_fit(fitter: Fitter, found: SearchResult,
                    doubted: Sequence[Term] = ()) -> GoodnessOfFit:
    """
    Return which accepted causes are backed, and where something is unexplained.

    Causes that are `doubted` are not: what they explain has another site or another form. Causes
    may cancel each other, so each counts with no more power than was wrong at first. What was
    asked before without doubts is known: it is asked again where nothing nameless was found.
    """
    if doubted:
        return _judged(fitter, found, doubted)
    known = _KNOWN.setdefault(fitter, WeakKeyDictionary())
    if found not in known:
        known[found] = _judged(fitter, found, doubted)
    return known[found]


def _judged(fitter: Fitter, found: SearchResult, doubted: Sequence[Term]) -> GoodnessOfFit:
    """Judge what was found, as `goodness_of_fit` does."""
    trained = fitter.rows.mean()
    fitter = fitter.everywhere()
    noise = fitter.noise ** 2
    fit = fitter.settled(found.last)        # numbers within tolerances, by all rows
    lacking = [fitter.lacking(fit, term) for term in fit.accepted]
    powers = [np.maximum(without.variance - fit.variance, 0.0) for without in lacking]
    counted = {term.place: np.minimum(power, found.first.variance) / noise
               for term, power in zip(fit.accepted, powers)}
    over = {term.place: power / noise for term, power in zip(fit.accepted, powers)}
    by_forms = left_by_forms(fitter, fit) / noise
    allowed = sum((HYPOTHESES[name].form_error * power for (name, _), power in counted.items()),
                  by_forms)
    other = reformed(fitter, fit)
    left = other.variance / noise - 1.0
    noisy = MATERIAL ** 2 * _unsure(fit)
    bar = noisy + allowed
    if (left > bar).any():
        left = np.where(_followed(fitter, other, left), left,
                        np.minimum(left, _left_at_all_frequencies(fitter, fit)))
    if (others := _where_none_acts(fitter, over) & (left > bar)).any():
        left = left - np.where(others, _of_itself(fitter, fit), 0.0)
    beyond = beyond_tolerance(fitter, fit, allowed) if fit.accepted else np.zeros_like(noise)
    rests = np.maximum(left / bar, beyond)
    curves = _formed(fitter, other, found, counted, trained, by_forms)
    formed = [term for term in fit.accepted if curves[term.place].share > 1.0
              and _sure_of_share(left, noisy, over[term.place], curves[term.place]) < 1.0]
    apart = [*doubted, *shapeless(fitter, fit, lacking)]
    wrong = [*formed, *apart]
    doubtful = shown_by(fitter, wrong)
    seen = (rests > 1.0) | doubtful
    unexplained = of_joints(fitter, seen, doubtful,
                            (left <= bar + IMMATERIAL * _nameless_power(fitter, fit))
                            & (beyond <= 1.0))
    margins = {place: min(_margin_beside(left, (noisy, bar), power, curves[place]),
                          margin_of_rest(float(beyond[acts_in(power)].max())))
               for place, power in over.items()}
    blamed = blamed_by(seen, unexplained, left, over)
    if blamed:
        steady = steady_shares(fitter, fit, found.steady)
        margins |= {place: margin_of_rest(steady[place]) for place in blamed & steady.keys()}
        blamed -= steady.keys() - {term.place for term in apart}
    backed = tuple(term for term in found.last.accepted if term.place not in blamed)
    return GoodnessOfFit(backed, unexplained, over, margins, _margin(rests, unexplained))


def _margin_beside(left: Array, bars: tuple[Array, Array], power: Array,
                   curve: '_CurveLeft') -> float:
    """
    Return the margin by which a cause is no stand-in for what has no name.

    Beside it are `left` powers (c,) over noise, and what a `curve` explains. The `bars` (c,) are
    what noise may leave, and what takes its name back. Or it leaves hardly anything of its own
    `power` (c,).
    """
    noisy, bar = bars
    margin = margin_of_rest(max(float((left / bar)[acts_in(power)].max()), curve.share))
    of_share = _sure_of_share(left, noisy, power, curve)
    return margin if curve.share > 1.0 > of_share else max(margin, of_share)


def _sure_of_share(left: Array, noisy: Array, power: Array, curve: '_CurveLeft') -> float:
    """
    Return the margin by which a cause of a `power` (c,) leaves too little to be a stand-in.

    What a curve improves grows with the length of a recording, and this does not. It says nothing
    where more is `left` (c,) than is `noisy` (c,). A curve that would take the name back counts
    by what the cause does in the same balances: one that does much in one says nothing of another.
    """
    acts = acts_in(power)
    if (left > noisy)[acts].any():
        return -math.inf
    most, does = float(left[acts].max()), float(power.max())
    there = float(power[curve.channels].max()) if curve.share > 1.0 else does
    return margin_of_share(max(most / max(does, 1e-300), curve.power / max(there, 1e-300)))


def _nameless_power(fitter: Fitter, fit: Fit) -> Array:
    """Return the power (c,) over noise of what was taken out of the balances without a name."""
    balancer, balance = fitter.balancer, fit.balance
    if not balancer.aside:
        return np.zeros_like(fitter.noise)
    arm = fitter.on(fit.terms)
    taken = balancer.beside(())(arm).residual - balancer(arm).residual
    return np.asarray(_power(taken, balance.valid) / fitter.noise ** 2)


def _left_at_all_frequencies(fitter: Fitter, fit: Fit) -> Array:
    """
    Return the power (c,) that a fit leaves beyond noise, over that of noise, without whitening.

    A whitened balance shows what is far below the noise of the readings. That is worth a cause
    that a law or a curve explains, but by its level alone it is nothing that is wrong with an arm.
    """
    balancer, arm = fitter.balancer.unwhitened, fitter.on(fit.terms)
    if balancer is fitter.balancer:
        return np.full_like(fitter.noise, np.inf)
    balance = balancer(arm)
    noise = np.minimum(*(noise_of(balancer, each)[0] for each in (fitter.arm, arm)))
    power = _power(balance.residual, balance.valid)
    return np.asarray(power / np.maximum(noise, 1e-300) ** 2 - 1.0)


def _followed(fitter: Fitter, fit: Fit, left: Array) -> NDArray[np.bool_]:
    """
    Return in which channels (c,) a curve explains most of what is `left`, for certain.

    What it leaves itself counts as noise there.
    """
    followed = np.zeros(len(left), bool)
    rows = fitter.effective * fitter.valid(fit.balance).sum(axis=0)
    for label, curve in best_curves(fitter, fit, fitter.arm.labels).items():
        shown = list(sites(fitter, label)[curve.site])
        explained = np.expm1(curve.improvement / np.maximum(rows[shown].sum(), 1.0))
        followed[shown] = curve.improvement > CERTAIN and explained > MOSTLY * left[shown].min()
    return followed


def _where_none_acts(fitter: Fitter, powers: Mapping[Place, Array]) -> NDArray[np.bool_]:
    """Return the channels (c,) in which no cause has a power that counts."""
    none = np.ones(len(fitter.noise), bool)
    for power in powers.values():
        none &= power <= MATERIAL ** 2
    return none


def _of_itself(fitter: Fitter, fit: Fit) -> Array:
    """
    Return the power (c,) over noise that an arm leaves which has what was fitted, and no more.

    Its recording is simulated. A play or a stop makes its joint jump, and other joints feel that
    faster than samples and filters follow. This is left of the method, whatever arm was measured.
    """
    made = _simulated(fitter, fit)(fitter.on(fit.terms))
    return np.asarray(np.maximum(_power(made.residual, made.valid) / fitter.noise ** 2 - 1.0, 0.0))


def _simulated(fitter: Fitter, fit: Fit, more: TorqueNoise | None = None) -> Balancer:
    """Return the balances of a simulated recording of an arm that has what was fitted."""
    arm, balancer = fitter.on(fit.terms), fitter.balancer
    return balancer.like(healthy_twin(balancer, arm, _NOISE, more))


def _curves_of_itself(fitter: Fitter, fit: Fit) -> Usual:
    """
    Return what each curve improves of an arm which has what was fitted, and no more.

    Noise of readings is in a curve along them as in the balance. It is louder beside what was
    found, as beside a payload.
    """
    arm = fitter.on(fit.terms)
    plain = noise_of(fitter.balancer, fitter.as_noisy(fit))[1]
    other = fitter.of_twin(_simulated(fitter, fit, torque_noise_of(
        fitter.noise, plain, fitter.balancer, arm)), arm)
    return usual_curves(other, other.fit(fit.accepted, fit.nuisance))


def _power(values: Array, valid: NDArray[np.bool_]) -> Array:
    """Return the mean square (c,) of columns (m, c) where they are valid."""
    return np.asarray((values ** 2).sum(axis=0, where=valid) / np.maximum(valid.sum(axis=0), 1))


def _margin(rests: Array, unexplained: NDArray[np.bool_]) -> float:
    """Return the margin by which nothing is left, beyond even odds where something is."""
    margin = margin_of_rest(float(rests.max()))
    return min(margin, -1.0) if unexplained.any() else margin


def _unsure(fit: Fit) -> Array:
    """Return how much worse than over a long motion the noise of each channel (c,) is known."""
    seconds = np.maximum(fit.balance.valid.sum(axis=0), 1) / RATE
    return np.sqrt(np.maximum(_ENOUGH / seconds, 1.0))


class _CurveLeft(NamedTuple):
    """What the best curve without a name explains beside a cause."""

    share: float        # of what takes a name back
    power: float        # over noise
    channels: list[int]     # in which it shows


def _formed(fitter: Fitter, fit: Fit, found: SearchResult, powers: Mapping[Place, Array],
            trained: float, by_forms: Array) -> dict[Place, _CurveLeft]:
    """
    Return what a simple curve explains of the rest of each cause.

    A curve at the motor is not what a cause in the torsion leaves, nor the reverse, where another
    cause of the joint is nearer. At a joint without one it is held against those of the whole arm
    that act where it is.
    Whose curve it is cannot be identified among those that are near, so it may be what all of
    their laws leave together, and laws of several forms of the whole arm. The `powers` (c,) of the
    causes are over noise; what these improve was found on the share `trained` of the rows that are
    looked at. So is the power (c,) `by_forms` that their best forms may leave.
    """
    whole = [term for term in fit.accepted if term.joint is None]
    joints = fitter.arm.labels if whole else {str(term.joint) for term in fit.accepted}
    if not joints:
        return {}
    none = {term.place: _CurveLeft(0.0, 0.0, []) for term in fit.accepted}
    rows = fitter.effective * fitter.valid(fit.balance).sum(axis=0)
    shares = {
        place: HYPOTHESES[place[0]].form_share * reason.improvement / trained
        + float(rows @ np.log1p(HYPOTHESES[place[0]].form_power * powers[place]))
        for place, reason in found.reasons().items()}
    shared = sum(share for (name, joint), share in shares.items() if joint is None
                 and HYPOTHESES[name].form_share > Hypothesis.form_share)

    def doubts(curves: Mapping[str, Curve]) -> dict[Place, _CurveLeft]:
        formed = dict(none)
        for label, curve in curves.items():
            own = [term for term in fit.accepted if term.joint == label]
            shown = list(sites(fitter, label)[curve.site])
            acting = [term for term in whole if acts_in(powers[term.place])[shown].any()]
            joint = fitter.own_channels(label)
            does = float(np.expm1(curve.improvement / max(rows[joint].max(), 1.0)))
            near = [term for term in own or acting if {
                curve.site, effect_named(term.name).site.value} not in _APART] or [
                    term for term in own if may_leave_across(does, powers[term.place])]
            if not near:
                continue
            allowed = sum(shares[term.place] for term in near) + (shared if own else 0.0)
            allowed += float(rows[joint] @ np.log1p(by_forms[joint]))
            bar = allowed + max(_least(curve, term, powers[term.place].max()) for term in near)
            left = _CurveLeft(curve.improvement / bar, does, shown)
            formed |= {term.place: max(left, formed[term.place]) for term in near}
        return formed

    formed = doubts(best_curves(fitter, fit, joints))
    if margin_of_rest(max(one.share for one in formed.values())) >= 1.0:
        return formed               # nothing that a name would be less sure for
    curves = best_curves(fitter, fit, joints, _curves_of_itself(fitter, found.last))
    return doubts(_without_law(fitter, fit, curves, found.names))


def _without_law(fitter: Fitter, fit: Fit, curves: Mapping[str, Curve],
                 names: Sequence[str]) -> Mapping[str, Curve]:
    """
    Return what curves explain beside many causes, nothing where one more of these names does.

    It must be of the same site.
    """
    known = dict[str, float]()
    for term, improvement in one_more(fitter, fit, names):
        curve = curves.get(str(term.joint))
        if curve and curve.site in (GEAR, effect_named(term.name).site.value):
            known[curve.joint] = max(known.get(curve.joint, 0.0), improvement)
    return {label: curve._replace(improvement=0.0)
            if label in known and known[label] >= NEARLY_ALL * curve.improvement else curve
            for label, curve in curves.items()}


def _least(curve: Curve, term: Term, power: float) -> float:
    """Return the improvement by a curve from which a cause of so much power is doubted."""
    sought = HYPOTHESES[term.name]
    near = term.joint is None or curve.site in (GEAR, effect_named(term.name).site.value)
    return sought.form if near and power >= sought.clear else Hypothesis.form


def shapeless(fitter: Fitter, fit: Fit, lacking: Sequence[Fit]) -> list[Term]:
    """
    Return the causes of several numbers without which one curve explains as much.

    They have their best forms. A curve along an angle explains what a wave along it is. One that
    explains nothing for certain does not compete with what chance explains. Where many causes act,
    what the curve explains beside the cause as well is a rest of another one.
    """
    found = []
    for term, without in zip(fit.accepted, lacking):
        if term.freedom > 1 and term.joint is not None:
            curve = best_curves(fitter, without, (term.joint,))[term.joint]
            is_law = (curve.form in HYPOTHESES[term.name].contains
                      or bool(term.waves) and 'angle' in curve.form)
            of_law = is_law and curve.site in (GEAR, effect_named(term.name).site.value)
            lead = curve.score - evidence(fitter, fit, [term])
            if len(fit.accepted) >= MANY:
                lead += improvement_of(fitter, fit, curve)
            if curve.improvement > SCORE_BAR > lead and not of_law:
                found.append(term)
    return found
