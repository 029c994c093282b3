"""
Torques that the links need for a measured motion, compiled (docs/model.md, eq:balance-parts).

Links in a plane and chains in space find them each in their own way; all else is one.
"""

from hda_arm_sim.foundation import chain
from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.chain import Chain, inverse_dynamics, lent, of_links
from hda_arm_sim.foundation.compiled import compiled, inlined
from hda_arm_sim.foundation.rigid import Inertia, mass_matrix
from hda_arm_sim.model.arm import ArmRecord
from hda_arm_sim.model.chain_side import pose
from hda_arm_sim.model.kernel import AXES, LINK_ANGLE, LINK_VELOCITY, NOW, REGISTERS, STATE
from hda_arm_sim.model.link_side import free_torque, Pose, tip_force
import numpy as np

from ...measurements.motion import Course


@inlined
def _planar_needed(arm: ArmRecord, inertia: Inertia, w: Array, acceleration: Array,
                   needed: Array) -> None:
    """Fill what links in a plane need (n,), M ddq + C dq - gravity - J^T F [N*m]."""
    two = acceleration.shape[0] == 2
    q1, dq1 = w[0, STATE + LINK_ANGLE], w[0, STATE + LINK_VELOCITY]
    q2, dq2 = (w[1, STATE + LINK_ANGLE], w[1, STATE + LINK_VELOCITY]) if two else (0.0, 0.0)
    force = tip_force(arm.body, w[0, NOW], 0.0, 0.0)
    free1, free2 = free_torque(arm.body, inertia, Pose(q1, q2, dq1, dq2), force)
    if two:
        m11, m12, m22 = mass_matrix(inertia, q2)
        needed[0] = m11 * acceleration[0] + m12 * acceleration[1] - free1
        needed[1] = m12 * acceleration[0] + m22 * acceleration[1] - free2
    else:
        needed[0] = inertia.p1 * acceleration[0] - free1


@compiled
def _spatial_needed(arm: ArmRecord, inertia: Chain, w: Array, acceleration: Array,
                    needed: Array) -> None:
    """Fill what a chain needs (n,), by inverse dynamics [N*m]."""
    c = inertia.table
    pose(arm, c, w, STATE)
    for j in range(acceleration.shape[0]):
        c[j + 1, chain.SPEEDING] = acceleration[j]
    chain.place(c)
    inverse_dynamics(c)
    for j in range(acceleration.shape[0]):
        needed[j] = c[j + 1, chain.TORQUE]


_needed = of_links(_planar_needed, _spatial_needed)


@compiled
def fill_needed(arm: ArmRecord, inertia: Inertia, links: Course, dt: float,
                needed: Array) -> None:
    """Fill what the links need for a course (k, n) on a base at rest (k, n) [N*m, output]."""
    joints = needed.shape[1]
    w = np.zeros((max(AXES, joints), REGISTERS))
    chain_or_pair = lent(inertia)
    for k in range(needed.shape[0]):
        w[0, NOW] = k * dt
        for j in range(joints):
            w[j, STATE + LINK_ANGLE] = links.angle[k, j]
            w[j, STATE + LINK_VELOCITY] = links.velocity[k, j]
        _needed(arm, chain_or_pair, w, links.acceleration[k], needed[k])
