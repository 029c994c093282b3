"""How the links of a chain move under what drives them, (docs/model.md#chains)."""

import numpy as np

from .arm import ArmRecord
from .link_side import (base_acceleration, bearing_level, link_torque, swing_of, swings,
                        tip_force_in_space)
from .registers import (AXES, BASE_OFFSET, BASE_RATE, BUDGET, DRIVE, FORCE, LINK_ANGLE,
                        LINK_VELOCITY, MODE, NOW, PUSHED, TORQUE)
from ..foundation import chain
from ..foundation.arrays import Array
from ..foundation.chain import base_couplings, Chain, COUPLING, inverse_dynamics, mass_matrix
from ..foundation.compiled import compiled, inlined, Record
from ..foundation.vectors import dot, put, Vector, vector


@compiled
def accelerate(arm: ArmRecord, inertia: Chain, w: Array, at: int, to: int) -> None:
    """Fill the links' accelerations, M ddq = tau + J^T F + gravity - C dq, (eq:links)."""
    c, joints = inertia.table, arm.joints.shape[0]
    pose(arm, c, w, at)
    chain.place(c)
    inverse_dynamics(c)
    mass_matrix(c)
    for j in range(joints):
        joint = arm.joints[j]
        c[j + 1, chain.TORQUE] = (
            w[j, TORQUE] + link_torque(joint, w[j, at + LINK_ANGLE]) - c[j + 1, chain.TORQUE]
            - w[j, MODE + 1] * bearing_level(joint, w[j, at + LINK_ANGLE]))
    if not swings(arm.body):
        _solve(arm, c, w, to)
        return
    free, swing = _stir(arm.body, c, w, at), swing_of(arm.body)
    _solve(arm, c, w, to)
    w[0, to + BASE_OFFSET], w[0, to + BASE_RATE] = w[0, at + BASE_RATE], free
    for j in range(joints):
        w[0, to + BASE_RATE] -= swing.amplitude * c[j + 1, COUPLING] * w[j, to + LINK_VELOCITY]


@inlined
def pose(arm: ArmRecord, c: Array, w: Array, at: int) -> None:
    """Hand angles, speeds and what pushes a link or the tip to the chain."""
    for j in range(arm.joints.shape[0]):
        c[j + 1, chain.ANGLE] = w[j, at + LINK_ANGLE]
        c[j + 1, chain.SPEED] = w[j, at + LINK_VELOCITY]
        c[j + 1, chain.SPEEDING] = 0.0
    last = arm.joints.shape[0] + 1
    at = int(w[0, PUSHED]) if w[0, PUSHED] > 0.0 else last      # a link's row is its number
    for axis in range(AXES):
        c[last, chain.WRENCH + axis] = 0.0
        c[at, chain.WRENCH + axis] = w[axis, FORCE]
    put(c, last, chain.WRENCH, tip_force_in_space(arm.body, w[0, NOW],
                                                  vector(c, last, chain.WRENCH)))


@inlined
def swing_direction(swing: Record) -> Vector:
    """Return the direction in which a base swings, in the base frame."""
    return np.cos(swing.direction), np.sin(swing.direction), 0.0


@inlined
def _stir(body: Record, c: Array, w: Array, at: int) -> float:
    """Let a base swing: couple it to matrix and torques, return its acceleration beneath rest."""
    swing = swing_of(body)
    along = swing_direction(swing)
    weight = base_couplings(c, along)           # it sags under that: the swing is about there
    push = -dot(vector(c, 1, chain.FORCE), along) - weight
    free = base_acceleration(body, push, w[0, at + BASE_OFFSET], w[0, at + BASE_RATE])
    for row in range(1, c.shape[0] - 1):
        c[row, chain.TORQUE] -= c[row, COUPLING] * free
    shake_less(swing, c)
    return free


@inlined
def shake_less(swing: Record, c: Array) -> None:
    """Take from the mass matrix what a base that gives way takes from it, (eq:base-load)."""
    for row in range(1, c.shape[0] - 1):
        for other in range(1, c.shape[0] - 1):
            c[row, chain.MATRIX + other - 1] -= (swing.amplitude * c[row, COUPLING]
                                                 * c[other, COUPLING])


@inlined
def _held(arm: ArmRecord, c: Array, w: Array, j: int) -> bool:
    """Return whether a bearing holds its link."""
    return bearing_level(arm.joints[j], c[j + 1, chain.ANGLE]) > 0.0 and w[j, MODE + 1] == 0.0


@inlined
def _solve(arm: ArmRecord, c: Array, w: Array, to: int) -> None:
    """Fill the links' accelerations, with bearings that hold or oppose them, (eq:bearing)."""
    joints = arm.joints.shape[0]
    for j in range(joints):
        held = _held(arm, c, w, j)
        for k in range(j + 1):
            apart = held or _held(arm, c, w, k)
            c[j + 1, chain.SOLVING + k] = 0.0 if apart else c[j + 1, chain.MATRIX + k]
        if held:
            c[j + 1, chain.SOLVING + j] = 1.0
        c[j + 1, chain.RIGHT] = 0.0 if held else c[j + 1, chain.TORQUE]
    chain.solve(c)
    for j in range(joints):
        w[j, to + LINK_VELOCITY] = c[j + 1, chain.RIGHT]
    for j in range(joints):
        level = bearing_level(arm.joints[j], c[j + 1, chain.ANGLE])
        if level > 0.0:
            load = c[j + 1, chain.TORQUE]
            for k in range(joints):
                load -= (0.0 if k == j else 1.0) * (c[j + 1, chain.MATRIX + k]
                                                    * c[k + 1, chain.RIGHT])
            w[j, DRIVE + 1], w[j, BUDGET + 1] = load, level
