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
from hda_arm_sim.model.effects import Effect, effect_named, EFFECTS, Scope
from hda_arm_sim.model.effects.catalogue import effects_at
from hda_arm_sim.model.effects.hypothesis import Grid, Hypothesis
from hda_arm_sim.model.effects.place import LOAD
from hda_arm_sim.model.typical_sizes import scaled_size
import numpy as np

from .nuisance import link_tolerances
from ...least_squares.charts import CarriedMoments, Identity
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
        if sought.more:
            yield from (_centred(name, present, joint), richer(arm, name, present, joint))
        for number, step in sought.instead.items() if arm.links is not None else ():
            yield _instead(arm, present, joint, number, step)


def free_of(arm: Arm, name: str) -> dict[str, float]:
    """Return the plain numbers of an effect that are free on an arm, with their usual steps."""
    sought = HYPOTHESES[name]
    return {**sought.free, **(sought.in_space if isinstance(arm.links, ChainLinks) else {})}


def richer(arm: Arm, name: str, present: Effect, joint: str | None) -> Term:
    """Return the law of an effect with its further numbers, those that the arm's links have."""
    (size, step), = HYPOTHESES[name].free.items()
    further = (number for number in HYPOTHESES[name].more
               if isinstance(arm.links, ChainLinks) or number not in present.spatial)
    return Term(present, joint, (CarriedMoments((size, *further), step),))


def _centred(name: str, present: Effect, joint: str | None) -> Term:
    """Return the law of a body with its centre where a point would be: its size and radius."""
    (size, step), = HYPOTHESES[name].free.items()
    return Term(present, joint, (CarriedMoments((size, HYPOTHESES[name].more[-1]), step),))


def _instead(arm: Arm, present: Effect, joint: str | None, number: str, step: float) -> Term:
    """Return the law in which one number of a link is free: in a plane others keep tolerances."""
    others = {} if isinstance(arm.links, ChainLinks) else link_tolerances(arm, str(joint))
    return Term(present, joint, (Identity((number,), step), *(
        Identity((other,), known, known) for other, known in others.items())))


def carried_by(arm: Arm) -> Iterator[Term]:
    """Yield what links may carry that carry nothing as stated, as a body of its usual size."""
    for kind in effects_at(LOAD):
        if kind.name in HYPOTHESES and arm.effect(kind.name).is_neutral():
            term = richer(arm, kind.name, kind(), None)
            yield term.at(term.all_steps() * np.eye(term.size)[0])


def is_richer(term: Term) -> bool:
    """Return whether a term has the further numbers of its law."""
    return bool(set(HYPOTHESES[term.name].more).intersection(term.free))


def _least(arm: Arm, sought: Hypothesis, joint: str | None) -> dict[str, float]:
    """Return the bounds of the free numbers at a joint, none where the law has none."""
    if joint is None:
        return {}
    return {name: least(arm.joint(joint)) for name, least in sought.least.items()}


def variant_of(term: Term) -> tuple[float, ...]:
    """Return what makes a term another law: how many numbers, and those its grid sets together."""
    return (float(is_richer(term)), float(term.size),
            *(getattr(term.effect, name) for names in HYPOTHESES[term.name].grid
              if not isinstance(names, str) for name in names))


def _named(grid: Grid, point: tuple[Any, ...]) -> dict[str, float]:
    """Return a point of a grid by the names of its numbers."""
    named: dict[str, float] = {}
    for names, values in zip(grid, point):
        named |= {names: values} if isinstance(names, str) else dict(zip(names, values))
    return named
