"""The filter that all balances of a measurement pass, and by which they are thinned."""

from hda_arm_sim.foundation.arrays import Array
import numpy as np
from scipy.signal import firwin, upfirdn

from ...measurements.measurement import Measurement


class LowPass:
    """A low-pass filter without delay over each recording of a measurement."""

    def __init__(self, measurement: Measurement, bandwidth: float, every: int) -> None:
        """Pass what is below a bandwidth [Hz], and keep one of `every` so many samples."""
        self._pieces, self._every = measurement.pieces(), every
        self.reach = 4 * max(1, round(0.25 / (bandwidth * measurement.dt) / 4.0) * 4)
        self._taps = firwin(2 * self.reach + 1, bandwidth, window=('kaiser', 6.0),
                            fs=1.0 / measurement.dt)

    def __call__(self, raw: Array) -> Array:
        """Return filtered columns (m, c) of raw ones (k, c)."""
        return np.concatenate([self._of_one(raw[piece]) for piece in self._pieces])

    def _of_one(self, raw: Array) -> Array:
        """Return the filtered columns of one recording."""
        early = -self.reach % self._every           # so that an output falls on the first sample
        padded = np.concatenate([np.zeros((early, raw.shape[1])), raw])
        thin = upfirdn(self._taps, padded, down=self._every, axis=0)
        first = (self.reach + early) // self._every
        return np.asarray(thin[first:first + -(-len(raw) // self._every)])
