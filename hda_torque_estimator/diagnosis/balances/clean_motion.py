"""
Motion as far as it is above the noise of its readings (eq:clean-motion).

A twin that follows noise as well has it in its derivatives. They go with the noise of the
recording then, of which instruments must know nothing.
"""

from typing import Literal

from hda_arm_sim.foundation.arrays import Array
import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.signal import firwin2, oaconvolve, welch

from .whitening import MOTION
from ...least_squares.normal import TINY
from ...significance import MOSTLY

Parity = Literal['odd', 'even']
# Numerics; choices unless stated otherwise.
_WINDOW = 1.0           # that a filter sees, and that spectra are of [s]
_BINS = 1.0             # of a spectrum that are smoothed together
_BURIED = 0.3           # noise over what is read, from which nothing passes
_QUIET = 0.5            # of the highest frequency of readings, above which they show noise alone


class CleanMotion:
    """Filters without delay, one for each joint, that pass what is far above noise."""

    def __init__(self, reading: Array, noise: Array, period: float, dt: float) -> None:
        """
        Learn from readings (r, n) that are a `period` apart, for samples `dt` apart [s].

        What is quick in them is noise, and white, where it is no more than twice the `noise` (n,)
        of quiet readings: an arm may shake. What is slower than MOTION passes as it is.
        """
        self._taps = [np.ones(1)] * reading.shape[1]
        size = round(_WINDOW / period)
        if size > len(reading):
            return
        frequency, power = welch(np.diff(reading, 2, axis=0), 1.0 / period, nperseg=size, axis=0)
        of_difference = 2.0 * np.sin(np.pi * frequency * period)[:, None]
        power = gaussian_filter1d(power, _BINS, axis=0) / np.maximum(of_difference ** 4, TINY)
        quick = np.median(power[frequency > _QUIET * frequency[-1]], axis=0)
        white = np.minimum(quick, 2.0 * period * (noise / MOSTLY) ** 2)
        gain = np.clip(1.0 - white / np.maximum(_BURIED * power, TINY), 0.0, 1.0)
        gain[frequency < MOTION] = 1.0
        self._taps = [_taps(frequency, column, dt) for column in gain.T]

    def angles(self, measured: Array) -> Array:
        """Return angles without noise (k, n) [rad]."""
        return self._filtered(measured, 'odd')

    def rates(self, measured: Array) -> Array:
        """Return the rates of such angles (k, n) [rad/s]."""
        return self._filtered(measured, 'even')

    def _filtered(self, measured: Array, parity: Parity) -> Array:
        return np.stack([_filtered(column, taps, parity)
                         for column, taps in zip(measured.T, self._taps)], axis=1)


def _taps(frequency: Array, gain: Array, dt: float) -> Array:
    """Return the taps (2 r + 1,) of a filter with these gains, that passes a constant as it is."""
    reach, most = round(0.5 * _WINDOW / dt), 0.5 / dt
    grid, gains = [*frequency[:-1].tolist(), most], [*gain[:-1].tolist(), 0.0]
    taps = firwin2(2 * reach + 1, grid, gains, fs=2.0 * most,
                   nfreqs=1 + 2 ** (4 * reach).bit_length())
    return np.asarray(taps / taps.sum())


def _filtered(values: Array, taps: Array, parity: Parity) -> Array:
    """Return values (k,) after a filter, which are of this parity about both of their ends."""
    reach = len(taps) // 2
    if reach == 0 or reach >= len(values):
        return values
    longer = np.pad(values, reach, 'reflect', reflect_type=parity)
    return np.asarray(oaconvolve(longer, taps, 'valid'))
