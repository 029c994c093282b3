"""
Two links on a base that may give way, in absolute angles a1, a2 of the links.

    [A, C cos(a2 - a1) + E, b1]   [a1'']   [Q1 + C sin(a2 - a1) a2'^2]
    [.,                 B,  b2] * [a2''] = [Q2 - C sin(a2 - a1) a1'^2]
    [.,                 ., 1/u]   [x'' ]   [-b1' a1' - b2' a2' - (w^2 x + 2 z w x') / u]

A, B and C are the moments of inertia about joint and elbow and their coupling; E is not zero
for decoupled axes only; b weighs the mass moments by the direction in which the base gives way,
and u is its mobility.
"""

import math

import numba
import numpy as np
from numpy.typing import NDArray

from .layout import Record
from .nominal import GRAVITY, LENGTH

Array = NDArray[np.float64]
POSE = 8


def body(arm: NDArray[np.void], joints: NDArray[np.void]) -> Array:
    """Return A, B, C, E [kg*m^2] and the mass moments of both links [kg*m], payload included."""
    error = joints['link_inertia_error_relative_error']
    load = float(arm[0]['payload_mass']) * LENGTH
    shoulder = arm[0]['p1'] * (1.0 + error[0]) + arm[0]['p2'] * error[1] + 2.0 * load * LENGTH
    elbow = arm[0]['p2'] * (1.0 + error[1]) + load * LENGTH
    mixed = arm[0]['p3'] + load * LENGTH
    apart = arm[0]['inertial_coupling_share']
    return np.array([shoulder - elbow + 2.0 * apart * elbow, elbow, (1.0 - apart) * mixed,
                     -apart * elbow, arm[0]['moment_1'] + load, arm[0]['moment_2'] + load])


@numba.njit(cache=True, error_model='numpy')
def write_pose(arm: Record, body: Array, a1: float, a2: float, fx: float, fy: float,
               pose: Array) -> None:
    """Write what follows from the link angles: coupling, base coupling and outer torques."""
    pose[0] = body[2] * math.cos(a2 - a1) + body[3]
    pose[1] = body[2] * math.sin(a2 - a1)
    pose[2:] = 0.0
    if arm.base_vibration_amplitude > 0.0:
        along = arm.base_vibration_direction
        pose[2] = -body[4] * math.sin(a1 - along)
        pose[3] = -body[5] * math.sin(a2 - along)
        pose[4] = body[4] * math.cos(a1 - along)
        pose[5] = body[5] * math.cos(a2 - along)
    if arm.base_tilt_tilt != 0.0:
        pull = GRAVITY * math.sin(arm.base_tilt_tilt)
        pose[6] = -pull * body[4] * math.sin(a1 - arm.base_tilt_direction)
        pose[7] = -pull * body[5] * math.sin(a2 - arm.base_tilt_direction)
    pose[6] += leverage(a1, fx, fy)
    pose[7] += leverage(a2, fx, fy)


@numba.njit(cache=True, error_model='numpy')
def leverage(angle: float, fx: float, fy: float) -> float:
    """Return the torque of a force at the end of a link about its beginning [N*m]."""
    if fx == 0.0 and fy == 0.0:
        return 0.0
    return LENGTH * (fy * math.cos(angle) - fx * math.sin(angle))


@numba.njit(cache=True, error_model='numpy')
def accelerate(arm: Record, body: Array, pose: Array, t1: float, t2: float, x: float, rate: Array,
               out: Array) -> None:
    """Write the accelerations of both links and the base under the joint torques t1, t2."""
    mobility = arm.base_vibration_amplitude
    swing = 2.0 * math.pi * arm.base_vibration_frequency
    pull = 0.0
    if mobility > 0.0:
        pull = (mobility * (pose[4] * rate[2] * rate[2] + pose[5] * rate[3] * rate[3])
                - swing * (swing * x + 2.0 * arm.base_vibration_damping * rate[4]))
    q1 = t1 - t2 + pose[6] + pose[1] * rate[3] * rate[3] - pose[2] * pull
    q2 = t2 + pose[7] - pose[1] * rate[2] * rate[2] - pose[3] * pull
    m11 = body[0] - mobility * pose[2] * pose[2]
    m12 = pose[0] - mobility * pose[2] * pose[3]
    m22 = body[1] - mobility * pose[3] * pose[3]
    determinant = m11 * m22 - m12 * m12
    out[2] = (m22 * q1 - m12 * q2) / determinant
    out[3] = (m11 * q2 - m12 * q1) / determinant
    out[4] = pull - mobility * (pose[2] * out[2] + pose[3] * out[3])


@numba.njit(cache=True, error_model='numpy')
def contact(arm: Record, time: float) -> tuple[float, float]:
    """Return the force of the hidden contact on the tip [N]: on and off along raised cosines."""
    since = time - arm.external_contact_onset
    left = arm.external_contact_duration - since
    if arm.external_contact_force == 0.0 or since <= 0.0 or left <= 0.0:
        return 0.0, 0.0
    edge = min(min(since, left) / (0.15 * arm.external_contact_duration), 1.0)
    push = arm.external_contact_force * (0.5 - 0.5 * math.cos(math.pi * edge))
    along = arm.external_contact_direction
    return push * math.cos(along), push * math.sin(along)


@numba.njit(cache=True, error_model='numpy')
def link_torque(joint: Record, q: float, time: float) -> float:
    """Return what pulls at one joint besides gear and dynamics [N*m]."""
    torque = -joint.cable_spring_stiffness * (q - joint.cable_spring_rest_angle)
    if joint.cubic_spring_coefficient != 0.0:
        torque -= joint.cubic_spring_coefficient * (q - joint.cubic_spring_centre) ** 3
    if joint.tooth_torque_amplitude != 0.0:
        torque += joint.tooth_torque_amplitude * math.sin(
            joint.tooth_torque_order * q + joint.tooth_torque_phase)
    if joint.link_torque_line_amplitude != 0.0:
        torque += joint.link_torque_line_amplitude * math.sin(
            2.0 * math.pi * joint.link_torque_line_frequency * time
            + joint.link_torque_line_phase)
    return torque
