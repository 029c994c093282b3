"""
The equation of motion, compiled; every effect acts here at its place (docs/model.md#motion).

All that moves stands in one array of registers (model/registers.py). Links in a plane and chains
in space have each their own way to move (planar_side.py, chain_side.py). Which one is chosen when
the kernel is compiled.
"""

import numpy as np

from . import chain_side, planar_side
from .arm import ArmRecord
from .effect_loops import acting_at, added, passed, record_at
from .effects.catalogue import sole_at
from .effects.place import (Bent, BRISTLES, GEAR, LOADED_GEAR, LOOP, PLAY, SLIDERS, TRANSMISSION,
                            Turned, Twisted)
from .motor_side import drag, friction_budget, ripple
from .registers import (AXES, BASE_OFFSET, BASE_RATE, BRISTLE, BUDGET, COMMAND, COMMANDS, CURRENT,
                        DRIVE, FORCE, FORCES, GUESS, HISTORY, HYSTERESIS, LINK_ANGLE,
                        LINK_VELOCITY, MODE, MOTOR_ANGLE, MOTOR_VELOCITY, NOW, REGISTERS,
                        registers, SENT, SLOPE_1, SLOPE_2, SLOPE_3, SLOPE_4, STAGE, STATE, STATES,
                        STRETCH, TIME, TORQUE, TRIAL)
from .torsion import torque_from_guess
from ..foundation.arrays import Array
from ..foundation.chain import of_links
from ..foundation.compiled import compiled, inlined, Record
from ..foundation.rigid import Inertia

__all__ = (                 # the registers are read by who reads the kernel
    'AXES', 'BASE_OFFSET', 'BASE_RATE', 'BRISTLE', 'BUDGET', 'COMMAND', 'COMMANDS', 'CURRENT',
    'DRIVE', 'FORCE', 'FORCES', 'GUESS', 'HISTORY', 'HYSTERESIS', 'LINK_ANGLE', 'LINK_VELOCITY',
    'MODE', 'MOTOR_ANGLE', 'MOTOR_VELOCITY', 'NOW', 'REGISTERS', 'SENT', 'SLOPE_1', 'SLOPE_2',
    'SLOPE_3', 'SLOPE_4', 'STAGE', 'STATE', 'STATES', 'STRETCH', 'TIME', 'TORQUE', 'TRIAL',
    'bends', 'bristles_of', 'gear_torque', 'growth', 'loop_of', 'loop_state', 'loops',
    'played_torsion', 'registers', 'settle', 'shaft_side', 'slide', 'slope', 'spring_torque',
    'torque_against', 'transmission', 'twist')

_ACCURACY = 1e-4        # of the spring's iteration: its cube, 1e-12, is left as an error
_MOST_GROWTH = 0.9      # of the gear's least compliance, so that more torque twists it more


@inlined
def _left(at: Twisted, torsion: float) -> Twisted:
    return Twisted(torsion, at.torsion_rate, at.state)


@inlined
def _rate_left(at: Twisted, rate: float) -> Twisted:
    return Twisted(at.torsion, rate, at.state)


_accelerate = of_links(planar_side.accelerate, chain_side.accelerate)
_turning, _leading = added(TRANSMISSION), added(TRANSMISSION, 'law_slope')
_growing, _rising = added(LOADED_GEAR), added(LOADED_GEAR, 'law_slope')
_played, _played_rate = passed(PLAY, _left), passed(PLAY, _rate_left, 'law_rate')
_damped, _looped, _slid = added(GEAR), sole_at(LOOP).law, sole_at(LOOP).law_after
loops, loop_of = acting_at(LOOP), record_at(LOOP)
bends, bristles_of = acting_at(BRISTLES), record_at(BRISTLES)
_bending, _bristled = sole_at(BRISTLES).law_rate, sole_at(BRISTLES).law


@inlined
def transmission(joint: Record, motor_angle: float) -> tuple[float, float]:
    """Return e(theta_m) [rad] and the effective ratio 1/N + e'(theta_m), (eq:kinematic-error)."""
    at = Turned(motor_angle)
    return _turning(joint, at, 0.0), 1.0 / joint.ratio + _leading(joint, at, 0.0)


@inlined
def growth(joint: Record, motor_angle: float) -> tuple[float, float]:
    """
    Return what each N*m adds to the torsion at a shaft angle [rad/(N*m)], and its slope.

    It stays within a share of the gear's least compliance; there it has no slope.
    """
    at = Turned(motor_angle)
    growing = _growing(joint, at, 0.0)
    if abs(growing) * joint.torsion.last_stiffness > _MOST_GROWTH:
        return np.sign(growing) * _MOST_GROWTH / joint.torsion.last_stiffness, 0.0
    return growing, _rising(joint, at, 0.0)


@inlined
def played_torsion(joint: Record, torsion: float) -> float:
    """Return what is left of a torsion to the spring behind all play, (eq:play) [rad]."""
    return _played(joint, Twisted(torsion, 0.0, 0.0), torsion)


@inlined
def spring_torque(joint: Record, torsion: float, growing: float, w: Array, j: int) -> float:
    """Return the torque of the spring alone, (eq:gear-torque); renews the joint's guess [N*m]."""
    torsion = played_torsion(joint, torsion)
    near, bend = 0.0, w[j, GUESS + 2]
    if bend > 0.0:
        near = w[j, GUESS + 1] + (torsion - w[j, GUESS]) / bend
    torque, bend = torque_from_guess(joint.torsion, joint.ratio, torsion, near, _ACCURACY,
                                     growing)
    w[j, GUESS], w[j, GUESS + 1], w[j, GUESS + 2] = torsion, torque, bend
    return torque


@inlined
def gear_torque(joint: Record, spring: float, torsion: float, torsion_rate: float,
                state: float) -> float:
    """Return the gear's torque, (eq:gear-torque) [N*m at the output, drives the link]."""
    rate = _played_rate(joint, Twisted(torsion, torsion_rate, state), torsion_rate)
    at = Twisted(torsion, rate, state)
    return _damped(joint, at, spring + _looped(loop_of(joint), at))


@inlined
def loop_state(joint: Record, w: Array, j: int, at: int, torsion: float) -> float:
    """Return the hysteresis z in [-1, 1] at a torsion, from its elements, (eq:hysteresis)."""
    own, total = loop_of(joint), 0.0
    for place in range(SLIDERS):
        total += _slid(own, w[j, at + STRETCH + place], torsion - w[j, at + HYSTERESIS], place)
    return total / (SLIDERS * own.width)


@inlined
def settle_gear(joint: Record, w: Array, j: int) -> None:
    """Let the elements of a joint's hysteresis slide to where the state stands, (eq:sliders)."""
    if loops(joint):
        angle = w[j, STATE + MOTOR_ANGLE]
        slide(joint, w, j, angle / joint.ratio + transmission(joint, angle)[0]
              - w[j, STATE + LINK_ANGLE])


@inlined
def slide(joint: Record, w: Array, j: int, torsion: float) -> None:
    """Let the elements of a joint's hysteresis slide to a torsion, (eq:sliders)."""
    change = torsion - w[j, STATE + HYSTERESIS]
    for place in range(SLIDERS):
        w[j, STATE + STRETCH + place] = _slid(
            loop_of(joint), w[j, STATE + STRETCH + place], change, place)
    w[j, STATE + HYSTERESIS] = torsion


@compiled
def settle(arm: ArmRecord, w: Array) -> None:
    """Let the elements of every hysteresis slide to where the state stands, (eq:sliders)."""
    for j in range(arm.joints.shape[0]):
        settle_gear(arm.joints[j], w, j)


@inlined
def twist(joint: Record, angle: float, velocity: float, link_angle: float,
          link_velocity: float) -> tuple[float, float, float]:
    """Return a joint's torsion [rad], its rate [rad/s], and the ratio in force at its shaft."""
    error, ratio = transmission(joint, angle)
    return angle / joint.ratio + error - link_angle, ratio * velocity - link_velocity, ratio


@inlined
def torque_against(ratio: float, torque: float, rising: float, spring: float) -> float:
    """Return the torque of a gear against its shaft, (eq:motor) [N*m motor]."""
    return ratio * torque + 0.5 * rising * spring * abs(spring)


@inlined
def gear_side(joint: Record, w: Array, j: int, at: int) -> tuple[float, float]:
    """Return the torques of a joint's gear: on its link [N*m], against its shaft [N*m motor]."""
    angle = w[j, at + MOTOR_ANGLE]
    torsion, rate, ratio = twist(joint, angle, w[j, at + MOTOR_VELOCITY], w[j, at + LINK_ANGLE],
                                 w[j, at + LINK_VELOCITY])
    growing, rising = growth(joint, angle)
    loop = 0.0
    if loops(joint):
        loop = loop_state(joint, w, j, at, torsion)
    spring = spring_torque(joint, torsion, growing, w, j)
    torque = gear_torque(joint, spring, torsion, rate, loop)
    return torque, torque_against(ratio, torque, rising, spring)


@inlined
def shaft_side(joint: Record, w: Array, j: int, gear: tuple[float, float], at: int,
               to: int) -> None:
    """Fill one joint's slopes of shaft and bristles under the torques of its gear, (eq:motor)."""
    angle, velocity, mode = w[j, at + MOTOR_ANGLE], w[j, at + MOTOR_VELOCITY], w[j, MODE]
    torque, against = gear
    drive = w[j, COMMAND] + ripple(joint, angle) - drag(joint, velocity, w[0, NOW]) - against
    sense = mode if mode != 0.0 else np.sign(drive)
    budget = friction_budget(joint, velocity, sense, torque, w[j, at + LINK_ANGLE])
    if bends(joint):
        bristles, bent = bristles_of(joint), w[j, at + BRISTLE]
        bending = _bending(bristles, Bent(velocity, bent, 0.0, budget))
        drive -= _bristled(bristles, Bent(velocity, bent, bending, budget))
        w[j, to + BRISTLE], budget = bending, 0.0
    net = 0.0 if mode == 0.0 and budget > 0.0 else drive - mode * budget
    w[j, to + MOTOR_ANGLE] = velocity
    w[j, to + MOTOR_VELOCITY] = net / joint.motor_inertia
    w[j, TORQUE], w[j, DRIVE], w[j, BUDGET] = torque, drive, budget


@compiled
def slope(arm: ArmRecord, inertia: Inertia, w: Array, at: int, to: int) -> None:
    """Fill the slopes in block `to` of the state in block `at`, (eq:torsion-angle to links)."""
    for j in range(arm.joints.shape[0]):
        joint = arm.joints[j]
        shaft_side(joint, w, j, gear_side(joint, w, j, at), at, to)
        w[j, to + LINK_ANGLE] = w[j, at + LINK_VELOCITY]
    _accelerate(arm, inertia, w, at, to)
