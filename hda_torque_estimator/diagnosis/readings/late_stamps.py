"""
Find stamps that do not say when a sample was taken: the jitter of a clock, (eq:stamped-slip).

An encoder that is dated wrongly shows the angle of another time. So readings, dated by their
stamps, are off by speed times that time, in all encoders at once. Slips are asked for from sample
to sample: in the eighth differences of readings no motion is left that samples resolve.

Stamps of a host come late. Then readings are smoother on an even grid than where stamps date
them, and the grid shows how late each is. Or stamps are even and the sampling is not. Then slips
are what independent encoders have in common. Stamps that know an uneven sampling date readings
rightly, whatever its jitter: that is no fault.
"""

from collections.abc import Iterator
from dataclasses import replace
import math
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array, Mask
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import ClockJitter
from hda_arm_sim.stamping import Stamper
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import convolve1d, median_filter
from scipy.signal import savgol_filter

from .local_rest import local_rest
from .lost_samples import steps_of
from .raw_cause import number, RawCause, TOLERABLE
from ...measurements.even_grid import as_stamped
from ...measurements.measurement import Measurement
from ...significance import (DEVIATIONS, IMMATERIAL, MOSTLY, NORMAL_90, NORMAL_MEDIAN,
                             SCORE_BAR)

# Numerics; choices unless stated otherwise.
_WINDOW, _DEGREE = 17, 3        # of the polynomials that give the speed [samples]
_CLEAR = 0.05           # slip that noise may make of a sample that shows it [samples]
_HALF_CLEAR = 0.1       # likewise of half of the encoders [samples]
_LEAST = 100            # samples that show slips, at least
_NEARBY = 51            # samples of which the usual delay is none of jitter
_STRETCHES = 20         # that are left out in turn for an interval
_TRIED = 200            # sizes, for the smallest one
# Eighth differences: with fewer a quick motion shows in slow samples.
_KERNEL = np.array([1.0, -8.0, 28.0, -56.0, 70.0, -56.0, 28.0, -8.0, 1.0])
_ALONE = float(np.sqrt(_KERNEL @ _KERNEL))      # what they make of a slip
# Variance of the logarithm of a mean square, for each sample of normal noise that these correlate
# (source: the median absolute deviation has 0.3675 of the efficiency of a standard deviation).
_VARIANCE = 2.0 / 0.3675 * float(np.square(np.correlate(_KERNEL, _KERNEL, 'full')).sum()
                                 / _ALONE ** 4)


class StampSlips(NamedTuple):
    """What samples (k,) slip by, all in samples: as stamped, as recorded, and in halves."""

    stamped: Array
    recorded: Array
    watched: Mask               # moved fast enough for slips of this size to show
    halves: tuple[tuple[Array, Array, Mask], ...]   # by independent encoders, where both show them
    past: Array                 # stamps, without what is usual near them
    channels: tuple[tuple[int, int], ...]   # columns and sides that show slips
    dt: float                   # of a sample [s]


class _Spread(NamedTuple):
    """The mean squares of slips: of all, of what is not jitter, and how many are independent."""

    whole: float
    without: float
    apart: float


def clock_jitter(slips: StampSlips, seen: Mask, arm: Arm) -> RawCause | None:
    """Return the cause that stamps in rows `seen` make, None if they say when samples were."""
    rows = slips.watched & seen
    if rows.sum() < _LEAST:
        return None
    spread = _spread(slips, rows)
    score = _evidence(spread, _least(arm, slips.dt))
    if score < SCORE_BAR or not slips.channels:
        return None
    size = slips.dt * _size(slips, rows)
    left_out = [slips.dt * _size(slips, _without(rows, part))
                for part in np.array_split(np.flatnonzero(rows), _STRETCHES)]
    sigma = math.sqrt((_STRETCHES - 1) * float(np.var(left_out)))
    most = ClockJitter.declaration('jitter').high
    effect = ClockJitter(jitter=min(size, most))
    return RawCause(effect, None, {'jitter': number(effect, 'jitter', NORMAL_90 * sigma)}, score,
                    slips.channels)


def smallest_jitter(slips: StampSlips, seen: Mask, arm: Arm) -> float | None:
    """Return the smallest jitter that rows `seen` would show [s], or None."""
    rows = slips.watched & seen
    if rows.sum() < _LEAST:
        return None
    without, least = _spread(slips, rows), _least(arm, slips.dt)
    most = ClockJitter.declaration('jitter').high / slips.dt
    tried: list[float] = np.geomspace(least, most, _TRIED).tolist() if most > least else []
    return next((slips.dt * jitter for jitter in tried if _evidence(
        without._replace(whole=without.without + jitter ** 2), least) > SCORE_BAR), None)


def stamp_slips(measurement: Measurement) -> StampSlips:
    """Return how far samples slip that neither were lost nor repeat the one before."""
    recorded, dt = measurement.reading, measurement.dt
    speed = savgol_filter(recorded, _WINDOW, _DEGREE, deriv=1, axis=0)
    away = convolve1d(recorded, _KERNEL, axis=0) / _ALONE
    scatter = np.maximum(np.median(np.abs(away), axis=0) / NORMAL_MEDIAN, 1e-12)
    moves = speed / scatter
    late = convolve1d(as_stamped(measurement), _KERNEL, axis=0) / _ALONE
    inner = convolve1d(measurement.put_in.astype(float), np.ones(len(_KERNEL))) == 0.0
    inner[:_WINDOW], inner[-_WINDOW:] = False, False
    whole = np.ones(recorded.shape[1:])
    watched = inner & (_noise(moves, whole) < _CLEAR)
    halves = []
    for one in _halves(whole.shape):
        other = whole - one
        clear = inner & (np.maximum(_noise(moves, one), _noise(moves, other)) < _HALF_CLEAR)
        if clear.sum() >= _LEAST:
            halves.append((_slip(late / scatter, moves, one), _slip(late / scatter, moves, other),
                           clear))
    return StampSlips(_slip(late / scatter, moves, whole), _slip(away / scatter, moves, whole),
                      watched, tuple(halves), _beyond_usual(measurement),
                      _channels(late, speed, scatter, watched), dt)


def stamped_along(measurement: Measurement, arm: Arm, seed: int, aside: float = 0.0) -> Array:
    """
    Return what encoders of an arm show beside a recorded motion (k, n, 2), as stamps date it.

    The motion is what local polynomials make of readings on time. No loop reads these stamps.
    """
    random, dt, steps = np.random.default_rng(seed), measurement.dt, steps_of(arm)
    noise = np.array([[joint.motor_encoder.noise, joint.link_encoder.noise]
                      for joint in arm.joints])
    angle = measurement.reading - local_rest(measurement.reading, dt) + aside
    shown = angle + noise * random.standard_normal(angle.shape)
    counts = np.where(steps > 0.0, steps, 1.0)
    shown = np.where(steps > 0.0, counts * np.round(shown / counts), shown)
    taken = np.round(1e9 * dt * np.arange(len(angle))).astype(np.int64)
    late = 1e-9 * (Stamper(arm, seed)(taken) - taken)
    return as_stamped(replace(measurement, reading=shown, past=late - late.mean()))


def _halves(shape: tuple[int, ...]) -> Iterator[Array]:
    """Yield ways to divide encoders (n, 2): motors and links, one joint and the others."""
    yield np.broadcast_to([1.0, 0.0], shape).copy()
    for column in range(shape[0] if shape[0] > 1 else 0):
        one = np.zeros(shape)
        one[column] = 1.0
        yield one


def _slip(away: Array, moves: Array, of: Array) -> Array:
    """Return by how much readings (k, n, 2) of some encoders slip at once (k,) [samples]."""
    power = (of * moves ** 2).sum(axis=(1, 2)) + 1e-30
    return np.asarray((of * away * moves).sum(axis=(1, 2)) / power)


def _noise(moves: Array, of: Array) -> Array:
    """Return the slip that noise of some encoders makes (k,) [samples]."""
    return np.asarray(((of * moves ** 2).sum(axis=(1, 2)) + 1e-30) ** -0.5)


def _beyond_usual(measurement: Measurement) -> Array:
    """Return how much later than those near them samples are stamped (k,) [samples]."""
    past = np.zeros(len(measurement.reading))
    came = ~measurement.put_in
    if len(measurement.past):
        late = measurement.past[came] / measurement.dt
        past[came] = late - median_filter(late, _NEARBY)
    return past


def _channels(late: Array, speed: Array, scatter: Array,
              watched: Mask) -> tuple[tuple[int, int], ...]:
    """Return the columns and sides of which slips are a material share of what scatters."""
    if not watched.any():
        return ()
    slip = _power(_slip(late / scatter, speed / scatter, np.ones(scatter.shape))[watched])
    made = slip * (speed[watched] ** 2).mean(axis=0)
    shown = made > IMMATERIAL * (late[watched] ** 2).mean(axis=0)
    return tuple((int(column), int(side)) for column, side in np.argwhere(shown))


def _power(slips: Array) -> float:
    """Return the mean square of usual slips, whatever a few samples do."""
    return float(np.median(np.abs(slips)) / NORMAL_MEDIAN) ** 2


def _common(slips: StampSlips, rows: Mask) -> float:
    """
    Return the mean square of slips that all encoders surely have in common, 0 if there is none.

    What one joint does alone is its motion, and what one side does alone is its own error. Two
    halves slip alike if their sum surpasses their difference by more than chance, eq:common-slip.
    """
    shared = []
    for one, other, clear in slips.halves:
        both = clear & rows
        if both.sum() >= _LEAST:
            alike, apart = _power((one + other)[both]), _power((one - other)[both])
            chance = math.exp(DEVIATIONS * math.sqrt(2.0 * _VARIANCE / both.sum()))
            shared.append(0.25 * (alike - apart) if alike > chance * apart else 0.0)
    return min(shared, default=0.0)


def _spread(slips: StampSlips, rows: Mask) -> _Spread:
    """Return the mean squares of slips in these rows."""
    whole, recorded = _power(slips.stamped[rows]), _power(slips.recorded[rows])
    without = min(recorded, whole, max(whole - _common(slips, rows), 0.0))
    return _Spread(whole, without, float(rows.sum()) / len(_KERNEL))


def _size(slips: StampSlips, rows: Mask) -> float:
    """
    Return the jitter in these rows [samples]: that of stamps, else that which slips show.

    What of the stamps readings confirm is no jitter: then samples were taken so.
    """
    spread = _spread(slips, rows)
    by_stamps = spread.whole - _power(slips.recorded[rows])
    if by_stamps < MOSTLY * (spread.whole - spread.without):
        return math.sqrt(_common(slips, rows))
    said = slips.recorded[rows] - slips.stamped[rows]           # by the stamps
    right = float(said @ slips.recorded[rows]) / max(float(said @ said), 1e-300)
    return float(np.std(slips.past[rows])) * math.sqrt(min(max(1.0 - right, 0.0), 1.0))


def _least(arm: Arm, dt: float) -> float:
    """Return the jitter that is tolerable, or that is stated [samples]."""
    stated, = arm.effect(ClockJitter.name, None).values()
    return max(TOLERABLE, (1.0 + MOSTLY) * stated / dt)


def _evidence(spread: _Spread, least: float) -> float:
    """Return twice the log likelihood ratio of such slips to those of a tolerable jitter."""
    ratio = spread.whole / (spread.without + least ** 2)
    return spread.apart * (ratio - 1.0 - math.log(ratio)) if ratio > 1.0 else 0.0


def _without(rows: Mask, part: NDArray[np.intp]) -> Mask:
    """Return rows without some of them."""
    kept = rows.copy()
    kept[part] = False
    return kept
