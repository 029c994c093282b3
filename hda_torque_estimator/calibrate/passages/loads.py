"""
What links, gravity, cables and known forces ask of the gears: a torque without a torque sensor.

The motion comes from the link encoders, the inertia from the arm. Weights and forces that are
known fix the scale of the torque; where there are none the inertia of the links does.
"""

from typing import NamedTuple

from hda_arm_sim.foundation.rigid import coriolis, gravity_torque, Inertia, mass_matrix, tip_torque
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.chain_links import ChainLinks
from hda_arm_sim.model.effects.catalogue import effects_at
from hda_arm_sim.model.effects.place import LINK_TORQUE
from hda_arm_sim.model.kernel import LINK_ANGLE, LINK_VELOCITY
from hda_arm_sim.model.link_side import loaded_inertia
import numpy as np
from numpy.typing import NDArray

from .chain_loads import chain_needs
from ...measurements.motion import MeasuredMotion

Floats = NDArray[np.float64]
DOUBTS = 3              # p1, p2, p3; of a chain none (layout)


class Loads(NamedTuple):
    """Torques through n gears (k, n) [N*m], and their doubt (k, n, DOUBTS), one sigma each."""

    torque: Floats
    doubt: Floats


def loads(arm: Arm, motion: MeasuredMotion, wrench: Floats) -> Loads:
    """Return what moves the links of an arm under a wrench (k, 6) on its tip [N, N*m, base]."""
    pulled = [sum(arm.effect(kind.name, label)(link_angle=motion.state[:, j, LINK_ANGLE])
                  for kind in effects_at(LINK_TORQUE)) for j, label in enumerate(arm.labels)]
    if isinstance(arm.links, ChainLinks):
        torque = chain_needs(arm, motion, wrench) - np.stack(pulled, axis=1)
        return Loads(torque, np.zeros((*torque.shape, DOUBTS)))     # the weight is as stated
    return _of_pair(arm, motion, wrench, pulled)


def _of_pair(arm: Arm, motion: MeasuredMotion, wrench: Floats, pulled: list[Floats]) -> Loads:
    """Return what moves links in a plane: forces in it push them, nothing else."""
    body = arm.record().body
    inertia, joints = loaded_inertia(body), len(arm.joints)
    angle = _pair(motion.state[:, :, LINK_ANGLE])
    links = arm.moving_links()
    weight = gravity_torque(inertia, body['pull'], body['direction'], *angle)
    push = tip_torque(links.length1, links.length2, *angle, wrench[:, 0], wrench[:, 1])
    moved = _moving(inertia, motion)
    torque = np.stack([moved[j] - weight[j] - push[j] - pulled[j] for j in range(joints)], axis=1)
    doubt = [np.stack(_moving(part, motion)[:joints], axis=1) for part in _parts(inertia)]
    return Loads(torque, arm.tolerances.link_inertia * np.stack(doubt, axis=2))


def _pair(columns: Floats) -> tuple[Floats, Floats]:
    """Return the columns of both joints, zeros for one that is not there."""
    return columns[:, 0], (columns[:, 1] if columns.shape[1] > 1 else np.zeros(len(columns)))


def _moving(inertia: Inertia, motion: MeasuredMotion) -> tuple[Floats, Floats]:
    """Return M(q) ddq + C(q, dq) dq of both joints (k,) [N*m]."""
    _, elbow = _pair(motion.state[:, :, LINK_ANGLE])
    rate1, rate2 = _pair(motion.state[:, :, LINK_VELOCITY])
    gain1, gain2 = _pair(motion.acceleration[:, :, 1])
    m11, m12, m22 = mass_matrix(inertia, elbow)
    turn1, turn2 = coriolis(inertia, elbow, rate1, rate2)
    return m11 * gain1 + m12 * gain2 + turn1, m12 * gain1 + m22 * gain2 + turn2


def _parts(inertia: Inertia) -> tuple[Inertia, ...]:
    """Return the inertia as a sum of three, of p1, p2 and p3 alone."""
    alone = inertia._replace(p1=0.0, p2=0.0, p3=0.0)
    return (alone._replace(p1=inertia.p1), alone._replace(p2=inertia.p2),
            alone._replace(p3=inertia.p3))
