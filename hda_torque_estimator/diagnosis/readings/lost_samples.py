"""
Find samples that were lost, repeated or late, and put in what the encoders would have shown.

A reading of another time than its stamp says is off by speed times that time, in all encoders at
once. Against the curve through its neighbours, each sample gives the time by which it slipped.
What slips by itself, where an encoder counts coarsely, a clock jitters or a motion is quicker than
the samples resolve, does so all about. A sample must slip far more than those near it usually do.

Mishaps come in bursts. There neighbours are wrong as well, so each is asked by good samples alone.
"""

from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array, Mask
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import CoarseQuantisation, DroppedSamples
import numpy as np
from scipy.ndimage import binary_closing, convolve1d, label, maximum_filter1d, median_filter
from scipy.signal import savgol_filter
from scipy.special import xlogy
from scipy.stats import chi2

from .over_gaps import blind_gaps, GAIN, KERNEL, laid, REACH, runs_of
from .raw_cause import HitSamples, RawCause, WRONG
from .repeats import repeats_of
from ..findings.gains import Gains
from ..findings.report import FittedNumber
from ...measurements.measurement import Measurement
from ...measurements.running_clock import Spans
from ...significance import DEVIATIONS, HARDLY, NORMAL_MEDIAN, SCORE_BAR, UNLIKE

# Numerics; choices unless stated otherwise.
_NEARBY = 25            # samples on each side that show how much samples slip by themselves
_PASSES = 12            # slipped samples next to each other come to light one by one
_RATES = 200            # that are tried
_CHANCE = 0             # seed of counts that chance makes
_FEWEST = 1e-12         # wrong samples of a stretch in which none can be
_RATE = 'rate'           # of what is lost


class Slips(NamedTuple):
    """Readings (k, n, 2) with slipped samples replaced, and which samples (k,) they are."""

    reading: Array
    slipped: Mask           # seen in the readings
    watched: Mask           # moved fast enough to be seen if they had slipped or repeated
    lost: Mask              # by the stamps
    repeated: Mask          # of the slipped ones: the reading before once more
    blind: tuple[int, ...]  # samples in which nobody knows how the arm moved


def lost_samples(slips: Slips, seen: Mask) -> RawCause | None:
    """
    Return the cause that slipped samples in rows `seen` make, None if tolerably few.

    Stamps of a host that come late slip as well. So enough samples must be lost or repeated.
    """
    watched = slips.watched & seen
    slipped, lost = int((slips.slipped & watched).sum()), int((slips.lost & seen).sum())
    of_slips, of_lost = slipped / max(int(watched.sum()), 1), lost / max(int(seen.sum()), 1)
    rate = of_slips + of_lost
    hits = slipped + lost
    score, surely = _evidence(hits, rate), int((slips.repeated & watched).sum()) + lost
    if min(score, _evidence(surely, rate * surely / max(hits, 1))) < SCORE_BAR:
        return None
    low, high = (rate * float(0.5 * chi2.ppf(share, 2 * hits + more) / hits)
                 for share, more in ((0.05, 0), (0.95, 2)))
    joints, sides = slips.reading.shape[1:]
    return RawCause(DroppedSamples(rate=rate), None, {_RATE: FittedNumber(rate, '', low, high)},
                    score,
                    tuple((column, side) for column in range(joints) for side in range(sides)),
                    counted=HitSamples(
                        slips.slipped & slips.watched | slips.lost,
                        np.where(slips.watched, of_slips + of_lost, of_lost)))


def counted_gains(cause: RawCause, given: Arm, spans: Spans, dt: float) -> Gains | None:
    """
    Return how far counts of wrong samples in stretches are from those that rates call for.

    None of a cause that hits no single samples. They are compared by the deviance of Poisson
    (eq:deviance). The rates are that of the cause, and that of the arm as `given`, or a tolerable
    one.
    """
    if cause.counted is None:
        return None
    rows = [slice(round(begin / dt), round(end / dt)) for begin, end in spans]
    hits, due = (np.array([part[row].sum() for row in rows], np.float64)
                 for part in cause.counted)
    rate = cause.numbers[_RATE].value
    usual = max(getattr(given.effect(cause.effect.name, None), _RATE), WRONG)
    drawn = np.random.default_rng(_CHANCE).poisson(due)
    return Gains(*(_deviance(*each) for each in (
        (hits, due * usual / rate), (hits, due), (drawn, due))))


def _deviance(hits: Array, due: Array) -> Array:
    """Return twice the log likelihood that counts (w,) lack beside their own rates."""
    due = np.maximum(due, _FEWEST)
    return np.asarray(2.0 * (xlogy(hits, hits / due) - (hits - due)))


def smallest_rate(slips: Slips, seen: Mask) -> float | None:
    """Return the smallest share of slipped samples that rows `seen` would show, or None."""
    watched = int((slips.watched & seen).sum())
    rates = np.geomspace(WRONG, DroppedSamples.declaration(_RATE).high, _RATES).tolist()
    return next((rate for rate in rates if rate * watched >= 1.0
                 and _evidence(round(rate * watched), rate) > SCORE_BAR), None)


def slips_of(measurement: Measurement, arm: Arm) -> Slips:
    """Return the slipped samples of a measurement whose encoders count as those of `arm`."""
    recorded, absent = measurement.reading, measurement.put_in
    scatter, lost = _scatter(recorded, steps_of(arm)), absent & ~_paused(absent)
    free = ~absent
    free[:2 * REACH], free[-2 * REACH:] = False, False
    again = repeats_of(recorded, steps_of(arm), absent)
    repeated = slipped = again.repeated & free
    watched = slipped
    for _ in range(_PASSES):
        good = ~(slipped | absent)
        fresh, watched = _slipping(_mended(recorded, slipped | lost, good), good, scatter)
        fresh &= free & good
        if not fresh.any():
            break
        slipped = free & _asked_again(recorded, slipped | fresh, repeated | absent, scatter)
    wrong, watched = slipped | absent, watched | again.watched
    blind = blind_gaps(recorded, wrong, watched & ~wrong, scatter, measurement.dt)
    return Slips(_mended(recorded, slipped | lost, ~wrong), slipped, watched & free, lost,
                 repeated, tuple(np.flatnonzero(blind).tolist()))


def _mended(reading: Array, wrong: Mask, good: Mask) -> Array:
    """Return readings (k, n, 2) with the wrong ones on curves through good ones."""
    mended, places = reading.copy(), np.flatnonzero(wrong)
    if len(places):
        mended[places] = laid(reading, good, places).reading
    return mended


def _slipping(reading: Array, good: Mask, scatter: Array) -> tuple[Mask, Mask]:
    """Return which good samples slip, more than their neighbours, and which would show it."""
    curve, noise = _beside_gaps(reading, good, scatter)
    speed = savgol_filter(reading, 4 * REACH + 1, 3, deriv=1, axis=0) / noise
    away = np.where(good[:, None, None], reading - curve, 0.0) / noise
    slip, power = _slip(away, speed)
    spread = _usual(slip * np.sqrt(power)) / np.sqrt(power)
    common = slip ** 2 * power > (1.0 - UNLIKE) * (away ** 2).sum(axis=(1, 2))
    clear = (np.abs(slip) > np.maximum(HARDLY, np.sqrt(SCORE_BAR) * spread)) & common
    highest = np.abs(slip) >= maximum_filter1d(np.abs(slip), 2 * REACH + 1)
    return clear & highest, np.sqrt(SCORE_BAR) * spread < HARDLY


def _beside_gaps(reading: Array, good: Mask, scatter: Array) -> tuple[Array, Array]:
    """Return curves through good neighbours (k, n, 2), and how far off they usually are."""
    curve, noise = convolve1d(reading, KERNEL, axis=0), np.ones((len(reading), 1, 1)) * scatter
    beside = good & maximum_filter1d(~good, 2 * REACH + 1)
    beside[:2 * REACH], beside[-2 * REACH:] = False, False
    places = np.flatnonzero(beside)
    if len(places):
        found = laid(reading, good, places)
        curve[places] = found.reading
        noise[places] *= found.gain[:, None, None] / GAIN
    return curve, noise


def _slip(away: Array, speed: Array) -> tuple[Array, Array]:
    """Return by how much samples slip that are `away`, and what that is known by (k,)."""
    power = (speed ** 2).sum(axis=(1, 2)) + 1e-30
    return (away * speed).sum(axis=(1, 2)) / power, power


def _asked_again(reading: Array, slipped: Mask, surely: Mask, scatter: Array) -> Mask:
    """
    Return which samples slipped, of those that may have and those between them.

    A curve through one wrong sample makes others near it look wrong. So where several lie within
    its reach, they and all between them are asked again, by curves through good ones alone. The
    best known of each group comes first, and if it is good helps to know the others.
    """
    wrong = slipped | surely
    group, count = label(binary_closing(np.pad(wrong, REACH), np.ones(2 * REACH + 1, bool)))
    group = group[REACH:-REACH]
    several = np.bincount(group, wrong, count + 1) > 1.0
    several[0] = False
    asked = several[group] & ~surely
    wrong = wrong & ~asked
    while asked.any():
        places = np.flatnonzero(asked)
        curves = laid(reading, ~(wrong | asked), places)
        order = np.lexsort((curves.gain, group[places]))
        first = order[np.diff(group[places[order]], prepend=0) > 0]
        best = places[first]
        noise = scatter * (curves.gain[first] / GAIN)[:, None, None]
        slip, power = _slip((reading[best] - curves.reading[first]) / noise,
                            curves.change[first] / noise)
        wrong[best] = np.abs(slip) > np.maximum(HARDLY, DEVIATIONS / np.sqrt(power))
        asked[best] = False
    return wrong


def _usual(slip: Array) -> Array:
    """Return by how much more than noise samples slip where they are (k,), from slips over it."""
    return np.maximum(median_filter(np.abs(slip), 2 * _NEARBY + 1) / NORMAL_MEDIAN, 1.0)


def _scatter(reading: Array, steps: Array) -> Array:
    """Return how far readings of healthy samples are from their curves (n, 2) [rad]."""
    away = reading - convolve1d(reading, KERNEL, axis=0)
    usual = np.median(np.abs(away), axis=0) / NORMAL_MEDIAN
    return np.maximum(np.maximum(usual, GAIN * steps / np.sqrt(12.0)), 1e-12)


def steps_of(arm: Arm) -> Array:
    """Return the steps of all encoders (n, 2) [rad]."""
    return np.array([arm.effect(CoarseQuantisation.name, label).values() for label in arm.labels])


def _paused(absent: Mask) -> Mask:
    """
    Return which absent samples belong to a pause of the recording.

    More are absent in a row than a curve is laid through: nothing shows that an arm moved on.
    """
    paused = np.zeros(len(absent), bool)
    for run in runs_of(absent):
        paused[run] = run.stop - run.start > 2 * REACH
    return paused


def _evidence(count: int, rate: float) -> float:
    """Return twice the log likelihood ratio of so many slips to those of a tolerable rate."""
    if rate <= WRONG:
        return 0.0
    samples = count / rate
    return 2.0 * float(xlogy(count, rate / WRONG)
                       + xlogy(samples - count, (1.0 - rate) / (1.0 - WRONG)))
