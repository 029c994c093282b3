"""
The torque of one joint from two witnesses, at one sample: torsion and motor, docs/estimation.md.

Each is corrected by what was learnt of it. Then they are weighed by what changes from sample to
sample, and no torque is told that motor, inertia and friction do not allow. Where they contradict
each other beyond what can be learnt, the better one stands alone.
"""

from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.compiled import compiled, inlined, Record
from hda_arm_sim.model.kernel import growth, played_torsion
from hda_arm_sim.model.torsion import flexed
import numpy as np

from .compiled_settings import CompiledSettings
from .fusion import close_half, gather
from .fusion_memory import effect_variance, EXCESS, falls_back, MOTOR_ALONE, UNEXPLAINED
from .motor_witness import (bound, first_bound, follow_scatter, has_friction, hear, Heard, Motor,
                            own_variance, tell)
from .route_errors import ERRORS, torque_effects, TORSION_ERRORS
from .torsion_torque import reading_deviation, torque_aside, torque_through_gear
from .witnesses import beyond, Bound, FAINT, is_near, share_of_second, Spring, tangent, within


class Twisted(NamedTuple):
    """What the encoders tell of a gear, already without what was learnt to be wrong."""

    elastic: float              # torsion [rad]
    rate: float                 # [rad/s]
    loop: float                 # hysteresis z in [-1, 1]
    learnt: float               # taken from it because it was learnt to be wrong [rad]
    gain: float                 # of a reading's noise in the rate [1/s]
    factor: float               # learnt of the stiffness


class Reading(NamedTuple):
    """What one reading of a torsion tells: torque [N*m], its variance, that of the motor's."""

    torque: float
    random: float               # [N^2*m^2]
    other: float                # [N^2*m^2]


class Told(NamedTuple):
    """A joint's torque and how sure it is [N*m], and the share of the motor in that."""

    torque: float
    deviation: float
    motor_share: float


@compiled
def joint_torque(joint: Record, settings: CompiledSettings, memory: Array, seen: Twisted,
                 heard: Heard, effect: Array) -> Told:
    """
    Return the torque of one joint at a sample.

    `effect` (ERRORS,) holds what a sigma of each error adds to the torsion [rad]; it is used up.
    """
    torque = _through(joint, heard, seen)
    stiffness, random = reading_deviation(joint, torque, seen.gain)
    lawless = joint.torsion.deviation ** 2
    both = settings.fusion > 0.0 and has_friction(joint)
    if not both or not hear(memory, heard):
        if falls_back(memory):
            torque = _through(joint, heard, _as_stated(seen))
        torque_effects(settings.known, _softer(joint, seen, torque), stiffness, effect)
        now, before = effect_variance(memory, effect, TORSION_ERRORS)
        own, held, far = random ** 2 + lawless, torque, 0.0
        if falls_back(memory):
            now = before
        if both and np.isfinite(heard.command):
            first = first_bound(joint, heard, _held(joint, torque))
            held = within(first, torque)
            far = beyond(first, held) ** 2 + (_held(joint, torque) - held) ** 2
        return Told(held, np.sqrt(own + now + far), _share(own + now, own + before))
    motor = tell(joint, settings.known, memory, heard, settings.window, effect)
    allowed = bound(memory, motor, effect)
    own = own_variance(memory, motor)
    near = _near(motor.driving - motor.inertia, allowed,
                 Reading(torque, random ** 2 + lawless, own))
    if not is_near(torque, near, random):
        torque, stiffness = _touched(joint, heard, seen, near)
        random = reading_deviation(joint, near, seen.gain)[1]
    torque_effects(settings.known, _softer(joint, seen, near), stiffness, effect)
    gather(memory, torque - motor.driving, effect, heard.dt)
    close_half(joint, memory, heard.angle, settings, stiffness, motor.friction)
    follow_scatter(memory, motor, torque - motor.driving + motor.inertia, heard.dt)
    if falls_back(memory):                      # what was learnt is not told, but stays learnt
        plain = _as_stated(seen)
        torque = _through(joint, heard, plain)
        near = _near(motor.plain - motor.inertia, allowed,
                     Reading(torque, random ** 2 + lawless, own))
        if not is_near(torque, near, random):
            torque = _touched(joint, heard, plain, near)[0]
    return _weighed(joint, memory, effect, motor, allowed, Reading(torque, random ** 2, own))


@inlined
def _as_stated(seen: Twisted) -> Twisted:
    """Return what the encoders tell by the arm as it was stated, without what was learnt."""
    return Twisted(seen.elastic + seen.learnt, seen.rate, seen.loop, 0.0, seen.gain, 1.0)


@inlined
def _through(joint: Record, heard: Heard, seen: Twisted) -> float:
    """Return the torque that a torsion tells, by the law as it is known [N*m]."""
    return torque_through_gear(joint, heard.angle, seen.elastic, seen.rate, seen.loop, seen.factor)


@inlined
def _softer(joint: Record, seen: Twisted, torque: float) -> float:
    """Return the torsion that a softer flexspline adds, for each 1 of the factor [rad]."""
    return flexed(joint.torsion, torque) / seen.factor ** 2


@inlined
def _near(other: float, allowed: Bound, seen: Reading) -> float:
    """Return where the torsion's torque and the motor's meet, within what is allowed [N*m]."""
    share = share_of_second(seen.random, seen.other)
    return within(allowed, seen.torque + share * (other - seen.torque))


@inlined
def _touched(joint: Record, heard: Heard, seen: Twisted, near: float) -> tuple[float, float]:
    """Return torque [N*m] and stiffness [N*m/rad] of a torsion by the law's tangent."""
    spring = Spring(played_torsion(joint, seen.elastic),
                    torque_aside(joint, seen.elastic, seen.rate, seen.loop),
                    growth(joint, heard.angle)[0], seen.factor)
    return tangent(joint, spring, near)


@inlined
def _held(joint: Record, torque: float) -> float:
    """Return a torque that the gear can hold: within the law's valid range [N*m]."""
    return min(max(torque, -joint.torsion.valid_torque), joint.torsion.valid_torque)


@inlined
def _share(now: float, before: float) -> float:
    return max(1.0 - now / max(before, 1e-300), 0.0)


@compiled
def _weighed(joint: Record, memory: Array, effect: Array, motor: Motor, allowed: Bound,
             seen: Reading) -> Told:
    """Weigh the torsion's torque and the motor's, (eq:weight, sigma-torque)."""
    own = seen.random + joint.torsion.deviation ** 2
    before = _squares(effect, 0, TORSION_ERRORS)
    single = falls_back(memory)
    other = (motor.plain if single else motor.driving) - motor.inertia
    if single:
        better = _squares(effect, TORSION_ERRORS, ERRORS) + seen.other < before + own
        memory[MOTOR_ALONE] = 1.0 if better else 0.0
        weight = memory[MOTOR_ALONE]
    else:
        weight = share_of_second(own, seen.other)
    weight = weight if weight >= FAINT else 0.0
    torque = seen.torque + weight * (other - seen.torque)
    held = within(allowed, torque)
    effect[:TORSION_ERRORS] *= 1.0 - weight
    effect[TORSION_ERRORS:] *= -weight
    now = (_squares(effect, 0, ERRORS) if single else
           effect_variance(memory, effect, ERRORS if weight > 0.0 else TORSION_ERRORS)[0])
    now += ((1.0 - weight) ** 2 * own + weight ** 2 * seen.other
            + max(weight, 1.0 - weight) ** 2 * memory[UNEXPLAINED]
            + (_held(joint, torque) - held) ** 2 + beyond(allowed, held) ** 2)
    if single:
        now += min(memory[EXCESS], joint.torsion.valid_torque) ** 2
    return Told(held, np.sqrt(now), _share(now, own + before))


@inlined
def _squares(effect: Array, first: int, end: int) -> float:
    total = 0.0
    for i in range(first, end):
        total += effect[i] * effect[i]
    return total
