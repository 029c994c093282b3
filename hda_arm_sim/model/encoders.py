"""
What both encoders of a joint show of an angle, and which angle is behind what they show.

See docs/model.md, 21-24.
"""

import numpy as np

from .compiled import compiled, inlined
from .effects.sensing import (interpolation_wave, link_runout, motor_runout, scale_excess,
                              tilted_torsion, tilting_moment)

_ROUNDS = 40            # of the inverse; an error's slope below 0.1 needs 15
_SAME = 1e-15           # change of an angle that ends the inverse [rad]


@inlined
def motor_error(joint, angle):                                      # type: ignore[no-untyped-def]
    """Return what the motor encoder adds to the shaft's angle [rad]."""
    disc = joint.motor_encoder_eccentricity
    return 0.0 if disc.amplitude == 0.0 else motor_runout(angle, disc.amplitude, disc.phase)


@inlined
def link_error(joint, angle, tilt_moment):                          # type: ignore[no-untyped-def]
    """Return what the link encoder adds to the link's angle [rad]."""
    disc, wave, error = joint.link_encoder_eccentricity, joint.encoder_interpolation_error, 0.0
    if disc.amplitude_1 != 0.0 or disc.amplitude_2 != 0.0:
        error += link_runout(angle, disc.amplitude_1, disc.phase_1, disc.amplitude_2,
                             disc.phase_2)
    if joint.encoder_scale_error.error != 0.0:
        error += scale_excess(angle, joint.encoder_scale_error.error)
    if wave.amplitude != 0.0:
        error += interpolation_wave(angle, wave.amplitude, wave.lines, wave.phase)
    if joint.bearing_crosstalk.coefficient != 0.0:
        error -= tilted_torsion(tilt_moment, joint.bearing_crosstalk.coefficient)
    return error


@compiled
def motor_angle_behind(joint, shown):                               # type: ignore[no-untyped-def]
    """Return the shaft's angle that the motor encoder shows as `shown`, (24) [rad]."""
    angle = shown
    for _ in range(_ROUNDS):
        last, angle = angle, shown - motor_error(joint, angle)
        if abs(angle - last) <= _SAME * abs(angle):
            break
    return angle


@compiled
def link_angle_behind(joint, shown, tilt_moment):                   # type: ignore[no-untyped-def]
    """Return the link's angle that the link encoder shows as `shown`, (24) [rad]."""
    angle = shown
    for _ in range(_ROUNDS):
        last, angle = angle, shown - link_error(joint, angle, tilt_moment)
        if abs(angle - last) <= _SAME * abs(angle):
            break
    return angle


@inlined
def motor_gain(joint, angle):                                       # type: ignore[no-untyped-def]
    """Return how much faster the motor encoder turns than its shaft, at an angle."""
    disc = joint.motor_encoder_eccentricity
    if disc.amplitude == 0.0:
        return 1.0
    return 1.0 + motor_runout(angle, disc.amplitude, disc.phase + 0.5 * np.pi)


@inlined
def link_gain(joint, angle):                                        # type: ignore[no-untyped-def]
    """Return how much faster the link encoder turns than its link; fine waves average out."""
    disc = joint.link_encoder_eccentricity
    if disc.amplitude_1 == 0.0 and disc.amplitude_2 == 0.0:
        return 1.0 + joint.encoder_scale_error.error
    turn = 0.5 * np.pi
    return (1.0 + joint.encoder_scale_error.error
            + link_runout(angle, disc.amplitude_1, disc.phase_1 + turn,
                          2.0 * disc.amplitude_2, disc.phase_2 + turn))


@compiled
def tilt_moments(body, inertia, elbow):                             # type: ignore[no-untyped-def]
    """Return the tilting moments on the bearings of joints 1 and 2 [N*m]."""
    return tilting_moment(inertia.first, inertia.second, body.weight, elbow)
