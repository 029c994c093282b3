"""
A term: an effect or a part of an arm at one place, with charts of the numbers that a fit may move.

Calibration and diagnosis fit the same terms. Bounds of every number are those of its declaration.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import chain
import math
from typing import Any, Protocol, runtime_checkable

from hda_arm_sim.foundation.arrays import Array, fixed
from hda_arm_sim.foundation.parameter import Declared
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import Effect
from hda_arm_sim.model.parts import Joint
import numpy as np

from .bounds import bounded, entered, Placing
from .charts import Chart, Identity, WaveParts

Place = tuple[str, str | None]        # an effect and its joint, None for the whole arm
# Choices unless stated otherwise.
_TO_BOUND = 0.7         # share of the way to a bound that a step may take
_MOST_CHARTS = 1024     # of terms, that are known at most


@dataclass(frozen=True)
class Term:
    """
    An effect or a part of a joint as it stands, and charts of its free numbers.

    `part` names what is no effect (`torsion`, `link_encoder`). `own` are the numbers that belong
    to the term where it shares its effect with others; none means all of them.
    """

    effect: Any
    joint: str | None
    charts: tuple[Chart, ...] = ()
    part: str = ''
    own: tuple[str, ...] = ()
    grown: bool = False             # whether the first number has a size to start from already

    @property
    def name(self) -> str:
        """Return the catalogue name of the effect, or that of the part."""
        return self.part or self.effect.name

    @property
    def place(self) -> Place:
        """Return what distinguishes a term from all others of a fit."""
        return self.name, self.joint

    @cached_property
    def size(self) -> int:
        """Return the number of unknowns."""
        return sum(chart.size for chart in self.charts)

    @cached_property
    def freedom(self) -> int:
        """Return the number of unknowns of which nothing is known."""
        return int(np.isinf(self.deviations()).sum())

    @property
    def free(self) -> tuple[str, ...]:
        """Return the numbers that are no waves."""
        return tuple(name for chart in self.charts if not isinstance(chart, WaveParts)
                     for name in chart.plain)

    @property
    def sought(self) -> tuple[str, ...]:
        """Return the numbers that are no waves and have no tolerance."""
        return tuple(name for chart in self.charts if not isinstance(chart, WaveParts)
                     and math.isinf(chart.prior) for name in chart.plain)

    @property
    def waves(self) -> tuple[tuple[str, ...], ...]:
        """Return the names of amplitude and phase of every wave."""
        return tuple(chart.names for chart in self.charts if isinstance(chart, WaveParts))

    def all_steps(self) -> Array:
        """Return the usual step of every unknown, to be read only."""
        return self._known['step']

    def deviations(self) -> Array:
        """Return one sigma of what is known of every unknown, infinite for nothing (read only)."""
        return self._known['prior']

    def bounds(self) -> tuple[Array, Array]:
        """Return where a search of every unknown ends, to be read only."""
        return self._known['low'], self._known['high']

    def declared(self) -> tuple[Array, Array]:
        """Return between which unknowns an arm can have the term."""
        ends = [chart.declared(type(self.effect)) for chart in self.charts]
        return (np.array([*chain.from_iterable(low for low, _ in ends)]),
                np.array([*chain.from_iterable(high for _, high in ends)]))

    @cached_property
    def _known(self) -> dict[str, Array]:       # a fit asks for it at every step
        return _of_charts(self.charts)

    def vector(self) -> Array:
        """Return the unknowns as they stand."""
        return self._vector.copy()

    @cached_property
    def _vector(self) -> Array:
        return fixed([unknown for chart in self.charts for unknown in chart.unknowns(self.effect)])

    def start(self) -> Array:
        """Return the unknowns where a search begins."""
        return np.array([unknown if chart.start is None else chart.start for chart in self.charts
                         for unknown in chart.unknowns(self.effect)])

    def meant(self, vector: Array) -> dict[str, float]:
        """Return the numbers that unknowns stand for, by name, in bounds or not."""
        return {name: value for chart, part in self._parts(vector)
                for name, value in chart.numbers(part.tolist()).items()}

    def _parts(self, vector: Array) -> Iterator[tuple[Chart, Array]]:
        first = 0
        for chart in self.charts:
            yield chart, vector[first:first + chart.size]
            first += chart.size

    def at(self, vector: Array) -> 'Term':
        """Return the term with other unknowns, its numbers kept within their declared bounds."""
        kind: type[Declared] = type(self.effect)
        return replace(self, effect=replace(self.effect, **bounded(kind, self.meant(vector))))

    def moved(self, step: Array) -> 'Term':
        """Return the term a step on, but no more than most of the way to a bound of the search."""
        return self.at(self.short_of_bounds(self.vector() + step))

    def short_of_bounds(self, vector: Array) -> Array:
        """Return other unknowns, or those most of the way to the lower bound of the search."""
        now = self.vector()
        return np.maximum(vector, now + _TO_BOUND * (self.bounds()[0] - now))

    def deviations_of_free(self, covariance: Array) -> dict[str, float]:
        """Return how unsure each free number is, by the covariance (p, p) of the unknowns."""
        first = 0
        found: dict[str, float] = {}
        for chart in self.charts:
            own = slice(first, first + chart.size)
            if not isinstance(chart, WaveParts):
                found |= dict(zip(chart.plain, chart.deviations(
                    self.effect, covariance[own, own]).tolist()))
            first += chart.size
        return found

    def interval(self, number: str, reach: float) -> tuple[float, float]:
        """Return a free number at both ends of a reach."""
        chart, = (chart for chart in self.charts if number in chart.plain)
        return chart.ends(self.effect, number, reach)

    def numbers(self) -> dict[str, float]:
        """Return the numbers that are the term's, by their names in an arm file."""
        names = self.own or tuple(name for chart in self.charts for name in chart.names)
        return {f'{self.name}.{name}': getattr(self.effect, name) for name in names}

    @property
    def is_whole(self) -> bool:
        """Return whether the term is an effect with all of its numbers."""
        return isinstance(self.effect, Effect) and not self.own

    def on(self, arm: Arm) -> Arm:
        """Return the arm with this term."""
        if self.is_whole:
            return arm.with_effect(self.effect, self.joint)
        return entered(arm, str(self.joint), self.numbers())


@lru_cache(_MOST_CHARTS)
def _of_charts(charts: tuple[Chart, ...]) -> dict[str, Array]:
    """Return steps, priors and bounds of all unknowns; a term that moves keeps its charts."""
    return {what: fixed([getattr(chart, what) for chart in charts for _ in range(chart.size)])
            for what in ('step', 'prior', 'low', 'high')}


@runtime_checkable
class OfJoint(Protocol):
    """What has the shape of a term, and is a number of one joint."""

    joint: str

    def on_joint(self, joint: Joint) -> Joint:
        """Return the joint with this number."""


def with_terms(arm: Arm, terms: Iterable[Any]) -> Arm:
    """
    Return the arm with all of these terms, or of what has their shape.

    Whole effects and numbers of joints are placed at once: every arm is checked, and a fit makes
    thousands of them.
    """
    made = Placing(arm)
    numbers: dict[str, dict[str, float]] = {}
    others = []
    for term in terms:
        if isinstance(term, Term) and term.is_whole:
            made.place(term.effect, term.joint)
        elif isinstance(term, Term):
            numbers.setdefault(str(term.joint), {}).update(term.numbers())
        elif isinstance(term, OfJoint):
            made.alter(term.joint, term.on_joint)
        else:
            others.append(term)
    for label, found in numbers.items():
        made.enter(label, found)
    arm = made.arm()
    for term in others:
        arm = term.on(arm)
    return arm


def looked_for(effect: Effect, joint: str | None, free: Mapping[str, float],
               waves: Mapping[tuple[str, str], float], least: Mapping[str, float],
               *, grown: bool = False) -> Term:
    """Return the term of an effect of which plain numbers and waves are looked for, by steps."""
    charts: list[Chart] = [Identity((name,), step, low=least.get(name, -np.inf))
                           for name, step in free.items()]
    charts += [WaveParts(names, step) for names, step in waves.items()]
    return Term(effect, joint, tuple(charts), grown=grown)
