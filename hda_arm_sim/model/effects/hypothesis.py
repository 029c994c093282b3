"""
How an effect is looked for: what a fit may change, where it starts, and what else could be meant.

These are declarations beside the law. Diagnosis, calibration and planning read them; none of them
lists effects of its own.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import Enum
import math
from typing import Any, TypeAlias

Grid: TypeAlias = Mapping[
    str | tuple[str, ...], tuple[float, ...] | tuple[tuple[float, ...], ...]]

# Experiments that decide between several effects.
TORQUE_LOOPS = ('slow torque loops about zero at two amplitudes and two rates with the motor '
                'clamped; constant speed both ways for skew')
SCALE = 'hang a known mass on the tip of a tilted arm, or push it with a force sensor'
SLOW = 'constant slow speeds over two motor turns, and reversals of different length'

# Improvement by a curve beside a law of one form, where another one differs from it by little
# (measured: a right delay left 10 to 57 of score, one that stood for a lag 93 to 398).
NO_OTHER_FORM = 75.0

# Of no segments, and of the data sheets of sizes 14, 17, 20 and 25 [N*m].
KNEES = ((0.0, 0.0), (2.0, 6.9), (3.9, 12.0), (7.0, 25.0), (14.0, 48.0))


class SearchStart(Enum):
    """Where a search starts: at points of a grid, or where something stands out of the rest."""

    GRID = 'grid'
    TOUCH = 'a force on the tip for some time'
    SWING = 'answers of a base to the links'


def nothing_more(effect: Any) -> tuple[Any, ...]:
    """Return no effects: published laws of one do nothing beside it."""
    return ()


@dataclass(frozen=True)
class Hypothesis:
    """
    How one effect is looked for.

    `free` and `waves` name the numbers to fit with a typical size. On a chain those of `in_space`
    are free as well. One of `instead` may be what differs in the place of all others, which in a
    plane keep their tolerances. Those of `more`, centre and radius of a body, are free in a second
    law of the effect, and cost as numbers do. None is farther from zero than `within` says of the
    links: beyond, the law stands for another. `grid` lists starting values of the first numbers,
    or of several at once, that the residual does not depend on linearly. Its torques are for the
    axis of the typical sizes. `least` bounds by the joint below which the law does not change any
    more. `form_error` is the share of the effect's power that its law may leave, where the
    literature has laws of several forms. A curve without a name at its site may improve the score
    by `form` and by `form_share` of what the effect improves it. It must lead another law of the
    same curve by `lead_share` of that, or by what is surely worth a cause. It may explain
    `form_power`, a share of the effect's power. `doubts` are half-widths that intervals have for
    the same reason, as shares of another number or absolute. `ends` are numbers at whose lower
    bound a part of the arm is gone: it means something. `twin` is an effect that no motion
    distinguishes from this one. What acts on the command acts on the noise of the encoders that it
    repeats. Two such effects are compared `below` a frequency [Hz]. One of which the power over
    that of noise is less than `clear` is not distinguished from the first of `alike`. No other
    `form` than the usual one is asked of it. `varies` are the coordinates along which published
    laws of the cause differ from this one. A form that does more than `reach`, a share of its
    power, is another law. Some laws do as well what other effects do, `beside` these numbers.
    A friction beside the spring begins to slide over a `path`, one of its numbers.
    `contains` are curves without a name that are this law, or a published form of it, at some of
    its numbers. One of them explains as much as the law and is the law. A `passing` effect acts
    for a part of a recording, from its `onset` on. A search begins as `start` says. Of many shapes
    one `stands` for all, where the smallest size that shows is asked for; else the `faintest`
    counts. One that `rests` has a link's angle somewhere within its travel as a number. A `weaker`
    effect does less the larger its number is. One that `scales` a torque lets a balance shrink
    beside another such. A wave of one that `bends` must be seen to do so: a straight part of it
    may be any error.
    `shaped` are numbers by which other published laws differ from the usual one, and values of
    them. They are tried where laws are linear in what is found; elsewhere such a law is a form.
    """

    free: Mapping[str, float] = field(default_factory=dict)
    in_space: Mapping[str, float] = field(default_factory=dict)
    instead: Mapping[str, float] = field(default_factory=dict)
    more: tuple[str, ...] = ()
    within: Mapping[str, Callable[[Any], float]] = field(default_factory=dict)    # of the links
    waves: Mapping[tuple[str, str], float] = field(default_factory=dict)
    grid: Grid = field(default_factory=dict)
    least: Mapping[str, Callable[[Any], float]] = field(default_factory=dict)     # of a joint
    alike: tuple[str, ...] = ()
    experiment: str = ''
    # share of its power that its law may leave (measured: dry friction of a bearing left that)
    form_error: float = 0.003
    # score of a curve beside it (measured: right causes left some 100, others 700 to 5500)
    form: float = 300.0
    # the same, as a share of what the effect improved (choice)
    form_share: float = 0.02
    # share of that by which it leads another law of its curve, unless the lead is surely worth a
    # cause (measured: of 28 leads the six below had five wrong names, all by less than a cause is
    # worth for sure, the six of up to four times as much had one)
    lead_share: float = 0.05
    # share of its power that such a curve may explain (choice: none)
    form_power: float = 0.0
    # half-width of an interval, as a share of a number or absolute (choice: the law is exact)
    doubts: Mapping[str, tuple[float, str]] = field(default_factory=dict)
    ends: tuple[str, ...] = ()
    passing: bool = False
    start: SearchStart = SearchStart.GRID
    stands: Mapping[str, float] = field(default_factory=dict)
    faintest: bool = False
    rests: str = ''
    weaker: bool = False
    scales: bool = False
    bends: bool = False
    shaped: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    varies: tuple[str, ...] = ()
    beside: Callable[[Any], tuple[Any, ...]] = nothing_more
    path: str = ''
    # share of its power that another form of its law may do (source: published laws differ by
    # 0.002 to 0.1 of it, unless an effect declares otherwise)
    reach: float = 0.1
    contains: tuple[str, ...] = ()
    twin: str = ''
    # power over that of noise, from which it is distinguished from its like (choice: at once)
    clear: float = 0.0
    # frequency below which it is compared with its like [Hz] (choice: at all of them)
    below: float = math.inf

    @property
    def chosen(self) -> tuple[str, ...]:
        """Return the names of the numbers that are chosen from the grid and not fitted."""
        fitted = {*self.free, *(name for pair in self.waves for name in pair)}
        names = [name for key in self.grid for name in ((key,) if isinstance(key, str) else key)]
        return tuple(name for name in names if name not in fitted)


@dataclass(frozen=True)
class Typical:
    """
    A size at which an effect is worth finding: of a drive that is neither new nor broken.

    Sizes are for an axis of 0.3 N*m at the motor and a ratio of 100. Numbers of `more` come on
    top of what the arm has; those of `shape` replace it.
    """

    more: Mapping[str, float]
    shape: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Unmeasured:
    """
    What is known of an effect at a joint that nobody has measured: a calibration begins there.

    `sigma` is how numbers scatter from joint to joint. It is in their own unit, and on the
    logarithm of those that have a `usual` value, or are relative to what a law has. Of waves with
    several amplitudes it is that of each `amplitude`.
    """

    sigma: Mapping[str, float]
    usual: Mapping[str, float] = field(default_factory=dict)


def wave(order: int, size: float) -> dict[tuple[str, str], float]:
    """Return a wave to fit: the names of its amplitude and phase, and its usual amplitude."""
    return {(f'amplitude_{order}', f'phase_{order}'): size}
