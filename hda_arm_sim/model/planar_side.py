"""How links in a plane move under what drives them, (docs/model.md, eq:links)."""

from .arm import ArmRecord
from .link_side import (base_acceleration, base_coupling, base_push, bearing_level, free_torque,
                        link_torque, Pose, swing_of, swings, tip_force)
from .registers import (BASE_OFFSET, BASE_RATE, BUDGET, DRIVE, FORCE, LINK_ANGLE, LINK_VELOCITY,
                        MODE, NOW, TORQUE)
from ..foundation.arrays import Array
from ..foundation.compiled import inlined
from ..foundation.rigid import Inertia, mass_matrix


@inlined
def accelerate(arm: ArmRecord, inertia: Inertia, w: Array, at: int, to: int) -> None:
    """Fill the links' accelerations, M ddq = tau + J^T F + gravity - C dq, (eq:links)."""
    two = arm.joints.shape[0] == 2
    q1, dq1 = w[0, at + LINK_ANGLE], w[0, at + LINK_VELOCITY]
    q2, dq2 = (w[1, at + LINK_ANGLE], w[1, at + LINK_VELOCITY]) if two else (0.0, 0.0)
    pose = Pose(q1, q2, dq1, dq2)
    force = tip_force(arm.body, w[0, NOW], w[0, FORCE], w[1, FORCE])
    net1, net2 = free_torque(arm.body, inertia, pose, force)
    net1 += w[0, TORQUE] + link_torque(arm.joints[0], q1)
    m11, m12, m22 = inertia.p1, 0.0, 1.0
    if two:
        net2 += w[1, TORQUE] + link_torque(arm.joints[1], q2)
        m11, m12, m22 = mass_matrix(inertia, q2)
    held = (bearing_level(arm.joints[0], q1), bearing_level(arm.joints[1], q2) if two else 0.0)
    if not swings(arm.body):
        _solve(w, two, held, (m11, m12, m22), (net1, net2), to)
        return
    swing = swing_of(arm.body)
    c1, c2 = base_coupling(inertia, swing.direction, q1, q2)
    push = base_push(inertia, swing.direction, pose, force)
    free = base_acceleration(arm.body, push, w[0, at + BASE_OFFSET], w[0, at + BASE_RATE])
    share1, share2 = swing.amplitude * c1, swing.amplitude * c2
    _solve(w, two, held, (m11 - share1 * c1, m12 - share1 * c2, m22 - share2 * c2),
           (net1 - c1 * free, net2 - c2 * free), to)
    w[0, to + BASE_OFFSET] = w[0, at + BASE_RATE]
    w[0, to + BASE_RATE] = free - share1 * w[0, to + LINK_VELOCITY]
    if two:
        w[0, to + BASE_RATE] -= share2 * w[1, to + LINK_VELOCITY]


@inlined
def _solve(w: Array, two: bool, levels: tuple[float, float], matrix: tuple[float, float, float],
           net: tuple[float, float], to: int) -> None:
    """Fill the links' accelerations, with bearings that hold or oppose them, (eq:bearing)."""
    (level1, level2), (m11, m12, m22), (net1, net2) = levels, matrix, net
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
