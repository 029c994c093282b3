"""
Friction at the motor shaft (docs/model.md, 11-13).

Dry friction is a budget: the most torque that it can oppose. Who applies it resolves sign and
sticking. Drag is a torque along the velocity.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from .effect import Effect, Site
from ..compiled import compiled
from ..parameter import parameter


@compiled
def dry_budget(level):                                              # type: ignore[no-untyped-def]
    """Return the Coulomb budget, (11) [N*m motor]."""
    return level


@compiled
def viscous_drag(motor_velocity, slope):                            # type: ignore[no-untyped-def]
    """Return the viscous torque that opposes the motor, (12) [N*m motor]."""
    return slope * motor_velocity


@compiled
def stribeck_budget(motor_velocity, excess, speed):                 # type: ignore[no-untyped-def]
    """Return the extra budget near standstill, (13) [N*m motor]."""
    return excess * np.exp(-(motor_velocity / speed) ** 2)


@dataclass(frozen=True)
class CoulombFriction(Effect):
    """Dry friction of motor, wave generator and seals: a constant budget, (11)."""

    name: ClassVar[str] = 'coulomb_friction'
    cause: ClassVar[str] = 'dry friction level of motor and wave generator differs'
    site: ClassVar[Site] = Site.MOTOR
    law = staticmethod(dry_budget)
    level: float = parameter(0.0, 'N*m', 0.0, 5.0, 'dry friction level, motor side')


@dataclass(frozen=True)
class ViscousFriction(Effect):
    """Drag proportional to speed: grease, iron losses, back EMF, (12)."""

    name: ClassVar[str] = 'viscous_friction'
    cause: ClassVar[str] = 'viscous friction of motor and grease differs'
    site: ClassVar[Site] = Site.MOTOR
    law = staticmethod(viscous_drag)
    slope: float = parameter(0.0, 'N*m*s/rad', 0.0, 1.0, 'viscous friction, motor side')


@dataclass(frozen=True)
class StribeckFriction(Effect):
    """Breakaway excess that dies away with speed: excess * exp(-(v / speed)^2), (13)."""

    name: ClassVar[str] = 'stribeck_friction'
    cause: ClassVar[str] = 'breakaway friction at low speed (boundary lubrication)'
    site: ClassVar[Site] = Site.MOTOR
    law = staticmethod(stribeck_budget)
    excess: float = parameter(0.0, 'N*m', 0.0, 5.0, 'breakaway excess over the sliding level')
    speed: float = parameter(5.0, 'rad/s', 0.1, 50.0, 'Stribeck speed, motor side')
