"""
Friction at the motor shaft (docs/model.md, 44-53).

Dry friction is a budget: the most torque that it can oppose. Who applies it resolves sign and
sticking. Drag is a torque along the velocity.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from .effect import Effect, Site
from ..compiled import compiled
from ..parameter import parameter

FASTEST = 2000.0        # relaxation of the bristles [1/s]; they are at rest within a sample anyway


@compiled
def dry_budget(level):                                              # type: ignore[no-untyped-def]
    """Return the Coulomb budget, (44) [N*m motor]."""
    return level


@compiled
def viscous_drag(motor_velocity, slope):                            # type: ignore[no-untyped-def]
    """Return the viscous torque that opposes the motor, (45) [N*m motor]."""
    return slope * motor_velocity


@compiled
def nonlinear_drag(motor_velocity, coefficient, exponent):          # type: ignore[no-untyped-def]
    """Return the drag that grows with a power of the speed, (46) [N*m motor]."""
    return coefficient * np.sign(motor_velocity) * np.abs(motor_velocity) ** exponent


@compiled
def stribeck_budget(motor_velocity, excess, speed):                 # type: ignore[no-untyped-def]
    """Return the extra budget near standstill, (47) [N*m motor]."""
    return excess * np.exp(-(motor_velocity / speed) ** 2)


@compiled
def bristle_rate(motor_velocity, state, budget, stiffness):         # type: ignore[no-untyped-def]
    """Return dz/dt of bristles, whose deflection z settles at budget / stiffness, (48) [rad/s]."""
    end, pace = _settling(motor_velocity, budget, stiffness)
    return pace * (end - state)


@compiled
def bristle_after(motor_velocity, state, budget, stiffness, time):  # type: ignore[no-untyped-def]
    """Return the deflection after a time at one speed, the solution of (48) [rad]."""
    end, pace = _settling(motor_velocity, budget, stiffness)
    return end + (state - end) * np.exp(-pace * time)


@compiled
def _settling(motor_velocity, budget, stiffness):                   # type: ignore[no-untyped-def]
    """Return where bristles settle at a speed [rad], and how fast [1/s]."""
    reach = np.maximum(budget, 1e-12) / stiffness
    pace = np.minimum(np.abs(motor_velocity) / reach, FASTEST)
    return np.sign(motor_velocity) * reach, pace


@compiled
def bristle_torque(state, state_rate, stiffness, damping):          # type: ignore[no-untyped-def]
    """Return the torque of the bristles that opposes the motor, (49) [N*m motor]."""
    return stiffness * state + damping * state_rate


@compiled
def asymmetric_budget(budget, sense, asymmetry):                    # type: ignore[no-untyped-def]
    """Return the extra budget of one sense of motion (+1, -1; 0 at rest), (50) [N*m motor]."""
    return budget * asymmetry * sense


@compiled
def load_budget(joint_torque, ratio, coefficient):                  # type: ignore[no-untyped-def]
    """Return the extra budget of a loaded mesh, (51) [N*m motor]."""
    return coefficient * np.abs(joint_torque) / ratio


@compiled
def warming_drag(motor_velocity, time, amplitude, time_constant):   # type: ignore[no-untyped-def]
    """Return the extra drag of cold grease, gone when the drive is warm, (52) [N*m motor]."""
    return amplitude * np.exp(-time / time_constant) * motor_velocity


@compiled
def position_budget(budget, link_angle, amplitude, order, phase):   # type: ignore[no-untyped-def]
    """Return the extra budget at a place of the turn, (53) [N*m motor]."""
    return budget * amplitude * np.sin(order * link_angle + phase)


@dataclass(frozen=True)
class CoulombFriction(Effect):
    """Dry friction of motor, wave generator and seals: a constant budget, (44)."""

    name: ClassVar[str] = 'coulomb_friction'
    cause: ClassVar[str] = 'dry friction level of motor and wave generator differs'
    site: ClassVar[Site] = Site.MOTOR
    law = staticmethod(dry_budget)
    level: float = parameter(0.0, 'N*m', 0.0, 5.0, 'dry friction level, motor side')


@dataclass(frozen=True)
class ViscousFriction(Effect):
    """Drag proportional to speed: grease, iron losses, back EMF, (45)."""

    name: ClassVar[str] = 'viscous_friction'
    cause: ClassVar[str] = 'viscous friction of motor and grease differs'
    site: ClassVar[Site] = Site.MOTOR
    law = staticmethod(viscous_drag)
    slope: float = parameter(0.0, 'N*m*s/rad', 0.0, 1.0, 'viscous friction, motor side')


@dataclass(frozen=True)
class NonlinearViscousFriction(Effect):
    """Drag along a power of the speed, on top of the linear one, (46)."""

    name: ClassVar[str] = 'nonlinear_viscous_friction'
    cause: ClassVar[str] = 'viscous friction is not linear in speed (grease thins or churns)'
    site: ClassVar[Site] = Site.MOTOR
    law = staticmethod(nonlinear_drag)
    coefficient: float = parameter(0.0, 'N*m', 0.0, 5.0, 'drag at 1 rad/s, motor side')
    exponent: float = parameter(0.5, '', 0.1, 3.0, 'power of the speed')


@dataclass(frozen=True)
class StribeckFriction(Effect):
    """Breakaway excess that dies away with speed: excess * exp(-(v / speed)^2), (47)."""

    name: ClassVar[str] = 'stribeck_friction'
    cause: ClassVar[str] = 'breakaway friction at low speed (boundary lubrication)'
    site: ClassVar[Site] = Site.MOTOR
    law = staticmethod(stribeck_budget)
    excess: float = parameter(0.0, 'N*m', 0.0, 5.0, 'breakaway excess over the sliding level')
    speed: float = parameter(5.0, 'rad/s', 0.1, 50.0, 'Stribeck speed, motor side')


@dataclass(frozen=True)
class PreslidingFriction(Effect):
    """Bristles that bend before they slide (LuGre) in the place of sticking, (48-49)."""

    name: ClassVar[str] = 'presliding_friction'
    cause: ClassVar[str] = 'friction builds up over a displacement after a reversal (bristles)'
    site: ClassVar[Site] = Site.MOTOR
    law = staticmethod(bristle_torque)
    rate = staticmethod(bristle_rate)
    stiffness: float = parameter(
        0.0, 'N*m/rad', 0.0, 1e3, 'of the bristles, motor side; 0 for friction that sticks')
    damping: float = parameter(0.0, 'N*m*s/rad', 0.0, 0.2, 'of the bristles, motor side')


@dataclass(frozen=True)
class AsymmetricFriction(Effect):
    """Dry friction that differs with the sense of motion, (50)."""

    name: ClassVar[str] = 'asymmetric_friction'
    cause: ClassVar[str] = 'dry friction differs with the direction of motion'
    site: ClassVar[Site] = Site.MOTOR
    law = staticmethod(asymmetric_budget)
    asymmetry: float = parameter(
        0.0, '', -0.95, 0.95, 'share by which the dry level is larger forwards, smaller backwards')


@dataclass(frozen=True)
class LoadDependentFriction(Effect):
    """Loss of the mesh, proportional to the torque through the gear, (51)."""

    name: ClassVar[str] = 'load_dependent_friction'
    cause: ClassVar[str] = 'mesh friction grows with the torque through the gear'
    site: ClassVar[Site] = Site.MOTOR
    law = staticmethod(load_budget)
    coefficient: float = parameter(
        0.0, '', 0.0, 0.9, 'friction per torque through the gear, both on the same side')


@dataclass(frozen=True)
class ThermalViscosity(Effect):
    """Viscosity of a cold drive that dies away as it warms up, from the start, (52)."""

    name: ClassVar[str] = 'thermal_viscosity'
    cause: ClassVar[str] = 'viscous friction falls as the drive warms up'
    site: ClassVar[Site] = Site.MOTOR
    law = staticmethod(warming_drag)
    amplitude: float = parameter(
        0.0, 'N*m*s/rad', 0.0, 1.0, 'extra viscous slope at time 0, motor side')
    time_constant: float = parameter(300.0, 's', 1.0, 1e5, 'of the warming up')


@dataclass(frozen=True)
class PositionDependentFriction(Effect):
    """Dry friction that varies along the turn of the link, (53)."""

    name: ClassVar[str] = 'position_dependent_friction'
    cause: ClassVar[str] = 'dry friction varies along the turn of the joint'
    site: ClassVar[Site] = Site.MOTOR
    law = staticmethod(position_budget)
    amplitude: float = parameter(0.0, '', 0.0, 0.95, 'variation as a share of the dry level')
    order: float = parameter(1.0, '1/turn', 0.1, 1e3, 'waves per turn of the link')
    phase: float = parameter(0.0, 'rad', -7.0, 7.0, 'phase at link angle 0')
