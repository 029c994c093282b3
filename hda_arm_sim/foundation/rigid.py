"""
Rigid dynamics of one and two links in a plane (docs/model.md#links).

Angles are relative (joint 2 from link 1), positive counter-clockwise; the base frame's x axis is
link 1 at q1 = 0. Every function answers for scalars and for arrays of samples alike; results are
tuples of components, so compiled code allocates nothing.
"""

from typing import NamedTuple

import numpy as np

from .compiled import compiled, Number


class Inertia(NamedTuple):
    """
    The inertia of the links as the equations need it.

    p1 = I1 + I2 + m1 c1^2 + m2 (l1^2 + c2^2), p2 = I2 + m2 c2^2, p3 = m2 l1 c2 [kg*m^2]. `first`
    and `second` are the mass moments m1 c1 + m2 l1 and m2 c2 [kg*m]. `coupled` is 1, or 0 for
    links that do not feel each other (the paper's equations 4 and 5).
    """

    p1: float
    p2: float
    p3: float
    first: float
    second: float
    coupled: float


@compiled
def mass_matrix(inertia: Inertia, elbow: Number) -> tuple[Number, Number, Number]:
    """Return M11, M12, M22 at the elbow angle q2 [rad], (eq:inertia) [kg*m^2]."""
    bend = inertia.coupled * inertia.p3 * np.cos(elbow)
    return inertia.p1 + 2.0 * bend, inertia.coupled * inertia.p2 + bend, inertia.p2 + 0.0 * bend


@compiled
def coriolis(inertia: Inertia, elbow: Number, dq1: Number, dq2: Number) -> tuple[Number, Number]:
    """Return the centrifugal and Coriolis torques C(q, dq) dq, (eq:coriolis) [N*m]."""
    swing = inertia.coupled * inertia.p3 * np.sin(elbow)
    return -swing * (2.0 * dq1 + dq2) * dq2, swing * dq1 * dq1


@compiled
def momentum_drift(inertia: Inertia, elbow: Number, dq1: Number, dq2: Number) -> Number:
    """Return the second component of C(q, dq)^T dq, (eq:coriolis-t) [N*m]; the first is zero."""
    return -inertia.coupled * inertia.p3 * np.sin(elbow) * dq1 * (dq1 + dq2)


@compiled
def gravity_torque(inertia: Inertia, pull: float, direction: float, q1: Number,
                   q2: Number) -> tuple[Number, Number]:
    """
    Return the torque that gravity exerts on joints 1 and 2, (eq:gravity) [N*m].

    `pull` is the in-plane part g sin(tilt) [m/s^2], `direction` the downhill direction [rad].
    """
    far = pull * inertia.second * np.sin(direction - q1 - q2)
    return pull * inertia.first * np.sin(direction - q1) + far, far


@compiled
def tip_torque(length1: float, length2: float, q1: Number, q2: Number, force_x: Number,
               force_y: Number) -> tuple[Number, Number]:
    """Return J(q)^T F of a force on the tip in the base frame [N], (eq:tip-load) [N*m]."""
    x2, y2 = length2 * np.cos(q1 + q2), length2 * np.sin(q1 + q2)
    x1, y1 = length1 * np.cos(q1), length1 * np.sin(q1)
    second = x2 * force_y - y2 * force_x
    return x1 * force_y - y1 * force_x + second, second


@compiled
def tip_position(length1: float, length2: float, q1: Number, q2: Number) -> tuple[Number, Number]:
    """Return the tip in the base frame, x and y [m]."""
    return (length1 * np.cos(q1) + length2 * np.cos(q1 + q2),
            length1 * np.sin(q1) + length2 * np.sin(q1 + q2))


@compiled
def tool_jacobian(length1: float, length2: float,
                  q2: Number) -> tuple[Number, Number, Number, Number]:
    """
    Return the Jacobian in the tool frame (x along link 2), row by row, (eq:tool-jacobian) [m].

    tau = J^T F with F = (axial, perpendicular).
    """
    return (length1 * np.sin(q2), 0.0 * q2,
            length1 * np.cos(q2) + length2, length2 + 0.0 * q2)


@compiled
def tilting_moment(first: float, second: float, gravity: float,
                   elbow: Number) -> tuple[Number, Number]:
    """Return the weight's moment that tilts the bearings of joints 1 and 2, (eq:tilting) [N*m]."""
    return gravity * (first + second * np.cos(elbow)), gravity * second + 0.0 * elbow
