"""
Which friction a motor has that turns both ways: the posterior of all sets of causes.

The load that friction may grow with is that of the fit itself. It is found in rounds, as are the
scales of laws. What all named
causes together leave counts as noise, with its memory: a rest that nothing explains makes each
name less sure.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import Effect
import numpy as np

from .friction_causes import (
    Along, along, causes, friction_effects, friction_laws, FrictionLaw, Rows, spacing)
from .motor_record import Sweep
from .posterior import PossibleCause, Posterior, posterior, Weigher
from ...significance import MOSTLY

# Numerics; choices unless stated otherwise.
_ROUNDS = 3             # in which the load and the scales of laws are found more closely
MEMORY = 0.3            # time over which errors of a torque may go together [s]
_EXACT = 1e-3           # of a relative tolerance: nothing is known exactly
_DIGITS = 6             # of a log evidence: the last ones depend on how a machine sums


class FrictionCause(NamedTuple):
    """One friction cause of a motor: its law, its numbers and how probable it is."""

    law: FrictionLaw
    columns: Array              # (k, p) what the motor needs per unit
    numbers: Array              # (p,) in units of the law
    covariance: Array           # (p, p)
    probability: float
    lead: float                 # log evidence that it has over the best set without it

    @property
    def name(self) -> str:
        """Return the name of its effect."""
        return self.law.effect.name


class StatedFriction(NamedTuple):
    """The friction that an arm's file states: its torque (k,), and columns of its tolerances."""

    torque: Array               # [N*m at the shaft]
    columns: Array              # (k, t)
    deviations: Array           # (t,)
    numbers: Mapping[str, float]    # the first of each effect


class FrictionFound(NamedTuple):
    """What friction a sweep shows, and what else its torque follows."""

    causes: tuple[FrictionCause, ...]
    posterior: Posterior
    nameless: str | None        # coordinate of a curve without a name that is needed


def load_columns(sweep: Sweep) -> Array:
    """Return the columns of inertia, of a load over the link angle and of an offset (k, 4)."""
    link = sweep.angle / sweep.joint.ratio
    return np.stack([sweep.acceleration, np.cos(link), np.sin(link), np.ones_like(link)], axis=1)


def friction_of(sweep: Sweep, waves: Array, stated: StatedFriction) -> FrictionFound:
    """
    Return the friction that a sweep shows beside waves (k, q) over the angle of its motor.

    The torque of the sweep is what it needs beyond what the arm's file has `stated`.
    """
    free = np.concatenate([load_columns(sweep), waves], axis=1)
    known = np.concatenate([free, stated.columns], axis=1)
    deviations = np.concatenate([np.full(free.shape[1], np.inf), stated.deviations])
    rows = np.flatnonzero(sweep.moving & ~sweep.held_out)
    size = float(np.sqrt(np.mean(sweep.torque[rows] ** 2)))
    numbers = _rubbing(sweep, free, rows)
    near: dict[str, tuple[Effect, float]] = {}
    for finer in range(_ROUNDS):
        motion = along(sweep, _load(sweep, numbers))
        laws = friction_laws(motion, rows, near)
        sought = causes(motion, laws, rows, size, stated.numbers)
        found = posterior(Weigher(sweep.torque[rows], known[rows], deviations, sought,
                                  _variance(sweep, known, sought, rows)))
        numbers = found.sets[0].numbers
        near = {found.causes[place].name: (laws[found.causes[place].name][number].effect,
                                           spacing(finer))
                for place, number in found.sets[0].chosen if found.causes[place].named}
    return FrictionFound(tuple(_held(found, laws, motion, known.shape[1])), found,
                         _needed(found))


def stated_friction(arm: Arm, sweep: Sweep) -> StatedFriction:
    """Return what the motor of a sweep needs against the friction that an arm's file states."""
    rows = np.flatnonzero(sweep.moving & ~sweep.held_out)
    motion = along(sweep, _load(sweep, _rubbing(sweep, load_columns(sweep), rows)))
    label = sweep.joint.label
    known = arm.tolerances_of(label)
    tolerances = {kind.name: getattr(known, kind.tolerance[1])
                  for kind in friction_effects() if kind.tolerance}
    effects = [effect for effect in (arm.effect(kind.name, label) for kind in friction_effects())
               if _acts(effect)]
    torques = {effect.name: motion.opposed(effect) for effect in effects}
    loose = [torques[name][:, None] for name in tolerances if name in torques]
    return StatedFriction(sum(torques.values(), np.zeros_like(sweep.time)),
                          np.concatenate([np.zeros((len(sweep.time), 0)), *loose], axis=1),
                          np.array([max(share, _EXACT) for name, share in tolerances.items()
                                    if name in torques]),
                          {effect.name: effect.values()[0] for effect in effects})


def _rubbing(sweep: Sweep, free: Array, rows: Rows) -> Array:
    """Return the numbers of columns (k, q) beside the usual friction, which comes last."""
    usual = np.stack([np.sign(sweep.speed), sweep.speed], axis=1)
    return _least_squares(np.concatenate([free, usual], axis=1)[rows], sweep.torque[rows])


def _acts(effect: Effect) -> bool:
    """Return whether an effect does anything."""
    names = effect.acts or tuple(each.name for each in effect.declarations())
    return any(getattr(effect, name) != 0.0 for name in names)


def _load(sweep: Sweep, numbers: Array) -> Array:
    """Return the torque through the gear (k,) [N*m at the output] by a fit."""
    inertia = max(float(numbers[0]) - sweep.joint.motor_inertia, 0.0)
    columns = load_columns(sweep)
    return np.asarray(sweep.joint.ratio * (
        inertia * columns[:, 0] + columns[:, 1:3] @ numbers[1:3]))


def _least_squares(columns: Array, values: Array) -> Array:
    """Return numbers (p,) that fit values (k,), the least of them where columns are alike."""
    scale = np.maximum(np.sqrt(np.mean(columns ** 2, axis=0)), 1e-300)
    return np.asarray(np.linalg.lstsq(columns / scale, values, rcond=1e-6)[0] / scale)


def _variance(sweep: Sweep, known: Array, sought: Sequence[PossibleCause], rows: Rows) -> float:
    """Return the power of what all named causes leave, over the share that is independent."""
    laws = [law.columns for cause in sought if cause.named
            for law in cause.usual()[::max(1, len(cause.usual()) // 2)]]
    columns = np.concatenate([known[rows], *laws], axis=1)
    torque = sweep.torque[rows]
    rest = torque - columns @ _least_squares(columns, torque)
    return float(np.mean(rest ** 2)) * fewer(rest, sweep.dt)


def fewer(rest: Array, dt: float) -> float:
    """Return how many samples of a rest (k,) count as much as one of white noise, 1 at least."""
    centred = rest - rest.mean()
    memory = np.fft.irfft(np.abs(np.fft.rfft(centred, 2 * len(rest))) ** 2)
    memory = memory[:max(1, round(MEMORY / dt))]
    return max(1.0, 2.0 * float(np.maximum(memory, 0.0).sum() / max(memory[0], 1e-300)) - 1.0)


def _held(found: Posterior, laws: dict[str, list[FrictionLaw]], motion: Along,
          first: int) -> list[FrictionCause]:
    """Return the named causes of the most probable set that more likely act than not."""
    best, held = found.sets[0], []
    for place, number in best.chosen:
        cause, law = found.causes[place], found.causes[place].laws[number]
        size = law.columns.shape[1]
        if cause.named and found.of(cause.name) > MOSTLY:
            own = slice(first, first + size)
            held.append(FrictionCause(
                laws[cause.name][number], laws[cause.name][number].columns(motion),
                best.numbers[own], best.covariance[own, own], found.of(cause.name),
                round(best.evidence - max((one.evidence for one in found.sets
                                           if cause.name not in found.names(one)),
                                          default=-np.inf), _DIGITS)))
        first += size + law.forms.shape[1]
    return held


def _needed(found: Posterior) -> str | None:
    """Return the coordinate of the curve without a name that is needed most, None for none."""
    if found.nameless() <= MOSTLY:
        return None
    curves = [cause.name for cause in found.causes if not cause.named]
    return max(curves, key=found.of)
