"""
Torques that the links need for a measured motion, compiled (docs/model.md, eq:balance-parts).

Links in a plane and chains in space find them each in their own way; all else is one.
"""

from typing import NamedTuple

from hda_arm_sim.foundation import chain
from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.chain import Chain, CONSTANTS, inverse_dynamics, lent, MASS, of_links
from hda_arm_sim.foundation.chain_others import torques_with_others
from hda_arm_sim.foundation.compiled import compiled, inlined
from hda_arm_sim.foundation.rigid import Inertia, mass_matrix
from hda_arm_sim.model.arm import Arm, ArmRecord
from hda_arm_sim.model.chain_links import ChainLinks
from hda_arm_sim.model.chain_side import pose
from hda_arm_sim.model.kernel import AXES, LINK_ANGLE, LINK_VELOCITY, NOW, REGISTERS, STATE
from hda_arm_sim.model.link_side import free_torque, loaded_inertia, Pose, tip_force
import numpy as np
from numpy.typing import NDArray

from ...measurements.motion import DifferentiatedAngle


class Others(NamedTuple):
    """Other links of a chain, each in the place of one of its own."""

    rows: NDArray[np.intp]      # (v,) of the chain
    bodies: Array               # (v, b) what each weighs, as its row has it


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


@inlined
def _ask(arm: ArmRecord, c: Array, w: Array, acceleration: Array) -> None:
    """Place a chain in its state, and ask for accelerations (n,)."""
    pose(arm, c, w, STATE)
    for j in range(acceleration.shape[0]):
        c[j + 1, chain.SPEEDING] = acceleration[j]
    chain.place(c)


@compiled
def _spatial_needed(arm: ArmRecord, inertia: Chain, w: Array, acceleration: Array,
                    needed: Array) -> None:
    """Fill what a chain needs (n,), by inverse dynamics [N*m]."""
    c = inertia.table
    _ask(arm, c, w, acceleration)
    inverse_dynamics(c)
    for j in range(acceleration.shape[0]):
        needed[j] = c[j + 1, chain.TORQUE]


_needed = of_links(_planar_needed, _spatial_needed)


@compiled
def fill_needed(arm: ArmRecord, inertia: Inertia, links: DifferentiatedAngle, dt: float,
                needed: Array) -> None:
    """Fill what the links need for a course (k, n) on a base at rest (k, n) [N*m, output]."""
    joints = needed.shape[1]
    w = np.zeros((max(AXES, joints), REGISTERS))
    chain_or_pair = lent(inertia)
    for k in range(needed.shape[0]):
        _stand(w, links, k, dt)
        _needed(arm, chain_or_pair, w, links.acceleration[k], needed[k])


@inlined
def _stand(w: Array, links: DifferentiatedAngle, k: int, dt: float) -> None:
    """Put the links where they are at one sample of a course."""
    w[0, NOW] = k * dt
    for j in range(links.angle.shape[1]):
        w[j, STATE + LINK_ANGLE] = links.angle[k, j]
        w[j, STATE + LINK_VELOCITY] = links.velocity[k, j]


@compiled
def fill_needed_with(arm: ArmRecord, inertia: Chain, others: Others, links: DifferentiatedAngle,
                     dt: float,
                     needed: Array) -> None:
    """Fill what a chain needs (v, k, n) with each of other links in place of its own, likewise."""
    joints, c = needed.shape[2], lent(inertia).table
    stated = c[:, MASS:CONSTANTS].copy()
    w, torque = np.zeros((max(AXES, joints), REGISTERS)), np.empty((needed.shape[0], joints))
    for k in range(needed.shape[1]):
        _stand(w, links, k, dt)
        _ask(arm, c, w, links.acceleration[k])
        torques_with_others(c, stated, others.rows, others.bodies, torque)
        needed[:, k] = torque


def other_link(arm: Arm, other: Arm) -> tuple[int, Array] | None:
    """
    Return the one link of a chain that another arm has otherwise: its row and its body.

    None where that is not all by which the other arm needs other torques for the same motion.
    """
    if not (isinstance(arm.links, ChainLinks) and isinstance(other.links, ChainLinks)):
        return None
    body, table = other.record().body.copy(), loaded_inertia(other.record().body).table
    body['links'] = arm.record().body['links']
    rows, columns = np.nonzero(table != loaded_inertia(arm.record().body).table)
    if (body.tobytes() != arm.record().body.tobytes() or len(set(rows)) != 1
            or (columns < MASS).any()):
        return None
    return int(rows[0]), table[rows[0], MASS:CONSTANTS]
