"""Gather what a report shows of a conclusion: residuals, coordinates, predictions."""

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.kernel import LINK_ANGLE, LINK_VELOCITY, MOTOR_ANGLE, MOTOR_VELOCITY
import numpy as np
from numpy.typing import NDArray

from .balance import Balancer
from .diagnose import Evidence
from .exhibits import Exhibits
from .predict import prediction_errors
from ..torsion_torque import torque_through_gear

Array = NDArray[np.float64]
HORIZONS = (0.01, 0.02, 0.05, 0.1, 0.2)     # over which predictions are shown [s]


def exhibits_of(evidence: Evidence) -> Exhibits:
    """Return the exhibits of a conclusion."""
    fitter, last = evidence.fitter, evidence.found.last
    balancer = fitter.balancer
    lacking = {(term.name, term.joint): balancer(fitter.on(
        [other for other in last.terms if other is not term])).residual for term in last.accepted}
    return Exhibits(
        balancer.time, fitter.arm.labels, balancer(evidence.before).residual,
        last.balance.residual, last.balance.valid, _coordinates(balancer, evidence.extended),
        np.array(HORIZONS), _predicted(balancer, evidence.before, evidence),
        _predicted(balancer, evidence.extended, evidence),
        _predicted(evidence.twin, evidence.extended, evidence), lacking=lacking)


def _predicted(balancer: Balancer, arm: Arm, evidence: Evidence) -> Array:
    """Return the rms errors of motors and links together, by horizon [rad at the output]."""
    angles = 2 * len(arm.joints)
    return np.array([np.sqrt(prediction_errors(balancer, arm, evidence.held_out, horizon)
                             [:, :angles].sum(axis=1).mean()) for horizon in HORIZONS])


def _coordinates(balancer: Balancer, arm: Arm) -> dict[str, Array]:
    """Return what residuals may depend on, at the times of the balances (m, n)."""
    state = balancer.motion(arm).state[::balancer.every]
    joints = arm.record().joints
    torsion = state[:, :, MOTOR_ANGLE] / joints['ratio'] - state[:, :, LINK_ANGLE]
    torque = np.array([[torque_through_gear(joint, value, 0.0, 0.0)
                        for joint, value in zip(joints, row)] for row in torsion])
    return {'motor_velocity': state[:, :, MOTOR_VELOCITY],
            'link_velocity': state[:, :, LINK_VELOCITY],
            'motor_angle': state[:, :, MOTOR_ANGLE], 'link_angle': state[:, :, LINK_ANGLE],
            'joint_torque': torque,
            'motor_torque': balancer.measurement.command[::balancer.every]}
