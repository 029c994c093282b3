"""
The equation of motion, compiled; every effect acts here at its place (docs/model.md#motion).

All that moves stands in one array of registers (n, REGISTERS), a row per joint. A row holds its
state, the stages and slopes of the integration, and the torques of the last slope taken. One array
and not a dozen, because handing over many arrays costs more than the physics itself.
"""

import numpy as np
from numpy.typing import NDArray

from .acting import added, passed
from .arm import ArmRecord
from .effects.environment import base_acceleration
from .effects.friction import bristle_rate, bristle_torque
from .effects.place import Bent, LOADED_GEAR, PLAY, Swung, TRANSMISSION, Turned, Twisted
from .effects.transmission import damping_torque, hysteresis_torque, slid, SLIDERS
from .link_side import base_coupling, base_push, free_torque, link_torque, tip_force
from .motor_side import drag, friction_budget, ripple
from .torsion import torque_from_guess
from ..foundation.compiled import compiled, inlined, Record
from ..foundation.rigid import Inertia, mass_matrix

Array = NDArray[np.float64]

# The state of one joint: shaft [rad, rad/s], link [rad, rad/s]; then what effects remember:
# torsion at which the elements of the hysteresis stand [rad], bristles [rad], torque of the
# current loop [N*m motor], in row 0 the base along its swing [m, m/s], the elements' stretches
# [rad].
MOTOR_ANGLE, MOTOR_VELOCITY, LINK_ANGLE, LINK_VELOCITY = range(4)
HYSTERESIS, BRISTLE, CURRENT, BASE_OFFSET, BASE_RATE, STRETCH = range(4, 10)
STATES = STRETCH + SLIDERS

# Registers: blocks of STATES first, then single ones.
STATE, STAGE, TRIAL, SLOPE_1, SLOPE_2, SLOPE_3, SLOPE_4 = range(0, 7 * STATES, STATES)
TIME = 7 * STATES       # in row 0: since the start of the recording [s]
(NOW,                   # in row 0: time of the stage [s]
 COMMAND,               # motor torque at the stage, shaft [N*m]
 FORCE,                 # tip force at the stage, base frame, x in row 0 and y in row 1 [N]
 TORQUE,                # through the gear, output side [N*m]
 ) = range(TIME + 1, TIME + 5)

# Registers of a joint's two contacts, first the motor's, then that of the link bearing.
MODE = TORQUE + 1       # direction of sliding, 0 for sticking
DRIVE = MODE + 2        # what drives a contact, or what it must hold [N*m at its side]
BUDGET = DRIVE + 2      # most torque that it can oppose [N*m at its side]

GUESS = BUDGET + 2      # last torsion of the spring, its torque and its slope
COMMANDS = GUESS + 3    # commanded torque at the start, the middle and the end of a step [N*m]
FORCES = COMMANDS + 3   # tip force likewise, x in row 0 and y in row 1 [N]
SENT = FORCES + 3       # the last commands, the newest first [N*m]
HISTORY = 66
REGISTERS = SENT + HISTORY

_ACCURACY = 1e-4        # of the spring's iteration: its cube, 1e-12, is left as an error
_MOST_GROWTH = 0.9      # of the gear's least compliance, so that more torque twists it more


def registers(state: Array) -> Array:
    """Return registers for a state (n, STATES); row 1 is there for the force even if n = 1."""
    fresh = np.zeros((max(2, len(state)), REGISTERS))
    fresh[:len(state), STATE:STATE + STATES] = state
    fresh[:, MODE] = np.sign(fresh[:, STATE + MOTOR_VELOCITY])
    fresh[:, MODE + 1] = np.sign(fresh[:, STATE + LINK_VELOCITY])
    return fresh


@inlined
def _left(at: Twisted, torsion: float) -> Twisted:
    return Twisted(torsion, at.torsion_rate, at.state)


@inlined
def _rate_left(at: Twisted, rate: float) -> Twisted:
    return Twisted(at.torsion, rate, at.state)


_turning, _leading = added(TRANSMISSION), added(TRANSMISSION, 'law_slope')
_growing, _rising = added(LOADED_GEAR), added(LOADED_GEAR, 'law_slope')
_played, _played_rate = passed(PLAY, _left), passed(PLAY, _rate_left, 'law_rate')


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
    return (spring + hysteresis_torque(joint.torsional_hysteresis, at)
            + damping_torque(joint.structural_damping, at))


@inlined
def loop_state(joint: Record, w: Array, j: int, at: int, torsion: float) -> float:
    """Return the hysteresis z in [-1, 1] at a torsion, from its elements, (eq:hysteresis)."""
    own, total = joint.torsional_hysteresis, 0.0
    for place in range(SLIDERS):
        total += slid(own, w[j, at + STRETCH + place], torsion - w[j, at + HYSTERESIS], place)
    return total / (SLIDERS * own.width)


@compiled
def settle(arm: ArmRecord, w: Array) -> None:
    """Let the elements of every hysteresis slide to where the state stands, (eq:sliders)."""
    for j in range(arm.joints.shape[0]):
        joint = arm.joints[j]
        if joint.torsional_hysteresis.level > 0.0:
            angle = w[j, STATE + MOTOR_ANGLE]
            torsion = (angle / joint.ratio + transmission(joint, angle)[0]
                       - w[j, STATE + LINK_ANGLE])
            change = torsion - w[j, STATE + HYSTERESIS]
            for place in range(SLIDERS):
                w[j, STATE + STRETCH + place] = slid(
                    joint.torsional_hysteresis, w[j, STATE + STRETCH + place], change, place)
            w[j, STATE + HYSTERESIS] = torsion


@inlined
def _motor_side(arm: ArmRecord, w: Array, j: int, at: int, to: int) -> None:
    """Fill one joint's slopes but the link's, and its registers of torque, (eq:motor)."""
    joint = arm.joints[j]
    angle, velocity, mode = w[j, at + MOTOR_ANGLE], w[j, at + MOTOR_VELOCITY], w[j, MODE]
    error, ratio = transmission(joint, angle)
    growing, rising = growth(joint, angle)
    torsion = angle / joint.ratio + error - w[j, at + LINK_ANGLE]
    rate = ratio * velocity - w[j, at + LINK_VELOCITY]
    loop = 0.0
    if joint.torsional_hysteresis.level > 0.0:
        loop = loop_state(joint, w, j, at, torsion)
    spring = spring_torque(joint, torsion, growing, w, j)
    torque = gear_torque(joint, spring, torsion, rate, loop)
    drive = (w[j, COMMAND] + ripple(joint, angle) - drag(joint, velocity, w[0, NOW])
             - (ratio * torque + 0.5 * rising * spring * abs(spring)))
    sense = mode if mode != 0.0 else np.sign(drive)
    budget = friction_budget(joint, velocity, sense, torque, w[j, at + LINK_ANGLE])
    bristles = joint.presliding_friction
    if bristles.stiffness > 0.0:
        bent = w[j, at + BRISTLE]
        bending = bristle_rate(bristles, Bent(velocity, bent, 0.0, budget))
        drive -= bristle_torque(bristles, Bent(velocity, bent, bending, budget))
        w[j, to + BRISTLE], budget = bending, 0.0
    net = 0.0 if mode == 0.0 and budget > 0.0 else drive - mode * budget
    w[j, to + MOTOR_ANGLE] = velocity
    w[j, to + MOTOR_VELOCITY] = net / joint.motor_inertia
    w[j, to + LINK_ANGLE] = w[j, at + LINK_VELOCITY]
    w[j, TORQUE], w[j, DRIVE], w[j, BUDGET] = torque, drive, budget


@inlined
def _link_side(arm: ArmRecord, inertia: Inertia, w: Array, at: int, to: int) -> None:
    """Fill the links' accelerations, M ddq = tau + J^T F + gravity - C dq, (eq:links)."""
    two = arm.joints.shape[0] == 2
    q1, dq1 = w[0, at + LINK_ANGLE], w[0, at + LINK_VELOCITY]
    q2, dq2 = (w[1, at + LINK_ANGLE], w[1, at + LINK_VELOCITY]) if two else (0.0, 0.0)
    force_x, force_y = tip_force(arm.body, w[0, NOW], w[0, FORCE], w[1, FORCE])
    net1, net2 = free_torque(arm.body, inertia, q1, q2, dq1, dq2, force_x, force_y)
    net1 += w[0, TORQUE] + link_torque(arm.joints[0], q1)
    m11, m12, m22 = inertia.p1, 0.0, 1.0
    if two:
        net2 += w[1, TORQUE] + link_torque(arm.joints[1], q2)
        m11, m12, m22 = mass_matrix(inertia, q2)
    swing = arm.body.base_vibration
    if swing.amplitude == 0.0:
        _accelerate(arm, w, two, m11, m12, m22, net1, net2, to)
        return
    c1, c2 = base_coupling(inertia, swing.direction, q1, q2)
    push = base_push(inertia, swing.direction, q1, q2, dq1, dq2, force_x, force_y)
    free = base_acceleration(swing, Swung(push, w[0, at + BASE_OFFSET], w[0, at + BASE_RATE]))
    share1, share2 = swing.amplitude * c1, swing.amplitude * c2
    _accelerate(arm, w, two, m11 - share1 * c1, m12 - share1 * c2, m22 - share2 * c2,
                net1 - c1 * free, net2 - c2 * free, to)
    w[0, to + BASE_OFFSET] = w[0, at + BASE_RATE]
    w[0, to + BASE_RATE] = free - share1 * w[0, to + LINK_VELOCITY]
    if two:
        w[0, to + BASE_RATE] -= share2 * w[1, to + LINK_VELOCITY]


@inlined
def _accelerate(arm: ArmRecord, w: Array, two: bool, m11: float, m12: float, m22: float,
                net1: float, net2: float, to: int) -> None:
    """Fill the links' accelerations, with bearings that hold or oppose them, (eq:bearing)."""
    level1 = arm.joints[0].link_bearing_friction.level
    level2 = arm.joints[1].link_bearing_friction.level if two else 0.0
    held1, held2 = level1 > 0.0 and w[0, MODE + 1] == 0.0, level2 > 0.0 and w[1, MODE + 1] == 0.0
    net1, net2 = net1 - w[0, MODE + 1] * level1, net2 - w[1, MODE + 1] * level2
    determinant = m11 * m22 - m12 * m12
    first = (m22 * net1 - m12 * net2) / determinant
    second = (m11 * net2 - m12 * net1) / determinant
    if held1 or held2:
        first, second = (0.0 if held1 else net1 / m11), (0.0 if held2 else net2 / m22)
    if level1 > 0.0 or level2 > 0.0:
        w[0, DRIVE + 1], w[0, BUDGET + 1] = net1 - m12 * second, level1
        w[1, DRIVE + 1], w[1, BUDGET + 1] = net2 - m12 * first, level2
    w[0, to + LINK_VELOCITY] = first
    if two:
        w[1, to + LINK_VELOCITY] = second


@compiled
def slope(arm: ArmRecord, inertia: Inertia, w: Array, at: int, to: int) -> None:
    """Fill the slopes in block `to` of the state in block `at`, (eq:torsion-angle to links)."""
    for j in range(arm.joints.shape[0]):
        _motor_side(arm, w, j, at, to)
    _link_side(arm, inertia, w, at, to)
