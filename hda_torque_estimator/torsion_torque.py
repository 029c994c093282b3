"""
Estimate the joint torque from the torsion, one joint and one sample (docs/model.md#estimator).

This is the paper's estimator with its equations made consistent: both encoders, minus kinematic
torsion, through the inverse of the torsion law. Hysteresis and damping come on top.
"""

from hda_arm_sim.model.compiled import compiled
from hda_arm_sim.model.effects.place import Sampled
from hda_arm_sim.model.effects.timing import sampled_late
from hda_arm_sim.model.effects.transmission import slid, SLIDERS
from hda_arm_sim.model.encoders import (link_angle_behind, link_gain, motor_angle_behind,
                                        motor_gain)
from hda_arm_sim.model.kernel import gear_torque, played_torsion, transmission
from hda_arm_sim.model.torsion import stiffness_at, torque_of_torsion
import numpy as np


@compiled
def shaft(joint, reading, rate):                                    # type: ignore[no-untyped-def]
    """Return angle and velocity of the shaft at the stamp, from what its encoder shows."""
    angle = motor_angle_behind(joint, reading - joint.motor_encoder.zero)
    velocity = rate / motor_gain(joint, angle)
    at = Sampled(angle, velocity, 0.0)
    return sampled_late(-joint.motor_encoder.sampling_time, at), velocity


@compiled
def link(joint, tilt_moment, reading, rate):                        # type: ignore[no-untyped-def]
    """Return angle and velocity of the link at the stamp, from what its encoder shows."""
    angle = link_angle_behind(joint, reading - joint.link_encoder.zero, tilt_moment)
    velocity = rate / link_gain(joint, angle)
    late = joint.motor_encoder.sampling_time + joint.clock_skew.skew
    return sampled_late(-late, Sampled(angle, velocity, 0.0)), velocity


@compiled
def torsions(                                                       # type: ignore[no-untyped-def]
        joint, motor_angle, motor_velocity, link_angle, link_velocity):
    """Return total torsion, kinematic -e(theta_m) [rad] and elastic rate, (eq:elastic-part)."""
    error, ratio = transmission(joint, motor_angle)
    return (motor_angle / joint.ratio - link_angle, -error,
            ratio * motor_velocity - link_velocity)


@compiled
def slide(joint, change, stretch):                                  # type: ignore[no-untyped-def]
    """
    Let the elements of the hysteresis (SLIDERS,) follow a change of the torsion, (eq:loop-state).

    Returns the hysteresis z in [-1, 1].
    """
    own, total = joint.torsional_hysteresis, 0.0
    for place in range(SLIDERS):
        stretch[place] = slid(own, stretch[place], change, place)
        total += stretch[place]
    return total / (SLIDERS * own.width)


@compiled
def torque_through_gear(joint, torsion, torsion_rate, state):       # type: ignore[no-untyped-def]
    """Return the gear's torque of an elastic torsion, (eq:torque-law) [N*m at the output]."""
    spring = played_torsion(joint, torsion)
    torque = torque_of_torsion(joint.torsion, joint.ratio, spring)
    return gear_torque(joint, torque, torsion, torsion_rate, state)


@compiled
def torsion_deviation(joint):                                       # type: ignore[no-untyped-def]
    """Return what counts and noise of both encoders make of a torsion, one sigma [rad]."""
    motor = (joint.coarse_quantisation.motor_step ** 2 / 12.0 + joint.motor_encoder.noise ** 2)
    link = (joint.coarse_quantisation.link_step ** 2 / 12.0 + joint.link_encoder.noise ** 2)
    return np.sqrt(motor / joint.ratio ** 2 + link)


@compiled
def reading_deviation(joint, torque, rate_gain):                    # type: ignore[no-untyped-def]
    """
    Return stiffness at a torque [N*m/rad] and deviation by readings [N*m], (eq:sigma-reading).

    It holds quantisation and noise of both encoders, which differ from sample to sample, in the
    torsion and by `rate_gain` [1/s] in its rate.
    """
    stiffness = stiffness_at(joint.torsion, joint.ratio, torque)
    noise = stiffness + joint.structural_damping.coefficient * rate_gain
    return stiffness, noise * torsion_deviation(joint)
