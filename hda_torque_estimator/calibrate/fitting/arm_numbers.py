"""What a fit found, as the numbers of an arm file with 90 % intervals and their origin."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
import math

from hda_arm_sim.model.arm import Arm
import numpy as np

from .bounds import declaration, entered
from .fit import Fit
from .terms import Term
from ...significance import NORMAL_90

# Choices unless told otherwise.
DOUBTFUL = 3.0                  # sigmas from what was known before
STEP = 1e-3                     # of a sigma, for the slopes of numbers over unknowns
LEAST = 0.2                     # of a tolerance, that a calibration leaves: arms change

_KNOWN_BY = {
    'stiffness': ('torsion.flexspline_stiffness',), 'torsion_zero': ('link_encoder.zero',),
    'clock_skew': ('clock_skew.skew',),
    'kinematic_error': tuple(f'kinematic_error.amplitude_{n}' for n in (1, 2, 4)),
    'eccentricity': tuple(f'link_encoder_eccentricity.amplitude_{n}' for n in (1, 2))}


@dataclass(frozen=True)
class Number:
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
    def remark(self) -> str:
        """Return what must be known of the number before it is believed, '' for nothing."""
        return ', at its bound: the arm file takes none beyond it' if self.at_bound else ''


def number(name: str, value: float, sigma: float) -> Number:
    """Return a number and its interval, both within what the arm file takes."""
    rule = declaration(name)
    low, middle, high = (float(np.clip(value + sign * NORMAL_90 * sigma, rule.low, rule.high))
                         for sign in (-1.0, 0.0, 1.0))
    return Number(name, middle, low, high, rule.unit, middle in (rule.low, rule.high))


def numbers(terms: Sequence[Term], found: Fit) -> list[Number]:
    """Return the numbers of the arm file with intervals, to first order in the unknowns."""
    found_numbers, first = [], 0
    for term in terms:
        part = slice(first, first := first + len(term.unknowns))
        values, covariance = found.values[part], found.covariance[part, part]
        slopes = {name: np.zeros(len(values)) for name in term.meant(values)}
        for place, sigma in enumerate(np.sqrt(np.diag(covariance))):
            moved = values + STEP * sigma * np.eye(len(values))[place]
            for name, value in term.meant(moved).items():
                slopes[name][place] = (value - term.meant(values)[name]) / (STEP * sigma)
        for name, value in term.numbers(values).items():
            sigma = float(np.sqrt(slopes[name] @ covariance @ slopes[name]))
            found_numbers.append(number(name, value, sigma))
    return found_numbers


def zero(arm: Arm, found: Fit) -> Number:
    """Return the mean zero of the link encoder; its interval is that of the recordings."""
    zeros = np.array([part.zero for part in found.balanced]) + arm.joints[0].link_encoder.zero
    return number('link_encoder.zero', float(zeros.mean()), float(zeros.std()))


def rest(error: float, parts: int) -> Number:
    """Return an rms error over so many independent parts as what the law leaves [N*m]."""
    return number('torsion.deviation', error, error / math.sqrt(2.0 * parts))


def with_numbers(arm: Arm, label: str, found: Sequence[Number], source: str) -> Arm:
    """Return the arm with the numbers of a joint, and in its provenance their source."""
    arm = entered(arm, label, {number.name: number.value for number in found})
    origins = {f'{label}.{number.name}': f'{number.low:.4g} .. {number.high:.4g} {number.unit} '
               f'(90 %){number.remark}, from {source}' for number in found}
    return replace(arm, provenance=tuple({**dict(arm.provenance), **origins}.items()))


def with_tolerances(arm: Arm, found: Mapping[str, Sequence[Number]]) -> Arm:
    """
    Return the arm with its torsion as well known as the numbers that were found of every joint.

    A tolerance holds for all joints, so the least sure one counts. Where a joint has no number
    of its own, and where the numbers are less sure than was known, it stays.
    """
    if set(found) != set(arm.labels):
        return arm
    known, origins = {}, dict(arm.provenance)
    for name, kinds in _KNOWN_BY.items():
        sigmas = [[_sigma(number, name) for number in numbers if number.name in kinds]
                  for numbers in found.values()]
        before = getattr(arm.tolerances, name)
        if all(sigmas) and (most := max(map(max, sigmas))) < before:
            known[name] = max(most, LEAST * before)
            origins[f'tolerances.{name}'] = f'calibrated, {most:.2g} at most; {before:g} before'
    return replace(arm, tolerances=replace(arm.tolerances, **known),
                   provenance=tuple(origins.items()))


def _sigma(number: Number, tolerance: str) -> float:
    """Return the deviation of a number, relative where its tolerance is."""
    whole = abs(number.value) if tolerance == 'stiffness' else 1.0
    return (number.high - number.low) / (2.0 * NORMAL_90 * whole)


def doubtful(terms: Sequence[Term], found: Fit) -> tuple[str, ...]:
    """Return the numbers that are further from what was known than its spread admits."""
    names, first = [], 0
    for term in terms:
        part = slice(first, first := first + len(term.unknowns))
        if np.abs(found.moved[part]).max() > DOUBTFUL:
            names += list(term.numbers(found.values[part]))
    return tuple(names)
