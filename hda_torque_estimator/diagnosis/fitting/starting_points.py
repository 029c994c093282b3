"""
Where to start a fit of effects that no fixed grid reaches: at a time, at a frequency.

The start is read from what is left: J^T F of one force that begins and ends stands out in all
joints for a while. A base that swings answers the links' own acceleration at one frequency.
"""

from collections.abc import Callable
from itertools import pairwise
from typing import Any, NamedTuple, TypeAlias

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.chain import ANGLE, place, tip_velocity
from hda_arm_sim.foundation.compiled import compiled
from hda_arm_sim.foundation.rigid import tip_torque
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.chain_links import ChainLinks
from hda_arm_sim.model.effects import Effect, effect_named
from hda_arm_sim.model.effects.catalogue import sole_at
from hda_arm_sim.model.effects.hypothesis import SearchStart
from hda_arm_sim.model.effects.place import TIP
from hda_arm_sim.model.kernel import LINK_ANGLE
from hda_arm_sim.model.link_side import loaded_inertia
import numpy as np
from numpy.typing import NDArray
from scipy.signal import fftconvolve

from .fit import Fit, Fitter
from .hypotheses import free_of, HYPOTHESES
from ..balances.balance import Balancer, RATE
from ..balances.swinging import swing_in
from ...least_squares.normal import TINY
from ...least_squares.term import looked_for, Term
from ...measurements.running_clock import Spans
from ...significance import MANY, STANDS_OUT, UNLIKE

# Numerics; choices unless stated otherwise.
DURATIONS = np.geomspace(0.2, 6.0, 18)      # of contacts that are tried [s]
_CLEAR = 1.25           # durations from a contact's begin to that of another
_NEAR = 0.3             # before and after a contact, where fits see all [s]
_AROUND = 0.25          # before and after a contact, of its duration, that is close to it

Numbers: TypeAlias = dict[str, float]           # of an effect, by their names


class ContactStart(NamedTuple):
    """One force on the tip for some time, with the power that it explains."""

    power: float                # over that of noise
    force: tuple[float, ...]    # along x and y of the base frame, of a chain z too [N]
    onset: float                # [s]
    duration: float             # [s]


def located(fitter: Fitter, fit: Fit, name: str) -> list[Term]:
    """Return the starts that the rest of a fit gives an effect, none where nothing stands out."""
    numbers = _READ[HYPOTHESES[name].start](fitter, fit)
    return [] if numbers is None else [_term(fitter.arm, effect_named(name)(**numbers))]


def contact_in(balancer: Balancer, arm: Arm, residual: Array, valid: NDArray[np.bool_],
               noise: Array) -> ContactStart | None:
    """Return the strongest force on the tip that stands out of a residual, None without any."""
    return next(iter(contacts_in(balancer, arm, residual, valid, noise)), None)


def contacts_in(balancer: Balancer, arm: Arm, residual: Array, valid: NDArray[np.bool_],
                noise: Array) -> list[ContactStart]:
    """
    Return the forces on the tip that stand out of a residual (m, c), the strongest first.

    They must be few and as long, far above every other time, fit one force each, and show in both
    balances alike. A smooth rest of another cause does not. What equal forces do may differ as
    much as that: where there may be fewer or more, they are those with most between.
    """
    if arm.links is None:
        return []
    joints = len(arm.labels)
    levers = leverage(balancer, arm)
    weight = valid / noise ** 2
    of_links = slice(joints, 2 * joints)
    sets = _standing_out(_sums(levers, residual[:, of_links], weight[:, of_links]))
    motor = _sums(levers, residual[:, :joints], weight[:, :joints])
    around = (weight[:, of_links] * residual[:, of_links] ** 2).sum(axis=1)

    def is_one_force(contact: ContactStart) -> bool:
        force, normal = _at(motor, contact)         # what it does to the joints must agree
        miss = force - contact.force
        near = float(around[_around(balancer.time, contact)].sum())
        return (contact.power > (1.0 - UNLIKE) * near
                and float(miss @ normal @ miss) < UNLIKE * float(force @ normal @ force))

    return next((found for found in sets if all(map(is_one_force, found))), [])


def split_at_contacts(balancer: Balancer, arm: Arm, noise: Array, training: Spans,
                      held_out: Spans) -> tuple[Spans, Spans]:
    """
    Return the stretches where fits see begin and end of each contact, and not its middle.

    Each is there once: stretches that alternate without regard to it would have all of it in
    those for fits, or none. Without a contact they stay as they are.
    """
    balance = balancer(arm)
    residual = balance.residual - np.median(balance.residual, axis=0)
    contacts = contacts_in(balancer, arm, residual, balance.valid, noise)
    pushes = sorted((one.onset, one.onset + one.duration) for one in contacts)
    borders = [0.0, *(0.5 * (one[1] + other[0]) for one, other in pairwise(pushes)), np.inf]
    near = tuple((max(begin - _NEAR, low), min(end + _NEAR, high))
                 for (begin, end), (low, high) in zip(pushes, pairwise(borders)))
    middles = tuple(_middle(*push) for push in pushes)
    return (tuple(sorted((*_without(training, near), *_without(near, middles)))),
            tuple(sorted((*_without(held_out, near), *middles))))


def _middle(begin: float, end: float) -> tuple[float, float]:
    """Return what fits do not see of a contact: not its edges, but some windows [s]."""
    centre, duration = 0.5 * (begin + end), end - begin
    reach = float(np.clip(0.15, 0.2 * duration, 0.3 * duration))
    return centre - reach, centre + reach


def _without(spans: Spans, taken: Spans) -> Spans:
    """Return spans of time without others."""
    for begin, end in taken:
        parts = (part for first, last in spans
                 for part in ((first, min(last, begin)), (max(first, end), last)))
        spans = tuple((first, last) for first, last in parts if first < last)
    return spans


def leverage(balancer: Balancer, arm: Arm) -> Array:
    """Return the torques of unit forces along x, y, of a chain z, on every joint (m, n, d) [m]."""
    angle = balancer.motion(arm).state[::balancer.every, :, LINK_ANGLE]
    if isinstance(arm.links, ChainLinks):
        made = np.empty((*angle.shape, 3))
        _levers(loaded_inertia(arm.record().body).table, np.ascontiguousarray(angle), made)
        return made
    links = arm.moving_links()
    elbow = angle[:, 1] if angle.shape[1] == 2 else np.zeros(len(angle))
    sides = [np.stack(tip_torque(links.length1, links.length2, angle[:, 0], elbow, *force), axis=1)
             for force in np.eye(2)]
    return np.stack(sides, axis=2)[:, :angle.shape[1]]


@compiled
def _levers(c: Array, angle: Array, made: Array) -> None:
    """Fill what a force on the tip of a chain does to its joints (m, n, 3), at angles (m, n)."""
    for k in range(angle.shape[0]):
        c[1:-1, ANGLE] = angle[k]
        place(c)
        for j in range(angle.shape[1]):
            made[k, j, 0], made[k, j, 1], made[k, j, 2] = tip_velocity(c, j + 1)


def _sums(leverage: Array, residual: Array, weight: Array) -> Array:
    """Return the normal equations of a force, per sample: matrix and right side (m, d, d + 1)."""
    matrix = np.einsum('mj,mja,mjb->mab', weight, leverage, leverage)
    right = np.einsum('mj,mja->ma', weight * residual, leverage)
    return np.concatenate([matrix, right[:, :, None]], axis=2)


def _profile(duration: float) -> Array:
    """Return the course of a contact of 1 N, from its begin on at the balances' rate."""
    time = np.arange(round(duration * RATE) + 1) / RATE
    contact: Any = sole_at(TIP)
    return np.asarray(contact(force=1.0, duration=duration)(time=time)[0])


def _forces(sums: Array, profile: Array) -> tuple[Array, Array]:
    """Return for every onset the force (k, d) of a profile and the power that it explains (k,)."""
    back, ways = profile[::-1, None, None], sums.shape[1]
    normal = fftconvolve(sums[:, :, :ways], back ** 2, 'valid', axes=0)
    right = fftconvolve(sums[:, :, ways], back[:, :, 0], 'valid', axes=0)
    size = np.trace(normal, axis1=1, axis2=2)
    ridge = max(1e-6 * float(size.max()), 1e-100)   # where nothing is valid, no force
    force = np.linalg.solve(normal + ridge * np.eye(ways), right[:, :, None])[:, :, 0]
    return np.asarray(force, float), np.asarray((force * right).sum(axis=1), float)


def _standing_out(sums: Array) -> list[list[ContactStart]]:
    """
    Return the contacts of the best duration that explain far more than one at other times.

    As many are first as have most between them and the next. Beside several there are other times
    for more than half of a recording.
    """
    tried = [_apart(sums, duration) for duration in DURATIONS[len(sums) > 2 * RATE * DURATIONS]]
    best = max(tried, key=lambda found: found[0].power, default=[])
    room = 0.5 * len(sums) / (2.0 * _CLEAR * best[0].duration * RATE) if best else 0.0
    gaps = {count: best[count - 1].power / max(best[count].power, TINY)
            for count in range(1, len(best)) if count == 1 or count <= room}
    return [best[:count] for count in sorted(gaps, key=lambda count: -gaps[count])
            if gaps[count] >= STANDS_OUT]


def _apart(sums: Array, duration: float) -> list[ContactStart]:
    """Return the best contacts of one duration at times apart, one more than there may be."""
    force, power = _forces(sums, _profile(duration))
    free, found = power.copy(), []
    for _ in range(MANY):               # so many are another cause's rest
        at = int(np.argmax(free))
        found.append(ContactStart(float(free[at]), tuple(force[at].tolist()), at / RATE, duration))
        free[np.abs(np.arange(len(free)) - at) <= _CLEAR * duration * RATE] = 0.0
    return found


def _at(sums: Array, contact: ContactStart) -> tuple[Array, Array]:
    """Return the force (d,) by other sums for the time of a contact [N], and its weight (d, d)."""
    profile = _profile(contact.duration)
    first, ways = round(contact.onset * RATE), sums.shape[1]
    own = sums[first:first + len(profile)]
    return _forces(own, profile)[0][0], np.einsum('mab,m->ab', own[:, :, :ways], profile ** 2)


def _around(time: Array, contact: ContactStart) -> NDArray[np.bool_]:
    """Return which times are within a contact or close to it."""
    begin, end = span_of(contact.onset, contact.duration)
    return np.asarray((time > begin) & (time < end))


def span_of(onset: float, duration: float) -> tuple[float, float]:
    """Return begin and end of a contact and what is close to it [s]."""
    return onset - _AROUND * duration, onset + duration + _AROUND * duration


def _touch(fitter: Fitter, fit: Fit) -> Numbers | None:
    """Return the contact that stands out of the rest of a fit."""
    found = contact_in(fitter.balancer, fitter.on(fit.terms), fit.balance.residual,
                       fitter.valid(fit.balance), fitter.noise)
    if found is None:
        return None
    x, y, z = (*found.force, 0.0)[:3]
    level = float(np.hypot(x, y))
    return {'force': float(np.hypot(level, z)), 'direction': float(np.arctan2(y, x)),
            'onset': found.onset, 'duration': found.duration,
            'elevation': float(np.arctan2(z, level))}


def _swing(fitter: Fitter, fit: Fit) -> Numbers | None:
    """Return the mode of the base that stands out of the rest of a fit."""
    found = swing_in(fitter.balancer, fitter.on(fit.terms), fit.balance.residual,
                     fitter.valid(fit.balance), fitter.noise)
    return None if found is None else found._asdict()


def _term(arm: Arm, start: Effect) -> Term:
    """Return the term that begins at this effect, with the free numbers of its hypothesis."""
    return looked_for(start, None, free_of(arm, start.name), {}, {}, grown=True)


_READ: dict[SearchStart, Callable[[Fitter, Fit], Numbers | None]] = {
    SearchStart.TOUCH: _touch, SearchStart.SWING: _swing}
LOCATED = tuple(name for name, sought in HYPOTHESES.items() if sought.start in _READ)
