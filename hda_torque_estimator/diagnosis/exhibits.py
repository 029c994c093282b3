"""
What a diagnosis shows beside its findings, and the coordinate that gives a cause away.

A residual depends on a coordinate as far as knowing the coordinate tells the residual: the share
of its variance between bins of the coordinate (eta squared, one-way analysis of variance). What
the same coordinate tells when it is shifted in time against the residual is chance.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Bins = NDArray[np.int64]
TURN = 2.0 * math.pi
WRAPPED = 'motor_angle'             # the coordinate that counts modulo one turn
VELOCITIES = ('motor_velocity', 'link_velocity')
MOST_BINS = 24
TURN_BINS = 120                     # of a motor turn: cogging has up to 42 periods in it
PER_BIN = 15                        # least samples in a bin, on average
TURNS = 2.0                         # least motor travel in which a period of one turn shows
_SHIFTS = 32
_BESIDES = 0.15                     # least share beyond the direction's own, to split by it
_SIMPLER = 0.05                     # by which a coordinate split by direction must be better
_TIE = 0.02                         # by which the velocity of the other side must be better
_EVERYTHING = 2.0                   # by which time, which everything follows, must be better
_LINE = 2                           # frequencies either side that belong to a line


@dataclass(frozen=True, eq=False)
class Example:
    """Angles in one window, measured and simulated (w, 2 n) [rad]: motors over ratio, links."""

    time: Array                     # (w,) [s]
    measured: Array
    before: Array
    after: Array


@dataclass(frozen=True, eq=False)
class Exhibits:
    """
    Residuals, coordinates and predictions of the arm as given and of the extended arm.

    Columns (m, 2 n) are balance A of every joint, then balance B of every joint [N*m at the
    output]. Coordinates (m, n) are `motor_velocity`, `link_velocity` [rad/s], `motor_angle` [rad
    at the shaft], `link_angle` [rad], `joint_torque` [N*m at the output] and `motor_torque` [N*m
    at the shaft]. Predictions are rms errors (h,) [rad at the output].
    """

    time: Array                     # (m,) [s]
    labels: tuple[str, ...]
    before: Array
    after: Array
    valid: Mask                     # (m, 2 n)
    coordinates: Mapping[str, Array]
    horizons: Array                 # (h,) [s]
    predicted_before: Array
    predicted_after: Array
    predicted_floor: Array
    example: Example | None = None
    # Residuals (m, 2 n) of the extended arm without one cause (effect, joint).
    lacking: Mapping[tuple[str, str | None], Array] = field(default_factory=dict)

    def of(self, effect: str, joint: str | None) -> 'Exhibits':
        """Return the exhibits of one cause: before is then the extended arm without it."""
        return replace(self, before=self.lacking.get((effect, joint), self.before))

    def rest(self) -> 'Exhibits':
        """Return the exhibits of what backed causes leave: before and after are then that."""
        return replace(self, before=self.after)

    def column(self, site: str, joint: str | None) -> int:
        """Return the column at a site and joint in which the extension removes the most."""
        joints = len(self.labels)
        sides = {'motor': (0,), 'torsion': (1,), 'link': (1,)}.get(site, (0, 1))
        columns = [side * joints + place for side in sides
                   for place, label in enumerate(self.labels) if joint in (None, label)]
        return max(columns, key=self._removed)

    def _removed(self, column: int) -> float:
        valid = self.valid[:, column]
        if not valid.any():
            return -math.inf
        return float(np.mean(self.before[valid, column] ** 2 - self.after[valid, column] ** 2))


class Dependence(NamedTuple):
    """How far a residual follows a coordinate."""

    coordinate: str
    by_direction: bool              # another curve for each direction of the motor
    eta2: float                     # share of the variance, in [0, 1]
    chance: float                   # the same with the coordinate shifted in time, median
    line: float | None = None       # strongest line: over time [Hz], over a motor turn [1/turn]

    @property
    def beyond_chance(self) -> float:
        """Return how much of what chance leaves is told by the coordinate, at most 1."""
        return (self.eta2 - self.chance) / max(1.0 - self.chance, 1e-12)


class Line(NamedTuple):
    """The strongest line of a spectrum."""

    frequency: float                # [Hz]
    share: float                    # of the variance, in [0, 1]


class Binned(NamedTuple):
    """A residual in bins of a coordinate, (b,) each: middle of the bin, median and quartiles."""

    centre: Array
    median: Array
    low: Array
    high: Array


def telling_coordinate(exhibits: Exhibits, column: int) -> tuple[str, float]:
    """
    Return the coordinate on which the residual of a column depends most, and its eta squared.

    `time` is returned where nothing that moves tells the residual.
    """
    best = dependences(exhibits, column)[0]
    return best.coordinate, best.eta2


def dependences(exhibits: Exhibits, column: int) -> list[Dependence]:
    """Return how far a column's residual depends on each coordinate of its joint, best first."""
    valid = exhibits.valid[:, column]
    values = exhibits.before[valid, column]
    direction = _coordinate(exhibits, 'motor_velocity', column) > 0.0
    found = [_moving(values, valid, direction, name, _coordinate(exhibits, name, column))
             for name in exhibits.coordinates if _is_told(exhibits, name, column)]
    found.append(_over_time(exhibits.time, values, valid))
    other_side = VELOCITIES[column < len(exhibits.labels)]
    return sorted(found, key=lambda told: _TIE * (told.coordinate == other_side) - _rank(told))


def strongest_line(time: Array, values: Array) -> Line:
    """Return the strongest line in the spectrum of evenly spaced values (m,)."""
    window = np.hanning(len(values))
    power = np.abs(np.fft.rfft((values - values.mean()) * window)) ** 2
    power[:_LINE] = 0.0             # a trend is no line
    if len(power) <= 2 * _LINE or not power.sum() > 0.0:
        return Line(math.nan, 0.0)
    peak = int(np.clip(np.argmax(power), _LINE, len(power) - 2))
    near = power[peak - _LINE:peak + _LINE + 1]
    low, middle, high = np.log(np.maximum(power[peak - 1:peak + 2], 1e-300))
    bend = 2.0 * middle - low - high
    between = 0.5 * (high - low) / bend if bend > 0.0 else 0.0
    period = (time[-1] - time[0]) * len(time) / (len(time) - 1)
    return Line((peak + float(between)) / period, float(near.sum() / power.sum()))


def binned(coordinate: Array, values: Array, bins: int) -> Binned:
    """Return median and quartiles of values (k,) in bins of equally many samples."""
    order = np.argsort(coordinate, kind='stable')
    parts = [part for part in np.array_split(order, bins) if len(part)]
    middle = np.array([np.median(coordinate[part]) for part in parts])
    low, median, high = np.array([np.quantile(values[part], (0.25, 0.5, 0.75))
                                  for part in parts]).reshape(-1, 3).T
    return Binned(middle, median, low, high)


def along(exhibits: Exhibits, told: Dependence, column: int) -> Array:
    """Return the coordinate (m,) of a dependence, within its period if it has one."""
    if told.coordinate == 'time':
        return exhibits.time if told.line is None else np.mod(exhibits.time, 1.0 / told.line)
    values = _coordinate(exhibits, told.coordinate, column)
    return np.mod(values, TURN) if told.coordinate == WRAPPED else values


def _coordinate(exhibits: Exhibits, name: str, column: int) -> Array:
    return exhibits.coordinates[name][:, column % len(exhibits.labels)]


def _is_told(exhibits: Exhibits, name: str, column: int) -> bool:
    """Tell whether a coordinate varies enough; a part of a turn looks like the link angle."""
    values = _coordinate(exhibits, name, column)[exhibits.valid[:, column]]
    if not len(values) or not np.isfinite(values).all():
        return False
    travel = float(np.ptp(values))
    return travel >= TURNS * TURN if name == WRAPPED else travel > 0.0


def _moving(values: Array, valid: Mask, direction: Mask, name: str,
            coordinate: Array) -> Dependence:
    """Return the dependence on a coordinate (m,), split by direction if that tells much more."""
    bins, count = _bins(name, coordinate, len(values))
    chance = float(np.median([_eta2(values, shifted[valid], count)
                              for shifted in _shifted(bins)]))
    plain = Dependence(name, False, _eta2(values, bins[valid], count), chance,
                       _order(values, bins[valid], count) if name == WRAPPED else None)
    if name in VELOCITIES:
        return plain
    split = _split(values, valid, direction, name, bins, count)
    return plain if split is None or _rank(split) <= _rank(plain) else split


def _split(values: Array, valid: Mask, direction: Mask, name: str, bins: Bins,
           count: int) -> Dependence | None:
    """Return the dependence by direction, or None if little of it is the coordinate's own."""
    cells = bins + count * direction
    eta2 = _eta2(values, cells[valid], 2 * count)
    alone = np.median([_eta2(values, (shifted + count * direction)[valid], 2 * count)
                       for shifted in _shifted(bins)])
    if eta2 - alone < _BESIDES:
        return None
    chance = float(np.median([_eta2(values, shifted[valid], 2 * count)
                              for shifted in _shifted(cells)]))
    return Dependence(name, True, eta2, chance,
                      _order(values * np.where(direction[valid], 1.0, -1.0), bins[valid], count)
                      if name == WRAPPED else None)


def _over_time(time: Array, values: Array, valid: Mask) -> Dependence:
    """Return the dependence on time: on when it is, or on the phase of one line."""
    bins, count = _bins('time', time, len(values))
    spread = np.zeros(len(time))
    spread[valid] = values - values.mean() if len(values) else 0.0
    line = strongest_line(time, spread)
    when = _eta2(values, bins[valid], count)
    if when >= line.share:
        return Dependence('time', False, when, 0.0)
    return Dependence('time', False, line.share, 0.0, line.frequency)


def _order(values: Array, bins: Bins, count: int) -> float | None:
    """Return how often the strongest wave in values (k,) repeats within all bins."""
    means = np.bincount(bins, values, count) / np.maximum(np.bincount(bins, minlength=count), 1)
    size = np.abs(np.fft.rfft(means))[1:]
    return float(1 + np.argmax(size)) if size.any() else None


def _rank(told: Dependence) -> float:
    """Return what dependences are ordered by: everything is some function of time."""
    if told.coordinate == 'time':
        return told.beyond_chance / _EVERYTHING
    return told.beyond_chance - _SIMPLER * told.by_direction


def _bins(name: str, coordinate: Array, samples: int) -> tuple[Bins, int]:
    """Return the bin (m,) of each sample, and how many bins there are."""
    most = TURN_BINS if name == WRAPPED else MOST_BINS
    count = int(np.clip(samples // (2 * PER_BIN), 2, most))
    if name == WRAPPED:
        return np.minimum((np.mod(coordinate, TURN) / TURN * count).astype(np.int64),
                          count - 1), count
    if name in VELOCITIES:
        reach = np.linspace(-1.0, 1.0, count + 1)[1:-1]
        edges = np.quantile(np.abs(coordinate), 0.98) * reach ** 3  # friction turns at low speed
    else:
        edges = np.quantile(coordinate, np.arange(1, count) / count)
    return np.searchsorted(edges, coordinate, side='right').astype(np.int64), count


def _eta2(values: Array, bins: Bins, count: int) -> float:
    """Return the share of the variance of values (k,) that lies between their bins (k,)."""
    if not len(values):
        return 0.0
    away = values - values.mean()
    total = float(away @ away)
    if not total > 0.0:
        return 0.0
    filled = np.bincount(bins, minlength=count)
    sums = np.bincount(bins, away, minlength=count)
    return float(np.sum(sums ** 2 / np.maximum(filled, 1))) / total


def _shifted(labels: Bins) -> Iterator[Bins]:
    """Yield labels (m,) shifted around in time, by steps that no periodic motion repeats."""
    golden = 0.5 * (math.sqrt(5.0) - 1.0)
    for place in range(1, _SHIFTS + 1):
        yield np.roll(labels, round((0.05 + 0.9 * (place * golden % 1.0)) * len(labels)))
