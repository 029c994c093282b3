"""What a fit found, as the numbers of an arm file with 90 % intervals and their origin."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
import math

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import EFFECTS
from hda_arm_sim.model.effects.catalogue import unmeasured_at
from hda_arm_sim.model.effects.place import MESH, MOTOR_INERTIA
from hda_arm_sim.model.parts import Tolerances
import numpy as np
from numpy.typing import NDArray

from ...least_squares.bounds import declaration, entered
from ...least_squares.descent import Minimum, places
from ...least_squares.term import Term
from ...significance import NORMAL_90

Floats = NDArray[np.float64]

# Choices unless stated otherwise.
DOUBTFUL = 3.0                  # sigmas from what was known before
STEP = 1e-3                     # of a sigma, for the slopes of numbers over unknowns
NOTHING = 1e-12             # of a number, to have a share of
LEAST = 0.2                     # of a tolerance, that a calibration leaves: arms change

# Numbers of a joint by the tolerance that they replace.
_KNOWN_BY = {
    'stiffness': ('torsion.flexspline_stiffness',), 'torsion_zero': ('link_encoder.zero',),
    'motor_inertia': (f'{unmeasured_at(MOTOR_INERTIA).name}.error',),
    **{known.tolerance: tuple(f'{effect.name}.{number}' for number in known.numbers)
       for effect in EFFECTS if (known := effect.known_by)}}
_OF_LOAD = f'{unmeasured_at(MESH).name}.coefficient'
(LEVEL,), (SLOPE,), (GAIN,), (OFFSET,), (ZERO,) = (_KNOWN_BY[tolerance] for tolerance in (
    'dry_friction', 'viscous_friction', 'torque_constant', 'drive_offset', 'torsion_zero'))


@dataclass(frozen=True)
class ArmNumber:
    """One number of the new arm file with its 90 % interval; `at_bound` is no real finding."""

    name: str
    value: float
    low: float
    high: float
    unit: str
    at_bound: bool = False

    def __str__(self) -> str:
        """Return the number as a line of a report."""
        return (f'{self.name} = {self.value:.4g} {self.unit} '
                f'({self.low:.4g} .. {self.high:.4g}){self.remark}')

    @property
    def sigma(self) -> float:
        """Return one sigma; a bound cuts an interval on one side only."""
        return max(self.high - self.value, self.value - self.low) / NORMAL_90

    @property
    def remark(self) -> str:
        """Return what must be known of the number before it is believed, '' for nothing."""
        return ', at its bound: the arm file takes none beyond it' if self.at_bound else ''


def number(name: str, value: float, sigma: float) -> ArmNumber:
    """Return a number and its interval, both within what the arm file takes."""
    rule = declaration(name)
    low, middle, high = (float(np.clip(value + sign * NORMAL_90 * sigma, rule.low, rule.high))
                         for sign in (-1.0, 0.0, 1.0))
    return ArmNumber(name, middle, low, high, rule.unit, middle in (rule.low, rule.high))


def numbers(found: Minimum, covariance: Floats) -> list[ArmNumber]:
    """
    Return the numbers of the terms of a fit with intervals, to first order in the unknowns.

    `covariance` (p, p) is that of the unknowns in sigmas from what was known.
    """
    found_numbers: list[ArmNumber] = []
    for term, place in zip(found.terms, places(found.terms)):
        known = term.deviations()
        values = term.vector() + known * found.scaled[place]
        found_numbers += _of_term(term, values, covariance[place, place] * np.outer(known, known))
    return found_numbers


def _of_term(term: Term, values: Floats, covariance: Floats) -> list[ArmNumber]:
    """Return the numbers of a term at values of its unknowns (p,), with their intervals."""
    middle = term.meant(values)
    slopes = {name: np.zeros(len(values)) for name in middle}
    for place, sigma in enumerate(np.sqrt(np.diag(covariance))):
        moved = values + STEP * sigma * np.eye(len(values))[place]
        for name, value in term.meant(moved).items():
            slopes[name][place] = (value - middle[name]) / (STEP * sigma)
    there = term.at(values)
    return [number(f'{term.name}.{name}', getattr(there.effect, name),
                   float(np.sqrt(slope @ covariance @ slope)) if (
                       slope := slopes.get(name)) is not None else 0.0)
            for name in term.own or tuple(middle)]


def rest(error: float, parts: int, name: str = 'torsion.deviation') -> ArmNumber:
    """Return an rms error over so many independent parts as what the law leaves [N*m]."""
    return number(name, error, error / math.sqrt(2.0 * parts))


def with_numbers(arm: Arm, label: str, found: Sequence[ArmNumber], source: str) -> Arm:
    """Return the arm with the numbers of a joint, and in its provenance their source."""
    arm = entered(arm, label, {number.name: number.value for number in found})
    origins = {f'{label}.{number.name}': f'{number.low:.4g} .. {number.high:.4g} {number.unit} '
               f'(90 %){number.remark}, from {source}' for number in found}
    return replace(arm, provenance=tuple({**dict(arm.provenance), **origins}.items()))


def with_tolerances(arm: Arm, found: Mapping[str, Sequence[ArmNumber]], *,
                    wider: bool = False) -> Arm:
    """
    Return the arm with each joint as well known as the numbers that were found of it.

    What no number of a joint determines stays as wide as it was. With `wider` a tolerance grows
    where numbers are less sure than was known, else it stays.
    """
    origins, joints = dict(arm.provenance), []
    for joint in arm.joints:
        before = arm.tolerances_of(joint.label)
        known = _known(before, found.get(joint.label, ()), wider=wider)
        origins |= {f'tolerances.{joint.label}.{name}': f'calibrated; {getattr(before, name):g} '
                    'before' for name in known}
        joints.append(replace(joint, tolerances=replace(before, **known)) if known else joint)
    return replace(arm, joints=tuple(joints), provenance=tuple(origins.items()))


def of_all_friction(found: Sequence[ArmNumber], load: float) -> tuple[ArmNumber, ...]:
    """
    Return numbers of which the dry level holds all dry friction there is under a load [N*m motor].

    Its interval stays. A tolerance of dry friction is a share of all that resists. Under a load a
    mesh may resist far more than all else.
    """
    of_load = sum(load * one.value for one in found if one.name == _OF_LOAD)
    return tuple(number(one.name, one.value + of_load, one.sigma)
                 if one.name == LEVEL else one for one in found)


def _known(before: Tolerances, found: Sequence[ArmNumber], *, wider: bool) -> dict[str, float]:
    """Return the tolerances of one joint that its numbers change, by their names."""
    known = {}
    for name, kinds in _KNOWN_BY.items():
        sigmas = [_sigma(number, name) for number in found if number.name in kinds]
        if not sigmas or name == 'motor_inertia' and before.motor_inertia == 0.0:
            continue
        most, now = min(max(sigmas), Tolerances.declaration(name).high), getattr(before, name)
        if most < now or wider:
            known[name] = max(most, LEAST * now)
    return known


def _sigma(number: ArmNumber, tolerance: str) -> float:
    """Return the deviation of a number, relative where its tolerance is."""
    relative = number.unit != Tolerances.declaration(tolerance).unit
    whole = abs(number.value) if relative else 1.0
    return number.sigma / max(whole, NOTHING)


def doubtful(found: Minimum) -> tuple[str, ...]:
    """Return the numbers that are further from what was known than its spread admits."""
    return tuple(name for term, place in zip(found.terms, places(found.terms))
                 if np.abs(found.scaled[place]).max() > DOUBTFUL
                 for name in term.numbers())
