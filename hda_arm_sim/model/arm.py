"""
The arm: joints, links, base, and the effects that are placed on it.

An `Arm` is a value. `record` turns it into the numpy records that compiled code reads. In them
every effect of the catalogue has its place, neutral where the arm does not have it.
"""

from dataclasses import dataclass, replace
from functools import cached_property
import math
from typing import Any, NamedTuple

from hda_msgs_json.errors import HdaError
from hda_msgs_json.topics import motor_name
import numpy as np
from numpy.typing import NDArray

from .chain_links import ChainLinks
from .effect_loops import numbers_at
from .effects import Effect, effect_named, effects_of, Scope, Site
from .effects.catalogue import record_fields, sole_at
from .effects.place import BASE, COUPLING, LINK_INERTIA, MOTOR_INERTIA, Place, WEIGHT
from .link_numbers import differ, differing_pair, is_definite
from .link_side import loaded_inertia, thrown_mass
from .parts import Base, Encoder, Joint, Links, Tolerances
from .torsion import TorsionLaw
from .torsion_in_force import OF_TORSION, torsion_record
from ..foundation.chain import CHAIN_RECORD, DOWN, MASS


class ArmError(HdaError):
    """An arm that cannot be: parts that do not fit each other, or a name it does not have."""


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
    ('motor_deviation', float), ('deviation_factor', float), ('effort_lag', float),
    ('held_share', float),
    ('tolerances', Tolerances.record_type()),
    *record_fields(Scope.JOINT)])
BODY_RECORD, CHAIN_BODY_RECORD = (np.dtype([
    ('links', links),
    ('pull', float), ('direction', float),      # gravity in the plane, and where to [m/s^2, rad]
    ('weight', float),                          # gravity across the plane [m/s^2]
    *record_fields(Scope.ARM)]) for links in (Links.record_type(), CHAIN_RECORD))


@dataclass(frozen=True)
class Arm:
    """An arm with n joints; without links (`links=None`) only its torsion is known."""

    joints: tuple[Joint, ...]
    links: Links | ChainLinks | None = None
    base: Base = Base()
    effects: tuple[Placed, ...] = ()
    tolerances: Tolerances = Tolerances()
    provenance: tuple[tuple[str, str], ...] = ()       # a number's name, and where it came from

    def __post_init__(self) -> None:
        """Check that the parts fit each other; raises ArmError."""
        _check_labels([joint.label for joint in self.joints])
        listed: set[tuple[str, str | None]] = set()
        for placed in self.effects:
            self._check_place(type(placed.effect), placed.joint)
            if (placed.effect.name, placed.joint) in listed:
                raise ArmError(f'{placed.effect.name} of {placed.joint or "the arm"} is listed '
                               'twice; an effect has one entry')
            listed.add((placed.effect.name, placed.joint))
        if self.links is not None:
            _check_links(self)
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

    def tolerances_of(self, label: str) -> Tolerances:
        """Return how well the numbers of a joint are known: its own, else the arm's."""
        return self.joint(label).tolerances or self.tolerances

    def _check_place(self, effect: type[Effect], joint: str | None) -> None:
        if effect.scope is Scope.ARM and joint is not None:
            raise ArmError(f'{effect.name} belongs to the arm as a whole, got joint {joint!r}')
        if effect.scope is Scope.JOINT:
            if joint is None:
                raise ArmError(f'{effect.name} belongs to one joint: name one of '
                               f'{", ".join(self.labels)}')
            self.joint(joint)

    @cached_property
    def _entries(self) -> dict[tuple[str, str | None], Effect]:
        return {(placed.effect.name, placed.joint): placed.effect for placed in self.effects}

    def effect(self, name: str, joint: str | None = None) -> Effect:
        """Return an effect in force: its entry, else the nominal one (raises on bad names)."""
        kind = effect_named(name)
        self._check_place(kind, joint)
        if found := self._entries.get((name, joint)):
            return found
        return (self.base if joint is None else self.joint(joint)).nominal(kind)

    def with_effect(self, effect: Effect, joint: str | None = None) -> 'Arm':
        """Return the arm with this effect in the place of any other of its name."""
        return replace(self, effects=(*self._others(effect.name, joint), Placed(effect, joint)))

    def without(self, name: str, joint: str | None = None) -> 'Arm':
        """Return the arm with the nominal effect of this name."""
        return replace(self, effects=self._others(name, joint))

    def _others(self, name: str, joint: str | None) -> tuple[Placed, ...]:
        """Return all entries but one."""
        return tuple(p for p in self.effects if (p.effect.name, p.joint) != (name, joint))

    def at(self, site: Site) -> tuple[Placed, ...]:
        """Return the placed effects of one site."""
        return tuple(placed for placed in self.effects if placed.effect.site is site)

    def record(self) -> ArmRecord:
        """Return the arm as compiled code reads it."""
        return self._record

    @cached_property
    def _record(self) -> ArmRecord:
        joints = np.array([self._joint_record(joint) for joint in self.joints], JOINT_RECORD)
        chain = isinstance(self.links, ChainLinks)
        body = np.zeros((), CHAIN_BODY_RECORD if chain else BODY_RECORD)[()]
        tilt = self._in_force(WEIGHT)
        down_x, down_y = tilt(gravity=self.base.gravity)
        if chain:
            body['links']['joints'] = len(self.joints)
            body['links']['parts'][:len(self.joints) + 2] = self.moving_parts()
        else:
            body['links'] = self.moving_links().values()
        body['pull'] = math.hypot(down_x, down_y)
        body['direction'] = tilt.direction
        body['weight'] = self.base.gravity * math.cos(tilt.tilt)
        for kind in effects_of(Scope.ARM):
            body[kind.name] = self._of_kind(kind, None).values()
        return ArmRecord(joints, body)

    def moving_links(self) -> Links:
        """
        Return two links with the effects that change their inertia, but without a payload.

        Raises ArmError for a chain, which has `moving_parts`.
        """
        return self._moving_links

    @cached_property
    def _moving_links(self) -> Links:
        links = self.links or Links()
        if isinstance(links, ChainLinks):
            raise ArmError('this is for two links in a plane; the arm has a chain of '
                           f'{len(self.joints)} joints')
        if len(self.joints) > 2:
            return links
        coupled = self._in_force(COUPLING)(nominal=links.coupled)
        return differing_pair(replace(links, coupled=float(coupled)), [
            self._in_force(LINK_INERTIA, joint.label) for joint in self.joints])

    def ranges(self) -> NDArray[np.float64]:
        """Return from where to where each link may turn (n, 2), by file and description [rad]."""
        most = np.array([joint.angle_limit for joint in self.joints])
        ranges = np.stack([-most, most], axis=1)
        if isinstance(self.links, ChainLinks):
            low, high = self.links.ranges.T
            ranges = np.stack([np.maximum(-most, low), np.minimum(most, high)], axis=1)
        return ranges

    def torsion_only(self) -> 'Arm':
        """Return the arm without its chain, for who knows two links in a plane, or none."""
        return replace(self, links=None) if isinstance(self.links, ChainLinks) else self

    def moving_parts(self) -> NDArray[np.float64]:
        """Return a chain (foundation.chain) with gravity and the effects on its inertia."""
        return self._moving_parts

    @cached_property
    def _moving_parts(self) -> NDArray[np.float64]:
        if not isinstance(self.links, ChainLinks):
            raise ArmError('this is for chains; the arm has links in a plane, or none')
        parts = self.links.parts.copy()
        for row, joint in zip(parts[1:], self.joints):
            differ(row, self._in_force(LINK_INERTIA, joint.label))
        tilt = self._in_force(WEIGHT)
        parts[0, DOWN:DOWN + 3] = (*tilt(gravity=self.base.gravity),
                                   -self.base.gravity * math.cos(tilt.tilt))
        parts.setflags(write=False)
        return parts

    def _in_force(self, place: Place, joint: str | None = None) -> Any:
        """Return what `effect` does of the only effect of a place that is there."""
        return self._of_kind(sole_at(place), joint)

    def _of_kind(self, kind: type[Effect], joint: str | None) -> Effect:
        return self._entries.get((kind.name, joint)) or (
            self.base if joint is None else self.joint(joint)).nominal(kind)

    def _joint_record(self, joint: Joint) -> Any:
        own = {name: effect.values() for (name, label), effect in self._entries.items()
               if label == joint.label}
        inertia = self._in_force(MOTOR_INERTIA, joint.label)(nominal=joint.motor_inertia)
        torsion = torsion_record(joint.ratio, joint.torsion, *(
            self._in_force(place, joint.label) for place in OF_TORSION))
        return (joint.ratio, inertia, torsion, joint.motor_encoder.values(),
                joint.link_encoder.values(), joint.motor_deviation, joint.deviation_factor,
                joint.effort_lag, joint.held_share, self.tolerances_of(joint.label).values(),
                *{**joint.stated, **own}.values())


def _check_labels(labels: list[str]) -> None:
    if not labels:
        raise ArmError('an arm needs at least one joint, got none')
    twice = sorted({label for label in labels if labels.count(label) > 1})
    if twice:
        raise ArmError(f'joint names must differ, got {", ".join(twice)} more than once')
    for label in labels:
        if motor_name(label) in labels:
            raise ArmError(f'{motor_name(label)} is the name of the motor of {label} in joint '
                           'states; give that joint another name')


def _check_links(arm: Arm) -> None:
    if isinstance(arm.links, ChainLinks):
        _check_chain(arm, arm.links)
        return
    joints = len(arm.joints)
    if joints > 2:
        raise ArmError(f'lengths and inertia are those of one or two links in a plane, got '
                       f'{joints} joints; write links: {{urdf: FILE, tip: FRAME, '
                       'joints: [...]}}')
    _check_flat(arm)
    _check_pair(arm.moving_links(), joints)


def _check_flat(arm: Arm) -> None:
    """Check that no effect asks for what links in a plane do not have."""
    for effect, _ in arm.effects:
        for name in effect.spatial:
            if getattr(effect, name):
                raise ArmError(f'{effect.name}.{name} is for chains; links in a plane have no '
                               'such number')


def _check_chain(arm: Arm, links: ChainLinks) -> None:
    if len(links.names) != len(arm.joints):
        raise ArmError(f'links has a chain of {len(links.names)} joints '
                       f'({", ".join(links.names)}), got {len(arm.joints)} joints')
    for joint, (low, high) in zip(arm.joints, arm.ranges()):
        if not low < high:
            raise ArmError(f'{joint.label} cannot turn: its angle_limit is {joint.angle_limit:g} '
                           f'rad, and the description states {low if low > 0.0 else high:g} rad '
                           f'{"at least" if low > 0.0 else "at most"}')
    coupling = sole_at(COUPLING).name
    if not arm.effect(coupling).is_neutral():
        raise ArmError(f'{coupling} is for two links in a plane; the links of a chain '
                       'always feel each other')
    for label, row in zip(arm.labels, arm.moving_parts()[1:]):
        if not is_definite(row.tobytes()):
            raise ArmError(f'{sole_at(LINK_INERTIA).name} of {label} leaves an inertia that no '
                           'body has')


def _check_pair(links: Links, joints: int) -> None:
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
    accelerance = float(numbers_at(arm.record().body, BASE)['amplitude'])
    if accelerance > 0.0:
        inertia = loaded_inertia(arm.record().body)
        mass = (float(inertia.table[1:-1, MASS].sum()) if isinstance(arm.links, ChainLinks)
                else thrown_mass(inertia, len(arm.joints)))
        if accelerance * mass >= 1.0:
            raise ArmError(f'{sole_at(BASE).name}.amplitude must lie below one over the mass that '
                           f'the links move, {1.0 / mass:.3g} 1/kg, got {accelerance:g} 1/kg')
