"""What a residual may follow: the coordinates of a measured motion, at the balances' times."""

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.compiled import compiled, Record
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.kernel import LINK_ANGLE, LINK_VELOCITY, MOTOR_ANGLE, MOTOR_VELOCITY
import numpy as np
from scipy.ndimage import gaussian_filter1d

from .balance import Balancer
from ...estimating.laws.torsion_torque import torque_through_gear

# Numerics; choices unless stated otherwise.
# (source: what noise moves has no less at high frequency; motions of robots end below 7 Hz)
SMOOTH = 3.0            # samples of the balances over which torques and rates are of the motion


def coordinates_of(balancer: Balancer, arm: Arm) -> dict[str, Array]:
    """
    Return what residuals may depend on, at the times of the balances, (m, n) each.

    Velocities [rad/s], angles [rad], `joint_torque` [N*m at the output], `motor_torque` [N*m at
    the shaft]; `other_link_angle` only where there is another joint.
    """
    state = balancer.motion(arm).state[::balancer.every]
    torque = torques_of(arm, state[:, :, MOTOR_ANGLE], state[:, :, LINK_ANGLE])
    found = {'motor_velocity': state[:, :, MOTOR_VELOCITY],
             'link_velocity': state[:, :, LINK_VELOCITY],
             'motor_angle': state[:, :, MOTOR_ANGLE], 'link_angle': state[:, :, LINK_ANGLE],
             'joint_torque': torque,
             'motor_torque': balancer.measurement.command[::balancer.every]}
    if len(arm.joints) > 1:
        found['other_link_angle'] = state[:, ::-1, LINK_ANGLE]
    return found


def of_motion(values: Array) -> Array:
    """
    Return coordinates (m, ...) without what is quick in them: noise of the readings.

    A torque through a gear and the balances have the same. No law follows it, and any would seem
    to.
    """
    return np.asarray(gaussian_filter1d(values, SMOOTH, axis=0))


def torques_of(arm: Arm, motor: Array, link: Array) -> Array:
    """Return what angles of motors and links (m, n) [rad] send through the gears [N*m, output]."""
    joints = arm.record().joints
    torque = np.empty(motor.shape)
    _fill_torques(joints, motor, motor / joints['ratio'] - link, torque)
    return torque


@compiled
def _fill_torques(joints: Record, motor: Array, torsion: Array, torque: Array) -> None:
    """Fill the torques (m, n) of torsions at angles of the motors."""
    for k in range(motor.shape[0]):
        for j in range(motor.shape[1]):
            torque[k, j] = torque_through_gear(joints[j], motor[k, j], torsion[k, j], 0.0, 0.0)
