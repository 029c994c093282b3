"""
Numbers of the arm that a fit holds at the end of their tolerance, though they would go on.

A tolerance is a measurement of a number. So what causes leave of it must be as small as noise, as
in any balance. A cause that stands in for another one bends what it may: inertias and stiffnesses
run to their ends. If such numbers had no tolerance and that explained much more, the causes beside
them explain too little (eq:beyond). At the site of a cause whose law has other forms it may be
one of these, and curves judge that.
"""

from collections.abc import Sequence

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.effects import effect_named, Site
from hda_arm_sim.model.effects.hypothesis import Hypothesis
import numpy as np

from .equal_noise import equal_noise_score, noise_in
from .law_forms import in_best_forms, InBestForms
from ..fitting.derivatives import IMPOSSIBLE
from ..fitting.fit import Fit, Fitter, moved
from ..fitting.hypotheses import HYPOTHESES
from ..fitting.nuisance import AnyTerm, CouplingInertia
from ..fitting.solve import at_end, Solution, solve
from ...least_squares.term import Place, Term
from ...significance import MOSTLY, SCORE_BAR

# (null: of 22 causes on 60 fresh records that were told rightly none had more than 13; stand-ins
# for one that was left out had 190 to 690)
_BAR = MOSTLY * Hypothesis.form     # improvement of the score that takes names back


def beyond_tolerance(fitter: Fitter, fit: Fit, allowed: Array) -> Array:
    """
    Return what numbers at the end of their tolerance would explain beyond it, by channel (c,).

    It is a share of what takes a name back. Causes have their best forms, as without these the
    numbers run to their ends for a form's sake. What the same numbers explain of a healthy arm is
    chance, and so is what they gain by making less noise. A channel in which they improve little
    shows nothing, nor does one where the power is `allowed` (c,) over noise: laws leave as much
    there.
    """
    formed = in_best_forms(fitter, fit)
    held = _solved(fitter, formed, ())
    ends = _at_end(fitter, formed, held)
    if not ends:
        return np.zeros_like(fitter.noise)
    free = _solved(fitter, formed, ends)
    gains, gain = held.scores - free.scores, held.score - free.score
    rows = np.maximum(fitter.effective * fitter.valid(fit.balance).sum(axis=0), 1.0)
    of_laws = (gains > 0.0) & (np.expm1(gains / rows) <= allowed)
    more = gain - gains[of_laws].sum() - _by_chance(fitter.healthy, ends)
    if more > SCORE_BAR:
        more -= _by_noise(fitter, formed, held, free)
    return np.where((gains > SCORE_BAR) & ~of_laws, max(more, 0.0) / _BAR, 0.0)


def _by_chance(healthy: Fitter | None, free: Sequence[Place]) -> float:
    """Return what numbers free of their tolerance explain of a healthy arm with as much noise."""
    if healthy is None:
        return 0.0
    first = in_best_forms(healthy, healthy.first)
    return max(_solved(healthy, first, ()).score - _solved(healthy, first, free).score, 0.0)


def _by_noise(fitter: Fitter, formed: InBestForms, held: Solution, free: Solution) -> float:
    """Return what numbers gain beyond their tolerance by making less noise, as `equal_noise`."""
    fit, count = formed.fit, len(formed.spread)
    try:
        within, beyond = (fitter.at(moved(fit.terms, found.step[count:]), len(fit.accepted),
                                    fit.slopes) for found in (held, free))
    except IMPOSSIBLE:
        return 0.0
    usual = noise_in(fitter, within)
    bought = [equal_noise_score(fitter, each, usual) - each.score for each in (within, beyond)]
    return max(bought[1] - bought[0], 0.0)


def _solved(fitter: Fitter, formed: InBestForms, free: Sequence[Place]) -> Solution:
    """Return the best step of a fit in which terms at some places are free of tolerances."""
    fit, columns, spread, _ = formed
    is_free = np.concatenate([np.full(term.size, term.place in free) for term in fit.terms])
    return solve(columns, fitter.noise, fitter.effective,
                 np.concatenate([np.zeros(len(spread)), fitter.away(fit.terms)]),
                 np.concatenate([spread, np.where(is_free, np.inf, fit.deviations)]))


def _at_end(fitter: Fitter, formed: InBestForms, held: Solution) -> list[Place]:
    """Return the places of terms of which a number is held at the end of its tolerance."""
    fit, _, spread, _ = formed
    is_held = at_end(fitter.away(fit.terms) + held.step[len(spread):], fit.deviations)
    taken = {(_site(term), term.joint) for term in fit.accepted
             if HYPOTHESES[term.name].varies}
    return [term.place for term in fit.nuisance
            if is_held[fit.own(term)].any() and (_site(term), term.joint) not in taken]


def _site(term: AnyTerm) -> Site:
    """Return where a term acts; what is tolerated is an effect, a zero, or a coupling of links."""
    if isinstance(term, Term):
        return effect_named(term.name).site
    return Site.LINK if isinstance(term, CouplingInertia) else Site.TORSION
