"""
Readings that are the one before once more, while the arm moved.

An encoder that counts coarsely repeats by itself when it is slow, and a noisy one by chance. So it
is asked only where it moves by more than its counts and its noise from sample to sample. All that
do must repeat at once, and the next other reading must make up for it. An arm that really stops
does not jump.
"""

from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array, Mask
import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from .raw_cause import BETWEEN
from ...significance import DEVIATIONS, MOSTLY, NORMAL_MEDIAN

_WINDOW, _DEGREE = 17, 3        # of the polynomials that give the usual change [samples]


class Repeats(NamedTuple):
    """Which samples (k,) repeat the one before, and which would show it."""

    repeated: Mask
    watched: Mask


def repeats_of(reading: Array, steps: Array, absent: Mask | None = None) -> Repeats:
    """
    Return the repeated samples of readings (k, n, 2) of encoders with these steps (n, 2).

    What is `absent` (k,) was never read. A streak of repeats is made up for by the reading after.
    """
    came = np.arange(len(reading)) if absent is None else np.flatnonzero(~absent)
    usual = savgol_filter(reading, _WINDOW, _DEGREE, deriv=1, axis=0)[came]
    change = np.diff(reading[came], axis=0, prepend=reading[came][:1])
    noise = np.median(np.abs(change - usual), axis=0) / NORMAL_MEDIAN
    quick = np.abs(usual) > np.maximum(BETWEEN * np.maximum(steps, _smallest(change)),
                                       DEVIATIONS * noise)
    watched = np.asarray(quick.any(axis=(1, 2)))
    same = watched & ((change == 0.0) | ~quick).all(axis=(1, 2))
    streak, end = _streaks(same)
    between = (1.0 + MOSTLY * streak)[:, None, None]        # it stood, and it only seemed to
    made_up = change[end] * np.sign(usual) > between * np.abs(usual)
    repeated = same & (made_up | ~quick).all(axis=(1, 2))
    return Repeats(_among(came, repeated, len(reading)), _among(came, watched, len(reading)))


def _streaks(marked: Mask) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return how long the streaks of marked samples (k,) are, and which sample is next to each."""
    count = np.arange(len(marked))
    before = np.maximum.accumulate(np.where(marked, 0, count))
    after = np.minimum.accumulate(np.where(marked, len(marked) - 1, count)[::-1])[::-1]
    return after - before - 1, after


def _among(places: NDArray[np.intp], marked: Mask, count: int) -> Mask:
    """Return which of all samples (count,) are marked ones, of those at some places."""
    mask = np.zeros(count, bool)
    mask[places] = marked
    return mask


def _smallest(change: Array) -> Array:
    """Return the smallest changes (n, 2) that encoders show, a count if they count."""
    size = np.where(change == 0.0, np.inf, np.abs(change))
    least = size.min(axis=0)
    return np.where(np.isfinite(least), least, 0.0)
