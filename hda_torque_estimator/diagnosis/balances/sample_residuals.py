"""
Residuals of one sample: measured less predicted accelerations, as torques (eq:balance-a).

Links in a plane and chains in space have their mass matrix each in its own way; all else is one.
"""

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.chain import Chain, MATRIX, of_links
from hda_arm_sim.foundation.compiled import compiled, inlined, Record
from hda_arm_sim.foundation.rigid import Inertia, mass_matrix
from hda_arm_sim.model.arm import ArmRecord
from hda_arm_sim.model.kernel import LINK_ANGLE, LINK_VELOCITY, MOTOR_VELOCITY, SLOPE_1, STATE
from hda_arm_sim.model.link_side import base_coupling, swing_of, swings


@inlined
def _planar_missed(arm: ArmRecord, inertia: Inertia, w: Array, acceleration: Array,
                   residual: Array) -> None:
    """Fill B of links in a plane: the mass matrix times what the prediction missed."""
    joints = acceleration.shape[0]
    miss1 = acceleration[0, 1] - w[0, SLOPE_1 + LINK_VELOCITY]
    residual[joints], miss2 = inertia.p1 * miss1, 0.0
    if joints == 2:
        miss2 = acceleration[1, 1] - w[1, SLOPE_1 + LINK_VELOCITY]
        m11, m12, m22 = mass_matrix(inertia, w[1, STATE + LINK_ANGLE])
        residual[2] = m11 * miss1 + m12 * miss2
        residual[3] = m12 * miss1 + m22 * miss2
    if swings(arm.body):                        # what is missed would shake the base less
        swing = swing_of(arm.body)
        sides = base_coupling(inertia, swing.direction, w[0, STATE + LINK_ANGLE],
                              w[1, STATE + LINK_ANGLE])
        shaken = swing.amplitude * (sides[0] * miss1 + sides[1] * miss2)
        residual[joints] -= sides[0] * shaken
        if joints == 2:
            residual[3] -= sides[1] * shaken


@compiled
def _spatial_missed(arm: ArmRecord, inertia: Chain, w: Array, acceleration: Array,
                    residual: Array) -> None:
    """Fill B of a chain, with the mass matrix that its slope has left, on a base that swings."""
    joints, table = acceleration.shape[0], inertia.table
    for j in range(joints):
        residual[joints + j] = 0.0
        for k in range(joints):
            residual[joints + j] += table[j + 1, MATRIX + k] * (
                acceleration[k, 1] - w[k, SLOPE_1 + LINK_VELOCITY])


@inlined
def motor_missed(joint: Record, w: Array, j: int, acceleration: float) -> float:
    """Return what a motor missed of an acceleration, N J ddtheta, as a torque [N*m, output]."""
    miss = acceleration - w[j, SLOPE_1 + MOTOR_VELOCITY]
    return joint.ratio * joint.motor_inertia * miss


_missed = of_links(_planar_missed, _spatial_missed)


@compiled
def missed_torques(arm: ArmRecord, inertia: Inertia, w: Array, acceleration: Array,
                   residual: Array) -> None:
    """Fill the residuals of one sample from measured accelerations and predicted ones."""
    joints = acceleration.shape[0]
    _missed(arm, inertia, w, acceleration, residual)
    for j in range(joints):
        missed = motor_missed(arm.joints[j], w, j, acceleration[j, 0])
        residual[j] = missed + residual[joints + j]
