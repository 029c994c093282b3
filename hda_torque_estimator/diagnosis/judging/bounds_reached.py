"""
Numbers that end at a bound of what was declared for them: the law is not what was measured.

A friction law with an exponent of nearly zero is dry friction. One that fits best there stands in
for another cause, which must be named instead. A bound that is the neutral value of a number, like
a mass of zero, limits nothing. Nor does one where a part of the arm is gone (`Hypothesis.ends`).
A law of a torsion may end within its bounds as well: where its gear carries nothing any more.
"""

import math

from hda_arm_sim.model.effects import effect_named, Site
from hda_arm_sim.model.effects.hypothesis import Hypothesis
import numpy as np

from ..findings.report import at_place, Finding
from ..fitting.fit import Fit, Fitter
from ..fitting.hypotheses import HYPOTHESES
from ...least_squares.term import Term
from ...significance import MOSTLY, NORMAL_90

_ROUND = ('phase', 'direction')     # what these begin with turns round and has no end


def limits_of(effect: str, number: str) -> tuple[float, float]:
    """Return the bounds of a number beyond which its law ends, infinite where it does not."""
    rule = effect_named(effect).declaration(number)
    if number.startswith(_ROUND):
        return -math.inf, math.inf
    ends = number in HYPOTHESES.get(effect, Hypothesis()).ends
    return (-math.inf if ends or rule.low == rule.default else rule.low,
            math.inf if ends or rule.high == rule.default else rule.high)


def ends_at_limit(fitter: Fitter, fit: Fit, term: Term) -> bool:
    """
    Return whether a free number of a term in a fit ends at a limit, or may by its interval.

    An interval counts where its law ends. How far a body may reach is a choice: one of which that
    is not well known is a body still.
    """
    if (any(_room(fitter, term, number) <= 0.0 for number in term.free)
            or takes_gear_away(fitter, fit, term)):
        return True
    near = [number for number in term.free if math.isfinite(_room_of_law(term, number))]
    if not near:
        return False
    own = np.flatnonzero(fit.own(term))
    unsure = term.deviations_of_free(fitter.covariance(fit)[np.ix_(own, own)])
    return any(_room_of_law(term, number) <= _most(term, number, NORMAL_90 * unsure[number])
               for number in near)


def takes_gear_away(fitter: Fitter, fit: Fit, term: Term) -> bool:
    """
    Return whether a law of a torsion leaves its gear less than its link needs (eq:gone).

    A play wider than all torsions, and a gear that hardly resists, are no laws of a gear that
    moves a link. They fit where encoders show a torsion that is not there. Such a law takes away
    most of what the gear carries without it, and most of what its link needs beyond noise.
    """
    if effect_named(term.name).site is not Site.TORSION or fitter.is_unloaded(term.joint):
        return False
    joint, channel = fitter.own_channels(term.joint)[:2]
    valid = fitter.valid(fit.balance)[:, channel]
    through, asked = fitter.balancer.gear_torques(fitter.on(fit.terms))
    before, _ = fitter.balancer.gear_torques(fitter.on(fitter.terms_without(fit, term)))
    left, needed, carried = (
        float(np.mean(fitter.balancer.in_balance(torque[:, [joint]], channel)[valid] ** 2))
        for torque in (through, asked, before))
    return left < MOSTLY ** 2 * min(carried, needed - float(fitter.noise[channel]) ** 2)


def _room_of_law(term: Term, number: str) -> float:
    """Return how far a number of a term is within the nearest limit of its law."""
    value = getattr(term.effect, number)
    return float(min(abs(value - bound) for bound in limits_of(term.name, number)))


def _room(fitter: Fitter, term: Term, number: str) -> float:
    """Return how far a number of a term is within its nearest limit, that of the arm too."""
    room = _room_of_law(term, number)
    within = HYPOTHESES[term.name].within
    links = fitter.arm.links
    if number in within and links is not None:
        room = min(room, within[number](links) - abs(getattr(term.effect, number)))
    return room


def _most(term: Term, number: str, reach: float) -> float:
    """Return how far a number changes at most within a reach."""
    return max(abs(end - getattr(term.effect, number)) for end in term.interval(number, reach))


def limited(finding: Finding) -> str | None:
    """
    Return what is wrong with a finding of which a number reaches a limit, if one does.

    Its interval counts as far as it is one of noise: not where its law may have another form.
    """
    sought = HYPOTHESES.get(finding.effect, Hypothesis())
    loose = sought.form_share > Hypothesis.form_share
    for name, number in finding.parameters.items():
        if number.chosen:
            continue
        low, high = limits_of(finding.effect, name)
        least, most = ((number.value, number.value) if loose or name in sought.doubts else
                       (number.low, number.high))
        if least <= low or most >= high:
            interval = f'{number.value:.4g} [{number.low:.4g}, {number.high:.4g}] {number.unit}'
            return (f'{at_place(finding.effect, finding.joint)} is not named: its {name} = '
                    f'{interval.rstrip()} reaches the bound {low if least <= low else high:g}, '
                    'so another law is at work')
    return None
