"""
The equation of motion, compiled; every effect acts here at its place (docs/model.md, 23-26).

All that moves stands in one array of registers (n, REGISTERS), a row per joint: its state, the
stages and slopes of the integration, and the torques of the last slope taken. One array and not
a dozen, because handing over many arrays costs more than the physics itself.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .arm import Arm, ArmRecord
from .compiled import compiled, inlined
from .effects.friction import dry_budget, stribeck_budget, viscous_drag
from .effects.load import loaded
from .effects.transmission import (damping_torque, hysteresis_rate, hysteresis_torque,
                                   played_torsion, transmission_error, transmission_slope)
from .rigid import coriolis, gravity_torque, Inertia, mass_matrix, tip_torque
from .torsion import torque_from_guess

Array = NDArray[np.float64]

# The state of one joint: shaft [rad, rad/s], link [rad, rad/s], hysteresis in [-1, 1].
MOTOR_ANGLE, MOTOR_VELOCITY, LINK_ANGLE, LINK_VELOCITY, HYSTERESIS = range(5)
STATES = 5

# Registers: blocks of STATES first, then single ones.
STATE, STAGE, TRIAL, SLOPE_1, SLOPE_2, SLOPE_3, SLOPE_4 = range(0, 7 * STATES, STATES)
(MODE,                  # direction in which the motor slides, 0 where it sticks
 COMMAND,               # motor torque at the stage, shaft [N*m]
 FORCE,                 # tip force at the stage, base frame, x in row 0 and y in row 1 [N]
 TORQUE,                # through the gear, output side [N*m]
 DRIVE,                 # at the shaft without dry friction [N*m]
 BUDGET,                # dry friction budget at the shaft [N*m]
 GUESS,                 # last torsion of the spring, its torque and its slope
 ) = range(7 * STATES, 7 * STATES + 7)
REGISTERS = GUESS + 3

_ACCURACY = 1e-4        # of the spring's iteration: its cube, 1e-12, is left as an error


def registers(state: Array) -> Array:
    """Return registers for a state (n, STATES); row 1 is there for the force even if n = 1."""
    fresh = np.zeros((max(2, len(state)), REGISTERS))
    fresh[:len(state), STATE:STATE + STATES] = state
    fresh[:, MODE] = np.sign(fresh[:, STATE + MOTOR_VELOCITY])
    return fresh


@inlined
def transmission(joint, motor_angle):                               # type: ignore[no-untyped-def]
    """Return e(theta_m) [rad] and the effective ratio 1/N + e'(theta_m), (14-15)."""
    wave = joint.kinematic_error
    if wave.amplitude_1 == 0.0 and wave.amplitude_2 == 0.0 and wave.amplitude_4 == 0.0:
        return 0.0, 1.0 / joint.ratio
    return (transmission_error(motor_angle, wave.amplitude_1, wave.phase_1, wave.amplitude_2,
                               wave.phase_2, wave.amplitude_4, wave.phase_4),
            1.0 / joint.ratio
            + transmission_slope(motor_angle, wave.amplitude_1, wave.phase_1, wave.amplitude_2,
                                 wave.phase_2, wave.amplitude_4, wave.phase_4))


@inlined
def spring_torque(joint, torsion, w, j):                            # type: ignore[no-untyped-def]
    """Return the torque of the spring alone, (23); renews the joint's guess [N*m]."""
    if joint.backlash.half_width > 0.0:
        torsion = played_torsion(torsion, joint.backlash.half_width)
    near, bend = 0.0, w[j, GUESS + 2]
    if bend > 0.0:
        near = w[j, GUESS + 1] + (torsion - w[j, GUESS]) / bend
    torque, bend = torque_from_guess(joint.torsion, joint.ratio, torsion, near, _ACCURACY)
    w[j, GUESS], w[j, GUESS + 1], w[j, GUESS + 2] = torsion, torque, bend
    return torque


@inlined
def gear_torque(joint, spring, torsion_rate, state):                # type: ignore[no-untyped-def]
    """Return the torque through the gear, (24) [N*m at the output, drives the link]."""
    return (spring + hysteresis_torque(state, joint.torsional_hysteresis.level)
            + damping_torque(torsion_rate, joint.structural_damping.coefficient))


@inlined
def friction_budget(joint, motor_velocity):                         # type: ignore[no-untyped-def]
    """Return the most torque that dry friction can oppose, (25) [N*m motor]."""
    excess = joint.stribeck_friction.excess
    budget = dry_budget(joint.coulomb_friction.level)
    if excess > 0.0:
        budget += stribeck_budget(motor_velocity, excess, joint.stribeck_friction.speed)
    return budget


@compiled
def loaded_inertia(body):                                           # type: ignore[no-untyped-def]
    """Return the inertia of the links with what they carry, (22)."""
    links = body.links
    bare = Inertia(links.p1, links.p2, links.p3, links.first, links.second, links.coupled)
    return loaded(bare, links.length1, links.length2, body.payload.mass)


@inlined
def _motor_side(arm, w, j, at, to):                                 # type: ignore[no-untyped-def]
    """Fill one joint's slopes but the link's, and its registers of torque."""
    joint = arm.joints[j]
    velocity, state = w[j, at + MOTOR_VELOCITY], w[j, at + HYSTERESIS]
    error, ratio = transmission(joint, w[j, at + MOTOR_ANGLE])
    torsion = w[j, at + MOTOR_ANGLE] / joint.ratio + error - w[j, at + LINK_ANGLE]
    rate = ratio * velocity - w[j, at + LINK_VELOCITY]
    torque = gear_torque(joint, spring_torque(joint, torsion, w, j), rate, state)
    drive = (w[j, COMMAND] - viscous_drag(velocity, joint.viscous_friction.slope)
             - ratio * torque)
    budget = friction_budget(joint, velocity)
    net = 0.0 if w[j, MODE] == 0.0 and budget > 0.0 else drive - w[j, MODE] * budget
    w[j, to + MOTOR_ANGLE] = velocity
    w[j, to + MOTOR_VELOCITY] = net / joint.motor_inertia
    w[j, to + LINK_ANGLE] = w[j, at + LINK_VELOCITY]
    w[j, to + HYSTERESIS] = 0.0
    if joint.torsional_hysteresis.level > 0.0:
        width = joint.torsional_hysteresis.width
        w[j, to + HYSTERESIS] = hysteresis_rate(rate, state, width)
    w[j, TORQUE], w[j, DRIVE], w[j, BUDGET] = torque, drive, budget


@inlined
def _link_side(arm, inertia, w, at, to):                            # type: ignore[no-untyped-def]
    """Fill the accelerations of one or two links, M ddq = tau + J^T F + gravity - C dq, (26)."""
    links, body = arm.body.links, arm.body
    two = arm.joints.shape[0] == 2
    q1, dq1 = w[0, at + LINK_ANGLE], w[0, at + LINK_VELOCITY]
    q2, dq2 = (w[1, at + LINK_ANGLE], w[1, at + LINK_VELOCITY]) if two else (0.0, 0.0)
    net1, net2 = tip_torque(links.length1, links.length2, q1, q2, w[0, FORCE], w[1, FORCE])
    if body.pull > 0.0:
        weight1, weight2 = gravity_torque(inertia, body.pull, body.direction, q1, q2)
        net1, net2 = net1 + weight1, net2 + weight2
    net1 += w[0, TORQUE]
    if not two:
        w[0, to + LINK_VELOCITY] = net1 / inertia.p1
        return
    turn1, turn2 = coriolis(inertia, q2, dq1, dq2)
    net1, net2 = net1 - turn1, net2 + w[1, TORQUE] - turn2
    m11, m12, m22 = mass_matrix(inertia, q2)
    determinant = m11 * m22 - m12 * m12
    w[0, to + LINK_VELOCITY] = (m22 * net1 - m12 * net2) / determinant
    w[1, to + LINK_VELOCITY] = (m11 * net2 - m12 * net1) / determinant


@compiled
def slope(arm, inertia, w, at, to):                                 # type: ignore[no-untyped-def]
    """Fill the slopes in block `to` of the state in block `at`, (23)-(26)."""
    for j in range(arm.joints.shape[0]):
        _motor_side(arm, w, j, at, to)
    _link_side(arm, inertia, w, at, to)


def energy(arm: Arm, state: Array) -> float:
    """Return the energy of an arm at a state (n, STATES): kinetic, elastic, gravity [J]."""
    record = arm.record()
    inertia = loaded_inertia(record.body)
    return (_kinetic(record, inertia, state) + _elastic(arm, state)
            + _potential(record.body, inertia, state[:, LINK_ANGLE]))


def _kinetic(record: ArmRecord, inertia: Inertia, state: Array) -> float:
    motors = 0.5 * record.joints['motor_inertia'] @ state[:, MOTOR_VELOCITY] ** 2
    if len(state) == 1:
        return float(motors + 0.5 * inertia.p1 * state[0, LINK_VELOCITY] ** 2)
    m11, m12, m22 = mass_matrix(inertia, state[1, LINK_ANGLE])
    dq = state[:, LINK_VELOCITY]
    return float(motors + 0.5 * dq @ np.array([[m11, m12], [m12, m22]]) @ dq)


def _elastic(arm: Arm, state: Array) -> float:
    """Return the energy in the springs: the integral of torque over torsion."""
    total = 0.0
    for row, joint in zip(state, arm.record().joints):
        error, _ = transmission(joint, row[MOTOR_ANGLE])
        torsion = row[MOTOR_ANGLE] / joint['ratio'] + error - row[LINK_ANGLE]
        nodes, weights = np.polynomial.legendre.leggauss(40)
        w = np.zeros((1, REGISTERS))
        total += 0.5 * torsion * sum(
            weight * spring_torque(joint, 0.5 * torsion * (1.0 + node), w, 0)
            for node, weight in zip(nodes, weights))
    return total


def _potential(body: Any, inertia: Inertia, q: Array) -> float:
    down = float(body['direction'])
    far = inertia.second * np.cos(down - q.sum()) if len(q) == 2 else 0.0
    return float(-body['pull'] * (inertia.first * np.cos(down - q[0]) + far))
