"""
Charts: the unknowns that a fit likes, and the numbers of an arm that they make.

A fit moves plain numbers as they are, and sizes along their logarithm. A wave it moves along its
sine and cosine parts, in which an arm is linear.
"""

from collections.abc import Sequence
from dataclasses import dataclass
import math
from typing import Any

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.parameter import Declared
import numpy as np


@dataclass(frozen=True)
class Chart:
    """
    Numbers of one owner, by name, and what is known of each of their unknowns.

    `step` is the usual change of an unknown. `prior` is one sigma of what is known before. A
    search ends at `low` and `high`. It begins at `start`, or where the number stands if that is
    None.
    """

    names: tuple[str, ...]
    step: float
    prior: float = math.inf
    low: float = -math.inf
    high: float = math.inf
    start: float | None = None

    @property
    def size(self) -> int:
        """Return the number of unknowns."""
        return len(self.names)

    @property
    def plain(self) -> tuple[str, ...]:
        """Return the names of the numbers that are looked for one by one."""
        return self.names[:1]

    def deviations(self, owner: Any, covariance: Array) -> Array:
        """Return how unsure the plain numbers of an owner are, by the unknowns' covariance."""
        return np.sqrt(np.maximum(np.diag(covariance), 0.0))

    def ends(self, owner: Any, name: str, reach: float) -> tuple[float, float]:
        """Return a plain number of an owner less and more a reach."""
        value = getattr(owner, name)
        return value - reach, value + reach

    def declared(self, kind: type[Declared]) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Return between which unknowns a kind of owner can be: all that are no plain size."""
        return (-math.inf,) * self.size, (math.inf,) * self.size

    def unknowns(self, owner: Any) -> tuple[float, ...]:
        """Return the unknowns that make the numbers of an owner."""
        raise NotImplementedError

    def numbers(self, unknowns: Sequence[float]) -> dict[str, float]:
        """Return the numbers that unknowns make, in bounds or not."""
        raise NotImplementedError


@dataclass(frozen=True)
class Identity(Chart):
    """A number as it is."""

    def declared(self, kind: type[Declared]) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Return the bounds of the number."""
        rule = kind.declaration(self.names[0])
        return (rule.low,), (rule.high,)

    def unknowns(self, owner: Any) -> tuple[float, ...]:
        """Return the number."""
        return (getattr(owner, self.names[0]),)

    def numbers(self, unknowns: Sequence[float]) -> dict[str, float]:
        """Return the number by its name."""
        return {self.names[0]: float(unknowns[0])}


@dataclass(frozen=True)
class CarriedMoments(Chart):
    """
    Mass, centre and radius of gyration of a body, as the moments in which an arm is linear.

    They are mass, mass times each number of the centre, and inertia about where the centre is
    zero. The first name is the mass, the last the radius. A body without mass has no centre and
    no radius.
    """

    @property
    def plain(self) -> tuple[str, ...]:
        """Return the names of all numbers."""
        return self.names

    def declared(self, kind: type[Declared]) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Return that mass and inertia are not negative; a moment may have any sign."""
        low = np.full(self.size, -math.inf)
        low[[0, -1]] = 0.0
        return tuple(low.tolist()), (math.inf,) * self.size

    def unknowns(self, owner: Any) -> tuple[float, ...]:
        """Return the moments."""
        mass, *centre, radius = (getattr(owner, name) for name in self.names)
        away = sum(number * number for number in centre)
        return mass, *(mass * number for number in centre), mass * (radius * radius + away)

    def numbers(self, unknowns: Sequence[float]) -> dict[str, float]:
        """Return the numbers by their names, no radius where the inertia is too small for one."""
        mass, *moments, inertia = map(float, unknowns)
        per = 1.0 / mass if mass > 0.0 else 0.0
        centre = [per * moment for moment in moments]
        away = sum(number * number for number in centre)
        return dict(zip(self.names, (mass, *centre, math.sqrt(max(per * inertia - away, 0.0)))))

    def deviations(self, owner: Any, covariance: Array) -> Array:
        """Return how unsure the numbers are, of the radius its square, by that of the moments."""
        mass, *numbers, radius = (getattr(owner, name) for name in self.names)
        per, centre = 1.0 / mass if mass > 0.0 else 0.0, np.array(numbers)
        slopes = per * np.eye(self.size)
        slopes[1:-1, 0] = -per * centre
        slopes[-1, :-1] = per * np.array([centre @ centre - radius * radius, *(-2.0 * centre)])
        slopes[0, 0] = 1.0
        return super().deviations(owner, slopes @ covariance @ slopes.T)

    def ends(self, owner: Any, name: str, reach: float) -> tuple[float, float]:
        """Return a number less and more a reach, which is that of the square of a radius."""
        value = getattr(owner, name)
        if name != self.names[-1]:
            return value - reach, value + reach
        return math.sqrt(max(value * value - reach, 0.0)), math.sqrt(value * value + reach)


@dataclass(frozen=True)
class Logarithm(Chart):
    """A size above zero, as the logarithm of its ratio to the size `about`."""

    about: float = 1.0

    def unknowns(self, owner: Any) -> tuple[float, ...]:
        """Return the logarithm of the ratio."""
        return (math.log(getattr(owner, self.names[0]) / self.about),)

    def numbers(self, unknowns: Sequence[float]) -> dict[str, float]:
        """Return the size by its name."""
        return {self.names[0]: self.about * math.exp(unknowns[0])}


@dataclass(frozen=True)
class Chords(Chart):
    """Stiffnesses of straight segments: the logarithm of all together, and of those beyond."""

    about: tuple[float, ...] = ()

    @property
    def size(self) -> int:
        """Return the number of unknowns, however many segments there are."""
        return 2

    def unknowns(self, owner: Any) -> tuple[float, ...]:
        """Return the logarithms of two ratios: of the first segment, and of others over it."""
        first, beyond = (math.log(getattr(owner, name) / size)
                         for name, size in zip(self.names[:2], self.about))
        return first, beyond - first

    def numbers(self, unknowns: Sequence[float]) -> dict[str, float]:
        """Return the stiffnesses by their names."""
        first, beyond = math.exp(unknowns[0]), math.exp(unknowns[0] + unknowns[1])
        return {name: size * (beyond if place else first)
                for place, (name, size) in enumerate(zip(self.names, self.about))}


@dataclass(frozen=True)
class Factor(Chart):
    """The relative error of a number, as the logarithm of the factor that it makes."""

    def unknowns(self, owner: Any) -> tuple[float, ...]:
        """Return the logarithm of the factor."""
        return (math.log(1.0 + getattr(owner, self.names[0])),)

    def numbers(self, unknowns: Sequence[float]) -> dict[str, float]:
        """Return the relative error by its name."""
        return {self.names[0]: math.expm1(unknowns[0])}


@dataclass(frozen=True)
class WaveParts(Chart):
    """Amplitude and phase of a sin(x + phase), as its parts along sine and cosine."""

    def unknowns(self, owner: Any) -> tuple[float, ...]:
        """Return both parts."""
        amplitude, phase = (getattr(owner, name) for name in self.names)
        return amplitude * math.cos(phase), amplitude * math.sin(phase)

    def numbers(self, unknowns: Sequence[float]) -> dict[str, float]:
        """Return amplitude and phase by their names."""
        amplitude, phase = self.names
        return {amplitude: math.hypot(*unknowns), phase: math.atan2(unknowns[1], unknowns[0])}
