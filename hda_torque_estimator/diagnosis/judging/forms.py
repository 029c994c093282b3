"""
Other forms of a law: what a cause does, changed smoothly along the coordinates of its joint.

Books write one cause by several laws. Dry friction sets in at once or over some speed, is stronger
one way, or falls with time. Each is the law of the catalogue times a factor near one. The factor
is a smooth curve of what published laws differ in (eq:forms), declared beside the law
(`Hypothesis.varies`). A wave may have a harmonic as well. Coefficients have a prior; a form that
is far from the law is another law. Laws of the torsion have none: each is a curve of the torque,
and would be all of the others.
"""

from collections.abc import Iterator, Mapping, MutableMapping, Sequence
from dataclasses import replace
from typing import NamedTuple
from weakref import WeakKeyDictionary

from hda_arm_sim.foundation.arrays import Array
import numpy as np

from .nameless import SLOW
from ..balances.balance import Balance
from ..balances.coordinates import coordinates_of
from ..fitting.fit import Fit, Fitter
from ..fitting.hypotheses import HYPOTHESES
from ..fitting.solve import Columns, condense, Solution, solve
from ...least_squares.term import Term

# Choices unless told otherwise.
# (source: the laws of forms.py of the hidden truth are within 0.6 of those of the catalogue)
SPREAD = 0.25           # deviation of each coefficient: a share of what the cause does
FARTHEST = 0.25         # share of a cause's power beyond which a form is another law
_APART = 0.05           # of a form, that is its own beside those before it
_ACTS = 3.0             # deviations of its power over time within which a cause acts
_ORDERS = (1, 2, 4)     # waves per motor turn by which a cause that is a wave is changed
RATE_OF = 'rate'        # of what a cause does: laws of a drive differ by its time behaviour
# Of a wave along a coordinate: it may have a harmonic, where the motion has seen a whole wave.
WAVES = {'motor_waves': 'motor_angle', 'link_waves': 'link_angle'}
_AT_REST = 1e-300       # rms of a coordinate along which nothing moved


class _Forms(NamedTuple):
    """What all causes of a fit do, and their other forms, condensed with its columns."""

    columns: Columns            # those of the forms first
    counts: tuple[int, ...]     # of the forms of each cause
    powers: Array               # (causes, c) of what each does [N^2*m^2]


# What is remembered of a fit must not hold it, nor its fitter: neither would ever be forgotten.
_KNOWN: MutableMapping[Fitter, MutableMapping[Fit, _Forms]] = WeakKeyDictionary()


def reformed(fitter: Fitter, fit: Fit) -> Fit:
    """Return a fit whose causes have the form that fits best, itself where that is another law."""
    found, cost = _solved(fitter, fit, fit.accepted)
    if found is None or cost > fit.score:
        return fit
    own = _all_forms(fitter, fit, _lacking(fitter, fit))
    columns = np.concatenate([*own, fit.columns], axis=2)
    return replace(fit, balance=Balance(fit.balance.residual + columns @ found.step,
                                        fit.balance.valid),
                   variance=found.variance, score=found.score)


def evidence(fitter: Fitter, fit: Fit, causes: Sequence[Term] | None = None) -> float:
    """Return the score of a fit in which `causes`, or all, may have other forms, at their cost."""
    return min(_solved(fitter, fit, fit.accepted if causes is None else causes)[1], fit.score)


def formed_gain(fitter: Fitter, fit: Fit) -> float:
    """Return by how much other forms of its causes improve the score of a fit, less their cost."""
    return fit.score - evidence(fitter, fit)


def powers(fitter: Fitter, fit: Fit) -> Array:
    """Return the power (causes, c) of what each cause of a fit does [N^2*m^2]."""
    return _known(fitter, fit).powers


def _known(fitter: Fitter, fit: Fit) -> _Forms:
    """Return the forms of all causes of a fit, found once."""
    known = _KNOWN.setdefault(fitter, WeakKeyDictionary())
    if fit not in known:
        known[fit] = _condensed(fitter, fit)
    return known[fit]


def _solved(fitter: Fitter, fit: Fit, causes: Sequence[Term]) -> tuple[Solution | None, float]:
    """Return a fit with some causes in the forms that fit best, and its score with their cost."""
    condensed, counts, _ = _known(fitter, fit)
    chosen = np.repeat([term in causes for term in fit.accepted], counts)
    count = int(chosen.sum())
    if not count:
        return None, fit.score
    kept = np.flatnonzero(np.concatenate([chosen, np.ones(fit.columns.shape[2], bool)]))
    condensed = condensed._replace(products=condensed.products[:, kept[:, None], kept],
                                   against=condensed.against[:, kept])
    found = solve(condensed, fitter.noise, fitter.effective,
                  np.concatenate([np.zeros(count), fitter.away(fit.terms)]),
                  np.concatenate([np.full(count, SPREAD), fit.deviations]))
    owner = np.repeat(np.arange(len(counts)), counts)[chosen]
    if np.bincount(owner, found.step[:count] ** 2).max() > FARTHEST:
        return None, fit.score
    gram = np.einsum('c,cpq->pq', fitter.effective / found.variance,
                     condensed.products[:, :count, :count])
    freedom = float(np.linalg.slogdet(np.eye(count) + SPREAD ** 2 * gram)[1])
    return found, found.score + freedom


def _condensed(fitter: Fitter, fit: Fit) -> _Forms:
    """Return the forms of all causes of a fit, condensed with its columns."""
    valid = fitter.valid(fit.balance)
    lacking = _lacking(fitter, fit)
    own = _all_forms(fitter, fit, lacking)
    columns = np.concatenate([*own, fit.columns], axis=2)
    count = np.maximum(valid.sum(axis=0), 1)
    does = [((fit.balance.residual - other) ** 2).sum(axis=0, where=valid) / count
            for other in lacking]
    return _Forms(condense(fit.balance.residual, columns, valid),
                  tuple(part.shape[2] for part in own),
                  np.reshape(does, (len(does), len(fitter.noise))))


def _lacking(fitter: Fitter, fit: Fit) -> list[Array]:
    """Return the residuals (m, c) without each cause of a fit in turn."""
    return [fitter.residual(fit.terms_beside(term), fit.slopes.noise) for term in fit.accepted]


def _all_forms(fitter: Fitter, fit: Fit, lacking: Sequence[Array]) -> list[Array]:
    """Return what each cause of a fit does in other forms (m, c, p); `lacking` are without it."""
    return [_forms_of(fitter, fit, *each) for each in zip(fit.accepted, lacking)]


def _forms_of(fitter: Fitter, fit: Fit, term: Term, lacking: Array) -> Array:
    """
    Return what a cause does in other forms (m, c, p), each as strong as the cause itself.

    They are orthogonal to the cause and to each other, in units of noise. Residuals `lacking`
    (m, c) are those without it.
    """
    does = np.where(fitter.valid(fit.balance), fit.balance.residual - lacking, 0.0) / fitter.noise
    size = float(np.sqrt((does ** 2).sum()))
    if size == 0.0 or not HYPOTHESES[term.name].varies:
        return np.zeros((*does.shape, 0))
    flat = np.stack([shape.ravel() for shape in (
        does, *_otherwise(fitter, fit, term, does, lacking))], axis=1)
    basis, upper = np.linalg.qr(flat / np.maximum(np.sqrt((flat ** 2).sum(axis=0)), _AT_REST))
    apart = np.abs(np.diag(upper))[1:] > _APART
    made = size * basis[:, 1:][:, apart]
    return made.reshape(*does.shape, -1) * fitter.noise[:, None]


def _otherwise(fitter: Fitter, fit: Fit, term: Term, does: Array,
               lacking: Array) -> Iterator[Array]:
    """Yield what other forms of a cause do (m, c), in units of noise; `lacking` is without it."""
    varies = HYPOTHESES[term.name].varies
    if RATE_OF in varies:
        rate = np.gradient(does, axis=0)
        yield rate
        yield np.gradient(rate, axis=0)
    coordinates = coordinates_of(fitter.balancer, fitter.on(fit.terms))
    for name in WAVES.keys() & set(varies):
        angle = coordinates[WAVES[name]][:, fitter.arm.labels.index(str(term.joint))]
        if np.ptp(angle) * term.effect.order >= 2.0 * np.pi:
            for made in _harmonics(fitter, fit, term):
                yield (made - lacking) / fitter.noise
    clock = _clock_of(fitter.balancer.time, does)
    factors = [list(factors_along(clock, {
        name: values[:, place] for name, values in coordinates.items()}, varies))
        for place in range(len(fitter.arm.labels))]
    for each in zip(*factors):
        yield does * np.tile(np.stack(each, axis=1), 2)


def _harmonics(fitter: Fitter, fit: Fit, term: Term) -> Iterator[Array]:
    """Yield what is left (m, c) with twice the waves of a cause in its place, at two phases."""
    beside = fit.terms_beside(term)
    for phase in (0.0, 0.5 * np.pi):
        twice = replace(term.effect, phase=phase, order=2.0 * term.effect.order)
        yield fitter.residual([replace(term, effect=twice), *beside], fit.slopes.noise)


def _clock_of(time: Array, does: Array) -> Array:
    """Return the time (m,) about the middle of what a cause does (m, c), held where it ends."""
    power = (does ** 2).sum(axis=1)
    middle = float(power @ time / power.sum())
    reach = _ACTS * float(np.sqrt(power @ (time - middle) ** 2 / power.sum()))
    return np.clip(time - middle, -reach, reach)


def factors_along(time: Array, along: Mapping[str, Array],
                  varies: Sequence[str]) -> Iterator[Array]:
    """
    Yield factors (m,) along the coordinates of a joint on which laws of a cause differ.

    `time` (m,) counts from the middle of what the cause does [s].
    """
    for name in varies:
        if name == RATE_OF or name in WAVES:
            continue
        if name == 'time':
            yield from _powers(time, 2)
        elif name == 'sense':
            yield np.tanh(along['motor_velocity'] / SLOW)
        elif name == 'motor_angle':
            for order in _ORDERS:
                yield np.sin(order * along['motor_angle'])
                yield np.cos(order * along['motor_angle'])
        elif name == 'link_angle':
            yield from _powers(along[name] - along[name].mean(), 2)
        else:
            yield from _powers(np.abs(along[name]), 3)
            if name == 'joint_torque':
                yield np.tanh(along[name] / max(float(np.std(along[name])), _AT_REST))


def _powers(values: Array, most: int) -> Iterator[Array]:
    """Yield the powers of values (m,) over the largest of them."""
    scaled = values / max(float(np.abs(values).max()), _AT_REST)
    for power in range(1, most + 1):
        yield scaled ** power
