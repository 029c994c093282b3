"""Find the motion that distinguishes effects best: weigh candidates, then refine the best one."""

from collections.abc import Callable
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.chain_links import ChainLinks
from hda_arm_sim.motions import home_of, Motion
from hda_arm_sim.simulate import checked
import numpy as np
from scipy.optimize import minimize

from .paths import candidates, ChainPaths, Path
from .question import PlanError, Question
from .separation import Load, load_of, SEED, separation, Strength, USED
from ..diagnosis.judging.selection_criteria import LOOKED_AT
from ..diagnosis.judging.verdict import TIED
from ..simulating.closed_loop import ClosedLoopRun, run

USUAL = 'rich'          # motion of the project that plans are compared to
# Choices unless stated otherwise.
SHORTEST, LONGEST = 10.0, 120.0         # plan that may be asked for [s]
_STEP = 2e-3            # of the samples while planning [s]
_TRIALS = 6             # of the refinement
_SHRINK = 0.8           # of excursions that exceed a limit
_ROOM = 0.93            # of the angles: the links overshoot
_ATTEMPTS = 8           # to bring a path within the limits


class WeighedPath(NamedTuple):
    """A path within the limits, and how strongly it separates the suspects."""

    path: Path
    strength: Strength


class Plan(NamedTuple):
    """
    The best path, the usual motion, all candidates, and what the best one takes of the limits.

    The usual motion is as it is, even where it asks for more than the limits.
    """

    best: WeighedPath
    usual: WeighedPath
    candidates: tuple[WeighedPath, ...]
    load: Load
    needed: float

    @property
    def answers(self) -> bool:
        """Return whether a diagnosis along the best path would name the effect that there is."""
        return self.best.strength.least >= self.needed


Progress = Callable[[int, int], None]       # steps done, and steps in all


def plan(asked: Question, duration: float, notify: Progress = lambda done, total: None) -> Plan:
    """Return the best motion of some duration [s]; raises PlanError, ArmError."""
    checked(asked.arm, _STEP)
    if not SHORTEST <= duration <= LONGEST:
        raise PlanError(f'a motion is planned for {SHORTEST:g} to {LONGEST:g} s, '
                        f'got {duration:g} s')
    paths = candidates(len(asked.arm.joints))
    total = 1 + len(paths) + _TRIALS
    usual = _as_it_is(asked, Path(USUAL, (1.0,) * len(asked.arm.joints)), duration)
    found: list[WeighedPath] = []
    for count, path in enumerate(paths, 1):
        notify(count, total)
        found.append(_weigh(asked, path, duration, max(map(_least, found), default=-1.0)))
    best = max(found, key=_least)
    if _least(best) > 0.0:
        best = _refined(asked, best, duration,
                        lambda trial: notify(min(len(paths) + trial, total), total))
    notify(total, total)
    return Plan(best, usual, tuple(found),
                load_of(asked.arm, _healthy(asked, best.path, duration)[1]),
                TIED if asked.between else LOOKED_AT)


def _least(weighed: WeighedPath) -> float:
    return weighed.strength.least


def planned_motion(asked: Question, path: Path, duration: float, dt: float) -> Motion:
    """Return a path as the motion of an arm, sampled every dt [s]."""
    (low, high), chain = asked.arm.ranges().T, None
    if isinstance(asked.arm.links, ChainLinks):
        chain = ChainPaths(home_of(asked.arm), [_ROOM * joint.velocity_limit / joint.ratio
                                                for joint in asked.arm.joints], 0.5 * (low + high))
    limits = _ROOM * 0.5 * (high - low)
    return path.motion(len(limits), duration, dt, limits.tolist(), chain)


def _healthy(asked: Question, path: Path, duration: float) -> tuple[Motion, ClosedLoopRun]:
    motion = planned_motion(asked, path, duration, _STEP)
    return motion, run(asked.arm, asked.arm, motion, SEED, estimator=None)


def _as_it_is(asked: Question, path: Path, duration: float) -> WeighedPath:
    return WeighedPath(path, separation(asked, *_healthy(asked, path, duration)))


def _weigh(asked: Question, path: Path, duration: float, least: float) -> WeighedPath:
    """Return a path, made smaller until it is within the limits, with its strength."""
    for attempt in range(_ATTEMPTS):
        motion, healthy = _healthy(asked, path, duration)
        load = load_of(asked.arm, healthy)
        if load.largest <= USED:
            return WeighedPath(path, separation(asked, motion, healthy, least))
        shaken = path.wave > 0.0 and attempt < _ATTEMPTS // 2 and load.torque.max() > USED
        path = path.scaled(amplitude=1.0 if shaken else _SHRINK, wave=_SHRINK)
    return WeighedPath(path, Strength((0.0,)))


def _refined(asked: Question, start: WeighedPath, duration: float,
             notify: Callable[[int], None]) -> WeighedPath:
    """Return the best of a few trials around a path: other excursions, another wave."""
    tried = [start]

    joints = len(start.path.amplitude)

    def cost(logarithms: Array) -> float:
        factors = np.exp(logarithms).tolist()
        notify(len(tried))
        path = start.path.scaled(amplitude=factors[:joints], wave=sum(factors[joints:]))
        tried.append(_weigh(asked, path, duration, max(map(_least, tried))))
        return -_least(tried[-1])

    steps = [-0.4] * joints + [0.5] * (start.path.wave > 0.0)
    simplex = np.vstack([np.diag(steps), np.zeros(len(steps))])
    minimize(cost, np.zeros(len(steps)), method='Nelder-Mead',
             options={'maxfev': _TRIALS, 'initial_simplex': simplex})
    return max(tried, key=_least)
