"""
Charts: the unknowns that a fit likes, and the numbers of an arm that they make.

A fit moves plain numbers as they are, and sizes along their logarithm. A wave it moves along its
sine and cosine parts, in which an arm is linear.
"""

from collections.abc import Sequence
from dataclasses import dataclass
import math
from typing import Any


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

    def unknowns(self, owner: Any) -> tuple[float, ...]:
        """Return the unknowns that make the numbers of an owner."""
        raise NotImplementedError

    def numbers(self, unknowns: Sequence[float]) -> dict[str, float]:
        """Return the numbers that unknowns make, in bounds or not."""
        raise NotImplementedError


@dataclass(frozen=True)
class Identity(Chart):
    """A number as it is."""

    def unknowns(self, owner: Any) -> tuple[float, ...]:
        """Return the number."""
        return (getattr(owner, self.names[0]),)

    def numbers(self, unknowns: Sequence[float]) -> dict[str, float]:
        """Return the number by its name."""
        return {self.names[0]: float(unknowns[0])}


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
