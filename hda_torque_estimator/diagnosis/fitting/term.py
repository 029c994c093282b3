"""
A term: one effect at one place, with the numbers that a fit may change.

Amplitude and phase of a wave are fitted as its two components, in which the arm is linear; all
other numbers as they are.
"""

from dataclasses import dataclass, replace
import math

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import Effect
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Place = tuple[str, str | None]        # an effect and its joint, None for the whole arm
# Choices unless told otherwise.
_TO_BOUND = 0.7         # share of the way to a bound that a step may take


@dataclass(frozen=True)
class Term:
    """
    An effect with free numbers, each with its usual step and, for a nuisance, its tolerance.

    `waves` are pairs (amplitude, phase) by their names. `tolerances` are standard deviations
    about the nominal value, one for each free number, infinite where nothing is known. `least`
    are bounds by the arm, one for each free number, where the law would clip it unseen.
    """

    effect: Effect
    joint: str | None
    free: tuple[str, ...] = ()
    steps: tuple[float, ...] = ()
    waves: tuple[tuple[str, str], ...] = ()
    wave_steps: tuple[float, ...] = ()
    tolerances: tuple[float, ...] = ()
    least: tuple[float, ...] = ()
    grown: bool = False             # whether the first number has a size to start from already

    @property
    def name(self) -> str:
        """Return the catalogue name of the effect."""
        return self.effect.name

    @property
    def place(self) -> Place:
        """Return what tells a term from all others of a fit."""
        return self.name, self.joint

    @property
    def size(self) -> int:
        """Return the number of free numbers."""
        return len(self.free) + 2 * len(self.waves)

    def all_steps(self) -> Array:
        """Return the step of every free number, for finite differences."""
        return np.array([*self.steps, *np.repeat(self.wave_steps, 2)])

    def deviations(self) -> Array:
        """Return the tolerance of every free number, infinite if there is none."""
        return np.array(self.tolerances) if self.tolerances else np.full(self.size, np.inf)

    def vector(self) -> Array:
        """Return the free numbers as they stand."""
        plain = [getattr(self.effect, name) for name in self.free]
        parts = [part for amplitude, phase in self.waves for part in _parts(
            getattr(self.effect, amplitude), getattr(self.effect, phase))]
        return np.array(plain + parts)

    def at(self, vector: Array) -> 'Term':
        """Return the term with other free numbers, kept within their declared bounds."""
        values = dict(zip(self.free, vector))
        for (amplitude, phase), pair in zip(self.waves, vector[len(self.free):].reshape(-1, 2)):
            values[amplitude] = math.hypot(*pair)
            values[phase] = math.atan2(pair[1], pair[0])
        kind = type(self.effect)
        bounded = {name: min(max(float(value), kind.declaration(name).low),
                             kind.declaration(name).high) for name, value in values.items()}
        return replace(self, effect=replace(self.effect, **bounded))

    def moved(self, step: Array) -> 'Term':
        """Return the term a step on, but no more than most of the way to a bound by the arm."""
        return self.at(self.short_of_bounds(self.vector() + step))

    def short_of_bounds(self, vector: Array) -> Array:
        """Return other free numbers, or those most of the way to a bound by the arm."""
        bounds = np.full(self.size, -math.inf)
        bounds[:len(self.least)] = self.least
        now = self.vector()
        return np.maximum(vector, now + _TO_BOUND * (bounds - now))

    def on(self, arm: Arm) -> Arm:
        """Return the arm with this effect."""
        return arm.with_effect(self.effect, self.joint)


def _parts(amplitude: float, phase: float) -> tuple[float, float]:
    """Return the components of a sin(x + phase): along sin and along cos."""
    return amplitude * math.cos(phase), amplitude * math.sin(phase)
