"""Effects between motor and link: what the torsion is not (docs/model.md, 62-70)."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from .effect import Effect, Site
from ..compiled import compiled
from ..parameter import parameter

SLIDERS = 4             # friction elements of a hysteresis


@compiled
def transmission_error(                                           # type: ignore[no-untyped-def]
        motor_angle, amplitude_1, phase_1, amplitude_2, phase_2, amplitude_4, phase_4,
        order_a, amplitude_a, phase_a, order_b, amplitude_b, phase_b,
        order_c, amplitude_c, phase_c, order_d, amplitude_d, phase_d):
    """Return e(theta_m), (69) [rad at the output]."""
    error = (amplitude_1 * np.sin(motor_angle + phase_1)
             + amplitude_2 * np.sin(2.0 * motor_angle + phase_2)
             + amplitude_4 * np.sin(4.0 * motor_angle + phase_4))
    if amplitude_a != 0.0:
        error = error + amplitude_a * np.sin(order_a * motor_angle + phase_a)
    if amplitude_b != 0.0:
        error = error + amplitude_b * np.sin(order_b * motor_angle + phase_b)
    if amplitude_c != 0.0:
        error = error + amplitude_c * np.sin(order_c * motor_angle + phase_c)
    if amplitude_d != 0.0:
        error = error + amplitude_d * np.sin(order_d * motor_angle + phase_d)
    return error


@compiled
def transmission_slope(                                           # type: ignore[no-untyped-def]
        motor_angle, amplitude_1, phase_1, amplitude_2, phase_2, amplitude_4, phase_4,
        order_a, amplitude_a, phase_a, order_b, amplitude_b, phase_b,
        order_c, amplitude_c, phase_c, order_d, amplitude_d, phase_d):
    """Return e'(theta_m), (70): how the error changes the gear ratio [rad/rad]."""
    turn = 0.5 * np.pi                  # a quarter of a wave: cosines in the place of sines
    return transmission_error(
        motor_angle, amplitude_1, phase_1 + turn, 2.0 * amplitude_2, phase_2 + turn,
        4.0 * amplitude_4, phase_4 + turn, order_a, order_a * amplitude_a, phase_a + turn,
        order_b, order_b * amplitude_b, phase_b + turn, order_c, order_c * amplitude_c,
        phase_c + turn, order_d, order_d * amplitude_d, phase_d + turn)


@compiled
def played_torsion(torsion, half_width):                            # type: ignore[no-untyped-def]
    """Return the torsion left to the spring after the play, (68) [rad]."""
    return torsion - np.minimum(np.maximum(torsion, -half_width), half_width)


@compiled
def played_rate(torsion, torsion_rate, half_width):                 # type: ignore[no-untyped-def]
    """Return the rate of what is left to the spring, none within the play, (68) [rad/s]."""
    return torsion_rate * (np.abs(torsion) >= half_width)


@compiled
def slid(stretch, change, width, place):                            # type: ignore[no-untyped-def]
    """Return the stretch of one friction element after the torsion changed, (65) [rad]."""
    reach = width * (2.0 * place + 1.0) / SLIDERS
    return np.minimum(np.maximum(stretch + change, -reach), reach)


@compiled
def hysteresis_torque(state, level):                                # type: ignore[no-untyped-def]
    """Return the torque of the hysteresis, (66) [N*m at the output]."""
    return level * state


@compiled
def damping_torque(torsion_rate, coefficient):                      # type: ignore[no-untyped-def]
    """Return the torque of the torsion's damping, (67) [N*m at the output]."""
    return coefficient * torsion_rate


@compiled
def stiffer(nominal, error):                                        # type: ignore[no-untyped-def]
    """Return the stiffness of the flexspline at zero torque, (62) [N*m/rad at the output]."""
    return nominal * (1.0 + error)


@compiled
def bent(                                                           # type: ignore[no-untyped-def]
        nominal, error, knee_1, second_stiffness, knee_2, third_stiffness):
    """Return curvature, knees and stiffnesses of the flexspline's law in force, (63)."""
    return nominal * (1.0 + error), knee_1, second_stiffness, knee_2, third_stiffness


@compiled
def softer(nominal, compliance):                                    # type: ignore[no-untyped-def]
    """Return the compliance of the wave generator at zero torque, (64) [rad/(N*m) motor side]."""
    return np.maximum(nominal + compliance, 0.0)


@dataclass(frozen=True)
class KinematicError(Effect):
    """
    Transmission error at wave-generator orders; it bends the torsion and the ratio, (69-70).

    Four more waves have orders of their own, whole ones and others: that of the teeth is
    2 (N + 1) / N per motor turn, one per turn of the link is 1 / N.
    """

    name: ClassVar[str] = 'kinematic_error'
    cause: ClassVar[str] = 'transmission error of the gear at wave-generator orders'
    site: ClassVar[Site] = Site.TORSION
    law = staticmethod(transmission_error)
    slope = staticmethod(transmission_slope)
    amplitude_1: float = parameter(0.0, 'rad', 0.0, 0.05, 'once per motor turn, output side')
    phase_1: float = parameter(0.0, 'rad', -7.0, 7.0, 'its phase')
    amplitude_2: float = parameter(0.0, 'rad', 0.0, 0.05, 'twice per motor turn, output side')
    phase_2: float = parameter(0.0, 'rad', -7.0, 7.0, 'its phase')
    amplitude_4: float = parameter(0.0, 'rad', 0.0, 0.05, 'four per motor turn, output side')
    phase_4: float = parameter(0.0, 'rad', -7.0, 7.0, 'its phase')
    order_a: float = parameter(3.0, '1/turn', 0.0, 100.0, 'of one more wave, per motor turn')
    amplitude_a: float = parameter(0.0, 'rad', 0.0, 0.05, 'of that wave, output side')
    phase_a: float = parameter(0.0, 'rad', -7.0, 7.0, 'its phase')
    order_b: float = parameter(6.0, '1/turn', 0.0, 100.0, 'of another wave, per motor turn')
    amplitude_b: float = parameter(0.0, 'rad', 0.0, 0.05, 'of that wave, output side')
    phase_b: float = parameter(0.0, 'rad', -7.0, 7.0, 'its phase')
    order_c: float = parameter(8.0, '1/turn', 0.0, 100.0, 'of another wave, per motor turn')
    amplitude_c: float = parameter(0.0, 'rad', 0.0, 0.05, 'of that wave, output side')
    phase_c: float = parameter(0.0, 'rad', -7.0, 7.0, 'its phase')
    order_d: float = parameter(2.02, '1/turn', 0.0, 100.0, 'of another wave, per motor turn')
    amplitude_d: float = parameter(0.0, 'rad', 0.0, 0.05, 'of that wave, output side')
    phase_d: float = parameter(0.0, 'rad', -7.0, 7.0, 'its phase')


@dataclass(frozen=True)
class Backlash(Effect):
    """Play at the output flange: a dead zone of the torsion, (68)."""

    name: ClassVar[str] = 'backlash'
    cause: ClassVar[str] = 'play between gear and load at the output flange'
    site: ClassVar[Site] = Site.TORSION
    law = staticmethod(played_torsion)
    half_width: float = parameter(0.0, 'rad', 0.0, 0.01, 'half of the play, output side')


@dataclass(frozen=True)
class TorsionalHysteresis(Effect):
    """Rate-independent loop of torque over torsion (Maxwell slip), (65-66)."""

    name: ClassVar[str] = 'torsional_hysteresis'
    cause: ClassVar[str] = 'rate-independent hysteresis of the flexspline'
    site: ClassVar[Site] = Site.TORSION
    law = staticmethod(hysteresis_torque)
    slide = staticmethod(slid)
    level: float = parameter(0.0, 'N*m', 0.0, 50.0, 'saturated torque of the loop, output side')
    width: float = parameter(
        1e-4, 'rad', 1e-6, 0.01, 'torsion at which half of the friction elements slide')


@dataclass(frozen=True)
class StructuralDamping(Effect):
    """Damping of the torsion, proportional to its rate, (67)."""

    name: ClassVar[str] = 'structural_damping'
    cause: ClassVar[str] = 'damping of the torsion differs'
    site: ClassVar[Site] = Site.TORSION
    law = staticmethod(damping_torque)
    coefficient: float = parameter(0.0, 'N*m*s/rad', 0.0, 1e4, 'D, output side')


@dataclass(frozen=True)
class StiffnessError(Effect):
    """Flexspline that is stiffer or softer than stated, at every torque alike, (62)."""

    name: ClassVar[str] = 'stiffness_error'
    cause: ClassVar[str] = 'the flexspline is stiffer or softer than stated'
    site: ClassVar[Site] = Site.TORSION
    law = staticmethod(stiffer)
    error: float = parameter(0.0, '', -0.9, 5.0, 'relative error of the flexspline stiffness')


@dataclass(frozen=True)
class StiffeningError(Effect):
    """Flexspline that stiffens otherwise: another curvature, or three straight segments, (63)."""

    name: ClassVar[str] = 'stiffening_error'
    cause: ClassVar[str] = 'the flexspline stiffens with torque otherwise than stated'
    site: ClassVar[Site] = Site.TORSION
    law = staticmethod(bent)
    error: float = parameter(0.0, '', -1.0, 10.0, 'relative error of c_f; -1 is a linear law')
    knee_1: float = parameter(
        0.0, 'N*m', 0.0, 1e4, 'torque T1 of the first knee of three segments; 0 for none')
    second_stiffness: float = parameter(
        0.0, 'N*m/rad', 0.0, 1e7, 'K2, beyond T1; 0 for segments that meet on the curve of c_f')
    knee_2: float = parameter(0.0, 'N*m', 0.0, 1e4, 'torque T2 of the second knee')
    third_stiffness: float = parameter(0.0, 'N*m/rad', 0.0, 1e7, 'K3, beyond T2')


@dataclass(frozen=True)
class WaveGeneratorCompliance(Effect):
    """Soft wind-up near zero torque that is larger or smaller than stated, (64)."""

    name: ClassVar[str] = 'wave_generator_compliance'
    cause: ClassVar[str] = 'the soft wind-up of the wave generator near zero torque differs'
    site: ClassVar[Site] = Site.TORSION
    law = staticmethod(softer)
    compliance: float = parameter(
        0.0, 'rad/(N*m)', -1e3, 1e3, 'added to 1 / K_w0, motor side; -1 / K_w0 leaves none')
