"""
Explain the torque of a motor alone by columns: load, friction, and waves over its angle.

Lines are added one by one, the strongest first, as long as they gain on held-out stretches.
"""

from collections.abc import Sequence
import math
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
import numpy as np
from scipy.ndimage import uniform_filter1d

from .motor_friction import (fewer, friction_of, FrictionFound, load_columns, stated_friction,
                             StatedFriction)
from .motor_record import Sweep
from .ripple import RippleLine, strongest_line, waves
from ..findings.gains import Gains
from ..judging.placebo import moved_away
from ...significance import FOURTH_DIFFERENCES, HARDLY, NORMAL_MEDIAN

# Numerics; choices unless stated otherwise.
MOST = 12               # lines of one motor that are tried
_PERIODS = 3.0          # of a line, over which slower errors are taken out of it
_WINDOW = 0.1           # of held-out errors [s]
LOAD = 3                # columns: inertia, and the load over the link angle (layout)
METRIC = ('mean squared error of the motor torque that the measured motion calls for, on held-out '
          'stretches, over white noise')


class Explained(NamedTuple):
    """
    A sweep and the columns (k, p) that explain its torque: load, friction, then waves.

    A sweep one way has a friction of two columns without a name, and no `friction`.
    """

    sweep: Sweep
    columns: Array
    lines: tuple[RippleLine, ...]
    numbers: Array          # (p,)
    spread: Array           # (p,) standard deviations
    friction: FrictionFound | None = None

    @property
    def first_wave(self) -> int:
        """Return the place of the first column of a wave."""
        return self.columns.shape[1] - 2 * len(self.lines)

    def wave(self, number: int) -> list[int]:
        """Return the places of the two columns of a wave."""
        return [self.first_wave + 2 * number, self.first_wave + 2 * number + 1]

    def rubbing(self, number: int) -> list[int]:
        """Return the places of the columns of a friction cause, by its number."""
        assert self.friction is not None
        sizes = [cause.columns.shape[1] for cause in self.friction.causes]
        first = self.first_wave - sum(sizes[number:])
        return list(range(first, first + sizes[number]))

    def without(self, taken: Sequence[int]) -> Array:
        """Return what the torque departs by (k,) if columns are taken away and the rest refit."""
        kept = [place for place in range(self.columns.shape[1]) if place not in taken]
        return _rest(self.sweep, self.columns[:, kept])


def explained(sweep: Sweep, arm: Arm) -> Explained:
    """
    Return what explains the torque of a sweep, fitted to its training stretches.

    Where the motor turns both ways, it is what is beyond the friction that the arm's file states.
    """
    stated = stated_friction(arm, sweep)
    if sweep.both_ways:
        sweep = sweep._replace(torque=sweep.torque - stated.torque)
    columns, lines = base(sweep), list[RippleLine]()
    tried: list[float] = []
    use = sweep.moving & ~sweep.held_out
    while len(tried) < MOST:
        rest = _rest(sweep, columns)
        line = strongest_line(sweep.angle[use], rest[use], tried)
        if line is None:
            break
        tried.append(line.order)
        more = np.concatenate([columns, waves(sweep.angle, line.order)], axis=1)
        if _repeats(sweep, line, rest, _rest(sweep, more)):
            columns = more
            lines.append(line)
    part = _without_losses(_fitted(sweep, columns, tuple(lines)))
    return _with_friction(part, stated) if sweep.both_ways else part


def _with_friction(part: Explained, stated: StatedFriction) -> Explained:
    """Return what explains a torque with the friction that it shows in the place of the usual."""
    turning = part.columns[:, part.first_wave:]
    found = friction_of(part.sweep, turning, stated)
    columns = np.concatenate([load_columns(part.sweep), *(
        cause.columns for cause in found.causes), turning], axis=1)
    return _fitted(part.sweep, columns, part.lines)._replace(friction=found)


def _without_losses(part: Explained) -> Explained:
    """Return what explains a torque without lines that lose on the held-out stretches."""
    gains = [gain_without(part, part.wave(number)).removed() for number in range(len(part.lines))]
    if all(gain > 0.0 for gain in gains):
        return part
    worst = int(np.argmin(gains))
    kept = [column for column in range(part.columns.shape[1]) if column not in part.wave(worst)]
    return _without_losses(_fitted(part.sweep, part.columns[:, kept],
                                   part.lines[:worst] + part.lines[worst + 1:]))


def _repeats(sweep: Sweep, line: RippleLine, before: Array, after: Array) -> bool:
    """Return whether a line gains on the held-out stretches, slower errors left aside."""
    pace = line.order * float(np.median(np.abs(sweep.speed[sweep.moving])))
    span = max(3, round(_PERIODS * 2.0 * math.pi / pace / sweep.dt))
    fast = [rest - uniform_filter1d(rest, span) for rest in (before, after)]
    return _gains(sweep, fast[0], fast[1], 1.0).interval()[0] > 0.0


def base(sweep: Sweep) -> Array:
    """Return the columns of a torque without waves (k, 5), and of the drive's offset (k, 6)."""
    link = sweep.angle / sweep.joint.ratio
    columns = [sweep.acceleration, np.cos(link), np.sin(link), np.sign(sweep.speed), sweep.speed]
    if sweep.both_ways:
        columns.append(np.ones_like(link))
    return np.stack(columns, axis=1)


def _solve(sweep: Sweep, columns: Array) -> tuple[Array, Array]:
    """Return numbers (p,) that fit the training stretches, and the inverse of their normal."""
    use = sweep.moving & ~sweep.held_out
    scale = np.maximum(np.sqrt(np.mean(columns[use] ** 2, axis=0)), 1e-30)
    scaled = columns[use] / scale
    inverse = np.linalg.pinv(scaled.T @ scaled, rcond=1e-9, hermitian=True)
    numbers = inverse @ (scaled.T @ sweep.torque[use]) / scale
    return numbers, inverse / np.outer(scale, scale)


def _rest(sweep: Sweep, columns: Array) -> Array:
    """Return what columns fitted to the training stretches leave of the torque (k,)."""
    return sweep.torque - columns @ _solve(sweep, columns)[0]


def _fitted(sweep: Sweep, columns: Array, lines: tuple[RippleLine, ...]) -> Explained:
    """Return the fit with standard deviations that know how long the rest remembers."""
    numbers, inverse = _solve(sweep, columns)
    rest = (sweep.torque - columns @ numbers)[sweep.moving]
    rest = rest - rest.mean()
    variance = float(np.mean(rest ** 2))
    spread = np.sqrt(np.maximum(np.diag(inverse), 0.0) * variance)
    spread[:columns.shape[1] - 2 * len(lines)] *= math.sqrt(fewer(rest, sweep.dt))
    return Explained(sweep, columns, lines, numbers, spread)


def _gains(sweep: Sweep, before: Array, after: Array, floor: float) -> Gains:
    """Return the errors of windows on held-out stretches, over a floor [N^2*m^2]."""
    use = sweep.moving & sweep.held_out
    window = np.asarray(sweep.time / _WINDOW, np.int64)[use]
    count = np.bincount(window)
    parts = [np.bincount(window, rest[use] ** 2)[count > 0] / count[count > 0] / floor
             for rest in (before, after)]
    return Gains(parts[0], parts[1], np.ones_like(parts[0]) if floor != 1.0 else 0.0 * parts[0])


def floor_of(part: Explained) -> float:
    """Return the power of white noise in the torque, by its fourth differences [N^2*m^2]."""
    rest = part.without(())[part.sweep.moving]
    usual = np.median(np.abs(np.diff(rest, 4))) / NORMAL_MEDIAN
    return float(usual) ** 2 / FOURTH_DIFFERENCES


def gain_without(part: Explained, taken: Sequence[int]) -> Gains:
    """Return what some columns gain on held-out stretches, over white noise."""
    return _gains(part.sweep, part.without(taken), part.without(()), floor_of(part))


def placebo_of(part: Explained, taken: Sequence[int]) -> float:
    """
    Return the share that the best placebo of some columns removes on held-out stretches.

    Of a motion that repeats, moved columns may be what the others hold already: these add nothing.
    """
    others = part.columns[:, [place for place in range(part.columns.shape[1])
                              if place not in taken]]
    before, floor, best = part.without(taken), floor_of(part), 0.0
    basis = np.linalg.qr(others / np.maximum(np.linalg.norm(others, axis=0), 1e-300))[0]
    for rolled in moved_away(part.columns[:, None, list(taken)]):
        moved = rolled[:, 0]
        apart = moved - basis @ (basis.T @ moved)
        if (np.linalg.norm(apart, axis=0) > HARDLY * np.linalg.norm(moved, axis=0)).all():
            after = _rest(part.sweep, np.concatenate([others, moved], axis=1))
            best = max(best, _gains(part.sweep, before, after, floor).removed())
    return best
