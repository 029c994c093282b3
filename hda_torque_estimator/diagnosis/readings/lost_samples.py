"""
Find samples that were lost, repeated or late, and put in what the encoders would have shown.

A reading of another time than its stamp says is off by speed times that time, in all encoders at
once. Against the curve through its neighbours, each sample gives the time by which it slipped.
What slips by itself, where an encoder counts coarsely, a clock jitters or a motion is quicker than
the samples resolve, does so all about. A sample must slip far more than those near it usually do.
"""

from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array, Mask
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import CoarseQuantisation, DroppedSamples
import numpy as np
from scipy.ndimage import convolve1d, maximum_filter1d, median_filter
from scipy.signal import savgol_filter
from scipy.special import xlogy
from scipy.stats import chi2

from .raw_cause import RawCause, WRONG
from .repeats import repeats_of
from ..findings.report import FittedNumber
from ...measurements.measurement import Measurement
from ...significance import HARDLY, NORMAL_MEDIAN, SCORE_BAR, UNLIKE

# Numerics; choices unless stated otherwise.
_REACH = 4              # neighbours on each side through which a curve is laid
_NEARBY = 25            # samples on each side that show how much samples slip by themselves
_PASSES = 12            # slipped samples next to each other come to light one by one
_RATES = 200            # that are tried


class Slips(NamedTuple):
    """Readings (k, n, 2) with slipped samples replaced, and which samples (k,) they are."""

    reading: Array
    slipped: Mask           # seen in the readings
    watched: Mask           # moved fast enough to be seen if they had slipped or repeated
    lost: Mask              # by the stamps
    repeated: Mask          # of the slipped ones: the reading before once more


def lost_samples(slips: Slips, seen: Mask) -> RawCause | None:
    """
    Return the cause that slipped samples in rows `seen` make, None if tolerably few.

    Stamps of a host that come late slip as well. So enough samples must be lost or repeated.
    """
    watched = slips.watched & seen
    slipped, lost = int((slips.slipped & watched).sum()), int((slips.lost & seen).sum())
    rate = slipped / max(int(watched.sum()), 1) + lost / max(int(seen.sum()), 1)
    hits = slipped + lost
    score, surely = _evidence(hits, rate), int((slips.repeated & watched).sum()) + lost
    if min(score, _evidence(surely, rate * surely / max(hits, 1))) < SCORE_BAR:
        return None
    low, high = (rate * float(0.5 * chi2.ppf(share, 2 * hits + more) / hits)
                 for share, more in ((0.05, 0), (0.95, 2)))
    joints, sides = slips.reading.shape[1:]
    return RawCause(DroppedSamples(rate=rate), None, {'rate': FittedNumber(rate, '', low, high)},
                    score,
                    tuple((column, side) for column in range(joints) for side in range(sides)))


def smallest_rate(slips: Slips, seen: Mask) -> float | None:
    """Return the smallest share of slipped samples that rows `seen` would show, or None."""
    watched = int((slips.watched & seen).sum())
    rates = np.geomspace(WRONG, DroppedSamples.declaration('rate').high, _RATES).tolist()
    return next((rate for rate in rates if rate * watched >= 1.0
                 and _evidence(round(rate * watched), rate) > SCORE_BAR), None)


def slips_of(measurement: Measurement, arm: Arm) -> Slips:
    """Return the slipped samples of a measurement whose encoders count as those of `arm`."""
    kernel, steps = _through_neighbours(), steps_of(arm)
    reading, absent = measurement.reading.copy(), measurement.put_in
    scatter = _scatter(reading - convolve1d(reading, kernel, axis=0), steps,
                       float(np.sqrt(1.0 + kernel @ kernel)))
    ends = np.zeros(len(reading), bool)
    ends[:2 * _REACH], ends[-2 * _REACH:] = True, True
    again = repeats_of(reading, steps)
    slipped = again.repeated & ~(ends | absent)
    watched = slipped
    for _ in range(_PASSES):
        curve = convolve1d(reading, kernel, axis=0)
        fresh, watched = _slipping(reading, curve, scatter)
        fresh &= ~(ends | absent)
        if not fresh.any() and not (slipped | absent).any():
            break
        slipped |= fresh
        reading[slipped | absent] = curve[slipped | absent]
    return Slips(reading, slipped, (watched | again.watched) & ~(ends | absent),
                 absent & ~_paused(absent), again.repeated & ~(ends | absent))


def _slipping(reading: Array, curve: Array, scatter: Array) -> tuple[Mask, Mask]:
    """Return which samples slip, more than their neighbours, and which would show it."""
    speed = savgol_filter(reading, 4 * _REACH + 1, 3, deriv=1, axis=0) / scatter
    away = (reading - curve) / scatter
    power = (speed ** 2).sum(axis=(1, 2)) + 1e-30
    slip = (away * speed).sum(axis=(1, 2)) / power
    spread = _usual(slip * np.sqrt(power)) / np.sqrt(power)
    common = slip ** 2 * power > (1.0 - UNLIKE) * (away ** 2).sum(axis=(1, 2))
    clear = (np.abs(slip) > np.maximum(HARDLY, np.sqrt(SCORE_BAR) * spread)) & common
    highest = np.abs(slip) >= maximum_filter1d(np.abs(slip), 2 * _REACH + 1)
    return clear & highest, np.sqrt(SCORE_BAR) * spread < HARDLY


def _usual(slip: Array) -> Array:
    """Return by how much more than noise samples slip where they are (k,), from slips over it."""
    return np.maximum(median_filter(np.abs(slip), 2 * _NEARBY + 1) / NORMAL_MEDIAN, 1.0)


def _through_neighbours() -> Array:
    """Return weights (2 reach + 1,) of a cubic through the neighbours, at the sample between."""
    places = np.arange(-_REACH, _REACH + 1, dtype=float)
    near = places != 0.0
    weights = np.zeros(len(places))
    weights[near] = np.linalg.pinv(np.vander(places[near], 4))[-1]
    return weights


def _scatter(away: Array, steps: Array, gain: float) -> Array:
    """Return how far readings of healthy samples are from their curves (n, 2) [rad]."""
    usual = np.median(np.abs(away), axis=0) / NORMAL_MEDIAN
    return np.maximum(np.maximum(usual, gain * steps / np.sqrt(12.0)), 1e-12)


def steps_of(arm: Arm) -> Array:
    """Return the steps of all encoders (n, 2) [rad]."""
    return np.array([arm.effect(CoarseQuantisation.name, label).values() for label in arm.labels])


def _paused(absent: Mask) -> Mask:
    """
    Return which absent samples belong to a pause of the recording.

    More are absent in a row than a curve is laid through: nothing shows that an arm moved on.
    """
    edges = np.flatnonzero(np.diff(absent.astype(int), prepend=0, append=0))
    paused = np.zeros(len(absent), bool)
    for begin, end in zip(edges[::2], edges[1::2]):
        paused[begin:end] = end - begin > 2 * _REACH
    return paused


def _evidence(count: int, rate: float) -> float:
    """Return twice the log likelihood ratio of so many slips to those of a tolerable rate."""
    if rate <= WRONG:
        return 0.0
    samples = count / rate
    return 2.0 * float(xlogy(count, rate / WRONG)
                       + xlogy(samples - count, (1.0 - rate) / (1.0 - WRONG)))
