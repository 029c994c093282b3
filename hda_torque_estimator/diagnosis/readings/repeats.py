"""
Readings that are the one before once more, while the arm moved.

An encoder that counts coarsely repeats by itself when it is slow, and a noisy one by chance. So it
is asked only where it moves by more than its counts and its noise from sample to sample. All that
do must repeat at once, and the next reading must make up for it: an arm that really stops does not
jump.
"""

from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array, Mask
import numpy as np
from scipy.signal import savgol_filter

from .raw_cause import BETWEEN
from ...significance import DEVIATIONS, NORMAL_MEDIAN

_WINDOW, _DEGREE = 17, 3        # of the polynomials that give the usual change [samples]


class Repeats(NamedTuple):
    """Which samples (k,) repeat the one before, and which would show it."""

    repeated: Mask
    watched: Mask


def repeats_of(reading: Array, steps: Array) -> Repeats:
    """Return the repeated samples of readings (k, n, 2) of encoders with these steps (n, 2)."""
    change = np.diff(reading, axis=0, prepend=reading[:1])
    usual = savgol_filter(reading, _WINDOW, _DEGREE, deriv=1, axis=0)
    noise = np.median(np.abs(change - usual), axis=0) / NORMAL_MEDIAN
    quick = np.abs(usual) > np.maximum(BETWEEN * np.maximum(steps, _smallest(change)),
                                       DEVIATIONS * noise)
    after = np.roll(change, -1, axis=0)
    again = (change == 0.0) & (after * np.sign(usual) > BETWEEN * np.abs(usual))
    watched = np.asarray(quick.any(axis=(1, 2)))
    return Repeats(watched & (again | ~quick).all(axis=(1, 2)), watched)


def _smallest(change: Array) -> Array:
    """Return the smallest changes (n, 2) that encoders show, a count if they count."""
    size = np.where(change == 0.0, np.inf, np.abs(change))
    least = size.min(axis=0)
    return np.where(np.isfinite(least), least, 0.0)
