"""
The torque of one joint from two witnesses, at one sample: torsion and motor, docs/estimation.md.

Each is corrected by what was learnt of it. Then they are weighed by what changes from sample to
sample, and no torque is reported that motor, inertia and friction do not allow. Where they
contradict each other beyond what can be learnt, the better one stands alone.
"""

from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.compiled import borrowed, compiled, inlined, Record
from hda_arm_sim.model.kernel import growth, played_torsion
from hda_arm_sim.model.torsion import flexed
import numpy as np

from .compiled_settings import CompiledSettings
from .fusion import close_half, gather
from .fusion_memory import (carried, effect_variance, errors_apart, EXCESS, falls_back,
                            follow_apart, gained, MOTOR_ALONE, SLOW_APART, SLOW_TIME, UNEXPLAINED)
from .motor_witness import (bound, first_bound, follow_scatter, has_friction, hear, Motor,
                            motor_estimate, MotorSample, Own, own_variance, Seen, torque_at_rest)
from .route_errors import ERRORS, torque_effects, TORSION_ERRORS, ZERO
from .torsion_scatter import follow_twist
from .torsion_torque import reading_deviation, torque_aside, torque_through_gear
from .witnesses import beyond, Bound, FAINT, is_near, share_of_second, Spring, tangent, within

# Choices unless stated otherwise.
_QUICK = 0.1            # of the variance of what no law describes, that is quick


class GearState(NamedTuple):
    """What the encoders show of a gear, already without what was learnt to be wrong."""

    elastic: float              # torsion [rad]
    rate: float                 # [rad/s]
    loop: float                 # hysteresis z in [-1, 1]
    learnt: float               # taken from it because it was learnt to be wrong [rad]
    gain: float                 # of a reading's noise in the rate [1/s]
    factor: float               # learnt of the stiffness


class Reading(NamedTuple):
    """What one reading of a torsion determines, and how sure it and the motor are."""

    torque: float               # [N*m]
    own: Own
    other: Own


class TorqueEstimate(NamedTuple):
    """A joint's torque and how sure it is [N*m], and the share of the motor in that."""

    torque: float
    deviation: float
    motor_share: float


@compiled
def joint_torque(joint: Record, settings: CompiledSettings, memory: Array, seen: GearState,
                 heard: MotorSample, effect: Array) -> TorqueEstimate:
    """
    Return the torque of one joint at a sample.

    `effect` (ERRORS,) holds what a sigma of each error adds to the torsion [rad]; it is used up.
    """
    effect = borrowed(effect)
    torque = _through(joint, heard, seen)
    stiffness, random = reading_deviation(joint, torque, seen.gain)
    lawless = joint.torsion.deviation ** 2
    both = settings.fusion > 0.0 and has_friction(joint)
    if not both or not hear(memory, heard):
        if falls_back(memory):
            torque = _through(joint, heard, _as_stated(seen))
        torque_effects(joint.tolerances, _softer(joint, seen, torque), stiffness, effect)
        now, before = effect_variance(memory, effect, TORSION_ERRORS)
        single, held, far = random ** 2 + lawless, torque, 0.0
        if falls_back(memory):
            now = before
        if both and np.isfinite(heard.command):
            first = first_bound(joint, heard, _held(joint, torque))
            held = within(first, torque)
            far = beyond(first, held) ** 2 + (_held(joint, torque) - held) ** 2
            if single + now > (first.slack + first.doubt) ** 2:     # the motor knows more
                held = first.middle
        sure = _as_found(joint, memory, effect, single + now)
        return TorqueEstimate(held, np.sqrt(sure + far), _share(single + now, single + before))
    motor = motor_estimate(joint, memory, heard, settings.window, effect)
    scatter = follow_twist(memory, seen.elastic + seen.learnt, motor.moving, heard.dt)
    random = reading_deviation(joint, torque, seen.gain, scatter)[1]
    allowed = bound(memory, motor, effect)
    others = own_variance(joint, memory, motor)
    near = _near(motor.driving - motor.inertia, allowed,
                 Reading(torque, Own(random ** 2, 0.0, lawless), others))
    if not is_near(torque, near, random):
        torque, stiffness = _touched(joint, heard, seen, near)
        random = reading_deviation(joint, near, seen.gain, scatter)[1]
    torque_effects(joint.tolerances, _softer(joint, seen, near), stiffness, effect)
    gather(memory, torque - motor.driving, effect, heard.dt)
    close_half(joint, memory, heard.angle, settings, stiffness, motor.friction)
    follow_scatter(memory, motor, Seen(torque - motor.driving + motor.inertia, lawless),
                   heard.dt)
    if falls_back(memory):                      # what was learnt is not used, but stays learnt
        plain = _as_stated(seen)
        torque = _through(joint, heard, plain)
        near = _near(motor.plain - motor.inertia, allowed,
                     Reading(torque, Own(random ** 2, 0.0, lawless), others))
        if not is_near(torque, near, random):
            torque = _touched(joint, heard, plain, near)[0]
    return _weighed(joint, memory, effect, motor, allowed,
                    Reading(torque, Own(random ** 2, 0.0, lawless), others), heard.dt)


@inlined
def _as_stated(seen: GearState) -> GearState:
    """Return what the encoders show by the arm as it was stated, without what was learnt."""
    return GearState(seen.elastic + seen.learnt, seen.rate, seen.loop, 0.0, seen.gain, 1.0)


@inlined
def _through(joint: Record, heard: MotorSample, seen: GearState) -> float:
    """Return the torque that belongs to a torsion, by the law as it is known [N*m]."""
    return torque_through_gear(joint, heard.angle, seen.elastic, seen.rate, seen.loop, seen.factor)


@inlined
def _softer(joint: Record, seen: GearState, torque: float) -> float:
    """Return the torsion that a softer flexspline adds, for each 1 of the factor [rad]."""
    return flexed(joint.torsion, torque) / seen.factor ** 2


@inlined
def _near(other: float, allowed: Bound, seen: Reading) -> float:
    """Return where the torsion's torque and the motor's meet, within what is allowed [N*m]."""
    share = share_of_second(_whole(seen.own), _whole(seen.other))
    return within(allowed, seen.torque + share * (other - seen.torque))


@inlined
def _touched(joint: Record, heard: MotorSample, seen: GearState, near: float) -> tuple[float,
                                                                                       float]:
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


@inlined
def _whole(own: Own) -> float:
    return own.random + own.held + own.lawless


@compiled
def _weighed(joint: Record, memory: Array, effect: Array, motor: Motor, allowed: Bound,
             seen: Reading, dt: float) -> TorqueEstimate:
    """Weigh the torsion's torque and the motor's, (eq:weight, sigma-torque)."""
    if falls_back(memory):
        return _alone(joint, memory, effect, motor, allowed, seen)
    apart = seen.torque - torque_at_rest(memory, motor, dt)
    left = follow_apart(memory, apart, dt)          # of what differs from sample to sample
    slow_own = left * seen.own.random + seen.own.lawless
    slow_other = seen.other.random + seen.other.held + seen.other.lawless
    both, first = errors_apart(memory, effect)
    made_up = 2.0 * min(carried(memory, motor.moving, dt) * seen.own.lawless,
                        np.sqrt(first * seen.own.lawless))
    weight = _clear(share_of_second(slow_own + first - made_up, slow_other + both - first))
    quick_own = seen.own.random + _QUICK * seen.own.lawless
    quick_other = seen.other.random + _QUICK * seen.other.lawless
    quick = _clear(share_of_second(quick_own, quick_other + seen.other.held))
    torque = seen.torque - quick * apart - (weight - quick) * memory[SLOW_APART]
    held = within(allowed, torque)
    before = _squares(effect, 0, TORSION_ERRORS) + _whole(seen.own)
    effect[:TORSION_ERRORS] *= 1.0 - weight
    effect[TORSION_ERRORS:] *= -weight
    usual = (effect_variance(memory, effect, ERRORS if weight > 0.0 else TORSION_ERRORS)[0]
             + _varies(seen.own, 1.0 - weight, 1.0 - quick, left)
             + _varies(seen.other, weight, quick, 1.0))
    now = (_as_found(joint, memory, effect, usual)
           + max(weight, 1.0 - weight) ** 2 * memory[UNEXPLAINED]
           + (_held(joint, torque) - held) ** 2 + beyond(allowed, held) ** 2)
    return TorqueEstimate(held, np.sqrt(now), _share(now, joint.deviation_factor ** 2 * before))


@inlined
def _as_found(joint: Record, memory: Array, effect: Array, usual: float) -> float:
    """
    Return a variance with the factor that left-out recordings asked for, (eq:sigma-torque).

    Of what a zero adds nothing is taken: how far it moves, few recordings show.
    """
    found = joint.deviation_factor ** 2
    zero = effect[ZERO] ** 2 * max(1.0 + gained(memory)[ZERO, ZERO], 0.0)
    return found * usual + max(1.0 - found, 0.0) * min(zero, usual)


@inlined
def _varies(own: Own, slow: float, quick: float, left: float) -> float:
    """Return the variance that is left of a witness with weights of slow and quick changes."""
    return (quick ** 2 * own.random + left * (slow ** 2 - quick ** 2) * own.random
            + slow ** 2 * (own.held + own.lawless))


@inlined
def _clear(weight: float) -> float:
    """Return a weight, or none where it is faint."""
    return weight if weight >= FAINT else 0.0


@compiled
def _alone(joint: Record, memory: Array, effect: Array, motor: Motor, allowed: Bound,
           seen: Reading) -> TorqueEstimate:
    """Return the estimate of the better of both alone, as before anything was learnt."""
    own, other = _whole(seen.own), _whole(seen.other)
    first = _squares(effect, 0, TORSION_ERRORS) + own
    second = _squares(effect, TORSION_ERRORS, ERRORS) + other
    memory[MOTOR_ALONE] = 1.0 if second < first else 0.0
    memory[SLOW_TIME] = 0.0
    torque = motor.plain - motor.inertia if second < first else seen.torque
    held = within(allowed, torque)
    now = (min(first, second) + memory[UNEXPLAINED] + (_held(joint, torque) - held) ** 2
           + beyond(allowed, held) ** 2 + min(memory[EXCESS], joint.torsion.valid_torque) ** 2)
    return TorqueEstimate(held, np.sqrt(now), _share(now, first))


@inlined
def _squares(effect: Array, first: int, end: int) -> float:
    total = 0.0
    for i in range(first, end):
        total += effect[i] * effect[i]
    return total
