"""The parts of an arm, each a group of declared parameters: joints, encoders, links, base."""

from dataclasses import dataclass
from functools import cache, cached_property
import math
from typing import ClassVar, NamedTuple

from .effects import Effect, effects_of, Scope
from .effects.effect import neutral
from .torsion import TorsionLaw
from ..foundation.parameter import Declared, parameter


@dataclass(frozen=True)
class Encoder(Declared):
    """One encoder; the angle is that of its own shaft."""

    name: ClassVar[str] = 'encoder'
    counts: float = parameter(0.0, '1/turn', 0.0, 1e10, 'counts per turn, 0 for a perfect encoder')
    zero: float = parameter(0.0, 'rad', -1e4, 1e4, 'reading at angle zero')
    noise: float = parameter(0.0, 'rad', 0.0, 0.1, 'standard deviation of the reading')
    sampling_time: float = parameter(0.0, 's', -0.1, 0.1, 'time of reading after the stamp')

    @property
    def step(self) -> float:
        """Return the angle of one count, 0 for a perfect encoder [rad]."""
        return 2.0 * math.pi / self.counts if self.counts > 0.0 else 0.0


@dataclass(frozen=True)
class Tolerances(Declared):
    """How well nominal parameters are known, of an arm or of one joint: one sigma, relative."""

    name: ClassVar[str] = 'tolerances'
    stiffness: float = parameter(0.01, '', 0.0, 1.0, 'flexspline stiffness')
    link_inertia: float = parameter(0.01, '', 0.0, 1.0, 'inertia of a link')
    carried_load: float = parameter(0.01, '', 0.0, 1.0, 'each number of what the tip carries')
    torque_constant: float = parameter(0.005, '', 0.0, 1.0, 'motor torque per command')
    motor_inertia: float = parameter(0.0, '', 0.0, 1.0, 'rotor and wave generator; 0 as stated')
    dry_friction: float = parameter(0.03, '', 0.0, 1.0, 'Coulomb level')
    viscous_friction: float = parameter(0.1, '', 0.0, 1.0, 'viscous slope')
    damping: float = parameter(0.1, '', 0.0, 1.0, 'damping of the torsion')
    torsion_zero: float = parameter(1e-5, 'rad', 0.0, 0.1, 'zero of the torsion, output side')
    kinematic_error: float = parameter(
        2e-6, 'rad', 0.0, 0.1, 'each wave of the torsion over the shaft')
    eccentricity: float = parameter(
        2e-6, 'rad', 0.0, 0.1, 'each wave of the torsion over the link')
    clock_skew: float = parameter(2e-6, 's', 0.0, 0.1, 'link encoder after motor encoder')
    torque_ripple: float = parameter(
        2e-4, 'N*m', 0.0, 1.0, 'each wave of the torque over the shaft')
    drive_offset: float = parameter(6e-4, 'N*m', 0.0, 1.0, 'constant torque of the drive, shaft')


class SensorErrors(NamedTuple):
    """
    What a torque sensor at the output of a joint shows beside the torque of the gear.

    It reads (1 + gain) times the torque, and `zero` on top. Its response to an impulse has the
    mean `lag` and the variance `blur`. A low-pass of the time constant T has T and T^2, a delay
    has no variance. These are of a recording: no arm file states them, and no simulation has them.
    """

    zero: float = 0.0           # [N*m]
    gain: float = 0.0           # relative
    lag: float = 0.0            # [s]
    blur: float = 0.0           # [s^2]


@dataclass(frozen=True)
class Joint(Declared):
    """One joint: motor, gear, torsion and two encoders; friction is stated at the motor shaft."""

    name: ClassVar[str] = 'joint'
    label: str = 'joint1'
    torsion: TorsionLaw = TorsionLaw()
    motor_encoder: Encoder = Encoder()
    link_encoder: Encoder = Encoder()
    tolerances: Tolerances | None = None        # its own, in the place of the arm's
    sensor: SensorErrors = SensorErrors()
    ratio: float = parameter(100.0, '', 1.0, 1e4, 'gear ratio N')
    motor_inertia: float = parameter(
        1.289e-4, 'kg*m^2', 1e-9, 10.0, 'J_m + J_w, rotor and wave generator, motor side')
    dry_friction: float = parameter(0.0, 'N*m', 0.0, 5.0, 'Coulomb level, motor side')
    viscous_friction: float = parameter(0.0, 'N*m*s/rad', 0.0, 1.0, 'slope, motor side')
    torque_limit: float = parameter(1.0, 'N*m', 1e-6, 1e4, 'largest motor torque, shaft')
    velocity_limit: float = parameter(700.0, 'rad/s', 1e-3, 1e5, 'largest motor speed, shaft')
    angle_limit: float = parameter(1e3, 'rad', 1e-3, 1e6, 'largest link angle either way')
    motor_deviation: float = parameter(
        0.0, 'N*m', 0.0, 1e3,
        'of true torques from all that is known of the motor, one sigma, output side')
    deviation_factor: float = parameter(
        1.0, '', 0.01, 10.0, 'deviations of true torques over those that all the others make')
    effort_lag: float = parameter(
        0.5, '', -1.0, 1.0,
        'samples by which a motor torque acts after its stamp: 0.5 held command, 0 measured')
    held_share: float = parameter(
        1.0, '', 0.0, 1.0, 'share of its dry friction that may hold a shaft at rest either way')

    @property
    def skew(self) -> float:
        """Return how much later the link encoder is read than that of the motor [s]."""
        return self.link_encoder.sampling_time - self.motor_encoder.sampling_time

    def nominal(self, effect: type[Effect]) -> Effect:
        """Return an effect as this joint has it without any entry in the arm's list."""
        return effect.as_stated(self) if effect.stated else neutral(effect)

    @cached_property
    def stated(self) -> dict[str, tuple[float, ...]]:
        """Return the numbers of every effect of a joint, as this one has it without any entry."""
        return _neutral_numbers() | {kind.name: self.nominal(kind).values()
                                     for kind in effects_of(Scope.JOINT) if kind.stated}


@cache
def _neutral_numbers() -> dict[str, tuple[float, ...]]:
    """Return the numbers of every effect of a joint that does nothing."""
    return {kind.name: neutral(kind).values() for kind in effects_of(Scope.JOINT)}


@dataclass(frozen=True)
class Links(Declared):
    """Two links (or one: length2, p2, p3 and second stay 0) that move in a plane."""

    name: ClassVar[str] = 'links'
    length1: float = parameter(0.15, 'm', 1e-3, 10.0, 'link 1, joint to joint')
    length2: float = parameter(0.0, 'm', 0.0, 10.0, 'link 2, joint to tip')
    p1: float = parameter(0.876, 'kg*m^2', 1e-9, 1e4, 'I1 + I2 + m1 c1^2 + m2 (l1^2 + c2^2)')
    p2: float = parameter(0.0, 'kg*m^2', 0.0, 1e4, 'I2 + m2 c2^2')
    p3: float = parameter(0.0, 'kg*m^2', -1e4, 1e4, 'm2 l1 c2')
    first: float = parameter(0.0, 'kg*m', -1e4, 1e4, 'mass moment about joint 1 at q2 = 90 deg')
    second: float = parameter(0.0, 'kg*m', -1e4, 1e4, 'mass moment about joint 2')
    coupled: float = parameter(1.0, '', 0.0, 1.0, '1, or 0 for links that do not feel each other')

    @property
    def last_length(self) -> float:
        """Return how far the tip is from the last joint [m]."""
        return self.length2 or self.length1


@dataclass(frozen=True)
class Base(Declared):
    """How the base stands; a level base feels no gravity in its plane."""

    name: ClassVar[str] = 'base'
    tilt: float = parameter(0.0, 'rad', 0.0, math.pi / 2, 'angle between base and horizontal')
    direction: float = parameter(0.0, 'rad', -7.0, 7.0, 'downhill direction in the base frame')
    gravity: float = parameter(9.80665, 'm/s^2', 0.0, 30.0, 'acceleration of free fall')

    def nominal(self, effect: type[Effect]) -> Effect:
        """Return an effect as the base has it without any entry in the arm's list."""
        return effect.as_stated(self) if effect.stated else neutral(effect)
