"""
Friction at the motor shaft (docs/model.md#effects).

Dry friction is a budget: the most torque that it can oppose. Who applies it resolves sign and
sticking. Drag is a torque along the velocity.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from .effect import Effect, KnownBy, Site
from .hypothesis import Hypothesis, SLOW, Typical, Unmeasured
from .place import (Bent, BREAKAWAY, BRISTLES, DRAG, Dragged, DRY_LEVEL, MESH, Place, Rubbed,
                    Signal)
from .words import CHECK_GREASE, CHECK_MESH, Words
from ...foundation.compiled import compiled, Record
from ...foundation.parameter import parameter

FASTEST = 2000.0        # relaxation of the bristles [1/s]; they are at rest within a sample anyway


@compiled
def dry_budget(own: Record, at: Rubbed) -> Signal:
    """Return the Coulomb budget, (eq:coulomb) [N*m motor]."""
    return own.level


@compiled
def viscous_drag(own: Record, at: Dragged) -> Signal:
    """Return the viscous torque that opposes the motor, (eq:viscous) [N*m motor]."""
    return own.slope * at.motor_velocity


@compiled
def nonlinear_drag(own: Record, at: Dragged) -> Signal:
    """Return the drag that grows with a power of the speed, (eq:power-drag) [N*m motor]."""
    speed = at.motor_velocity
    return own.coefficient * np.sign(speed) * np.abs(speed) ** own.exponent


@compiled
def stribeck_budget(own: Record, at: Rubbed) -> Signal:
    """Return the extra budget near standstill, (eq:stribeck) [N*m motor]."""
    return own.excess * np.exp(-(at.motor_velocity / own.speed) ** 2)


@compiled
def bristle_rate(own: Record, at: Bent) -> Signal:
    """Return dz/dt of bristles, which settle at budget / stiffness, (eq:bristles) [rad/s]."""
    end, pace = _settling(own, at)
    return pace * (end - at.state)


@compiled
def bristle_after(own: Record, at: Bent, time: float) -> Signal:
    """Return the deflection after a time at one speed, the solution of (eq:bristles) [rad]."""
    end, pace = _settling(own, at)
    return end + (at.state - end) * np.exp(-pace * time)


@compiled
def _settling(own: Record, at: Bent) -> tuple[Signal, Signal]:
    """Return where bristles settle at a speed [rad], and how fast [1/s]."""
    reach = np.maximum(at.budget, 1e-12) / own.stiffness
    pace = np.minimum(np.abs(at.motor_velocity) / reach, FASTEST)
    return np.sign(at.motor_velocity) * reach, pace


@compiled
def bristle_torque(own: Record, at: Bent) -> Signal:
    """Return the bristles' torque that opposes the motor, (eq:bristle-torque) [N*m motor]."""
    return own.stiffness * at.state + own.damping * at.state_rate


@compiled
def bristle_stiffness(own: Record, at: Bent) -> Signal:
    """Return the stiffness of bristles that bend, (eq:bristle-torque) [N*m/rad motor]."""
    return own.stiffness


@compiled
def asymmetric_budget(own: Record, at: Rubbed) -> Signal:
    """Return the extra budget of one sense of motion (+1, 0, -1), (eq:asymmetry) [N*m motor]."""
    return at.budget * own.asymmetry * at.sense


@compiled
def load_budget(own: Record, at: Rubbed) -> Signal:
    """Return the extra budget of a loaded mesh, (eq:load-friction) [N*m motor]."""
    load = np.abs(at.joint_torque)
    share = own.coefficient * (1.0 + own.growth * load)
    return share * load / at.ratio / (1.0 + own.fall * np.abs(at.motor_velocity))


@compiled
def warming_drag(own: Record, at: Dragged) -> Signal:
    """Return the extra drag of cold grease, gone once it is warm, (eq:thermal) [N*m motor]."""
    return own.amplitude * np.exp(-at.time / own.time_constant) * at.motor_velocity


@compiled
def position_budget(own: Record, at: Rubbed) -> Signal:
    """Return the extra budget at a place of the turn, (eq:place-friction) [N*m motor]."""
    return at.budget * own.amplitude * np.sin(own.order * at.link_angle + own.phase)


@dataclass(frozen=True)
class CoulombFriction(Effect):
    """Dry friction of motor, wave generator and seals: a constant budget, (eq:coulomb)."""

    name: ClassVar[str] = 'coulomb_friction'
    cause: ClassVar[str] = 'dry friction level of motor and wave generator differs'
    site: ClassVar[Site] = Site.MOTOR
    place: ClassVar[Place] = DRY_LEVEL
    stated: ClassVar[Mapping[str, str]] = {'level': 'dry_friction'}
    law = staticmethod(dry_budget)
    # (source: one that sets in over 0.03 of the fastest of even speeds lacks 0.012 of its power)
    hypothesis: ClassVar[Hypothesis | None] = Hypothesis(
        varies=('onset',), reach=0.02, free={'level': 0.01}, alike=('stribeck_friction',),
        experiment=SLOW)
    typical: ClassVar[Typical | None] = Typical({'level': 0.012})
    tolerance: ClassVar[tuple[str, str] | None] = ('level', 'dry_friction')
    known_by: ClassVar[KnownBy | None] = KnownBy(
        'dry_friction', ('level',),
        'dry friction changed by {percent:+.0f} %')
    words: ClassVar[Words] = Words(
        'has {size} of dry friction at its motor, not what its model says', 'wave_generator',
        CHECK_GREASE, ('level',))
    level: float = parameter(0.0, 'N*m', 0.0, 5.0, 'dry friction level, motor side')


@dataclass(frozen=True)
class ViscousFriction(Effect):
    """Drag proportional to speed: grease, iron losses, back EMF, (eq:viscous)."""

    name: ClassVar[str] = 'viscous_friction'
    cause: ClassVar[str] = 'viscous friction of motor and grease differs'
    site: ClassVar[Site] = Site.MOTOR
    place: ClassVar[Place] = DRAG
    stated: ClassVar[Mapping[str, str]] = {'slope': 'viscous_friction'}
    law = staticmethod(viscous_drag)
    # (source: a power of 0.8 to 1.2 of the speed leaves up to 0.005 to a line)
    hypothesis: ClassVar[Hypothesis | None] = Hypothesis(
        varies=('motor_velocity',), reach=0.005,
        free={'slope': 5e-05}, alike=('thermal_viscosity', 'nonlinear_viscous_friction'),
        experiment='at least three speeds, the same early and late')
    typical: ClassVar[Typical | None] = Typical({'slope': 0.0002})
    tolerance: ClassVar[tuple[str, str] | None] = ('slope', 'viscous_friction')
    known_by: ClassVar[KnownBy | None] = KnownBy(
        'viscous_friction', ('slope',),
        'viscous friction changed by {percent:+.0f} %')
    words: ClassVar[Words] = Words(
        'has {size} of viscous friction at its motor, not what its model says', 'wave_generator',
        CHECK_GREASE, ('slope',))
    slope: float = parameter(0.0, 'N*m*s/rad', 0.0, 1.0, 'viscous friction, motor side')


@dataclass(frozen=True)
class NonlinearViscousFriction(Effect):
    """Drag along a power of the speed, on top of the linear one, (eq:power-drag)."""

    name: ClassVar[str] = 'nonlinear_viscous_friction'
    cause: ClassVar[str] = 'viscous friction is not linear in speed (grease thins or churns)'
    site: ClassVar[Site] = Site.MOTOR
    place: ClassVar[Place] = DRAG
    acts: ClassVar[tuple[str, ...]] = ('coefficient',)
    law = staticmethod(nonlinear_drag)
    hypothesis: ClassVar[Hypothesis | None] = Hypothesis(
        varies=('motor_velocity',),
        free={'coefficient': 0.001, 'exponent': 0.1}, grid={'exponent': (0.5, 1.7)},
        stands={'exponent': 0.5},
        contains=('motor_velocity, squared', 'motor_velocity, cubed'),
        alike=('viscous_friction', 'stribeck_friction'), experiment='at least three speeds')
    typical: ClassVar[Typical | None] = Typical({'coefficient': 0.003}, {'exponent': 0.5})
    words: ClassVar[Words] = Words(
        'has friction of {size} at 1 rad/s that grows with speed to the power {exponent}',
        'wave_generator', CHECK_GREASE, ('coefficient',))
    coefficient: float = parameter(0.0, 'N*m', 0.0, 5.0, 'drag at 1 rad/s, motor side')
    exponent: float = parameter(0.5, '', 0.1, 3.0, 'power of the speed')


@dataclass(frozen=True)
class StribeckFriction(Effect):
    """Breakaway excess that dies away with speed: excess * exp(-(v / speed)^2), (eq:stribeck)."""

    name: ClassVar[str] = 'stribeck_friction'
    cause: ClassVar[str] = 'breakaway friction at low speed (boundary lubrication)'
    site: ClassVar[Site] = Site.MOTOR
    place: ClassVar[Place] = BREAKAWAY
    acts: ClassVar[tuple[str, ...]] = ('excess',)
    law = staticmethod(stribeck_budget)
    # (source: half as strong again one way)
    hypothesis: ClassVar[Hypothesis | None] = Hypothesis(
        varies=('motor_velocity', 'sense', 'joint_torque', 'load_sense'), reach=0.3,
        free={'excess': 0.01, 'speed': 1.0}, grid={'speed': (3.0, 10.0, 25.0)}, faintest=True,
        alike=('coulomb_friction', 'presliding_friction', 'motor_cogging'), form_error=0.02,
        contains=('sense below 5 rad/s', 'sense below 20 rad/s'), experiment=SLOW)
    typical: ClassVar[Typical | None] = Typical({'excess': 0.02}, {'speed': 8.0})
    unmeasured: ClassVar[Unmeasured | None] = Unmeasured({'speed': 1.0}, {'speed': 5.0})
    words: ClassVar[Words] = Words(
        'needs {size} more at its motor to break away at low speed', 'wave_generator',
        'Check the grease: too little or too old makes surfaces touch at low speed.', ('excess',))
    excess: float = parameter(0.0, 'N*m', 0.0, 5.0, 'breakaway excess over the sliding level')
    speed: float = parameter(5.0, 'rad/s', 0.1, 50.0, 'Stribeck speed, motor side')


@dataclass(frozen=True)
class PreslidingFriction(Effect):
    """Bristles that bend before they slide (LuGre), in place of sticking, (eq:bristles)."""

    name: ClassVar[str] = 'presliding_friction'
    cause: ClassVar[str] = 'friction builds up over a displacement after a reversal (bristles)'
    site: ClassVar[Site] = Site.MOTOR
    place: ClassVar[Place] = BRISTLES
    acts: ClassVar[tuple[str, ...]] = ('stiffness',)
    law = staticmethod(bristle_torque)
    law_rate = staticmethod(bristle_rate)
    law_after = staticmethod(bristle_after)
    law_stiffness = staticmethod(bristle_stiffness)
    hypothesis: ClassVar[Hypothesis | None] = Hypothesis(
        free={'stiffness': 1.0}, in_space={'damping': 0.005},     # shows behind light wrists
        grid={'stiffness': (3.0, 10.0)}, weaker=True,
        alike=('stribeck_friction', 'current_loop_lag'), form_share=0.08, form_error=0.02,
        experiment=SLOW)
    typical: ClassVar[Typical | None] = Typical({'stiffness': 2.0, 'damping': 0.01})
    words: ClassVar[Words] = Words(
        'builds up its friction over a displacement after each reversal ({size} at the motor)',
        'wave_generator', 'Check the preload of the bearings and the seals of the motor shaft.',
        ('stiffness',))
    stiffness: float = parameter(
        0.0, 'N*m/rad', 0.0, 1e3, 'of the bristles, motor side; 0 for friction that sticks')
    damping: float = parameter(0.0, 'N*m*s/rad', 0.0, 0.2, 'of the bristles, motor side')


@dataclass(frozen=True)
class AsymmetricFriction(Effect):
    """Dry friction that differs with the sense of motion, (eq:asymmetry)."""

    name: ClassVar[str] = 'asymmetric_friction'
    cause: ClassVar[str] = 'dry friction differs with the direction of motion'
    site: ClassVar[Site] = Site.MOTOR
    place: ClassVar[Place] = DRY_LEVEL
    acts: ClassVar[tuple[str, ...]] = ('asymmetry',)
    law = staticmethod(asymmetric_budget)
    # (source: drags that differ with the direction as well)
    hypothesis: ClassVar[Hypothesis | None] = Hypothesis(
        varies=('motor_velocity', 'time'), reach=0.3,
        free={'asymmetry': 0.1}, alike=('drive_offset',), twin='drive_offset',
        experiment='a dwell at zero command, and a return run')
    typical: ClassVar[Typical | None] = Typical({'asymmetry': 0.2})
    unmeasured: ClassVar[Unmeasured | None] = Unmeasured({'asymmetry': 0.3})
    words: ClassVar[Words] = Words(
        'has dry friction that is {size} larger forwards than its mean', 'wave_generator',
        'Check seals and brake, and read the current at standstill.', ('asymmetry',),
        less='has dry friction that is {size} larger backwards than its mean')
    asymmetry: float = parameter(
        0.0, '', -0.95, 0.95, 'share by which the dry level is larger forwards, smaller backwards')


@dataclass(frozen=True)
class LoadDependentFriction(Effect):
    """Loss of the mesh by the torque through the gear, (eq:load-friction)."""

    name: ClassVar[str] = 'load_dependent_friction'
    cause: ClassVar[str] = 'mesh friction grows with the torque through the gear'
    site: ClassVar[Site] = Site.MOTOR
    place: ClassVar[Place] = MESH
    acts: ClassVar[tuple[str, ...]] = ('coefficient',)
    law = staticmethod(load_budget)
    # (source: a square of the load instead of its size)
    hypothesis: ClassVar[Hypothesis | None] = Hypothesis(
        varies=('joint_torque', 'load_sense'), reach=0.3,
        free={'coefficient': 0.1}, alike=('torque_constant_error',),
        shaped={'growth': (0.1, 0.3, 1.0, 3.0, 10.0), 'fall': (1e-3, 3e-3, 0.01, 0.03, 0.1)},
        experiment='both directions under both signs of load')
    typical: ClassVar[Typical | None] = Typical({'coefficient': 0.15})
    unmeasured: ClassVar[Unmeasured | None] = Unmeasured({'coefficient': 0.2})
    words: ClassVar[Words] = Words(
        'loses {size} of the torque through its gear to friction of the mesh', 'flexspline',
        CHECK_MESH, ('coefficient',), beside=(
            ('growth', 'a share that grows with torque by {size}'),
            ('fall', 'a share that falls with speed by {size}')))
    coefficient: float = parameter(
        0.0, '', 0.0, 0.9, 'friction per torque through the gear, both on the same side')
    growth: float = parameter(
        0.0, '1/(N*m)', 0.0, 100.0, 'of that share with the torque through the gear')
    fall: float = parameter(
        0.0, 's/rad', 0.0, 10.0, 'of it with speed: half is left at the inverse, motor side')


@dataclass(frozen=True)
class ThermalViscosity(Effect):
    """Viscosity of a cold drive that dies away as it warms up, from the start, (eq:thermal)."""

    name: ClassVar[str] = 'thermal_viscosity'
    cause: ClassVar[str] = 'viscous friction falls as the drive warms up'
    site: ClassVar[Site] = Site.MOTOR
    place: ClassVar[Place] = DRAG
    acts: ClassVar[tuple[str, ...]] = ('amplitude',)
    law = staticmethod(warming_drag)
    hypothesis: ClassVar[Hypothesis | None] = Hypothesis(
        varies=('time',),
        free={'amplitude': 0.0001, 'time_constant': 10.0}, grid={'time_constant': (20.0, 100.0)},
        alike=('viscous_friction',), form_share=0.08, form_error=0.03,
        experiment='the same motion early, in the middle and late')
    typical: ClassVar[Typical | None] = Typical({'amplitude': 0.0003}, {'time_constant': 15.0})
    words: ClassVar[Words] = Words(
        'has {size} more viscous friction cold, gone after some {time_constant} s',
        'wave_generator',
        'Warm the joint up before a measurement, or log the temperature of the gear.',
        ('amplitude',))
    amplitude: float = parameter(
        0.0, 'N*m*s/rad', 0.0, 1.0, 'extra viscous slope at time 0, motor side')
    time_constant: float = parameter(300.0, 's', 1.0, 1e5, 'of the warming up')


@dataclass(frozen=True)
class PositionDependentFriction(Effect):
    """Dry friction that varies along the turn of the link, (eq:place-friction)."""

    name: ClassVar[str] = 'position_dependent_friction'
    cause: ClassVar[str] = 'dry friction varies along the turn of the joint'
    site: ClassVar[Site] = Site.MOTOR
    place: ClassVar[Place] = DRY_LEVEL
    acts: ClassVar[tuple[str, ...]] = ('amplitude',)
    law = staticmethod(position_budget)
    # (source: a second order of up to 0.6 of the first)
    hypothesis: ClassVar[Hypothesis | None] = Hypothesis(
        varies=('link_waves',), reach=0.3,
        waves={('amplitude', 'phase'): 0.1}, grid={'order': (1.0, 2.0, 3.0, 4.0, 6.0)},
        stands={'order': 2.0},
        alike=('asymmetric_friction',), experiment='a slow full turn of the link both ways')
    typical: ClassVar[Typical | None] = Typical({'amplitude': 0.3}, {'order': 2.0, 'phase': 0.5})
    words: ClassVar[Words] = Words(
        'has dry friction that varies by {size}, {order} times per link turn', 'bearing',
        'Turn the link by hand and feel for a tight spot; check the seats of its bearing.',
        ('amplitude',))
    amplitude: float = parameter(0.0, '', 0.0, 0.95, 'variation as a share of the dry level')
    order: float = parameter(1.0, '1/turn', 0.1, 1e3, 'waves per turn of the link')
    phase: float = parameter(0.0, 'rad', -7.0, 7.0, 'phase at link angle 0')
