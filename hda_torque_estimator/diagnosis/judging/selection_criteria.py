"""
When a cause earns its place: by the score, and materially.

It must explain much more than its freedom buys, and be well above what a healthy arm leaves. What
the causes beside it may leave as one form of several is no reason for another, unless it explains
nearly all of that. More is asked of one that they are confused with. One that fits best where
a number of it is at its bound stands for another (`bounds_reached`). Where none is beside it, a
certain one may even be less than noise. One that is quick enough passes for noise until it is
known, and must stand out of what is noise then.
"""

from collections.abc import Sequence
from enum import Enum

from hda_arm_sim.model.effects.hypothesis import Hypothesis
import numpy as np
from numpy.typing import NDArray

from .bounds_reached import ends_at_limit
from .discrepancy_curves import is_worth_a_look
from .equal_noise import equal_noise_score, noise_in
from .law_forms import evidence, left_by_forms, powers, reformed
from .low_frequency import gain_below, power_below
from .null_distribution import by_chance
from ..balances.balance import BANDWIDTH
from ..fitting.fit import Fit, Fitter
from ..fitting.hypotheses import HYPOTHESES
from ...least_squares.term import Term
from ...significance import (CERTAIN, HARDLY, IMMATERIAL, MATERIAL, MOSTLY, NEARLY_ALL, SCORE_BAR,
                             surely_above)

Array = NDArray[np.float64]

# Improvement of the score that may pass for noise at first; silence and plans rest on it too. What
# is worth so much is surely beyond SCORE_BAR. A simple curve improved the score of healthy arms by
# 61 at most. At 300 a quick cogging that is worth 1735 was not looked at.
LOOKED_AT = surely_above(SCORE_BAR)

# Numerics; choices unless stated otherwise.
# (source: what laws do along motions of robots is nearly all below this)
SLOW = 10.0             # frequency [Hz] below which as much of the noise there is enough


class Standing(Enum):
    """What a term is in a fit."""

    CHANCE = 'no more than its freedom, or the forms of others, would explain'
    SMALL = 'there, and less than what is worth a cause'
    CAUSE = 'worth a cause'


def freedom(fitter: Fitter, term: Term) -> float:
    """Return what the freedom of a term costs (BIC): a number with a tolerance is not free."""
    return term.freedom * cost_of_number(fitter)


def cost_of_number(fitter: Fitter) -> float:
    """Return what the freedom of one number costs: ln(samples)."""
    return float(np.log(max(fitter.rows.sum() * fitter.effective, 2.0)))


def threshold(fitter: Fitter, term: Term) -> float:
    """Return the improvement of the score that a term must reach."""
    return SCORE_BAR + freedom(fitter, term)


def accepted(fitter: Fitter, first: Fit, without: Fit, extended: Fit, term: Term) -> bool:
    """Return whether a term of an `extended` fit earns its place in it, by a fit without it."""
    return standing(fitter, first, without, extended, term) is Standing.CAUSE


def standing(fitter: Fitter, first: Fit, without: Fit, extended: Fit, term: Term) -> Standing:
    """Return what a term of an `extended` fit is in it, by a fit without it."""
    beside = extended.causes_beside(term)
    improvement = without.score - extended.score
    if improvement < threshold(fitter, term) or ends_at_limit(fitter, extended, term):
        return Standing.CHANCE
    if not fitter.can_lack_each(extended):
        return Standing.CHANCE
    fair = without.score - equal_noise_score(fitter, extended, noise_in(fitter, without))
    if fair < threshold(fitter, term):
        return Standing.CHANCE
    if (np.isfinite(HYPOTHESES[term.name].below) and not fitter.balancer.is_commanded
            and not _follows_motion(fitter, without, extended, term)):
        return Standing.CHANCE              # what is quick is of commands that nobody recorded
    form = _form_power(fitter, first, without)
    formed = np.inf
    if beside:                              # other forms of what is known may explain as much
        formed = evidence(fitter, without) - evidence(fitter, extended, beside)
        if formed < threshold(fitter, term):
            return Standing.CHANCE
        without, extended = reformed(fitter, without), reformed(fitter, extended, beside)
    chance = by_chance(fitter, term)        # asked last: it takes a fit of the twin
    if chance > MOSTLY * improvement or improvement - chance < threshold(fitter, term):
        return Standing.CHANCE
    improvement = min(improvement - chance, fair, formed)
    if improvement > LOOKED_AT and alone(fitter, term, beside):
        return Standing.CAUSE
    gain, rest = without.variance - extended.variance, without.variance - fitter.noise ** 2
    slow = power_below(fitter, without, SLOW) - power_below(fitter, extended, SLOW)
    if not _is_material(fitter, gain, slow):
        return Standing.SMALL
    if _is_material(fitter, gain, slow, form):
        return Standing.CAUSE
    alike = any(term.name in HYPOTHESES[other.name].alike for other in beside
                if other.joint == term.joint)
    # Of one that it is confused with all but what is immaterial, which must be at least noise.
    least = fitter.noise ** 2 / IMMATERIAL if alike else floor(fitter)
    nearly_all = gain > (1.0 - IMMATERIAL if alike else NEARLY_ALL) * rest
    explains = improvement > CERTAIN and bool((nearly_all & (gain > least)).any())
    return Standing.CAUSE if explains else Standing.CHANCE


def _follows_motion(fitter: Fitter, without: Fit, extended: Fit, term: Term) -> bool:
    """
    Return whether a term explains what is slow: enough for a cause, and most of it (eq:of-motion).

    What a lag takes from noise of commands is mostly quick, but some of that noise is slow too.
    """
    before, after = (power_below(fitter, fit, SLOW) for fit in (without, extended))
    return bool(gain_below(fitter, without, extended, SLOW) >= threshold(fitter, term)
                and (before - after > MOSTLY * before).any())


def alone(fitter: Fitter, term: Term, beside: Sequence[Term]) -> bool:
    """Return whether no other term shows where a term does."""
    own = set(fitter.channels_of(term))
    return not any(own.intersection(fitter.channels_of(other)) for other in beside)


def _is_material(fitter: Fitter, gain: Array, slow: Array, form: Array | float = 0.0) -> bool:
    """
    Return whether a cause that explains so much is worth one beside others in some channel.

    It is by the power (c,) at all frequencies, or by that where arms move: there noise is less,
    and effects are not. The others may leave the power `form` (c,) as one form of several, all
    powers in [N^2*m^2].
    """
    return bool(((gain > np.maximum(floor(fitter), form))
                 | (slow > np.maximum(_slow_floor(fitter), form))).any())


def material(fitter: Fitter, first: Fit, fit: Fit) -> Array:
    """Return the power (c,) [N^2*m^2] of a slow effect that is worth a cause beside a fit's."""
    return np.maximum(_slow_floor(fitter), _form_power(fitter, first, fit, Hypothesis.form_error))


def _form_power(fitter: Fitter, first: Fit, fit: Fit, usual: float = 0.0) -> Array:
    """
    Return the power (c,) that causes of a fit may leave as one form of several [N^2*m^2].

    It is a share of what each does, and of no more than was wrong at `first`: some may cancel.
    Those that have other forms leave hardly anything beside the best of them (`left_by_forms`),
    unless they state more than that. Those that leave no more than is `usual` leave nothing.
    """
    excess = np.maximum(first.variance - fitter.noise ** 2, 0.0)
    left = [HYPOTHESES[term.name].form_error * np.minimum(power, excess)
            for term, power in zip(fit.accepted, powers(fitter, fit))
            if HYPOTHESES[term.name].form_error > (
                max(usual, HARDLY) if HYPOTHESES[term.name].varies else usual)]
    return np.max([left_by_forms(fitter, fit), *left], axis=0)


def floor(fitter: Fitter) -> Array:
    """Return the power (c,) that is far above noise [N^2*m^2]."""
    return np.asarray((MATERIAL * fitter.noise) ** 2)


def _slow_floor(fitter: Fitter) -> Array:
    """Return the power (c,) that is far above slow noise [N^2*m^2]; all of it is white."""
    return floor(fitter) * SLOW / BANDWIDTH


def open_rest(fitter: Fitter, fit: Fit) -> bool:
    """Return whether more is left than noise, or less that a simple curve explains for certain."""
    left = reformed(fitter, fit).variance
    if (left - fitter.noise ** 2 > floor(fitter)).any():
        return True
    quiet = quiet_joints(fitter, fit)
    return bool(quiet) and is_worth_a_look(fitter, fit, quiet, LOOKED_AT)


def quiet_joints(fitter: Fitter, fit: Fit) -> list[str]:
    """Return the joints at which nothing was accepted: less than noise is looked into there."""
    taken = {channel for term in fit.accepted for channel in fitter.channels_of(term)}
    return [label for label in fitter.arm.labels
            if not taken.intersection(fitter.own_channels(label))]


def confirmed(fitter: Fitter, first: Fit, last: Fit) -> tuple[Term, ...]:
    """
    Return the accepted terms of the `last` fit that stand out of noise as it is known now.

    One that passed for noise makes the noise less once it is known, and then stands out of it.
    """
    before = fitter.at(first.terms, 0, first.slopes)
    after = fitter.at(last.terms, len(last.accepted), last.slopes)
    slow = power_below(fitter, before, SLOW) - power_below(fitter, after, SLOW)
    is_clear = (before.variance - after.variance > floor(fitter)) | (slow > _slow_floor(fitter))
    return tuple(term for place, term in enumerate(last.accepted)
                 if not alone(fitter, term, last.accepted[:place] + last.accepted[place + 1:])
                 or is_clear[fitter.channels_of(term)].any())
