"""Weigh every hypothesis at once, to first order, before the best are fitted exactly."""

from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import NamedTuple

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import effect_named, Site
import numpy as np
from numpy.typing import NDArray

from ..fitting.derivatives import IMPOSSIBLE
from ..fitting.fit import Fit, Fitter
from ..fitting.hypotheses import terms_of, variant_of
from ..fitting.slopes import of_noise
from ..fitting.solve import Columns, condense, condense_more, Solution, solve
from ..fitting.starting_points import LOCATED, located
from ..fitting.steps import acts_apart
from ...least_squares.term import Term, with_terms
from ...significance import MANY, MATERIAL

Array = NDArray[np.float64]


class Prospect(NamedTuple):
    """A term at the size that the first order gives it, and the score it would reach."""

    term: Term
    score: float


def screen(fitter: Fitter, fit: Fit, names: Sequence[str]) -> list[Prospect]:
    """Return one prospect for every law and place, from its most promising start."""
    best: dict[tuple[object, ...], Prospect] = {}
    names = [name for name in names if _may_show(fitter, fit, effect_named(name).site)]
    known = condense(fit.balance.residual, fit.columns, fitter.valid(fit.balance))
    for name in names:
        for prospect in _possible(fitter, fit, known, name):
            key = (name, prospect.term.joint, *variant_of(prospect.term))
            if key not in best or prospect.score < best[key].score:
                best[key] = prospect
    return sorted((_with_all_numbers(fitter, fit, known, prospect) for prospect in best.values()),
                  key=lambda prospect: prospect.score)


def one_more(fitter: Fitter, fit: Fit, names: Sequence[str]) -> Iterator[tuple[Term, float]]:
    """
    Yield each of these effects that a fit of many causes lacks, and what it would improve.

    It is one imperfection more: too small for a cause, but of a known law. Beside few causes there
    is none, as it would have been found.
    """
    if len(fit.accepted) < MANY or not names:
        return
    taken = {term.place for term in fit.accepted}
    for term, score in screen(fitter, fit, names):
        if term.place not in taken:
            yield term, fit.score - score


def _with_all_numbers(fitter: Fitter, fit: Fit, known: Columns, prospect: Prospect) -> Prospect:
    """
    Return a prospect with all free numbers of its law where the first order has them.

    A grid holds few values of a number. A cable whose rest angle is not near one of them was
    weighed at a sixth of what it explains, and never tried.
    """
    term, arm = prospect.term, fitter.on(fit.terms)
    if term.waves or term.name in LOCATED or len(term.sought) < 2 or term.size > len(term.sought):
        return prospect
    here, steps = term.vector(), term.all_steps()
    vectors = [here, *(here + steps * (np.arange(term.size) == number)
                       for number in range(1, term.size))]
    try:
        shares = _shares(fitter, fit, known, [term.at(vector) for vector in vectors])
        whole = float(shares.sum())
        if whole == 0.0:
            return prospect
        now = here[0] if term.grown else getattr(arm.effect(*term.place), term.free[0])
        start = term.at(np.append(now, here[1:] + shares[1:] / whole * steps[1:]))
        better = [_weighed(fitter, fit, known, *each) for each in shifts(fitter, fit, [start])]
    except IMPOSSIBLE:
        return prospect
    return min(prospect, *better, key=lambda each: each.score)


def _shares(fitter: Fitter, fit: Fit, known: Columns, terms: Sequence[Term]) -> Array:
    """Return how much (d,) of each of these terms of one law together explains most."""
    shift = np.stack([_shift(fitter, fit, term) for term in terms], axis=2)
    return solved(fitter, fit, known, shift).step[:len(terms)]


def _shift(fitter: Fitter, fit: Fit, term: Term) -> Array:
    """Return what a term changes in the residual (m, c)."""
    arm = fitter.on(fit.terms)
    return fitter.change(fit.terms, term.on(arm)) - of_noise(term, arm, fit.slopes.noise)


def _may_show(fitter: Fitter, fit: Fit, site: Site) -> bool:
    """
    Return whether more than noise is left where effects of a site show most, or nowhere.

    Of led links, what a motor gives is held against the torsion alone, or against a sensor whose
    gain may take what a torsion has wrong into the balance of the motor.
    """
    joints = len(fitter.arm.labels)
    loud = fit.variance > (1.0 + MATERIAL ** 2) * fitter.noise ** 2
    loud |= not loud.any()
    if fitter.balancer.measurement.led:
        return bool(loud.any())
    where = {Site.MOTOR: loud[:joints], Site.TORSION: loud[joints:]}
    return bool(where.get(site, loud).any())


def _possible(fitter: Fitter, fit: Fit, known: Columns, name: str) -> list[Prospect]:
    """Return the prospects of one effect, none where the arm cannot have it."""
    try:
        return list(_prospects(fitter, fit, known, name))
    except IMPOSSIBLE:
        return []


def _prospects(fitter: Fitter, fit: Fit, known: Columns, name: str) -> Iterator[Prospect]:
    starts = (located(fitter, fit, name) if name in LOCATED else
              list(terms_of(fitter.on(fit.terms), name)))
    for start, shift in shifts(fitter, fit, starts):
        yield _weighed(fitter, fit, known, start, shift)


def shifts(fitter: Fitter, fit: Fit, starts: Sequence[Term]) -> Iterator[tuple[Term, Array]]:
    """Yield starts of one effect with what each of their directions changes (m, c, d)."""
    if not starts or not acts_apart(starts[0]):
        for start in starts:
            yield start, _shifts(fitter, fit, [start])[0]
        return
    per_joint = [list(group) for _, group in groupby(starts, key=lambda term: term.joint)]
    for together in zip(*per_joint):                # one simulation for all joints
        yield from zip(together, _shifts(fitter, fit, together))


def _shifts(fitter: Fitter, fit: Fit, starts: Sequence[Term]) -> list[Array]:
    """Return what the directions of each start change in the residual, starts all at once."""
    arm = fitter.on(fit.terms)
    changes = [fitter.change(fit.terms, with_terms(arm, trials)) - sum(
        of_noise(trial, arm, fit.slopes.noise) for trial in trials)
        for trials in zip(*(directions(start) for start in starts))]
    together = np.stack(changes, axis=2)
    if len(starts) == 1:
        return [together]
    parts = [np.zeros_like(together) for _ in starts]
    for part, start in zip(parts, starts):
        own = fitter.own_channels(start.joint)
        part[:, own] = together[:, own]
    return parts


def directions(start: Term) -> list[Term]:
    """Return the terms to which a start is compared: one for a size, two for each wave."""
    steps = start.all_steps()
    if start.free:
        vector = start.vector()
        if not start.grown:
            vector[0] += steps[0]
        return [start.at(vector)]
    trials = []
    for number in range(start.size):
        vector = start.vector()
        vector[number] += steps[number]
        trials.append(start.at(vector))
    return trials


def _weighed(fitter: Fitter, fit: Fit, known: Columns, start: Term,
             shift: Array) -> Prospect:
    """Return the first-order prospect of one start."""
    found = solved(fitter, fit, known, shift)
    sized = _sized(fitter.on(fit.terms), start, found.step[:shift.shape[2]])
    return Prospect(sized, fit.score if sized is start else found.score)


def solved(fitter: Fitter, fit: Fit, known: Columns, shift: Array) -> Solution:
    """Return the best step of a fit, its `known` columns condensed, and a `shift` (m, c, d)."""
    extra = shift.shape[2]
    return solve(condense_more(known, fit.balance.residual, fit.columns, shift,
                               fitter.valid(fit.balance)),
                 fitter.noise, fitter.effective,
                 np.concatenate([np.zeros(extra), fitter.away(fit.terms)]),
                 np.concatenate([np.full(extra, np.inf), fit.deviations]))


def _sized(arm: Arm, start: Term, shares: Array) -> Term:
    """Return the start at the size that the shares give, or itself where that is impossible."""
    vector = start.vector()
    if start.free:
        now = getattr(arm.effect(start.name, start.joint), start.free[0])
        full = directions(start)[0].vector()[0]
        vector[0] = now + float(np.clip(shares[0], -5.0, 5.0)) * (full - now)
        vector = start.short_of_bounds(vector)
    else:
        vector = vector + shares * start.all_steps()
    sized = start.at(vector)
    possible = np.allclose(sized.vector(), vector, rtol=1e-6, atol=1e-12)
    return sized if possible else start
