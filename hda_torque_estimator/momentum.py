"""External torque from torsion torque and motion: a momentum observer (docs/model.md, 32-33)."""

from hda_arm_sim.model.compiled import compiled
from hda_arm_sim.model.rigid import gravity_torque, mass_matrix, momentum_drift


@compiled
def momentum(inertia, joints, elbow, dq1, dq2):                     # type: ignore[no-untyped-def]
    """Return the generalised momentum M(q) dq of one or two links [kg*m^2/s]."""
    if joints == 1:
        return inertia.p1 * dq1, 0.0
    m11, m12, m22 = mass_matrix(inertia, elbow)
    return m11 * dq1 + m12 * dq2, m12 * dq1 + m22 * dq2


@compiled
def expected_rate(                                                  # type: ignore[no-untyped-def]
        inertia, body, joints, q1, q2, dq1, dq2, torque1, torque2):
    """Return dp/dt of links that nothing but the gears and gravity moves, (32) [N*m]."""
    weight1, weight2 = gravity_torque(inertia, body.pull, body.direction, q1, q2)
    if joints == 1:
        return torque1 + weight1, 0.0
    return torque1 + weight1, torque2 + weight2 + momentum_drift(inertia, q2, dq1, dq2)
