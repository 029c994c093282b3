"""The spectrum of a difference, and the lines that stand out of it."""

from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
import numpy as np
from scipy.ndimage import median_filter
from scipy.signal import find_peaks, welch
from scipy.stats import chi2

from .overlay import Overlay

_SEGMENTS = 4                       # lengths of a segment in a recording; they overlap by half
_LEAST, _MOST_SAMPLES = 256, 1 << 14        # samples in a segment
_AROUND = 41                        # bins whose median is the floor of the one in their middle
_FALSE = 1e-4                       # chance of a line in noise
_MARGIN = 1.5                       # for a floor that is not flat
_LOBE = 2                           # bins on both sides that belong to a line
_MOST = 3                           # lines worth a mention
_EXACT = 1e-9                       # of a signal: differences below it are those of arithmetic


class SpectralLine(NamedTuple):
    """Name a line: its frequency [Hz] and the amplitude of its sine, in the unit of the signal."""

    frequency: float
    amplitude: float


class Spectrum(NamedTuple):
    """Hold a one-sided spectrum: frequencies [Hz] (k,) and amplitude density [unit/sqrt(Hz)]."""

    frequency: Array
    density: Array
    lines: tuple[SpectralLine, ...]         # the strongest first


def spectrum(laid: Overlay) -> Spectrum:
    """Return the spectrum of a difference, by Welch's method, with its strongest lines."""
    time = np.arange(laid.time[0], laid.time[-1], laid.period)
    even = np.interp(time, laid.time, laid.difference)
    length = min(len(even), max(_LEAST, len(even) // _SEGMENTS), _MOST_SAMPLES)
    frequency, power = welch(even, 1.0 / laid.period, nperseg=length)
    segments = max(1, 2 * len(even) // length - 1)
    exact = np.abs(even).max() <= _EXACT * np.abs(laid.first).max()
    lines = () if exact else _lines(frequency, power, segments)
    return Spectrum(frequency, np.sqrt(power), lines)


def _lines(frequency: Array, power: Array, segments: int) -> tuple[SpectralLine, ...]:
    floor = median_filter(power, _AROUND, mode='mirror')
    freedom = 2.0 * segments
    least = _MARGIN * chi2.isf(_FALSE / len(power), freedom) / chi2.median(freedom)
    peaks = find_peaks(power)[0]
    # Below a few bins a line cannot be distinguished from a drift.
    peaks = peaks[(power[peaks] > least * floor[peaks]) & (peaks > _LOBE)]
    found = [_line(frequency, power, floor, int(peak)) for peak in peaks]
    return tuple(sorted(found, key=lambda line: -line.amplitude)[:_MOST])


def _line(frequency: Array, power: Array, floor: Array, peak: int) -> SpectralLine:
    """Return a line from the bins around its peak."""
    left, top, right = np.log(power[peak - 1:peak + 2] + 1e-12 * power[peak])
    shift = 0.5 * (left - right) / (left - 2.0 * top + right)
    lobe = slice(peak - _LOBE, peak + _LOBE + 1)
    energy = np.maximum(power[lobe] - floor[lobe], 0.0).sum() * frequency[1]
    return SpectralLine(float(frequency[peak] + shift * frequency[1]),
                        float(np.sqrt(2.0 * energy)))
