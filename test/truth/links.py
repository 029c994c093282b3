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
from .nominal import GRAVITY

Array = NDArray[np.float64]
POSE = 8

# Forms of laws, by effect (`forms.py`); 0 is the one of README.md.
OWN_INERTIA, SHORT = 1, 2               # payload
COUPLING, MASS = 1, 2                   # link_inertia_error
PARTIAL, BALANCED = 1, 2                # inertial_coupling
SINKING, FLEXING = 1, 2                 # base_tilt
PROGRESSIVE, KINKED = 1, 2              # cable_spring
HALF_SINE, TRAPEZOID, IMPACT, SEVERAL = 1, 2, 3, 4      # external_contact
HARD_SPRING, OVERDAMPED = 1, 2          # base_vibration


def body(arm: NDArray[np.void], joints: NDArray[np.void]) -> Array:
    """Return A, B, C, E [kg*m^2] and the mass moments of both links [kg*m], payload included."""
    p1, p2, p3, first, second = bare(arm[0], joints)
    mass, own = float(arm[0]['payload_mass']), 0.0
    near, far = float(arm[0]['length_1']), float(arm[0]['length_2'])
    if arm[0]['payload_form'] == SHORT:
        near, far = (near, far * arm[0]['payload_first']) if far else (
            near * arm[0]['payload_first'], far)
    elif arm[0]['payload_form'] == OWN_INERTIA:
        own = mass * (arm[0]['payload_first'] * near) ** 2
    shoulder = p1 + (mass * far * far + mass * near * near) + own
    elbow = p2 + mass * far * far + (own if far else 0.0)
    mixed = p3 + mass * near * far
    apart = arm[0]['inertial_coupling_share'] + arm[0]['apart']
    if arm[0]['inertial_coupling_form'] == PARTIAL:
        apart *= arm[0]['inertial_coupling_first']
    elif arm[0]['inertial_coupling_form'] == BALANCED:
        apart, mixed = 0.0, 0.0
    return np.array([shoulder - elbow + 2.0 * apart * elbow, elbow, (1.0 - apart) * mixed,
                     -apart * elbow, first + mass * near, second + mass * far])


def bare(arm: np.void, joints: NDArray[np.void]) -> tuple[float, float, float, float, float]:
    """Return p1, p2, p3 [kg*m^2] and the mass moments [kg*m] without payload."""
    error, form = joints['link_inertia_error_relative_error'], joints['link_inertia_error_form']
    p1 = arm['p1'] * (1.0 + error[0]) + arm['p2'] * error[1]
    p2, p3 = arm['p2'] * (1.0 + error[1]), arm['p3']
    first, second = arm['moment_1'], arm['moment_2']
    if form[0] == MASS:
        first = first * (1.0 + error[0])
    if form[1] == MASS and second > 0.0:        # its middle is halfway: m2 = 2 moment / length
        p1 = p1 + error[1] * second * 2.0 / arm['length_2'] * arm['length_1'] ** 2
        p3, first = p3 * (1.0 + error[1]), first + error[1] * second * (
            2.0 * arm['length_1'] / arm['length_2'])
        second = second * (1.0 + error[1])
    if form[1] == COUPLING:
        p1, p2, p3 = arm['p1'] * (1.0 + error[0]), arm['p2'], p3 * (1.0 + error[1])
    return p1, p2, p3, first, second


@numba.njit(cache=True, error_model='numpy')
def write_pose(arm: Record, body: Array, a1: float, a2: float, force: tuple[float, float],
               pose: Array, time: float = 0.0) -> None:
    """Write what follows from the link angles: coupling, base coupling and outer torques."""
    fx, fy = force
    pose[0] = body[2] * math.cos(a2 - a1) + body[3]
    pose[1] = body[2] * math.sin(a2 - a1)
    pose[2:] = 0.0
    if arm.base_vibration_amplitude > 0.0:
        along = arm.base_vibration_direction
        pose[2] = -body[4] * math.sin(a1 - along)
        pose[3] = -body[5] * math.sin(a2 - along)
        pose[4] = body[4] * math.cos(a1 - along)
        pose[5] = body[5] * math.cos(a2 - along)
    for pull, down in ((arm.pull, arm.downhill),
                       (tilted(arm, body, a1, time), arm.base_tilt_direction)):
        if pull != 0.0:
            pose[6] -= pull * body[4] * math.sin(a1 - down)
            pose[7] -= pull * body[5] * math.sin(a2 - down)
    pose[6] += leverage(arm.length_1, a1, fx, fy)
    pose[7] += leverage(arm.length_2, a2, fx, fy)


@numba.njit(cache=True, error_model='numpy')
def tilted(arm: Record, body: Array, a1: float, time: float) -> float:
    """Return what a base that is not level pulls downhill [m/s^2]."""
    tilt = arm.base_tilt_tilt
    if tilt == 0.0:
        return 0.0
    if arm.base_tilt_form == SINKING:
        tilt *= 1.0 + arm.base_tilt_first * (time / 30.0 - 1.0)
    elif arm.base_tilt_form == FLEXING:
        tilt *= 1.0 + arm.base_tilt_first * math.cos(a1 - arm.base_tilt_direction)
    return GRAVITY * math.sin(tilt)


@numba.njit(cache=True, error_model='numpy')
def leverage(length: float, angle: float, fx: float, fy: float) -> float:
    """Return the torque of a force at the end of a link about its beginning [N*m]."""
    if fx == 0.0 and fy == 0.0:
        return 0.0
    return length * (fy * math.cos(angle) - fx * math.sin(angle))


@numba.njit(cache=True, error_model='numpy')
def accelerate(arm: Record, body: Array, pose: Array, torques: tuple[float, float], x: float,
               rate: Array, out: Array) -> None:
    """Write the accelerations of both links and the base under the torques of both joints."""
    t1, t2 = torques
    mobility = arm.base_vibration_amplitude
    swing = 2.0 * math.pi * arm.base_vibration_frequency
    pull, damping, back = 0.0, arm.base_vibration_damping, swing * x
    if arm.base_vibration_form == OVERDAMPED:
        damping = arm.base_vibration_first
    elif arm.base_vibration_form == HARD_SPRING:
        back *= 1.0 + (x / arm.base_vibration_first) ** 2
    if mobility > 0.0:
        pull = (mobility * (pose[4] * rate[2] * rate[2] + pose[5] * rate[3] * rate[3])
                - swing * (back + 2.0 * damping * rate[4]))
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
    if arm.external_contact_force == 0.0:
        return 0.0, 0.0
    since, form = time - arm.external_contact_onset, arm.external_contact_form
    if form == SEVERAL and since > 0.0:
        since -= min(math.floor(since / arm.external_contact_first),
                     arm.external_contact_second - 1.0) * arm.external_contact_first
    share = pushed(form, since, arm.external_contact_duration)
    if share == 0.0:
        return 0.0, 0.0
    push, along = arm.external_contact_force * share, arm.external_contact_direction
    return push * math.cos(along), push * math.sin(along)


@numba.njit(cache=True, error_model='numpy')
def pushed(form: float, since: float, duration: float) -> float:
    """Return the share of the largest force at a time since a contact began."""
    left = duration - since
    if since <= 0.0 or left <= 0.0:
        return 0.0
    if form in (HALF_SINE, SEVERAL):
        return math.sin(math.pi * since / duration)
    if form == TRAPEZOID:
        return min(min(since, left) / (0.25 * duration), 1.0)
    if form == IMPACT:      # a knock that rings down at some 12 Hz
        return min(since / 0.01, 1.0) * math.exp(-6.0 * since / duration) * math.cos(75.0 * since)
    edge = min(min(since, left) / (0.15 * duration), 1.0)
    return 0.5 - 0.5 * math.cos(math.pi * edge)


@numba.njit(cache=True, error_model='numpy')
def link_torque(joint: Record, q: float, time: float) -> float:
    """Return what pulls at one joint besides gear and dynamics [N*m]."""
    away, pull = q - joint.cable_spring_rest_angle, joint.cable_spring_stiffness
    if joint.cable_spring_form == PROGRESSIVE:
        pull *= 1.0 + joint.cable_spring_first * away * away
    elif joint.cable_spring_form == KINKED and away < 0.0:
        pull *= joint.cable_spring_first
    torque = -pull * away
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
