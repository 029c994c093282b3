"""What the encoders show that is not so, and in which steps (docs/model.md, 71-77)."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from .effect import Effect, Site
from ..compiled import compiled
from ..parameter import parameter


@compiled
def quantised(angle, step):                                         # type: ignore[no-untyped-def]
    """Return the angle in whole steps, (75); a step of zero is a perfect encoder [rad]."""
    return np.floor(angle / step + 0.5) * step if step > 0.0 else angle + 0.0


@compiled
def quantised_sides(                                                # type: ignore[no-untyped-def]
        motor_angle, link_angle, motor_step, link_step):
    """Return both angles in whole steps, shaft and link, (75) [rad]."""
    return quantised(motor_angle, motor_step), quantised(link_angle, link_step)


@compiled
def link_runout(                                                    # type: ignore[no-untyped-def]
        angle, amplitude_1, phase_1, amplitude_2, phase_2):
    """Return what a link encoder off its axis adds to the angle, (71) [rad]."""
    return (amplitude_1 * np.sin(angle + phase_1)
            + amplitude_2 * np.sin(2.0 * angle + phase_2))


@compiled
def motor_runout(angle, amplitude, phase):                          # type: ignore[no-untyped-def]
    """Return what a motor encoder off its axis adds to the angle, (72) [rad]."""
    return amplitude * np.sin(angle + phase)


@compiled
def scale_excess(angle, error):                                     # type: ignore[no-untyped-def]
    """Return what a wrong scale adds to the angle, (73) [rad]."""
    return error * angle


@compiled
def interpolation_wave(angle, amplitude, lines, phase):             # type: ignore[no-untyped-def]
    """Return what the interpolation between two lines adds to the angle, (74) [rad]."""
    return amplitude * np.sin(lines * angle + phase)


@compiled
def tilting_moment(first, second, gravity, elbow):                  # type: ignore[no-untyped-def]
    """Return the moment of the weight that tilts the bearings of joints 1 and 2, (76) [N*m]."""
    return gravity * (first + second * np.cos(elbow)), gravity * second + 0.0 * elbow


@compiled
def tilted_torsion(tilt_moment, coefficient):                       # type: ignore[no-untyped-def]
    """Return the torsion that a tilting moment on the bearing feigns, (77) [rad]."""
    return coefficient * tilt_moment


@dataclass(frozen=True)
class CoarseQuantisation(Effect):
    """Encoder step of each side, (75); zero is a perfect encoder."""

    name: ClassVar[str] = 'coarse_quantisation'
    cause: ClassVar[str] = 'an encoder counts in larger steps than stated'
    site: ClassVar[Site] = Site.SENSING
    law = staticmethod(quantised_sides)
    motor_step: float = parameter(0.0, 'rad', 0.0, 0.1, 'step of the motor encoder, shaft')
    link_step: float = parameter(0.0, 'rad', 0.0, 0.1, 'step of the link encoder')


@dataclass(frozen=True)
class LinkEncoderEccentricity(Effect):
    """Disc of the link encoder off its axis (order 1) or out of round (order 2), (71)."""

    name: ClassVar[str] = 'link_encoder_eccentricity'
    cause: ClassVar[str] = 'the disc of the link encoder sits off its axis or out of round'
    site: ClassVar[Site] = Site.TORSION
    law = staticmethod(link_runout)
    amplitude_1: float = parameter(0.0, 'rad', 0.0, 0.05, 'once per link turn')
    phase_1: float = parameter(0.0, 'rad', -7.0, 7.0, 'its phase')
    amplitude_2: float = parameter(0.0, 'rad', 0.0, 0.05, 'twice per link turn')
    phase_2: float = parameter(0.0, 'rad', -7.0, 7.0, 'its phase')


@dataclass(frozen=True)
class MotorEncoderEccentricity(Effect):
    """Disc of the motor encoder off its axis, (72)."""

    name: ClassVar[str] = 'motor_encoder_eccentricity'
    cause: ClassVar[str] = 'the disc of the motor encoder sits off its axis'
    site: ClassVar[Site] = Site.TORSION
    law = staticmethod(motor_runout)
    amplitude: float = parameter(0.0, 'rad', 0.0, 0.2, 'once per motor turn, at the shaft')
    phase: float = parameter(0.0, 'rad', -7.0, 7.0, 'its phase')


@dataclass(frozen=True)
class EncoderScaleError(Effect):
    """Link angle in a wrong scale: wrong counts, a scale that grew, another gear ratio, (73)."""

    name: ClassVar[str] = 'encoder_scale_error'
    cause: ClassVar[str] = 'encoder counts and gear ratio do not fit: torsion grows with the angle'
    site: ClassVar[Site] = Site.TORSION
    law = staticmethod(scale_excess)
    error: float = parameter(0.0, '', -0.2, 0.2, 'relative excess of the link encoder')


@dataclass(frozen=True)
class EncoderInterpolationError(Effect):
    """Error of the link encoder that repeats with every line of its scale, (74)."""

    name: ClassVar[str] = 'encoder_interpolation_error'
    cause: ClassVar[str] = 'the link encoder interpolates its lines unevenly'
    site: ClassVar[Site] = Site.SENSING
    law = staticmethod(interpolation_wave)
    amplitude: float = parameter(0.0, 'rad', 0.0, 1e-3, 'error of the link angle')
    lines: float = parameter(20000.0, '1/turn', 2.0, 1e6, 'lines of the link encoder per turn')
    phase: float = parameter(0.0, 'rad', -7.0, 7.0, 'its phase')


@dataclass(frozen=True)
class BearingCrosstalk(Effect):
    """Tilt of the link bearing under the weight of the links, read as torsion, (76-77)."""

    name: ClassVar[str] = 'bearing_crosstalk'
    cause: ClassVar[str] = 'tilting of the bearing under the weight is read as torsion'
    site: ClassVar[Site] = Site.TORSION
    law = staticmethod(tilted_torsion)
    coefficient: float = parameter(
        0.0, 'rad/(N*m)', -1e-3, 1e-3, 'torsion shown per tilting moment')
