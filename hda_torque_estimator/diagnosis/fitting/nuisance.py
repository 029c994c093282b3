"""
What may differ without being wrong: the arm's numbers within their tolerances, and two zeros.

They are terms like any other, with a prior; an effect is named only beyond what they explain.
A log of every so many commands does not know when what acted between them began to act (eq:late).
"""

from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TypeVar

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.chain_links import ChainLinks
from hda_arm_sim.model.effects import EFFECTS, Scope
from hda_arm_sim.model.effects.catalogue import sole_at
from hda_arm_sim.model.effects.place import LINK_INERTIA, WIRE
from hda_arm_sim.model.parts import Joint, Links, Tolerances
import numpy as np

from .solve import REACH
from ...least_squares.charts import Identity
from ...least_squares.term import Place, Term

# Numerics; choices unless stated otherwise.
_FLOOR = 1e-3           # of a relative tolerance: nothing is known exactly
_ZERO_STEP = 1e-6       # of an encoder's zero, for a derivative [rad]
# (source: from 0, had commands changed at once, to a half, if the log's own loop held them)
_LATE = 0.5             # of the time between two commands, by which they acted late at most
_LATENESS = sole_at(WIRE)
SENSOR_GAIN = 0.02      # of a torque sensor, one sigma; of 0.1, wrong names came
_ANY_GAIN = 1.0         # the same, of which nothing is known but its sign
_SENSOR_LAG = 0.02      # of a reference torque, as a calibration has it [s]
_SENSOR = 'sensor_'     # what the names of errors of a sensor begin with
GAIN = f'{_SENSOR}gain'
# Effect, number and tolerance of all numbers that an arm is given with: errors, and sizes.
_KNOWN = [(kind, *kind.tolerance) for kind in EFFECTS if kind.tolerance]
_ERRORS, _SIZES = ([(kind.name, number, tolerance) for kind, number, tolerance in _KNOWN
                    if kind.scope is Scope.JOINT
                    and bool(kind.declaration(number).unit) == has_unit]
                   for has_unit in (False, True))
_OF_ARM = [known for known in _KNOWN if known[0].scope is Scope.ARM]

One = TypeVar('One', bound='OneNumber')


@dataclass(frozen=True)
class OneNumber:
    """One free number beside the effects of the catalogue, in the shape of a term."""

    joint: str | None = None
    name: str = ''
    tolerance: float = np.inf
    value: float = 0.0
    size: int = 1

    @property
    def place(self) -> Place:
        """Return what distinguishes a term from all others of a fit."""
        return self.name, self.joint

    def all_steps(self) -> Array:
        """Return the step for finite differences."""
        return self.deviations()

    def deviations(self) -> Array:
        """Return the tolerance."""
        return np.array([self.tolerance])

    def vector(self) -> Array:
        """Return the number."""
        return np.array([self.value])

    def at(self: One, vector: Array) -> One:
        """Return another number."""
        return replace(self, value=float(vector[0]))


@dataclass(frozen=True)
class Zero(OneNumber):
    """The zero of one link encoder, of which nothing is known [rad]."""

    name: str = 'encoder_zero'

    def on(self, arm: Arm) -> Arm:
        """Return the arm with this zero added to the one that it has."""
        return _with_joint(self, arm)

    def all_steps(self) -> Array:
        """Return the step for finite differences [rad]."""
        return np.array([_ZERO_STEP])

    def on_joint(self, joint: Joint) -> Joint:
        """Return the joint with this zero added to the one that it has."""
        encoder = replace(joint.link_encoder, zero=joint.link_encoder.zero + self.value)
        return replace(joint, link_encoder=encoder)


@dataclass(frozen=True)
class CouplingInertia(OneNumber):
    """The relative error of p3, by which the links feel each other."""

    name: str = 'coupling_inertia'

    def on(self, arm: Arm) -> Arm:
        """Return the arm with p3 so much larger than it has it."""
        assert isinstance(arm.links, Links)
        return replace(arm, links=replace(arm.links, p3=arm.links.p3 * (1.0 + self.value)))


@dataclass(frozen=True)
class SensorError(OneNumber):
    """One error of the torque sensor of a joint (eq:balance-reference): `sensor_` and which."""

    def on(self, arm: Arm) -> Arm:
        """Return the arm whose sensor has this error."""
        return _with_joint(self, arm)

    def on_joint(self, joint: Joint) -> Joint:
        """Return the joint whose sensor has this error."""
        errors = {self.name.removeprefix(_SENSOR): self.value}
        return replace(joint, sensor=joint.sensor._replace(**errors))


def any_gains(terms: Iterable['AnyTerm'], labels: Collection[str],
              values: Mapping[str, float] | None = None) -> list['AnyTerm']:
    """Return tolerances with any gains of the sensors of some joints, of `values` if given."""
    found = values or {}
    return [replace(term, tolerance=_ANY_GAIN, value=found.get(str(term.joint), term.value))
            if isinstance(term, SensorError) and term.name == GAIN and term.joint in labels
            else term for term in terms]


def _with_joint(term: Zero | SensorError, arm: Arm) -> Arm:
    """Return the arm with a number at the joint that it is of."""
    return replace(arm, joints=tuple(
        term.on_joint(joint) if joint.label == term.joint else joint for joint in arm.joints))


AnyTerm = Term | Zero | CouplingInertia | SensorError


def nuisances(arm: Arm, untold: float = 0.0,
              sensors: Mapping[str, float] | None = None,
              unscaled: Collection[str] = ()) -> tuple[AnyTerm, ...]:
    """
    Return the tolerances of an arm as terms about its nominal numbers.

    Nobody knows what acted for the time `untold` [s] after each recorded command. Joints held
    against `sensors` have their errors as well. A zero may be off by what its torque varies by,
    which stands there [N*m]. Sensors that are `unscaled` have any gain.
    """
    terms: list[AnyTerm] = []
    for label in arm.labels:
        known = arm.tolerances_of(label)
        for name, number, tolerance in _ERRORS:
            if share := max(getattr(known, tolerance), _floor(tolerance)):
                terms.append(_term(arm, name, label, {number: share}))
        if link := link_tolerances(arm, label):
            terms.append(_term(arm, sole_at(LINK_INERTIA).name, label, link))
        for name, number, tolerance in _SIZES:
            value = getattr(arm.effect(name, label), number)
            if value > 0.0:
                terms.append(_term(arm, name, label, {
                    number: value * max(getattr(known, tolerance), _FLOOR)}))
        terms.append(Zero(label))
    if isinstance(arm.links, Links) and arm.links.p3:
        terms.append(CouplingInertia(tolerance=max(arm.tolerances.link_inertia, _FLOOR)))
    if untold > 0.0:
        late = {'delay': _LATE * untold / REACH}
        terms += [_term(arm, _LATENESS.name, label, late) for label in arm.labels]
    for label, varies in (sensors or {}).items():
        terms += [SensorError(label, _SENSOR + number, tolerance) for number, tolerance in (
            ('zero', varies), ('gain', _ANY_GAIN if label in unscaled else SENSOR_GAIN),
            ('lag', _SENSOR_LAG),
            ('blur', _SENSOR_LAG ** 2))]
    return *terms, *_carried(arm)


def _floor(tolerance: str) -> float:
    """Return the least of a tolerance; what an arm file need not tolerate has none."""
    return _FLOOR if Tolerances.declaration(tolerance).default > 0.0 else 0.0


def _carried(arm: Arm) -> Iterator[Term]:
    """Yield what an arm is stated to carry: each of its numbers is known to a share."""
    for kind, size, tolerance in _OF_ARM:
        effect = arm.effect(kind.name)
        known = max(getattr(arm.tolerances, tolerance), _FLOOR)
        stated = {rule.name: known * abs(value) for rule in kind.declarations()
                  if (value := getattr(effect, rule.name))}
        if size in stated:
            yield _term(arm, kind.name, None, stated)


def is_of_log(term: AnyTerm) -> bool:
    """Return whether what is tolerated is of the recording, and no property of the arm."""
    return isinstance(term, (Zero, SensorError)) or term.name == _LATENESS.name


def link_tolerances(arm: Arm, joint: str) -> dict[str, float]:
    """Return how well the numbers of a joint's link are known, by name; none without links."""
    usual = arm.tolerances_of(joint).link_inertia
    if not isinstance(arm.links, ChainLinks):
        return {} if arm.links is None else {'error': max(usual, _FLOOR)}
    known = arm.links.known(usual)[arm.labels.index(joint)]
    centre = {f'centre_{axis}': known.centre for axis in 'xyz'} if known.centre > 0.0 else {}
    return {'error': max(known.inertia, _FLOOR), 'mass': max(known.mass, _FLOOR), **centre}


def _term(arm: Arm, name: str, joint: str | None, known: Mapping[str, float]) -> Term:
    return Term(arm.effect(name, joint), joint, tuple(
        Identity((number,), deviation, deviation) for number, deviation in known.items()))
