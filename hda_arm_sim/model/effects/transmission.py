"""Effects between motor and link: what the torsion is not (docs/model.md, 14-19)."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from .effect import Effect, Site
from ..compiled import compiled
from ..parameter import parameter


@compiled
def transmission_error(motor_angle, amplitude_1, phase_1, amplitude_2, phase_2,
                       amplitude_4, phase_4):                       # type: ignore[no-untyped-def]
    """Return e(theta_m), (14) [rad at the output]."""
    return (amplitude_1 * np.sin(motor_angle + phase_1)
            + amplitude_2 * np.sin(2.0 * motor_angle + phase_2)
            + amplitude_4 * np.sin(4.0 * motor_angle + phase_4))


@compiled
def transmission_slope(motor_angle, amplitude_1, phase_1, amplitude_2, phase_2,
                       amplitude_4, phase_4):                       # type: ignore[no-untyped-def]
    """Return e'(theta_m), (15): how the error changes the gear ratio [rad/rad]."""
    return (amplitude_1 * np.cos(motor_angle + phase_1)
            + 2.0 * amplitude_2 * np.cos(2.0 * motor_angle + phase_2)
            + 4.0 * amplitude_4 * np.cos(4.0 * motor_angle + phase_4))


@compiled
def played_torsion(torsion, half_width):                            # type: ignore[no-untyped-def]
    """Return the torsion left to the spring after the play, (16) [rad]."""
    return torsion - np.minimum(np.maximum(torsion, -half_width), half_width)


@compiled
def hysteresis_rate(torsion_rate, state, width):                    # type: ignore[no-untyped-def]
    """Return dz/dt of the Bouc-Wen state z in [-1, 1], (17) [1/s]."""
    along = 0.5 * (np.abs(torsion_rate) * state + torsion_rate * np.abs(state))
    return (torsion_rate - along) / width


@compiled
def hysteresis_torque(state, level):                                # type: ignore[no-untyped-def]
    """Return the torque of the hysteresis, (18) [N*m at the output]."""
    return level * state


@compiled
def damping_torque(torsion_rate, coefficient):                      # type: ignore[no-untyped-def]
    """Return the torque of the torsion's damping, (19) [N*m at the output]."""
    return coefficient * torsion_rate


@dataclass(frozen=True)
class KinematicError(Effect):
    """Transmission error at wave-generator orders; it bends the torsion and the ratio, (14-15)."""

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


@dataclass(frozen=True)
class Backlash(Effect):
    """Play at the output flange: a dead zone of the torsion, (16)."""

    name: ClassVar[str] = 'backlash'
    cause: ClassVar[str] = 'play between gear and load at the output flange'
    site: ClassVar[Site] = Site.TORSION
    law = staticmethod(played_torsion)
    half_width: float = parameter(0.0, 'rad', 0.0, 0.01, 'half of the play, output side')


@dataclass(frozen=True)
class TorsionalHysteresis(Effect):
    """Rate-independent loop of torque over torsion (Bouc-Wen), (17-18)."""

    name: ClassVar[str] = 'torsional_hysteresis'
    cause: ClassVar[str] = 'rate-independent hysteresis of the flexspline'
    site: ClassVar[Site] = Site.TORSION
    law = staticmethod(hysteresis_torque)
    rate = staticmethod(hysteresis_rate)
    level: float = parameter(0.0, 'N*m', 0.0, 50.0, 'saturated torque of the loop, output side')
    width: float = parameter(1e-4, 'rad', 1e-6, 0.01, 'torsion over which the loop closes')


@dataclass(frozen=True)
class StructuralDamping(Effect):
    """Damping of the torsion, proportional to its rate, (19)."""

    name: ClassVar[str] = 'structural_damping'
    cause: ClassVar[str] = 'damping of the torsion differs'
    site: ClassVar[Site] = Site.TORSION
    law = staticmethod(damping_torque)
    coefficient: float = parameter(0.0, 'N*m*s/rad', 0.0, 1e4, 'D, output side')
