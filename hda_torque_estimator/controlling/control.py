"""
The controller's compiled step: PD on the motor side with torque feedback (eq:control-law).

    tau = K_P (N q_d - theta_m) + K_D (N dq_d - dtheta_m) + (K_J / N) tau_hat

tau_hat is the estimated torque through the gear, which loads the motor with tau_hat / N. K_J = -1
adds the load once more, so that the arm follows a push. 0 < K_J < 1 takes that share of the load
off the motor, so that the arm rejects it. K_J = 1 makes the load invisible to the motor.

The links of a chain have a weight g(q_d), which the motors hold, and the feedback is about that,
(eq:control-weight):

    tau = (the law of tau_hat + g) - g / N
"""

from typing import Any, NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.compiled import compiled
from hda_arm_sim.model.arm import ArmRecord
from hda_arm_sim.model.weight import weights
import numpy as np

# Memory, per joint.
LAST_ANGLE, VELOCITY, LAST_COMMAND, HANDOVER = range(4)
MEMORY = 4

# A reference, per joint, on the link side.
ANGLE, RATE = 0, 1


class CompiledControlSettings(NamedTuple):
    """What the compiled step reads of the settings and of the arm's limits."""

    position_gain: float
    velocity_gain: float
    torque_feedback: float
    gravity_compensation: float         # 0 for links in a plane
    velocity_bandwidth: float
    rate_limit: float
    handover_time: float
    torque_limits: Array                # (n,) [N*m, shaft]


@compiled
def law(settings: CompiledControlSettings, ratio: float, angle: float, rate: float,
        motor_angle: float,
        motor_velocity: float, joint_torque: float) -> float:
    """Return the motor torque that the law asks for, (eq:control-law) [N*m, shaft]."""
    return (settings.position_gain * (ratio * angle - motor_angle)
            + settings.velocity_gain * (ratio * rate - motor_velocity)
            + settings.torque_feedback / ratio * joint_torque)


@compiled
def limited(command: float, last: float, limit: float, change: float) -> float:
    """Return the command within the limits of torque and of its change, (eq:limits) [N*m]."""
    near = min(max(command, last - change), last + change)
    return min(max(near, -limit), limit)


class ControlledArm(NamedTuple):
    """The arm as the controller believes it to be, and its links with what they carry."""

    record: ArmRecord
    inertia: Any            # an Inertia, or a Chain


class Asked(NamedTuple):
    """What one sample asks for."""

    reference: Array            # (n, 2) link angle and rate [rad, rad/s]
    motor_angle: Array          # (n,) of the shafts [rad]
    joint_torque: Array         # (n,) estimated torques [N*m]
    dt: float                   # since the last sample, 0 to take over without a step [s]


@compiled
def step(body: ControlledArm, settings: CompiledControlSettings, memory: Array, asked: Asked,
         command: Array) -> None:
    """
    Fill the motor torques (n,) [N*m] that answer one sample.

    The command starts at what holds a chain's weight, which is zero for links in a plane. What
    the law asks for beyond that comes in, (eq:handover).
    """
    record, (reference, motor_angle, joint_torque, dt) = body.record, asked
    share = 1.0 - np.exp(-2.0 * np.pi * settings.velocity_bandwidth * dt)
    left = np.exp(-dt / settings.handover_time)
    weight = np.zeros(record.joints.shape[0])
    if settings.gravity_compensation > 0.0:
        weights(record, body.inertia, reference[:, ANGLE], weight)
    for j in range(record.joints.shape[0]):
        ratio = record.joints[j].ratio
        pull = settings.gravity_compensation * weight[j]
        if dt > 0.0:
            rate = (motor_angle[j] - memory[j, LAST_ANGLE]) / dt
            memory[j, VELOCITY] += share * (rate - memory[j, VELOCITY])
        memory[j, LAST_ANGLE] = motor_angle[j]
        wanted = law(settings, ratio, reference[j, ANGLE], reference[j, RATE], motor_angle[j],
                     memory[j, VELOCITY], joint_torque[j] + pull)
        memory[j, HANDOVER] = memory[j, HANDOVER] * left if dt > 0.0 else -wanted
        last = memory[j, LAST_COMMAND] if dt > 0.0 else -pull / ratio
        command[j] = limited(wanted + memory[j, HANDOVER] - pull / ratio, last,
                             settings.torque_limits[j], settings.rate_limit * dt)
        memory[j, LAST_COMMAND] = command[j]
