"""
Other forms of a law: what a cause does, changed smoothly along the coordinates of its joint.

Books write one cause by several laws. Dry friction sets in at once or over some speed, is stronger
one way, or falls with time. Each is the law of the catalogue times a factor near one. The factor
is a smooth curve of what published laws differ in (eq:forms), declared beside the law
(`Hypothesis.varies`). It is as fine as the cause has power along that coordinate (eq:curves), so
no coordinate needs a scale. A wave may have a harmonic as well. Coefficients have a prior; a form
that is farther from the law than published ones (`Hypothesis.reach`) is another law.
"""

from collections.abc import Iterable, Iterator, Mapping, MutableMapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple
from weakref import WeakKeyDictionary

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.effects.effect import Effect, Site
import numpy as np

from .discrepancy_curves import SLOW
from .friction_path import (bent_over, built_up, LINK_PATH, ONSET, other_paths, set_in,
                            TORSION_PATH)
from .push_course import courses, PUSH
from ..balances.balance import Balance
from ..balances.coordinates import coordinates_of, of_motion
from ..fitting.derivatives import IMPOSSIBLE
from ..fitting.fit import FAR, Fit, Fitter, moved, PASSES
from ..fitting.hypotheses import HYPOTHESES
from ..fitting.nuisance import AnyTerm
from ..fitting.solve import Columns, condense, Solution, solve
from ...least_squares.bounds import bounded
from ...least_squares.term import Place, Term
from ...significance import HARDLY, IMMATERIAL

# Numerics; choices unless stated otherwise.
_ORDERS = (1, 2, 4)     # waves per motor turn by which a cause that is a wave is changed
_PHASES = (0.0, 0.5 * np.pi)    # of a wave, that make one of any phase [rad]
_SLOW = 0.1             # waves per turn that are none, of a law of waves
_CURVES = 3             # smooth curves along a coordinate (choice)
_DIFFERENCES = (0.75, -0.15, 1.0 / 60.0)    # of neighbours by 1, 2, 3 samples: a rate
_NEARER, _SHORTER = 0.6, 20     # of a spread, and how often, until a form is within its reach
_DIGITS = 9             # of the largest of values, by which two are told apart (choice)
_AT_REST = 1e-300       # rms of a coordinate along which nothing moved
RATE_OF = 'rate'        # of what a cause does: laws of a drive differ by its time behaviour
ORDERS = 'orders'       # of a wave that has its own order and twice that: all others
# A wave may have a harmonic where the motion has seen a whole one, and else any course.
WAVES = {'motor_waves': 'motor_angle', 'link_waves': 'link_angle'}
_OTHERWISE = (RATE_OF, LINK_PATH, TORSION_PATH, ONSET, ORDERS, PUSH, *WAVES)     # no factors
# Coordinates that laws follow with their sign, and on which they go on evenly, whether a cause
# acts or not: a cable does nothing at its rest angle, and is the same law on both sides of it.
_SIGNED = ('time', 'link_angle')


class _Forms(NamedTuple):
    """What all causes of a fit do, and their other forms, condensed with its columns."""

    made: tuple[Array, ...]     # (m, c, p) of each cause
    columns: Columns            # those of the forms first
    powers: Array               # (causes, c) of what each does [N^2*m^2]


class _Best(NamedTuple):
    """What a fit leaves whose causes have the forms that fit best."""

    terms: tuple[AnyTerm, ...]  # beside whose numbers the forms were found
    own: Array                  # (p,) by which these numbers move with them
    residual: Array             # (m, c) that is left [N*m]
    found: Solution
    cost: float                 # the score of it, with what the freedom of the forms costs


# What is remembered of a fit must not hold it, nor its fitter: neither would ever be forgotten.
_KNOWN: MutableMapping[Fitter, MutableMapping[Fit, _Forms]] = WeakKeyDictionary()
_BEST: MutableMapping[Fitter, MutableMapping[Fit, dict[frozenset[Place], _Best | None]]] = (
    WeakKeyDictionary())


class InBestForms(NamedTuple):
    """A fit whose causes have the forms that fit best, ready to be solved with other priors."""

    fit: Fit                    # beside whose numbers these forms were found
    columns: Columns            # those of the forms first
    spread: Array               # (p,) of the forms
    forms: Array                # (m, c, p) what each does, none where no form pays


def reformed(fitter: Fitter, fit: Fit, causes: Sequence[Term] | None = None) -> Fit:
    """Return a fit whose `causes`, or all, have the forms that fit best; itself if none pays."""
    best = _best(fitter, fit, causes)
    if best is None or best.cost > fit.score:
        return fit
    return replace(fit, balance=Balance(best.residual, fit.balance.valid),
                   variance=best.found.variance, score=best.found.score)


def evidence(fitter: Fitter, fit: Fit, causes: Sequence[Term] | None = None) -> float:
    """Return the score of a fit in which `causes`, or all, may have other forms, at their cost."""
    best = _best(fitter, fit, causes)
    return fit.score if best is None else min(best.cost, fit.score)


def formed_gain(fitter: Fitter, fit: Fit) -> float:
    """Return by how much other forms of its causes improve the score of a fit, less their cost."""
    return fit.score - evidence(fitter, fit)


def in_best_forms(fitter: Fitter, fit: Fit) -> InBestForms:
    """Return a fit with all of its causes in their best forms, without forms if none pays."""
    best = _best(fitter, fit, None)
    if best is None or best.cost > fit.score:
        return InBestForms(fit, condense(fit.balance.residual, fit.columns,
                                         fitter.valid(fit.balance)), np.zeros(0),
                           np.zeros((*fit.balance.residual.shape, 0)))
    beside = fitter.at(best.terms, len(fit.accepted), fit.slopes)
    made, columns, _ = _known(fitter, beside)
    owner: Array = np.repeat(np.arange(len(made)), [part.shape[2] for part in made])
    return InBestForms(beside, columns, _within_reach(fitter, beside, columns, owner)[1],
                       np.concatenate(made, axis=2))


def left_by_forms(fitter: Fitter, fit: Fit) -> Array:
    """
    Return the power (c,) that best forms may leave: immaterial to what they explain [N^2*m^2].

    A form is a few curves, and no law of the literature is just these (eq:left-by-forms).
    """
    return IMMATERIAL * np.maximum(fit.variance - reformed(fitter, fit).variance, 0.0)


def powers(fitter: Fitter, fit: Fit) -> Array:
    """Return the power (causes, c) of what each cause of a fit does [N^2*m^2]."""
    return _known(fitter, fit).powers


def _known(fitter: Fitter, fit: Fit) -> _Forms:
    """Return the forms of all causes of a fit, found once."""
    known = _KNOWN.setdefault(fitter, WeakKeyDictionary())
    if fit not in known:
        known[fit] = _condensed(fitter, fit)
    return known[fit]


def _best(fitter: Fitter, fit: Fit, causes: Sequence[Term] | None) -> _Best | None:
    """Return what some causes, or all, leave in their best forms, None where none has any."""
    chosen = frozenset(term.place for term in (fit.accepted if causes is None else causes))
    known = _BEST.setdefault(fitter, WeakKeyDictionary()).setdefault(fit, {})
    if chosen not in known:
        known[chosen] = _formed(fitter, fit, chosen)
    return known[chosen]


def _formed(fitter: Fitter, fit: Fit, chosen: frozenset[Place]) -> _Best | None:
    """
    Return what the `chosen` causes leave in their best forms, None where none has any.

    Numbers that fit a law alone are not those of another form of it. After a far step what a
    cause does, and so its forms, are not as they were.
    """
    best, score = _solved(fitter, fit, chosen), fit.score
    for _ in range(PASSES):
        if best is None or score - best.cost < FAR:
            break
        try:
            beside = fitter.at(moved(best.terms, best.own), len(fit.accepted), fit.slopes)
        except IMPOSSIBLE:
            break
        nearer = _solved(fitter, beside, chosen)
        if nearer is None or nearer.cost > best.cost:
            break
        best, score = nearer, best.cost
    return best


def _solved(fitter: Fitter, fit: Fit, chosen: frozenset[Place]) -> _Best | None:
    """Return what the `chosen` causes leave in their best forms beside the numbers of a fit."""
    made, condensed, _ = _known(fitter, fit)
    counts = [part.shape[2] for part in made]
    is_own = np.repeat([term.place in chosen for term in fit.accepted], counts)
    count = int(is_own.sum())
    if not count:
        return None
    kept = np.flatnonzero(np.concatenate([is_own, np.ones(fit.columns.shape[2], bool)]))
    condensed = condensed._replace(products=condensed.products[:, kept[:, None], kept],
                                   against=condensed.against[:, kept])
    found, spread = _within_reach(fitter, fit, condensed,
                                  np.repeat(np.arange(len(counts)), counts)[is_own])
    gram = np.einsum('c,cpq->pq', fitter.effective / found.variance,
                     condensed.products[:, :count, :count])
    freedom = float(np.linalg.slogdet(
        np.eye(count) + spread[:, None] * gram * spread)[1])
    forms = [part for term, part in zip(fit.accepted, made) if term.place in chosen]
    columns = np.concatenate([*forms, fit.columns], axis=2)
    return _Best(fit.terms, found.step[count:], fit.balance.residual + columns @ found.step, found,
                 found.score + freedom)


def _within_reach(fitter: Fitter, fit: Fit, condensed: Columns,
                  owner: Array) -> tuple[Solution, Array]:
    """
    Return the best forms of causes, none of them another law, and the spread (p,) they have.

    `owner` (p,) says whose each form is. A law that would go farther has less spread.
    """
    reach = np.array([HYPOTHESES[term.name].reach for term in fit.accepted])
    spread = spread_of(reach)[owner]
    away = np.concatenate([np.zeros(len(owner)), fitter.away(fit.terms)])
    for _ in range(_SHORTER):
        found = solve(condensed, fitter.noise, fitter.effective, away,
                      np.concatenate([spread, fit.deviations]))
        far = np.bincount(owner, found.step[:len(owner)] ** 2) / reach[:owner.max() + 1]
        if far.max() <= 1.0:
            break
        spread = np.where(far[owner] > 1.0, _NEARER * spread, spread)
    return found, spread


def spread_of(reach: Array) -> Array:
    """Return the deviation of each coefficient where curves together go as far as a `reach`."""
    return np.asarray(np.sqrt(reach / _CURVES))


def _condensed(fitter: Fitter, fit: Fit) -> _Forms:
    """Return the forms of all causes of a fit, condensed with its columns."""
    valid = fitter.valid(fit.balance)
    lacking = [fitter.residual(fitter.terms_without(fit, term), fit.slopes.noise)
               for term in fit.accepted]        # of each cause in turn
    own = tuple(_forms_of(fitter, fit, *each) for each in zip(fit.accepted, lacking))
    columns = np.concatenate([*own, fit.columns], axis=2)
    count = np.maximum(valid.sum(axis=0), 1)
    does = [((fit.balance.residual - other) ** 2).sum(axis=0, where=valid) / count
            for other in lacking]
    return _Forms(own, condense(fit.balance.residual, columns, valid),
                  np.reshape(does, (len(does), len(fitter.noise))))


def _forms_of(fitter: Fitter, fit: Fit, term: Term, lacking: Array) -> Array:
    """
    Return what a cause does in other forms (m, c, p), each as strong as the cause itself.

    Those of another push are as much stronger as a force does more at its time. All are orthogonal
    to the cause and to each other, in units of noise. Residuals `lacking` (m, c) are those without
    it.
    """
    does = (fit.balance.residual - lacking) / fitter.noise
    valid = fitter.valid(fit.balance)
    size = float(np.sqrt((does ** 2).sum(where=valid)))
    if size == 0.0 or not HYPOTHESES[term.name].varies:
        return np.zeros((*does.shape, 0))
    level = _level(fitter, fit, term, lacking)
    if level is not None:       # what is level in a piece of a wave is none of a wave
        both = float((does * level).sum(where=valid)) ** 2
        size *= float(np.sqrt(max(1.0 - both / max(
            size ** 2 * float((level ** 2).sum(where=valid)), _AT_REST), 0.0)))
    others = [(shape, 1.0) for shape in _otherwise(fitter, fit, term, does, lacking, level)]
    if PUSH in HYPOTHESES[term.name].varies:
        others += courses(fitter, fit, term.effect, lacking)
    flat = np.stack([np.where(valid, shape, 0.0).ravel() for shape in (
        does, *(shape for shape, _ in others))], axis=1)
    shown = flat.any(axis=1)                # of what passes, a short time
    basis, upper = np.linalg.qr(
        flat[shown] / np.maximum(np.sqrt((flat ** 2).sum(axis=0)), _AT_REST))
    apart = np.abs(np.diag(upper))[1:] > HARDLY     # of as many as there are rows, at most
    made = np.zeros((len(flat), int(apart.sum())))
    strengths = np.array([strength for _, strength in others[:len(apart)]])[apart]
    made[shown] = size * strengths * basis[:, 1:][:, apart]
    return made.reshape(*does.shape, -1) * fitter.noise[:, None]


def _otherwise(fitter: Fitter, fit: Fit, term: Term, does: Array, lacking: Array,
               level: Array | None) -> Iterator[Array]:
    """
    Yield what other forms of a cause do (m, c), in units of noise; `lacking` is without it.

    A wave of which the motion saw only a piece has a `level`.
    """
    varies = HYPOTHESES[term.name].varies
    if LINK_PATH in varies:
        yield from built_up(fitter, fit, term, does)
    if TORSION_PATH in varies:
        yield from _instead(fitter, fit, term, other_paths(term), lacking)
        yield from bent_over(fitter, fit, term, does)
    if RATE_OF in varies:
        rate = _rate(does)
        yield rate
        yield _rate(rate)
    if ORDERS in varies:
        yield from _instead(fitter, fit, term, _other_orders(term.effect), lacking)
    beside = HYPOTHESES[term.name].beside(term.effect)
    if not {(one.name, term.joint) for one in beside} & {one.place for one in fit.accepted}:
        yield from _instead(fitter, fit, term, beside, lacking)
    coordinates = coordinates_of(fitter.balancer, fitter.on(fit.terms))
    if term.effect.site is not Site.TORSION:    # whose laws follow it as it was read
        coordinates['joint_torque'] = of_motion(coordinates['joint_torque'])
    if ONSET in varies:
        place = fitter.arm.labels.index(str(term.joint))
        yield from set_in(fitter, fit, term, does, coordinates['motor_velocity'][:, place])
    for name in WAVES.keys() & set(varies):
        if level is None:
            waves = [_wave(term.effect, phase, 2.0 * term.effect.order) for phase in _PHASES]
            yield from _instead(fitter, fit, term, waves, lacking)
        else:
            angle = coordinates[WAVES[name]][:, fitter.arm.labels.index(str(term.joint))]
            yield from (level * curve[:, None]
                        for curve in _curves(angle, (level ** 2).sum(axis=1)))
    power = np.where(fitter.valid(fit.balance), does, 0.0) ** 2
    count = len(fitter.arm.labels)
    factors = [list(factors_along(
        np.asarray(sum(power[:, own] for own in fitter.own_channels(label))),
        {'time': fitter.balancer.time,
         **{name: values[:, place] for name, values in coordinates.items()}}, varies))
        for place, label in enumerate(fitter.arm.labels)]
    for each in zip(*factors):
        yield does * np.tile(np.stack(each, axis=1), does.shape[1] // count)


def _level(fitter: Fitter, fit: Fit, term: Term, lacking: Array) -> Array | None:
    """Return what a wave would do as a level (m, c), None where the motion saw a whole wave."""
    for name in WAVES.keys() & set(HYPOTHESES[term.name].varies):
        angle = coordinates_of(fitter.balancer, fitter.on(fit.terms))[WAVES[name]][
            :, fitter.arm.labels.index(str(term.joint))]
        if np.ptp(angle) * term.effect.order < 2.0 * np.pi:
            slow = _wave(term.effect, _PHASES[1], _SLOW)
            return next(_instead(fitter, fit, term, [slow], lacking))
    return None


def _wave(effect: Effect, phase: float, order: float) -> Effect:
    """Return a law of waves with another phase and order, the nearest one that it may have."""
    numbers: dict[str, Any] = {'phase': phase, **bounded(type(effect), {'order': order})}
    return replace(effect, **numbers)


def _other_orders(effect: Effect) -> Iterator[Effect]:
    """Yield a law of a wave and of one twice as often with the other whole orders it may have."""
    own = effect.order      # type: ignore[attr-defined]
    last = bounded(type(effect), {'order': np.inf})['order']
    for order in np.arange(1.0, last + 1.0):
        if order not in (own, 2.0 * own):
            yield from (_wave(effect, phase, order) for phase in _PHASES)


def _rate(values: Array) -> Array:
    """Return by how much columns (m, c) grow in a sample, exact up to half of what they hold."""
    return np.asarray(sum(share * (np.roll(values, -lag, axis=0) - np.roll(values, lag, axis=0))
                          for lag, share in enumerate(_DIFFERENCES, 1)))


def _instead(fitter: Fitter, fit: Fit, term: Term, effects: Iterable[Effect],
             lacking: Array) -> Iterator[Array]:
    """Yield what other numbers of a cause do (m, c), in units of noise."""
    beside = fitter.terms_without(fit, term)
    for effect in effects:
        made = fitter.residual([replace(term, effect=effect), *beside], fit.slopes.noise)
        yield (made - lacking) / fitter.noise


def factors_along(power: Array, along: Mapping[str, Array], varies: Sequence[str],
                  count: int = _CURVES) -> Iterator[Array]:
    """
    Yield factors (m,) along the coordinates of a joint on which laws of a cause differ.

    They vary where the cause has its `power` (m,). A `count` of curves follows time itself, and as
    many a link's angle.
    """
    for name in varies:
        if name in _OTHERWISE:
            continue
        if name == 'sense':
            yield np.tanh(along['motor_velocity'] / SLOW)
        elif name == 'load_sense':
            yield np.tanh(along['joint_torque'] / max(float(np.std(along['joint_torque'])),
                                                      _AT_REST))
        elif name == 'motor_angle':
            for order in _ORDERS:
                yield np.sin(order * along['motor_angle'])
                yield np.cos(order * along['motor_angle'])
        else:
            signed = name in _SIGNED
            yield from _curves(along[name] if signed else np.abs(along[name]), power,
                               count if signed else 0)


def _curves(values: Array, power: Array, count: int = 0) -> Iterator[Array]:
    """
    Yield smooth curves (m,) that are as fine as there is power (m,) along values (eq:curves).

    They are Chebyshev polynomials of the share of the power that smaller values have, and a
    `count` of them, first, of the values themselves.
    """
    order = np.argsort(np.round(values / np.max(np.abs(values), initial=_AT_REST), _DIGITS),
                       kind='stable')       # what rounding alone parts keeps the order of time
    share = np.empty_like(values)
    share[order] = np.cumsum(power[order])
    low, high = np.min(values[power > 0.0], initial=np.inf), np.max(
        values[power > 0.0], initial=-np.inf)
    for along, whole, most in ((values - low, high - low, count),
                               (share, float(power.sum()), _CURVES)):
        angle = np.arccos(np.clip(2.0 * along / max(whole, _AT_REST) - 1.0, -1.0, 1.0))
        yield from (np.cos(order * angle) for order in range(1, most + 1))
