"""Align two recordings of one motion roughly in time, by cross-correlation."""

from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
import numpy as np
from numpy.typing import NDArray
from scipy.signal import correlate, find_peaks

_SHARE = 0.25                       # least overlap, of the shorter recording
_TIE = 0.002                        # correlations that differ less are alike


class Coarse(NamedTuple):
    """Hold the lag of the best correlation, and those of others as good."""

    lag: int                        # samples by which the second is later
    correlation: float              # of the rates of change, in [-1, 1]
    rivals: tuple[int, ...]


def coarse(first: Array, second: Array) -> Coarse:
    """
    Return the lag at which the changes of two sets of signals (n, s), (m, s) are most alike.

    Where several lags are alike, since the motion repeats itself, the one of most overlap counts.
    """
    lags, alike = correlations(np.gradient(first, axis=0), np.gradient(second, axis=0))
    best = float(alike.max())
    peaks = find_peaks(np.pad(alike, 1, constant_values=-np.inf))[0] - 1
    peaks = peaks if len(peaks) else np.array([int(alike.argmax())])
    near = peaks[1.0 - alike[peaks] <= 2.0 * (1.0 - best) + _TIE]
    ends = len(first) - len(second)
    chosen = int(min(near, key=lambda peak: abs(2 * lags[peak] - ends)))
    return Coarse(int(lags[chosen]), float(alike[chosen]),
                  tuple(int(lags[peak]) for peak in near if peak != chosen))


def correlations(first: Array, second: Array) -> tuple[NDArray[np.int64], Array]:
    """Return lags that leave enough overlap, and the correlation of all signals at each."""
    scale = np.sqrt(0.5 * ((first ** 2).mean(axis=0) + (second ** 2).mean(axis=0)))
    one, two = first / scale, second / scale
    ones = np.ones(len(one)), np.ones(len(two))
    both = sum(correlate(a, b, method='fft') for a, b in zip(one.T, two.T))
    energy = (np.maximum(correlate((one ** 2).sum(axis=1), ones[1], method='fft'), 0.0)
              * np.maximum(correlate(ones[0], (two ** 2).sum(axis=1), method='fft'), 0.0))
    lags = np.arange(len(one) + len(two) - 1) - (len(two) - 1)
    overlap = np.minimum(len(one), lags + len(two)) - np.maximum(lags, 0)
    # Where either hardly moves in the overlap, being alike shows nothing.
    observable = energy > 0.01 * energy.max()
    kept = (overlap >= _SHARE * min(len(one), len(two))) & observable
    return lags[kept], np.asarray(both)[kept] / np.sqrt(energy[kept])
