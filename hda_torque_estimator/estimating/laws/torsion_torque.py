"""
Estimate the joint torque from the torsion, one joint and one sample (docs/model.md#estimator).

This is the paper's estimator with its equations made consistent: both encoders, minus kinematic
torsion, through the inverse of the torsion law. Hysteresis and damping come on top.
"""

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.compiled import compiled, Record
from hda_arm_sim.model.effect_loops import added
from hda_arm_sim.model.effects.catalogue import sole_at
from hda_arm_sim.model.effects.place import GEAR, LOOP, SLIDERS, Twisted
from hda_arm_sim.model.encoders import (counts_of, link_angle_behind, link_gain, link_lateness,
                                        motor_angle_behind, motor_gain, shown_after)
from hda_arm_sim.model.kernel import gear_torque, growth, loop_of, played_torsion, transmission
from hda_arm_sim.model.torsion import stiffer_torque, stiffness_at, torque_of_torsion
import numpy as np

_slid, _damping = sole_at(LOOP).law_after, added(GEAR, 'law_damping')


@compiled
def shaft(joint: Record, reading: float, rate: float) -> tuple[float, float]:
    """Return angle and velocity of the shaft at the stamp, from what its encoder shows."""
    angle = motor_angle_behind(joint, reading - joint.motor_encoder.zero)
    velocity = rate / motor_gain(joint, angle)
    return shown_after(-joint.motor_encoder.sampling_time, angle, velocity, 0.0), velocity


@compiled
def link(joint: Record, tilt_moment: float, reading: float, rate: float) -> tuple[float, float]:
    """Return angle and velocity of the link at the stamp, from what its encoder shows."""
    angle = link_angle_behind(joint, reading - joint.link_encoder.zero, tilt_moment)
    velocity = rate / link_gain(joint, angle)
    return shown_after(-link_lateness(joint), angle, velocity, 0.0), velocity


@compiled
def torsions(joint: Record, motor_angle: float, motor_velocity: float, link_angle: float,
             link_velocity: float) -> tuple[float, float, float]:
    """Return total torsion, kinematic -e(theta_m) [rad] and elastic rate, (eq:elastic-part)."""
    error, ratio = transmission(joint, motor_angle)
    return (motor_angle / joint.ratio - link_angle, -error,
            ratio * motor_velocity - link_velocity)


@compiled
def slide(joint: Record, change: float, stretch: Array) -> float:
    """
    Let the elements of the hysteresis (SLIDERS,) follow a change of the torsion, (eq:loop-state).

    Returns the hysteresis z in [-1, 1].
    """
    own, total = loop_of(joint), 0.0
    for place in range(SLIDERS):
        stretch[place] = _slid(own, stretch[place], change, place)
        total += stretch[place]
    return total / (SLIDERS * own.width)


@compiled
def torque_through_gear(joint: Record, motor_angle: float, torsion: float, torsion_rate: float,
                        state: float, factor: float = 1.0) -> float:
    """
    Return the gear's torque of an elastic torsion, (eq:torque-law) [N*m at the output].

    `factor` is by how much the flexspline is stiffer than its law says, (eq:stiffer).
    """
    spring, growing = played_torsion(joint, torsion), growth(joint, motor_angle)[0]
    torque = torque_of_torsion(joint.torsion, joint.ratio, spring, growing)
    torque = stiffer_torque(joint.torsion, joint.ratio, torque, factor, growing)
    return gear_torque(joint, torque, torsion, torsion_rate, state)


@compiled
def torsion_deviation(joint: Record) -> float:
    """Return what counts and noise of both encoders make of a torsion, one sigma [rad]."""
    motor = counts_of(joint).motor_step ** 2 / 12.0 + joint.motor_encoder.noise ** 2
    link = counts_of(joint).link_step ** 2 / 12.0 + joint.link_encoder.noise ** 2
    return np.sqrt(motor / joint.ratio ** 2 + link)


@compiled
def reading_deviation(joint: Record, torque: float, rate_gain: float,
                      scatter: float = 0.0) -> tuple[float, float]:
    """
    Return stiffness at a torque [N*m/rad] and deviation by readings [N*m], (eq:sigma-reading).

    It holds quantisation and noise of both encoders, which differ from sample to sample, in the
    torsion and by `rate_gain` [1/s] in its rate. Their variance is at least `scatter` [rad^2].
    """
    stiffness = stiffness_at(joint.torsion, joint.ratio, torque)
    noise = stiffness + _damping(joint, Twisted(0.0, 0.0, 0.0), 0.0) * rate_gain
    return stiffness, noise * max(torsion_deviation(joint), np.sqrt(scatter))


@compiled
def torque_aside(joint: Record, torsion: float, torsion_rate: float, state: float) -> float:
    """Return what hysteresis and damping carry parallel to the spring, (eq:gear-torque) [N*m]."""
    return gear_torque(joint, 0.0, torsion, torsion_rate, state)
