"""
The arm: joints, links, base, and the effects that are placed on it.

An `Arm` is a value. `record` turns it into the numpy records that compiled code reads, in which
every effect of the catalogue has its place, neutral where the arm does not have it.
"""

from dataclasses import dataclass, replace
import math
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .effects import (BaseTilt, BaseVibration, ClockSkew, CoarseQuantisation, CoulombFriction,
                      Effect, effect_named, effects_of, InertialCoupling, LinkInertiaError,
                      MotorInertiaError, Scope, Signals, Site, StiffeningError, StiffnessError,
                      StructuralDamping, TorqueSaturation, ViscousFriction,
                      WaveGeneratorCompliance)
from .effects.catalogue import record_fields
from .link_side import loaded_inertia, thrown_mass
from .parameter import Declared, parameter
from .torsion import TorsionLaw


_SEGMENTS = ('knee_1', 'second_stiffness', 'knee_2', 'third_stiffness')


class ArmError(ValueError):
    """An arm that cannot be: parts that do not fit each other, or a name it does not have."""


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
class Joint(Declared):
    """One joint: motor, gear, torsion and two encoders; friction is stated at the motor shaft."""

    name: ClassVar[str] = 'joint'
    label: str = 'joint1'
    torsion: TorsionLaw = TorsionLaw()
    motor_encoder: Encoder = Encoder()
    link_encoder: Encoder = Encoder()
    ratio: float = parameter(100.0, '', 1.0, 1e4, 'gear ratio N')
    motor_inertia: float = parameter(
        1.289e-4, 'kg*m^2', 1e-9, 10.0, 'J_m + J_w, rotor and wave generator, motor side')
    dry_friction: float = parameter(0.0, 'N*m', 0.0, 5.0, 'Coulomb level, motor side')
    viscous_friction: float = parameter(0.0, 'N*m*s/rad', 0.0, 1.0, 'slope, motor side')
    torque_limit: float = parameter(1.0, 'N*m', 1e-6, 1e4, 'largest motor torque, shaft')
    velocity_limit: float = parameter(700.0, 'rad/s', 1e-3, 1e5, 'largest motor speed, shaft')
    angle_limit: float = parameter(1e3, 'rad', 1e-3, 1e6, 'largest link angle either way')

    def nominal(self, effect: type[Effect]) -> Effect:
        """Return an effect as this joint has it without any entry in the arm's list."""
        return {
            CoulombFriction: lambda: CoulombFriction(level=self.dry_friction),
            ViscousFriction: lambda: ViscousFriction(slope=self.viscous_friction),
            StructuralDamping: lambda: StructuralDamping(coefficient=self.torsion.damping),
            ClockSkew: lambda: ClockSkew(
                skew=self.link_encoder.sampling_time - self.motor_encoder.sampling_time),
            CoarseQuantisation: lambda: CoarseQuantisation(
                motor_step=self.motor_encoder.step, link_step=self.link_encoder.step),
            TorqueSaturation: lambda: TorqueSaturation(limit=self.torque_limit),
        }.get(effect, effect)()


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


@dataclass(frozen=True)
class Base(Declared):
    """How the base stands; a level base feels no gravity in its plane."""

    name: ClassVar[str] = 'base'
    tilt: float = parameter(0.0, 'rad', 0.0, math.pi / 2, 'angle between base and horizontal')
    direction: float = parameter(0.0, 'rad', -7.0, 7.0, 'downhill direction in the base frame')
    gravity: float = parameter(9.80665, 'm/s^2', 0.0, 30.0, 'acceleration of free fall')

    def nominal(self, effect: type[Effect]) -> Effect:
        """Return an effect as the base has it without any entry in the arm's list."""
        if effect is BaseTilt:
            return BaseTilt(tilt=self.tilt, direction=self.direction)
        return effect()


@dataclass(frozen=True)
class Tolerances(Declared):
    """How well the nominal parameters are known: one sigma, relative."""

    name: ClassVar[str] = 'tolerances'
    stiffness: float = parameter(0.01, '', 0.0, 1.0, 'flexspline stiffness')
    link_inertia: float = parameter(0.01, '', 0.0, 1.0, 'inertia of a link')
    torque_constant: float = parameter(0.005, '', 0.0, 1.0, 'motor torque per command')
    dry_friction: float = parameter(0.03, '', 0.0, 1.0, 'Coulomb level')
    viscous_friction: float = parameter(0.1, '', 0.0, 1.0, 'viscous slope')
    damping: float = parameter(0.1, '', 0.0, 1.0, 'damping of the torsion')


class Placed(NamedTuple):
    """An effect at its place: a joint's label, or None for the arm as a whole."""

    effect: Effect
    joint: str | None


class ArmRecord(NamedTuple):
    """What compiled code reads: one record per joint, and one for links, base and arm effects."""

    joints: NDArray[Any]
    body: Any


JOINT_RECORD = np.dtype([
    ('ratio', float), ('motor_inertia', float), ('torsion', TorsionLaw.record_type()),
    ('motor_encoder', Encoder.record_type()), ('link_encoder', Encoder.record_type()),
    *record_fields(Scope.JOINT)])
BODY_RECORD = np.dtype([
    ('links', Links.record_type()),
    ('pull', float), ('direction', float),      # gravity in the plane, and where to [m/s^2, rad]
    ('weight', float),                          # gravity across the plane [m/s^2]
    *record_fields(Scope.ARM)])


@dataclass(frozen=True)
class Arm:
    """An arm with n joints; without links (`links=None`) only its torsion is known."""

    joints: tuple[Joint, ...]
    links: Links | None = None
    base: Base = Base()
    effects: tuple[Placed, ...] = ()
    tolerances: Tolerances = Tolerances()
    provenance: tuple[tuple[str, str], ...] = ()       # a number's name, and where it came from

    def __post_init__(self) -> None:
        """Check that the parts fit each other; raises ArmError."""
        _check_labels([joint.label for joint in self.joints])
        for placed in self.effects:
            self._check_place(type(placed.effect), placed.joint)
        if self.links is not None:
            _check_links(self.moving_links(), len(self.joints))
            _check_base(self)

    @property
    def labels(self) -> tuple[str, ...]:
        """Return the names of the joints in order."""
        return tuple(joint.label for joint in self.joints)

    def joint(self, label: str) -> Joint:
        """Return one joint by its name; raises ArmError with the valid names."""
        for joint in self.joints:
            if joint.label == label:
                return joint
        raise ArmError(f'the arm has no joint {label!r}; its joints are {", ".join(self.labels)}')

    def _check_place(self, effect: type[Effect], joint: str | None) -> None:
        if effect.scope is Scope.ARM and joint is not None:
            raise ArmError(f'{effect.name} belongs to the arm as a whole, got joint {joint!r}')
        if effect.scope is Scope.JOINT:
            if joint is None:
                raise ArmError(f'{effect.name} belongs to one joint: name one of '
                               f'{", ".join(self.labels)}')
            self.joint(joint)

    def effect(self, name: str, joint: str | None = None) -> Effect:
        """Return an effect in force: its entry, else the nominal one (raises on bad names)."""
        kind = effect_named(name)
        self._check_place(kind, joint)
        for placed in self.effects:
            if placed.joint == joint and placed.effect.name == name:
                return placed.effect
        return (self.base if joint is None else self.joint(joint)).nominal(kind)

    def with_effect(self, effect: Effect, joint: str | None = None) -> 'Arm':
        """Return the arm with this effect in the place of any other of its name."""
        return replace(self, effects=(*self.without(effect.name, joint).effects,
                                      Placed(effect, joint)))

    def without(self, name: str, joint: str | None = None) -> 'Arm':
        """Return the arm with the nominal effect of this name."""
        kept = tuple(p for p in self.effects if (p.effect.name, p.joint) != (name, joint))
        return replace(self, effects=kept)

    def at(self, site: Site) -> tuple[Placed, ...]:
        """Return the placed effects of one site."""
        return tuple(placed for placed in self.effects if placed.effect.site is site)

    def record(self) -> ArmRecord:
        """Return the arm as compiled code reads it."""
        joints = np.array([self._joint_record(joint) for joint in self.joints], JOINT_RECORD)
        body = np.zeros((), BODY_RECORD)[()]
        tilt = self._in_force(BaseTilt)
        down_x, down_y = tilt(Signals(gravity=self.base.gravity))
        body['links'] = self.moving_links().values()
        body['pull'] = math.hypot(down_x, down_y)
        body['direction'] = tilt.direction
        body['weight'] = self.base.gravity * math.cos(tilt.tilt)
        for kind in effects_of(Scope.ARM):
            body[kind.name] = self.effect(kind.name).values()
        return ArmRecord(joints, body)

    def moving_links(self) -> Links:
        """Return the links with the effects that change their inertia, but without a payload."""
        links = self.links or Links()
        if len(self.joints) > 2:
            return links
        coupled = self._in_force(InertialCoupling)(Signals(nominal=links.coupled))
        far = 0.0 if len(self.joints) == 1 else links.p2
        near = links.p1 - coupled * far
        change = [self._in_force(LinkInertiaError, joint.label)(Signals(nominal=own)) - own
                  for joint, own in zip(self.joints, (near, far))]
        change2 = change[1] if len(change) == 2 else 0.0
        return replace(links, p1=links.p1 + change[0] + coupled * change2, p2=links.p2 + change2,
                       coupled=float(coupled))

    def moving_torsion(self, joint: Joint) -> TorsionLaw:
        """Return the torsion law of a joint with the effects that change it."""
        law = joint.torsion
        bent = self._in_force(StiffeningError, joint.label)
        curvature, *segments = bent(Signals(nominal=law.flexspline_curvature))
        softer = self._in_force(WaveGeneratorCompliance, joint.label)
        if segments[0] > 0.0:
            law = replace(law, **dict(zip(_SEGMENTS, segments)))
        if not softer.is_neutral():
            rest = softer(Signals(nominal=1.0 / law.wave_generator_stiffness))
            law = replace(law, wave_generator_stiffness=1.0 / rest if rest > 0.0 else math.inf)
        stiffness = self._in_force(StiffnessError, joint.label)(
            Signals(nominal=law.flexspline_stiffness))
        return replace(law, flexspline_stiffness=stiffness, flexspline_curvature=curvature)

    def _in_force(self, kind: type[Effect], joint: str | None = None) -> Any:
        return self.effect(kind.name, joint)

    def _joint_record(self, joint: Joint) -> Any:
        effects = (self.effect(kind.name, joint.label).values()
                   for kind in effects_of(Scope.JOINT))
        inertia = self._in_force(MotorInertiaError, joint.label)(
            Signals(nominal=joint.motor_inertia))
        return (joint.ratio, inertia, tuple(self.moving_torsion(joint).record(joint.ratio)),
                joint.motor_encoder.values(), joint.link_encoder.values(), *effects)


def _check_labels(labels: list[str]) -> None:
    if not labels:
        raise ArmError('an arm needs at least one joint, got none')
    twice = sorted({label for label in labels if labels.count(label) > 1})
    if twice:
        raise ArmError(f'joint names must differ, got {", ".join(twice)} more than once')


def _check_links(links: Links, joints: int) -> None:
    if joints > 2:
        raise ArmError(f'links are modelled for one or two joints, got {joints} joints; '
                       'write "links: none" for torsion only')
    if joints == 2 and links.length2 <= 0.0:
        raise ArmError(f'two joints need two link lengths > 0 m, got {links.length2:g} m')
    if joints == 2 and not links.p2 > 0.0:
        raise ArmError(f'two joints need p2 > 0 kg*m^2, got {links.p2:g} kg*m^2')
    definite = links.p2 * (links.p1 - links.p2) > links.p3 ** 2
    if joints == 2 and links.coupled and not definite:
        raise ArmError('the mass matrix must be positive definite: p2 (p1 - p2) > p3^2, got '
                       f'p = ({links.p1:g}, {links.p2:g}, {links.p3:g}) kg*m^2')


def _check_base(arm: Arm) -> None:
    """Check that the mass of a swinging base holds at least what the links throw about."""
    accelerance = arm.effect(BaseVibration.name).values()[2]
    if accelerance > 0.0:
        mass = thrown_mass(loaded_inertia(arm.record().body), len(arm.joints))
        if accelerance * mass >= 1.0:
            raise ArmError('base_vibration.amplitude must lie below one over the mass that the '
                           f'links move, {1.0 / mass:.3g} 1/kg, got {accelerance:g} 1/kg')
