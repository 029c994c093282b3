"""
What acts on the shaft of one joint: every effect of the motor at its place, by its law.

See docs/model.md, 15-18.
"""

from .compiled import inlined
from .effects.actuation import biased_torque, cogging_torque, ripple_torque, scaled_torque
from .effects.friction import (asymmetric_budget, dry_budget, load_budget, nonlinear_drag,
                               position_budget, stribeck_budget, viscous_drag, warming_drag)


@inlined
def shaft_torque(joint, current):                                   # type: ignore[no-untyped-def]
    """Return the torque at the shaft of what the current loop delivers [N*m motor]."""
    return biased_torque(scaled_torque(current, joint.torque_constant_error.error),
                         joint.drive_offset.offset)


@inlined
def ripple(joint, motor_angle):                                     # type: ignore[no-untyped-def]
    """Return the torques that vary along the turn of the motor [N*m motor]."""
    wave, teeth, torque = joint.torque_ripple, joint.motor_cogging, 0.0
    if wave.amplitude_2 != 0.0 or wave.amplitude_4 != 0.0:
        torque += ripple_torque(motor_angle, wave.amplitude_2, wave.phase_2, wave.amplitude_4,
                                wave.phase_4)
    if teeth.amplitude != 0.0:
        torque += cogging_torque(motor_angle, teeth.amplitude, teeth.order, teeth.phase)
    return torque


@inlined
def drag(joint, motor_velocity, time):                              # type: ignore[no-untyped-def]
    """Return the torque of viscous friction, against the motion [N*m motor]."""
    bent, cold = joint.nonlinear_viscous_friction, joint.thermal_viscosity
    torque = viscous_drag(motor_velocity, joint.viscous_friction.slope)
    if bent.coefficient != 0.0:
        torque += nonlinear_drag(motor_velocity, bent.coefficient, bent.exponent)
    if cold.amplitude != 0.0:
        torque += warming_drag(motor_velocity, time, cold.amplitude, cold.time_constant)
    return torque


@inlined
def friction_budget(                                                # type: ignore[no-untyped-def]
        joint, motor_velocity, sense, joint_torque, link_angle):
    """
    Return the most torque that dry friction can oppose, (18) [N*m motor].

    `sense` is the sign of sliding, or of the torque that would start it.
    """
    excess, place = joint.stribeck_friction.excess, joint.position_dependent_friction
    budget = dry_budget(joint.coulomb_friction.level)
    if place.amplitude != 0.0:
        budget += position_budget(budget, link_angle, place.amplitude, place.order, place.phase)
    if joint.asymmetric_friction.asymmetry != 0.0:
        budget += asymmetric_budget(budget, sense, joint.asymmetric_friction.asymmetry)
    if excess != 0.0:
        budget += stribeck_budget(motor_velocity, excess, joint.stribeck_friction.speed)
    if joint.load_dependent_friction.coefficient != 0.0:
        budget += load_budget(joint_torque, joint.ratio, joint.load_dependent_friction.coefficient)
    return budget
