"""
Align two recordings of one motion in time: offset and drift with their uncertainty.

The time of the first is t1 = t2 + a + d (t2 - m), with m the middle of what both hold. Both, a and
d, make the sum of squares of x2(t2) - x1(t1) least, over all signals that move, each less its
mean. Signals and stretches that differ for other reasons count less: their weight is one over
their own residual. The uncertainty comes from leaving out one stretch after the other (jackknife),
so it covers noise of any colour that is shorter than a stretch.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.stats import t as student

from .coarse_alignment import Coarse, coarse
from .signals import BagSignals, CompareError
from .tracks import Tracks, tracks

MODES = ('none', 'offset', 'drift')
MOST_DRIFT = 0.01                   # no clock is worse
LEAST_ALIKE = 0.6                   # correlation below which the motions are not the same
_SOUGHT = {'offset': 'an offset; use --align none to compare by stamps',
           'drift': 'a drift; use --align offset or none'}
_FARTHEST = 0.1                     # of what both hold: how far a fit goes from its start
_STRETCHES = 40
_ROUNDS = 30
_SETTLED = 1e-3                     # of a standard deviation: no further step is worth it
_COARSE_RATE = 50.0                 # [Hz]
_EDGE = 10                          # samples that a filter spoils at the ends of a track
_EXACT = 1e-9                       # of a signal: residuals below it are those of arithmetic
_LEVEL = 0.95                       # one-sided: intervals of 90 %


@dataclass(frozen=True, eq=False)
class Alignment:
    """Say which time of the first bag belongs to a time of the second, each from its start."""

    mode: str
    shift: float                    # a [s]
    drift: float                    # d, a pure number
    middle: float                   # m [s]
    covariance: Array               # of (a, d) (2, 2)
    quantile: float                 # half a 90 % interval, in standard deviations
    correlation: float | None = None
    rivals: tuple[float, ...] = ()  # other offsets at which the motions look as alike [s]

    def to_first(self, time: Array) -> Array:
        """Return the times of the first bag for times of the second [s]."""
        return time + self.shift + self.drift * (time - self.middle)

    def to_second(self, time: Array) -> Array:
        """Return the times of the second bag for times of the first [s]."""
        return (time - self.shift + self.drift * self.middle) / (1.0 + self.drift)

    @property
    def offset(self) -> float:
        """Return the time of the first bag at which the second starts [s]."""
        return float(self.shift - self.drift * self.middle)

    def deviation(self, time: Array) -> Array:
        """Return the standard deviation of `to_first` at times of the second bag [s]."""
        from_middle = time - self.middle
        (aa, ad), (_, dd) = self.covariance
        return np.sqrt(np.maximum(aa + 2.0 * ad * from_middle + dd * from_middle ** 2, 0.0))


class _Normal(NamedTuple):
    """Hold the normal equations of each stretch: (b, 2, 2) and (b, 2)."""

    matrix: Array
    side: Array


def by_stamps(first: BagSignals, second: BagSignals) -> Alignment:
    """Return the alignment that believes the stamps of both bags."""
    return Alignment('none', (second.start - first.start) * 1e-9, 0.0, 0.0, np.zeros((2, 2)), 0.0)


def align(first: BagSignals, second: BagSignals, names: Sequence[str], mode: str) -> Alignment:
    """
    Return the alignment of two bags from their common signals.

    Raise CompareError if no signal moves or the motions are not alike.
    """
    if mode == 'none':
        return by_stamps(first, second)
    one, two = tracks(first, second, names)
    every = max(1, round(one.rate / _COARSE_RATE))
    inner = slice(_EDGE, -_EDGE, every)
    rough = coarse(one.values[inner], two.values[inner])
    _check_alike(rough, first, second)
    start = rough.lag * every / one.rate
    rivals = tuple(lag * every / one.rate for lag in rough.rivals)
    return _Fine(one, two, mode).run(start, rough.correlation, rivals)


def _check_alike(rough: Coarse, first: BagSignals, second: BagSignals) -> None:
    if rough.correlation < LEAST_ALIKE:
        raise CompareError(
            f'{first.source} and {second.source} cannot be aligned: at best their motions '
            f'correlate by {rough.correlation:.2f}, at least {LEAST_ALIKE} is needed; use '
            '--align none to compare by stamps')


class _Fine:
    """Find offset and drift by Gauss-Newton steps from a rough offset."""

    def __init__(self, one: Tracks, two: Tracks, mode: str) -> None:
        """Take the tracks of both bags."""
        self._one = CubicSpline(np.arange(len(one.values)) / one.rate, one.values)
        self._end = (len(one.values) - 1) / one.rate
        self._time = np.arange(len(two.values)) / two.rate
        self._two = CubicSpline(self._time, two.values)
        self._least = _EXACT ** 2 * two.values.var(axis=0)
        self._mode, self._free = mode, 2 if mode == 'drift' else 1

    def run(self, start: float, correlation: float, rivals: tuple[float, ...]) -> Alignment:
        """Return the alignment near a rough offset [s]."""
        inside = self._time[(self._time + start >= 0.0) & (self._time + start <= self._end)]
        middle, found = float(inside.mean()), np.array([start, 0.0])
        for _ in range(_ROUNDS):
            normal = self._normal(found, middle)
            step, covariance = self._solved(normal)
            found = found + step
            self._check_near(found - (start, 0.0), float(inside[-1] - inside[0]))
            if (np.abs(step) <= _SETTLED * np.sqrt(np.diag(covariance)) + 1e-15).all():
                break
        quantile = float(student.ppf(_LEVEL, len(normal.side) - self._free))
        return Alignment(self._mode, float(found[0]), float(found[1]), middle, covariance,
                         quantile, correlation, rivals)

    def _check_near(self, moved: Array, overlap: float) -> None:
        """Raise CompareError if a fit went where no clock goes: the motions are not the same."""
        if abs(moved[0]) > _FARTHEST * overlap or abs(moved[1]) > MOST_DRIFT:
            raise CompareError(
                f'the bags cannot be aligned: their signals fit best {abs(moved[0]):.3g} s from '
                f'where the motions are alike, with a drift of {100.0 * moved[1]:.2g} % (at most '
                f'{_FARTHEST * overlap:.3g} s and {100.0 * MOST_DRIFT:.0f} % are believed); use '
                '--align none to compare by stamps')

    def _normal(self, found: Array, middle: float) -> _Normal:
        """Return the normal equations of every stretch at an alignment."""
        mapped = self._time + found[0] + found[1] * (self._time - middle)
        kept = (mapped >= 0.0) & (mapped <= self._end)
        time, mapped = self._time[kept], mapped[kept]
        missed = _centred(self._two(time) - self._one(mapped))              # (n, s)
        slope_one, slope_two = self._one(mapped, 1), self._two(time, 1)
        cuts = np.linspace(0, len(time), min(_STRETCHES, len(time)) + 1).astype(int)[:-1]
        weight = _weights(missed, cuts, self._least)
        # The noise of the two slopes is independent: their product holds the motion only.
        steep = (weight * slope_one * slope_two).sum(axis=1)
        pull = (weight * 0.5 * (slope_one + slope_two) * missed).sum(axis=1)
        basis = np.stack([np.ones(len(time)), time - middle], axis=1)
        return _Normal(
            np.add.reduceat(steep[:, None, None] * basis[:, :, None] * basis[:, None, :], cuts),
            np.add.reduceat(pull[:, None] * basis, cuts))

    def _solved(self, normal: _Normal) -> tuple[Array, Array]:
        """Return the step (2,) and its covariance (2, 2); what is not free stays."""
        matrix, side = normal.matrix[:, :self._free, :self._free], normal.side[:, :self._free]
        total, pull, count = matrix.sum(axis=0), side.sum(axis=0), len(side)
        rests = total - matrix
        if not np.linalg.eigvalsh(rests).min() > 0.0:
            raise CompareError('the bags cannot be aligned: common signals move too little, or '
                               f'too shortly, in what both hold, to find {_SOUGHT[self._mode]}')
        step = np.linalg.solve(total, pull)
        left = np.linalg.solve(rests, (pull - side)[:, :, None])[:, :, 0] - step
        full_step, covariance = np.zeros(2), np.zeros((2, 2))
        full_step[:self._free] = step
        covariance[:self._free, :self._free] = (count - 1) / count * left.T @ left
        return full_step, covariance


def _centred(values: Array) -> Array:
    return values - values.mean(axis=0)


def _weights(missed: Array, cuts: NDArray[np.int64], least: Array) -> Array:
    """Return one over the squared residual of every signal in every stretch, (n, s)."""
    lengths = np.diff(np.append(cuts, len(missed)))
    squares = np.add.reduceat(missed ** 2, cuts) / lengths[:, None]
    usual = np.median(squares, axis=0)
    return np.repeat(1.0 / (squares + usual + least), lengths, axis=0)
