"""
Causes that leave themselves, times a curve of a coordinate that no published law of them follows.

What a right cause leaves is another form of its law, and these follow known coordinates
(`Hypothesis.varies`). A cable that pulls more from minute to minute is none: what pulls there has
another law, and its name is not known. So a cause that explains much more if it may vary along
another coordinate as well is in doubt (eq:other-law). What was taken out of the balances without a
name is asked of too, for it may be the rest of the same. Of a play nobody knows along what
published laws differ: it is not asked. Beside many causes, what one more effect of the catalogue
explains as well is one imperfection more.
"""

from collections.abc import Iterator
from dataclasses import replace

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.effects.hypothesis import Hypothesis
import numpy as np

from .law_forms import (
    factors_along, in_best_forms, InBestForms, left_by_forms, reformed, spread_of, WAVES)
from .screening import one_more
from .search import SearchResult
from ..balances.coordinates import coordinates_of, of_motion
from ..fitting.fit import Fit, Fitter
from ..fitting.hypotheses import HYPOTHESES
from ..fitting.solve import condense_more, solve
from ...least_squares.term import Place, Term
from ...significance import CERTAIN, HARDLY, MOSTLY, NEARLY_ALL

# Numerics; choices unless stated otherwise.
_ALONG = ('time', 'joint_torque', 'link_angle', 'motor_velocity')    # that laws of joints follow
_LEAST = 1e-300         # size of a shape, below which it is none


def of_other_laws(fitter: Fitter, found: SearchResult) -> list[Term]:
    """
    Return the causes that explain more, for certain, if they vary as no law of theirs does.

    Beside causes without a name it must be most of what these explain, all taken together.
    """
    trained, fitter = fitter.rows.mean(), fitter.everywhere()
    fit = fitter.settled(found.last)
    bar = CERTAIN
    if fitter.balancer.aside:
        fitter, beside = replace(fitter, balancer=fitter.balancer.beside(())), fit
        fit = fitter.fit(fit.accepted, fit.nuisance)
        bar = max(CERTAIN, MOSTLY * (fit.score - beside.score))
    if not fit.accepted:
        return []
    rows = fitter.effective * fitter.valid(fit.balance).sum(axis=0)
    bar += float(rows @ np.log1p(left_by_forms(fitter, fit) / fitter.noise ** 2))
    formed, reasons = in_best_forms(fitter, fit), found.reasons()
    gains = dict[Place, float]()
    for term in filter(_has_known_forms, formed.fit.accepted):
        share = HYPOTHESES[term.name].form_share * reasons[term.place].improvement / trained
        most = max(_gains(fitter, formed, term), default=0.0)
        if most > bar + share:
            gains[term.place] = most
    if gains:
        for more, improvement in one_more(fitter, reformed(fitter, fit), found.names):
            gains = {(name, joint): gain for (name, joint), gain in gains.items()
                     if joint not in (None, more.joint) or improvement < NEARLY_ALL * gain}
    return [term for term in found.last.accepted if term.place in gains]


def _has_known_forms(term: Term) -> bool:
    """Return whether it is known along what published laws of a cause differ, if they do."""
    sought = HYPOTHESES[term.name]
    return bool(sought.varies) or sought.form_share <= Hypothesis.form_share


def _gains(fitter: Fitter, formed: InBestForms, term: Term) -> Iterator[float]:
    """Yield what a cause explains more if it varies along each coordinate that its laws do not."""
    fit, columns, spread, forms = formed
    known = {*HYPOTHESES[term.name].varies}
    known |= {WAVES[name] for name in known & WAVES.keys()}
    valid, count = fitter.valid(fit.balance), len(spread)
    away = np.concatenate([np.zeros(count), fitter.away(fit.terms)])
    deviations = np.concatenate([spread, fit.deviations])
    before = solve(columns, fitter.noise, fitter.effective, away, deviations).score
    for name in _ALONG:
        if name in known:
            continue
        more = _varying(fitter, fit, term, name)
        size = more.shape[2]
        wide = condense_more(columns, fit.balance.residual,
                             np.concatenate([forms, fit.columns], axis=2), more, valid)
        prior = np.full(size, spread_of(np.array(Hypothesis.reach)))
        after = solve(wide, fitter.noise, fitter.effective,
                      np.concatenate([np.zeros(size), away]),
                      np.concatenate([prior, deviations]))
        gram = np.einsum('c,cpq->pq', fitter.effective / after.variance,
                         wide.products[:, :size, :size])
        freedom = np.linalg.slogdet(np.eye(size) + prior[:, None] * gram * prior)[1]
        yield before - after.score - float(freedom)


def _varying(fitter: Fitter, fit: Fit, term: Term, coordinate: str) -> Array:
    """
    Return what a cause does times curves of a coordinate (m, c, p), each as strong as the cause.

    They are orthogonal to it and to each other, in units of noise. No law follows the noise of the
    readings, which the coordinates and the balances both have.
    """
    valid, count = fitter.valid(fit.balance), len(fitter.arm.labels)
    lacking = fitter.residual(fitter.terms_without(fit, term), fit.slopes.noise)
    does = np.where(valid, (fit.balance.residual - lacking) / fitter.noise, 0.0)
    balances = does.shape[1] // count
    power = (does ** 2).reshape(len(does), balances, count).sum(axis=1)
    along = {name: of_motion(values) for name, values in
             coordinates_of(fitter.balancer, fitter.on(fit.terms)).items()}
    along['time'] = np.tile(fitter.balancer.time[:, None], count)
    factors = [np.stack(list(factors_along(power[:, place], {
        coordinate: along[coordinate][:, place]}, (coordinate,))), axis=1)
        for place in range(count)]
    shapes = does[:, :, None] * np.concatenate([np.stack(factors, axis=1)] * balances, axis=1)
    flat = np.concatenate([does.reshape(-1, 1), shapes.reshape(does.size, -1)], axis=1)
    sizes = np.maximum(np.sqrt((flat ** 2).sum(axis=0)), _LEAST)
    basis, upper = np.linalg.qr(flat / sizes)
    apart = np.abs(np.diag(upper))[1:] > HARDLY
    made = sizes[0] * basis[:, 1:][:, apart]
    return np.asarray(made.reshape(*does.shape, -1) * fitter.noise[:, None])
