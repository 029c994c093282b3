"""The harmonic drive: transmission error, play, torsion law and Maxwell-slip hysteresis."""

import math

import numba

from .layout import Record
from .nominal import RATIO
from .torsion import Array, look_up

SLIDERS = 10


@numba.njit(cache=True, error_model='numpy')
def transmission_error(joint: Record, motor: float) -> tuple[float, float]:
    """Return the error of the output angle at a motor angle [rad], and its slope."""
    error, slope = 0.0, 0.0
    for order, size, phase in (
            (2, joint.kinematic_error_amplitude_2, joint.kinematic_error_phase_2),
            (4, joint.kinematic_error_amplitude_4, joint.kinematic_error_phase_4),
            (3, joint.third_order_kinematic_error_amplitude,
             joint.third_order_kinematic_error_phase)):
        if size != 0.0:
            error += size * math.sin(order * motor + phase)
            slope += order * size * math.cos(order * motor + phase)
    return error, slope


@numba.njit(cache=True, error_model='numpy')
def seat(joint: Record, torsion: float) -> tuple[float, float]:
    """
    Return the torsion behind the play [rad], and the share of its rate that gets there.

    The flanks meet over a thirtieth of the play, not at a corner.
    """
    half = joint.backlash_half_width
    if half <= 0.0:
        return torsion, 1.0
    soft = half / 30.0
    out, back = torsion - half, -torsion - half
    behind = 0.5 * (out + math.sqrt(out * out + soft * soft)
                    - back - math.sqrt(back * back + soft * soft))
    share = 1.0 + 0.5 * (out / math.sqrt(out * out + soft * soft)
                         + back / math.sqrt(back * back + soft * soft))
    return behind, share


@numba.njit(cache=True, error_model='numpy')
def drag_sliders(joint: Record, torsion: float, was: float, sliders: Array) -> float:
    """Move the friction elements along with the torsion; return their torque [N*m]."""
    full = joint.torsional_hysteresis_level
    if full == 0.0:
        return 0.0
    width = joint.torsional_hysteresis_width
    stiffness = full / width / SLIDERS
    torque = 0.0
    for i in range(SLIDERS):
        yields = width * (2 * i + 1) / SLIDERS
        stretch = min(max(sliders[i] + torsion - was, -yields), yields)
        sliders[i] = stretch
        torque += stiffness * stretch
    return torque


@numba.njit(cache=True, error_model='numpy')
def elastic_torque(joint: Record, law: Array, behind: float, link: float) -> float:
    """Return the spring's torque at a torsion behind the play and a link angle [N*m]."""
    torque = look_up(law, behind)
    if joint.angle_dependent_stiffness_amplitude != 0.0:
        torque *= 1.0 + joint.angle_dependent_stiffness_amplitude * math.sin(
            joint.angle_dependent_stiffness_order * link + joint.angle_dependent_stiffness_phase)
    return torque


@numba.njit(cache=True, error_model='numpy')
def under_load(joint: Record, law: Array, behind: float, motor: float,
               link: float) -> tuple[float, float]:
    """
    Return the spring's torque with the error that it causes [N*m], and what its lever gains.

    The error follows the torque and the torque the error, until both stand still. Half of the
    error's slope is the lever's: the other half is what the spring stores.
    """
    torque = elastic_torque(joint, law, behind, link)
    size = joint.loaded_kinematic_error_amplitude
    if size == 0.0:
        return torque, 0.0
    angle = 2.0 * motor + joint.loaded_kinematic_error_phase
    for _ in range(200):
        before = torque
        torque = elastic_torque(joint, law, behind + size * abs(torque) * math.sin(angle), link)
        if abs(torque - before) < 1e-12:
            break
    return torque, size * abs(torque) * math.cos(angle)


@numba.njit(cache=True, error_model='numpy')
def hold(joint: Record, law: Array, motor: float, link: float, sliders: Array,
         held: Record) -> None:
    """Write what follows from the angles alone: spring torque, lever and damping."""
    error, slope = transmission_error(joint, motor)
    torsion, share = seat(joint, motor / RATIO + error - link)
    torque, gained = under_load(joint, law, torsion, motor, link)
    held.elastic = torque + drag_sliders(joint, torsion, held.torsion, sliders)
    held.torsion = torsion
    held.lever = 1.0 / RATIO + slope + gained
    held.damping = share * (joint.damping + joint.structural_damping_coefficient)
