"""The shape in which each effect is put into a recording, to see how small it may be there."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import Effect, effect_named
from hda_arm_sim.model.effects.hypothesis import SearchStart
from hda_arm_sim.model.effects.place import LIMIT
from hda_arm_sim.model.kernel import LINK_ANGLE
import numpy as np

from ..fitting.fit import Fitter
from ..fitting.hypotheses import HYPOTHESES, is_richer, terms_of
from ...least_squares.term import looked_for, Term

# Whose shapes nobody chooses: the faintest counts.
AT_LEAST_SEEN = tuple(name for name, sought in HYPOTHESES.items()
                      if sought.faintest or sought.start is SearchStart.SWING)
# Numerics; choices unless stated otherwise.
_CLIPPED = (0.6, 0.8, 0.92, 1.0)    # limits of torque, over the largest command: one a start
_TOUCH = 1.0            # duration of a contact [s]
_CREEPS = 2.0           # damping of a base that shows least: twice what keeps it from ringing
_SWINGS = (0.0, 0.5 * np.pi)        # directions of it, along x and y [rad]


def shapes(fitter: Fitter, arm: Arm, name: str) -> Iterator[Term]:
    """Yield an effect at every place in the shapes in which it is looked for, or some of them."""
    kind, start = effect_named(name), HYPOTHESES[name].start
    for number, term in enumerate(terms_of(arm, name)):
        if start is SearchStart.TOUCH:
            yield looked_for(_touch(fitter, kind), None, {}, {('force', 'direction'): 1.0}, {})
        elif start is SearchStart.SWING:
            for along in _SWINGS:
                yield replace(term, effect=replace(term.effect, damping=_CREEPS, direction=along))
        elif not _stands(term):
            continue
        elif kind.place is LIMIT:
            yield _clipped(fitter, arm, term, _CLIPPED[number % len(_CLIPPED)])
        elif HYPOTHESES[name].rests:
            yield from _resting(fitter, arm, term)
        else:
            yield term


def _stands(term: Term) -> bool:
    """
    Return whether a shape stands for the others of its effect, or for itself.

    One in other numbers than those that a size is stated in (`instead`) says nothing of them.
    """
    others = HYPOTHESES[term.name].instead
    return not is_richer(term) and not others.keys() & set(term.free) and all(
        getattr(term.effect, number) == value
        for number, value in HYPOTHESES[term.name].stands.items())


def _touch(fitter: Fitter, kind: Any) -> Effect:
    """Return a contact without force in the middle of the longest stretch that is fitted."""
    edges = np.flatnonzero(np.diff(fitter.rows.astype(int), prepend=0, append=0))
    time = np.append(fitter.balancer.time, fitter.balancer.time[-1])
    longest = max(zip(time[edges[::2]], time[edges[1::2]]), key=lambda span: span[1] - span[0])
    contact: Effect = kind(onset=float(0.5 * sum(longest) - 0.5 * _TOUCH), duration=_TOUCH)
    return contact


def _resting(fitter: Fitter, arm: Arm, term: Term) -> Iterator[Term]:
    """Yield an effect that rests at either end of its link's travel, and in the middle."""
    travel = fitter.balancer.motion(arm).state[:, arm.labels.index(str(term.joint)), LINK_ANGLE]
    for rest_angle in (travel.min(), travel.mean(), travel.max()):
        rest: Any = {HYPOTHESES[term.name].rests: float(rest_angle)}
        yield replace(term, effect=replace(term.effect, **rest))


def _clipped(fitter: Fitter, arm: Arm, term: Term, share: float) -> Term:
    """Return a limit as a share of the largest command of its joint, as soft as it is known."""
    column = fitter.balancer.measurement.command[:, arm.labels.index(str(term.joint))]
    known: Any = arm.effect(*term.place)
    return replace(term, effect=replace(
        known, limit=max(share * float(np.abs(column).max()), 1e-6)))
