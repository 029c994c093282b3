"""
How the base swings along a measured motion (docs/model.md, eq:base-motion).

The links' measured acceleration drives it. The torque through the gear, which a simulation would
take, carries the steps of the motor encoder, and a mode that rings adds them up.
"""

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.chain import (ANGLE, base_couplings, Chain, COUPLING, FORCE,
                                          inverse_dynamics, place)
from hda_arm_sim.foundation.compiled import compiled, Record
from hda_arm_sim.foundation.vectors import dot, Vector, vector
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effect_loops import any_acts, numbers_at
from hda_arm_sim.model.effects.place import BASE
from hda_arm_sim.model.link_side import (base_acceleration, base_coupling, base_push,
                                         loaded_inertia, Pose)
import numpy as np
from scipy.signal import cont2discrete

from ...measurements.motion import DifferentiatedAngle


def gives_way(arm: Arm) -> bool:
    """Return whether the base of an arm may give way."""
    return any_acts(arm.record().body, BASE)


def base_direction(arm: Arm) -> float:
    """Return the direction in which the base of an arm gives way [rad]."""
    return float(numbers_at(arm.record().body, BASE)['direction'])


def base_motion(arm: Arm, links: DifferentiatedAngle, dt: float) -> Array:
    """Return offset [m] and rate [m/s] of the base (k, 2) from rest, zero where it is rigid."""
    if not gives_way(arm):
        return np.zeros((len(links.angle), 2))
    return _answer(arm.record().body, stirring(arm, links, base_direction(arm))[0], dt)


def base_acceleration_under(arm: Arm, push: Array, dt: float) -> Array:
    """Return the acceleration (k,) of a base, from rest, under a push over time (k,) [m/s^2]."""
    body, acceleration = arm.record().body, np.empty_like(push)
    _fill_acceleration(body, push, _answer(body, push, dt), acceleration)
    return acceleration


def _answer(body: Record, course: Array, dt: float) -> Array:
    """Return offset [m] and rate [m/s] (k, 2) of a base, from rest, to a push over time (k,)."""
    amplitude, damping, frequency = (float(numbers_at(body, BASE)[name]) for name in (
        'amplitude', 'damping', 'frequency'))
    pace, answer = 2.0 * np.pi * frequency, np.empty((len(course), 2))
    mode = np.array([[0.0, 1.0], [-pace ** 2, -2.0 * damping * pace]])
    step = cont2discrete((mode, np.array([[0.0], [amplitude]]), np.eye(2),
                          np.zeros((2, 1))), dt, 'foh')     # a push straight between samples
    past, push, driven, now = (np.ascontiguousarray(part) for part in step[:4])
    _march(past, push, driven, now, course, answer)
    return answer


def stirring(arm: Arm, links: DifferentiatedAngle, direction: float) -> tuple[Array, Array]:
    """
    Return the push (k,) of the links on a base [N], and its coupling (k, n) [kg*m].

    The course of the links has (k, n) each.
    """
    inertia, joints = loaded_inertia(arm.record().body), links.angle.shape[1]
    if isinstance(inertia, Chain):
        return _chain_stirring(inertia, links, direction)
    angle, rate = links.angle.T, links.velocity.T
    if joints == 1:
        angle, rate = np.vstack([angle, 0.0 * angle]), np.vstack([rate, 0.0 * rate])
    (q1, q2), (dq1, dq2) = angle, rate
    coupling = np.stack(base_coupling(inertia, direction, q1, q2), axis=1)[:, :joints]
    push = base_push(inertia, direction, Pose(q1, q2, dq1, dq2), (0.0, 0.0))
    return push - (coupling * links.acceleration).sum(axis=1), coupling


def _chain_stirring(chain: Chain, links: DifferentiatedAngle,
                    direction: float) -> tuple[Array, Array]:
    """Return push (k,) and coupling (k, n) of a chain; its weight is where the base has sagged."""
    push, coupling = np.empty(len(links.angle)), np.empty(links.angle.shape)
    moved = np.ascontiguousarray(np.stack(links, axis=2))
    _stir(chain.table, (np.cos(direction), np.sin(direction), 0.0), moved, push, coupling)
    return push, coupling


@compiled
def _stir(c: Array, along: Vector, moved: Array, push: Array, coupling: Array) -> None:
    """Fill what a chain does to a base along a motion (k, n, 3)."""
    for k in range(moved.shape[0]):
        for j in range(moved.shape[1]):
            for number in range(3):
                c[j + 1, ANGLE + number] = moved[k, j, number]
        place(c)
        inverse_dynamics(c)
        weight = base_couplings(c, along)
        push[k] = -dot(vector(c, 1, FORCE), along) - weight
        for j in range(moved.shape[1]):
            coupling[k, j] = c[j + 1, COUPLING]


@compiled
def _fill_acceleration(body: Record, push: Array, base: Array, acceleration: Array) -> None:
    """Fill the acceleration (k,) of a base under a push, where it stands [m/s^2]."""
    for k in range(push.shape[0]):
        acceleration[k] = base_acceleration(body, push[k], base[k, 0], base[k, 1])


@compiled
def _march(past: Array, push: Array, driven: Array, now: Array, course: Array,
           answer: Array) -> None:
    """Fill the answer (k, 2) of a mode, given in discrete steps, to the course (k,) of a push."""
    first, second = 0.0, 0.0
    for k in range(course.shape[0]):
        for row in range(2):
            answer[k, row] = driven[row, 0] * first + driven[row, 1] * second + now[row,
                                                                                    0] * course[k]
        first, second = (past[0, 0] * first + past[0, 1] * second + push[0, 0] * course[k],
                         past[1, 0] * first + past[1, 1] * second + push[1, 0] * course[k])
