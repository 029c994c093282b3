"""
The controller's compiled step: PD on the motor side with torque feedback (eq:control-law).

    tau = K_P (N q_d - theta_m) + K_D (N dq_d - dtheta_m) + (K_J / N) tau_hat

tau_hat is the estimated torque through the gear, which loads the motor with tau_hat / N. K_J = -1
adds the load once more, so that the arm follows a push. 0 < K_J < 1 takes that share of the load
off the motor, so that the arm rejects it. K_J = 1 makes the load invisible to the motor.
"""

from hda_arm_sim.model.compiled import compiled
import numpy as np

# Memory, per joint.
LAST_ANGLE, VELOCITY, LAST_COMMAND, HANDOVER = range(4)
MEMORY = 4

# A reference, per joint, on the link side.
ANGLE, RATE = 0, 1


@compiled
def law(                                                            # type: ignore[no-untyped-def]
        settings, ratio, angle, rate, motor_angle, motor_velocity, joint_torque):
    """Return the motor torque that the law asks for, (eq:control-law) [N*m, shaft]."""
    return (settings.position_gain * (ratio * angle - motor_angle)
            + settings.velocity_gain * (ratio * rate - motor_velocity)
            + settings.torque_feedback / ratio * joint_torque)


@compiled
def limited(command, last, limit, change):                          # type: ignore[no-untyped-def]
    """Return the command within the limits of torque and of its change, (eq:limits) [N*m]."""
    near = min(max(command, last - change), last + change)
    return min(max(near, -limit), limit)


@compiled
def step(                                                           # type: ignore[no-untyped-def]
        record, settings, memory, reference, motor_angle, joint_torque, dt, command):
    """
    Fill the motor torques (n,) [N*m] that answer one sample.

    `reference` (n, 2) is link angle and rate [rad, rad/s], `motor_angle` (n,) the shafts' [rad],
    `joint_torque` (n,) the estimated torques [N*m]. `dt` [s] is since the last sample, 0 to take
    over without a step. The command starts at zero and what the law asks for comes in,
    (eq:handover).
    """
    share = 1.0 - np.exp(-2.0 * np.pi * settings.velocity_bandwidth * dt)
    left = np.exp(-dt / settings.handover_time)
    for j in range(record.joints.shape[0]):
        ratio = record.joints[j].ratio
        if dt > 0.0:
            rate = (motor_angle[j] - memory[j, LAST_ANGLE]) / dt
            memory[j, VELOCITY] += share * (rate - memory[j, VELOCITY])
        memory[j, LAST_ANGLE] = motor_angle[j]
        wanted = law(settings, ratio, reference[j, ANGLE], reference[j, RATE], motor_angle[j],
                     memory[j, VELOCITY], joint_torque[j])
        memory[j, HANDOVER] = memory[j, HANDOVER] * left if dt > 0.0 else -wanted
        command[j] = limited(wanted + memory[j, HANDOVER], memory[j, LAST_COMMAND],
                             settings.torque_limits[j], settings.rate_limit * dt)
        memory[j, LAST_COMMAND] = command[j]
