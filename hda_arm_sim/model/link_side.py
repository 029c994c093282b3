"""
What acts on the links: every effect of the links and the base at its place, by its law.

See docs/model.md, eq:links.
"""

from typing import Any, NamedTuple

import numpy as np

from .effect_loops import acting_at, added, pair_added, passed, record_at, triple_added
from .effects.catalogue import sole_at
from .effects.place import (BASE, BEARING, Carried, LINK_TORQUE, LOAD, Pulled, Signal, Swung, TIP,
                            Touched)
from ..foundation.arrays import Array
from ..foundation.chain import Chain, chain, of_links
from ..foundation.compiled import compiled, inlined, Number, Record
from ..foundation.rigid import coriolis, gravity_torque, Inertia, mass_matrix, tip_torque
from ..foundation.vectors import Vector


@inlined
def _carried(at: Carried, inertia: Inertia) -> Carried:
    return Carried(inertia, at.length1, at.length2)


@inlined
def _as_they_are(at: Array, table: Array) -> Array:
    return at


_loaded, _loaded_chain = passed(LOAD, _carried), passed(LOAD, _as_they_are, 'law_chain')
_touched, _touched_in_space = pair_added(TIP), triple_added(TIP)
_pulled, _held_by = added(LINK_TORQUE), added(BEARING)
swings, swing_of = acting_at(BASE), record_at(BASE)    # whether a base does, and its numbers
_stirred = sole_at(BASE).law


class Pose(NamedTuple):
    """Angles and rates of two joints, numbers or arrays over time."""

    q1: Signal
    q2: Signal
    dq1: Signal
    dq2: Signal


@inlined
def _loaded_pair(body: Record) -> Inertia:
    links = body.links
    bare = Inertia(links.p1, links.p2, links.p3, links.first, links.second, links.coupled)
    return _loaded(body, Carried(bare, links.length1, links.length2), bare)


@inlined
def _loaded_links(body: Record) -> Chain:
    made = chain(body.links.parts[:int(body.links.joints) + 2])
    _loaded_chain(body, made.table, made.table)
    return made


_loaded_inertia = of_links(_loaded_pair, _loaded_links)


@compiled
def loaded_inertia(body: Record) -> Any:
    """Return the Inertia or the Chain of the links with what they carry, (eq:payload)."""
    return _loaded_inertia(body)


@inlined
def tip_force(body: Record, time: float, force_x: float,
              force_y: float) -> tuple[float, float]:
    """Return all force on the tip in the base frame, x and y [N]."""
    return _touched(body, Touched(time), (force_x, force_y))


@inlined
def tip_force_in_space(body: Record, time: float, force: Vector) -> Vector:
    """Return all force on the tip of a chain in the base frame [N]."""
    return _touched_in_space(body, Touched(time), force)


@inlined
def free_torque(body: Record, inertia: Inertia, pose: Pose,
                force: tuple[float, float]) -> tuple[float, float]:
    """Return what tip force, gravity and motion do to joints 1 and 2, without gears [N*m]."""
    (q1, q2, dq1, dq2), (force_x, force_y) = pose, force
    turn1, turn2 = coriolis(inertia, q2, dq1, dq2)
    net1, net2 = -turn1, -turn2
    if force_x != 0.0 or force_y != 0.0:        # seldom, and a force costs four waves
        tip1, tip2 = tip_torque(body.links.length1, body.links.length2, q1, q2, force_x, force_y)
        net1, net2 = net1 + tip1, net2 + tip2
    if body.pull != 0.0:
        weight1, weight2 = gravity_torque(inertia, body.pull, body.direction, q1, q2)
        net1, net2 = net1 + weight1, net2 + weight2
    return net1, net2


@inlined
def link_torque(joint: Record, link_angle: float) -> float:
    """Return the torque of what pulls a joint's link, as a cable does [N*m at the output]."""
    return _pulled(joint, Pulled(link_angle), 0.0)


@inlined
def bearing_level(joint: Record, link_angle: float) -> float:
    """Return the most torque that a joint's link bearing opposes, (eq:bearing) [N*m output]."""
    return _held_by(joint, Pulled(link_angle), 0.0)


@inlined
def base_acceleration(body: Record, push: float, offset: float, rate: float) -> float:
    """Return the acceleration of a base beneath joints at rest, (eq:base-motion) [m/s^2]."""
    return _stirred(swing_of(body), Swung(push, offset, rate))


@compiled
def base_coupling(inertia: Inertia, direction: float, q1: Number,
                  q2: Number) -> tuple[Number, Number]:
    """Return the torque on joints 1 and 2 per acceleration of the base, (eq:base-load) [kg*m]."""
    far = inertia.second * np.sin(direction - q1 - q2)
    return inertia.first * np.sin(direction - q1) + far, far


@compiled
def base_push(inertia: Inertia, direction: float, pose: Pose,
              force: tuple[Number, Number]) -> Number:
    """Return the push of links and tip on the base, along `direction`, (eq:base-motion) [N]."""
    (q1, q2, dq1, dq2), (force_x, force_y) = pose, force
    swing = (inertia.first * dq1 * dq1 * np.cos(direction - q1)
             + inertia.second * (dq1 + dq2) ** 2 * np.cos(direction - q1 - q2))
    return swing + force_x * np.cos(direction) + force_y * np.sin(direction)


def thrown_mass(inertia: Inertia, joints: int) -> float:
    """Return the largest mass with which free joints can answer a push on the base [kg]."""
    elbow = np.linspace(0.0, 2.0 * np.pi, 73) if joints == 2 else np.zeros(1)
    m11, m12, m22 = mass_matrix(inertia, elbow)
    matrix = np.array([[m11, m12], [m12, m22]])[:joints, :joints].transpose(2, 0, 1)
    sides = [base_coupling(inertia, direction, 0.0 * elbow, elbow)
             for direction in (0.0, 0.5 * np.pi)]
    push = np.array([[side[0] + 0.0 * elbow, side[1]] for side in sides])[:, :joints]
    push = push.transpose(2, 1, 0)                                  # (elbows, joints, directions)
    thrown = push.transpose(0, 2, 1) @ np.linalg.solve(matrix, push)
    return float(np.linalg.eigvalsh(thrown).max())
