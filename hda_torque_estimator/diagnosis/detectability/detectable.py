"""
The smallest size of every effect that a recording could have shown.

Every effect is tried with the shapes in which it is looked for; the smallest size of all is
stated. Of waves it is that of the phase that shows least, and of a base that of the mode that
does. What would not show within the bounds that are declared for an effect, this motion cannot
show.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
import math
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import effect_named
import numpy as np

from .effect_shapes import AT_LEAST_SEEN, shapes
from .visibility import Imagined, Visibility
from ..findings.smallest import hidden, places, size_numbers, Smallest, WEAKER
from ..fitting.derivatives import IMPOSSIBLE
from ..fitting.fit import Fit, Fitter
from ..judging.null_distribution import Chances
from ..judging.screening import shifts
from ..judging.search import SearchResult
from ...least_squares.term import Term

# Numerics; choices unless stated otherwise.
_BEYOND = 3.0           # values that were tried, to which lines through them go on


class SizeAboveBar(NamedTuple):
    """A value of a number, and how far above what is needed an effect of it is."""

    value: float
    strength: float


def smallest_in_balances(fitter: Fitter, found: SearchResult, fit: Fit,
                         names: Sequence[str]) -> Iterator[Smallest]:
    """Yield the smallest size of each effect and place that shows beside what `fit` knows."""
    coarse = replace(fitter, balancer=fitter.balancer.thinned)
    sight = Visibility(coarse, found, coarse.at(fit.terms, len(fit.accepted), fit.slopes))
    chances = Chances(fitter.healthy)
    for name in names:
        yield from _of_effect(sight, chances, name)


def _of_effect(sight: Visibility, chances: Chances, name: str) -> Iterator[Smallest]:
    """Yield the smallest size of one effect at every place."""
    arm = sight.fitter.on(sight.fit.terms)
    sizes: dict[str | None, list[Smallest]] = {place: [] for place in places(arm, name)}
    points: dict[str | None, list[SizeAboveBar]] = {place: [] for place in sizes}
    for start, seen in _shifts(sight, chances, arm, name):
        if start.grown:
            points[start.joint].append(SizeAboveBar(start.vector()[0],
                                                    sight.strength(start, seen)))
        else:
            sizes[start.joint] += [*_in_steps(sight, arm, start, seen)] or [
                hidden(name, start.joint)]
    chosen = max if name in AT_LEAST_SEEN else min
    for place, grown in points.items():
        tried = [*sizes[place], *_between(arm, name, place, grown)]
        yield chosen(tried, key=lambda one: math.inf if one.size is None else one.size,
                     default=hidden(name, place))


def _shifts(sight: Visibility, chances: Chances, arm: Arm,
            name: str) -> list[tuple[Term, Imagined]]:
    """Return the shapes of one effect and what they change, none where no arm can have it."""
    try:
        found = list(shifts(sight.fitter, sight.fit, list(shapes(sight.fitter, arm, name))))
    except IMPOSSIBLE:
        return []
    return [(start, Imagined(shift, chance))
            for (start, shift), chance in zip(found, chances.of([start for start, _ in found]))]


def _in_steps(sight: Visibility, arm: Arm, start: Term, seen: Imagined) -> Iterator[Smallest]:
    """Return the smallest sizes of numbers in which the residuals are linear."""
    steps, width = start.all_steps(), 1 if start.free else 2
    for place, number in enumerate(start.free[:1] or [number for number, _ in start.waves]):
        rule = effect_named(start.name).declaration(number)
        now = getattr(arm.effect(start.name, start.joint), number)
        step = float(steps[width * place])
        most = max(rule.high - now, now - rule.low) / step
        own = seen._replace(shift=seen.shift[:, :, width * place:width * (place + 1)])
        share = sight.least(start, own, most)
        if share < most:
            yield Smallest(start.name, start.joint, number, share * step)


def _between(arm: Arm, name: str, place: str | None,
             points: Sequence[SizeAboveBar]) -> Iterator[Smallest]:
    """Return the sizes at which the strengths of an effect, found at some values, pass 1."""
    number = size_numbers(name)[0]
    rule, now = effect_named(name).declaration(number), getattr(arm.effect(name, place), number)
    value = np.array([point.value for point in points])
    above = np.sqrt(np.maximum([point.strength for point in points], 0.0))
    if name in WEAKER:
        size = -_passing(-np.log(value), above)     # its logarithm: a line may pass anywhere
        if math.log(value.min() / _BEYOND) < size < math.log(_BEYOND * value.max()):
            yield Smallest(name, place, number, math.exp(size))
        return
    for side in (1.0, -1.0):
        away = side * (value - now)
        ahead = away > 0.0
        size = _passing(np.append(away[ahead], 0.0), np.append(above[ahead], 0.0))
        if rule.low <= now + side * size <= rule.high:
            yield Smallest(name, place, number, size)


def _passing(places: Array, heights: Array) -> float:
    """Return where a line through points, which rises and goes on straight, passes 1."""
    order = np.argsort(places)
    places, heights = places[order], heights[order]
    if len(places) < 2 or heights[-1] <= 0.0:
        return math.inf
    last = min(max(int(np.searchsorted(heights, 1.0)), 1), len(places) - 1)
    rise = heights[last] - heights[last - 1]
    run = places[last] - places[last - 1]
    return float(places[last] + (1.0 - heights[last]) * run / rise) if rise > 0.0 else math.inf
