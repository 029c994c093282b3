"""
What could be wrong: every effect as hypotheses from which a search can start.

How an effect is looked for is declared beside its law; here it becomes terms of a fit.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import product
from typing import Any

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.chain_links import ChainLinks
from hda_arm_sim.model.effects import effect_named, EFFECTS, Scope
from hda_arm_sim.model.effects.hypothesis import Grid, Hypothesis
from hda_arm_sim.model.typical_sizes import scaled_size

from ...least_squares.term import looked_for, Term

HYPOTHESES: dict[str, Hypothesis] = {effect.name: effect.hypothesis for effect in EFFECTS
                                     if effect.hypothesis is not None}


def left_aside(arm: Arm, names: Sequence[str]) -> tuple[str, ...]:
    """Return which effects are not looked for on an arm: of a chain, those of a plane."""
    return tuple(name for name in names
                 if isinstance(arm.links, ChainLinks) and effect_named(name).planar)


def terms_of(arm: Arm, name: str) -> Iterator[Term]:
    """
    Return every start of one hypothesis: each place on the arm, each point of the grid.

    Torques of a grid are for the axis of the typical sizes, and grow with what a motor can give.
    """
    kind, sought, free = effect_named(name), HYPOTHESES[name], free_of(arm, name)
    for joint in (None,) if kind.scope is Scope.ARM else arm.labels:
        present = arm.effect(name, joint)
        for point in product(*sought.grid.values()):
            start = replace(present, **{
                number: scaled_size(arm, kind, joint, number, value)
                for number, value in _named(sought.grid, point).items()})
            yield looked_for(start, joint, free, sought.waves, _least(arm, sought, joint),
                             grown=next(iter(sought.free), '') in sought.grid)
        if isinstance(arm.links, ChainLinks):
            for number, step in sought.instead.items():
                yield looked_for(present, joint, {number: step}, {}, {})


def free_of(arm: Arm, name: str) -> dict[str, float]:
    """Return the plain numbers of an effect that are free on an arm, with their usual steps."""
    sought = HYPOTHESES[name]
    return {**sought.free, **(sought.in_space if isinstance(arm.links, ChainLinks) else {})}


def _least(arm: Arm, sought: Hypothesis, joint: str | None) -> dict[str, float]:
    """Return the bounds of the free numbers at a joint, none where the law has none."""
    if joint is None:
        return {}
    return {name: least(arm.joint(joint)) for name, least in sought.least.items()}


def variant_of(term: Term) -> tuple[float, ...]:
    """Return the numbers of a term that its grid sets together: they make it another law."""
    return tuple(getattr(term.effect, name) for names in HYPOTHESES[term.name].grid
                 if not isinstance(names, str) for name in names)


def _named(grid: Grid, point: tuple[Any, ...]) -> dict[str, float]:
    """Return a point of a grid by the names of its numbers."""
    named: dict[str, float] = {}
    for names, values in zip(grid, point):
        named |= {names: values} if isinstance(names, str) else dict(zip(names, values))
    return named
