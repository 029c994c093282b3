"""External torque from torsion torque and motion: a momentum observer (docs/model.md)."""

from typing import NamedTuple

from hda_arm_sim.foundation.compiled import compiled, Record
from hda_arm_sim.foundation.rigid import gravity_torque, Inertia, mass_matrix, momentum_drift
from hda_arm_sim.model.link_side import bearing_level, link_torque
import numpy as np

# Choices unless stated otherwise.
_AT_REST = 1e-3         # speed below which a link bearing may hold either way [rad/s]


class LinkMotion(NamedTuple):
    """Where the links are [rad] and how they move [rad/s]; a second one may be missing."""

    q1: float
    q2: float
    dq1: float
    dq2: float


@compiled
def momentum(inertia: Inertia, joints: int, at: LinkMotion) -> tuple[float, float]:
    """Return the generalised momentum M(q) dq of one or two links [kg*m^2/s]."""
    if joints == 1:
        return inertia.p1 * at.dq1, 0.0
    m11, m12, m22 = mass_matrix(inertia, at.q2)
    return m11 * at.dq1 + m12 * at.dq2, m12 * at.dq1 + m22 * at.dq2


@compiled
def hold(joint: Record, angle: float, velocity: float) -> tuple[float, float]:
    """
    Return what cable and bearing do to a link, and how far that is in doubt [N*m].

    A bearing at rest holds any torque up to its level, which cannot be observed from outside.
    """
    level = bearing_level(joint, angle)
    if abs(velocity) < _AT_REST:
        return link_torque(joint, angle), level
    return link_torque(joint, angle) - level * np.sign(velocity), 0.0


@compiled
def inertia_doubt(inertia: Inertia, at: LinkMotion, ddq1: float, ddq2: float) -> tuple[float,
                                                                                       float]:
    """
    Return the squared torques that p1, p2 and p3 make, each alone, on both joints (eq:sigma-ext).

    Times the relative variance of the three they are the variance of the torques that move links.
    """
    c, s = np.cos(at.q2), np.sin(at.q2)
    p2, p3 = inertia.coupled * inertia.p2, inertia.coupled * inertia.p3
    bend1 = p3 * (c * (2.0 * ddq1 + ddq2) - s * (2.0 * at.dq1 + at.dq2) * at.dq2)
    bend2 = p3 * (c * ddq1 + s * at.dq1 * at.dq1)
    return ((inertia.p1 * ddq1) ** 2 + (p2 * ddq2) ** 2 + bend1 ** 2,
            (p2 * ddq1 + inertia.p2 * ddq2) ** 2 + bend2 ** 2)


@compiled
def expected_rate(inertia: Inertia, body: Record, joints: int, at: LinkMotion,
                  torque: tuple[float, float]) -> tuple[float, float]:
    """Return dp/dt of links that only gears and gravity move, (eq:expected-rate) [N*m]."""
    weight1, weight2 = gravity_torque(inertia, body.pull, body.direction, at.q1, at.q2)
    if joints == 1:
        return torque[0] + weight1, 0.0
    return (torque[0] + weight1,
            torque[1] + weight2 + momentum_drift(inertia, at.q2, at.dq1, at.dq2))
