"""
Whiten the noise of balances: what is loud at high frequency must not hide what is slow.

Noise of readings enters by their second differences. Of a slow log nearly all of it is above 8 Hz,
while arms move below 4 Hz. A filter of its own for every balance passes each frequency by as
much as its noise is above that of slow motion (eq:whitening). It passes slow balances as they
are, so residuals keep their unit.
"""

from collections.abc import Sequence
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d
from scipy.signal import firwin2, welch

# Numerics; choices unless stated otherwise.
_SEGMENT = 256          # samples of the balances in a spectrum
_BINS = 1.5             # of a spectrum that are smoothed together
# (source: motions of robots end below 7 Hz, most of their power below 4 Hz)
MOTION = 5.0            # frequency below which an arm moves [Hz]
_WORTH = 0.7            # gain at some frequency from which a filter is worth its reach
_HALF = 0.5             # gain at a frequency of which a filter sees a wave to each side,
_REACH = 0.1            # but no more than this [s]
_KAISER = 2.5           # shape of its window


class Whitening(NamedTuple):
    """Filters (2 r + 1, c) without delay, one for each balance, at the balances' rate."""

    taps: Array

    @property
    def reach(self) -> int:
        """Return how many samples (r) a filter sees to each side."""
        return len(self.taps) // 2

    def of(self, values: Array, channel: int) -> Array:
        """Return columns (m, k) of one recording as a balance has them."""
        return np.stack([np.convolve(column, self.taps[:, channel], 'same')
                         for column in values.T], axis=1)

    def holds(self, valid: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Return where filters see only what is valid (m, c)."""
        around = np.ones(2 * self.reach + 1)
        return np.stack([np.convolve(~column, around, 'same') < 0.5 for column in valid.T], axis=1)


def whitening_of(noise: Array, white: Array, rate: float, most: float) -> Whitening | None:
    """
    Return the filters for the `noise` (m, c) of balances at a rate [Hz], None if it is white.

    Beside it they have `white` noise of these densities (c,) [N^2*m^2/Hz], and frequencies up to
    `most` [Hz].
    """
    if len(noise) < _SEGMENT:
        return None
    frequency, power = welch(noise, rate, nperseg=_SEGMENT, axis=0)
    loud = gaussian_filter1d(np.sqrt(power + white), _BINS, axis=0)
    slow = np.median(loud[frequency < MOTION], axis=0)
    gain = np.minimum(1.0, np.divide(slow, loud, where=loud > 0.0, out=np.ones_like(loud)))
    gain[frequency > most] = gain[frequency <= most][-1]
    if gain.min() > _WORTH:
        return None
    low = frequency[(gain < _HALF).any(axis=1)]
    reach = round(rate * _REACH / max(_REACH * low[0], 1.0)) if len(low) else 1
    return Whitening(np.stack([_filter(frequency, column, reach, rate) for column in gain.T],
                              axis=1))


def _filter(frequency: Array, gain: Array, reach: int, rate: float) -> Array:
    """Return the taps (2 r + 1,) of a filter with these gains, that passes a constant as it is."""
    grid: Sequence[float] = (frequency / frequency[-1] * rate / 2.0).tolist()
    taps = firwin2(2 * reach + 1, grid, gain, window=('kaiser', _KAISER), fs=rate)
    return np.asarray(taps / taps.sum())
