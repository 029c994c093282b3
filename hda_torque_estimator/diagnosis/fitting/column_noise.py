"""
What of the derivative columns of tolerated numbers is noise (eq:column-noise).

A healthy twin has the same motion and other noise: what its columns do not explain of ours is
noise. But no twin moves quite as the arm did. Where readings are fine, what it lacks is more than
noise. So in each band of frequency noise has no more power than noise of the readings makes. Where
a band holds more, its noise is what goes with the noise of the residual.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from hda_arm_sim.foundation.arrays import Array
import numpy as np
from numpy.typing import NDArray

from .nuisance import AnyTerm, Zero
from .steps import columns_of, Sized, sized
from ...least_squares.normal import RIDGE, TINY

# Numerics; choices unless stated otherwise.
_BANDS = 24             # of frequency, in each of which noise has one power


@dataclass(frozen=True, eq=False)
class ColumnNoise:
    """How loud the columns of tolerated numbers are, and a twin's columns, for an arm as given."""

    places: Mapping[Sized, slice]       # of the numbers' columns
    twin: Array                         # (m, c, q) columns of a healthy twin
    power: Array                        # (b, c, q) of the noise of columns, by bands
    across: Array                       # (b, c, q) cross-spectra with that of the residual
    rest: Array                         # (b, c) power of the noise of the residual
    by_torques: NDArray[np.bool_]       # (c,) balances that have noise of torques as well

    @classmethod
    def made(cls, terms: Sequence[AnyTerm], twin: Array, columns: Array, rest: Array,
             valid: NDArray[np.bool_], by_torques: NDArray[np.bool_]) -> 'ColumnNoise':
        """Return it from noise that was made: of `columns` (m, c, q) and of the `rest` (m, c)."""
        loud = _spectra(np.where(valid[:, :, None], columns, 0.0))
        of_rest = _spectra(np.where(valid, rest, 0.0))
        places = {sized(term): own for term, own in columns_of(terms)
                  if not isinstance(term, Zero)}
        return cls(places, twin, _in_bands(np.abs(loud) ** 2),
                   _in_bands(loud * of_rest.conj()[:, :, None]), _in_bands(np.abs(of_rest) ** 2),
                   by_torques)

    def noise_in(self, terms: Sequence[AnyTerm], columns: Array, rest: Array,
                 valid: NDArray[np.bool_], weight: Array) -> dict[Sized, Array]:
        """
        Return what of the columns (m, c, p) of terms is noise, by the places of known numbers.

        The `rest` (m, c) is what they leave. What the twin explains is weighed by `weight` (m, c),
        one over the standard deviation of noise, or 0.
        """
        wanted = [(sized(term), own, self.places[sized(term)]) for term, own in columns_of(terms)
                  if sized(term) in self.places]
        if not wanted:
            return {}
        ours = np.concatenate([np.arange(own.start, own.stop) for _, own, _ in wanted])
        theirs = np.concatenate([np.arange(part.start, part.stop) for _, _, part in wanted])
        apart = columns[:, :, ours] - projection(columns[:, :, ours], self.twin, weight)
        noise = self._as_loud_as_noise(np.where(valid[:, :, None], apart, 0.0), theirs,
                                       np.where(valid, rest, 0.0), weight)
        ends = np.cumsum([own.stop - own.start for _, own, _ in wanted])
        return {place: np.ascontiguousarray(part) for (place, _, _), part in zip(
            wanted, np.split(noise, ends[:-1], axis=2))}

    def _as_loud_as_noise(self, apart: Array, known: NDArray[np.intp], rest: Array,
                          weight: Array) -> Array:
        """Return the noise in what columns `apart` (m, c, p) from the twin have, those `known`."""
        noise = np.zeros_like(apart)
        for channel in map(int, np.flatnonzero(apart.any(axis=(0, 2)))):
            spectrum, left = _spectra(apart[:, channel]), _spectra(rest[:, channel])
            power, across = self.power[:, channel, known], self.across[:, channel, known]
            share = np.minimum(2.0 * power / np.maximum(     # the twin has as much noise again
                _in_bands(np.abs(spectrum) ** 2), TINY), 1.0)
            along = across / self._of_rest(channel, rest, weight)[:, None]
            bound = np.abs(along) ** 2 * _in_bands(np.abs(left) ** 2)[:, None]
            along = along * np.sqrt(np.minimum(power / np.maximum(bound, TINY), 1.0))
            mixed = (_by_bin(share, len(left)) * spectrum
                     + _by_bin((1.0 - share) * along, len(left)) * left[:, None])
            noise[:, channel] = np.fft.irfft(mixed, len(apart), axis=0)
        return noise

    def _of_rest(self, channel: int, rest: Array, weight: Array) -> Array:
        """
        Return the power (b,) of all noise in a residual, that of readings at least.

        Some balances have noise of torques as well, which no column of a reading goes with.
        """
        of_readings = np.maximum(self.rest[:, channel], TINY)
        most = float(weight[:, channel].max())
        if not self.by_torques[channel] or most == 0.0:
            return of_readings
        whole = np.count_nonzero(rest[:, channel]) * len(rest) / 2.0 / most ** 2
        return np.asarray(of_readings * max(whole / float(of_readings.sum()), 1.0))


def projection(columns: Array, twin: Array, weight: Array) -> Array:
    """
    Return what the columns (m, c, q) of a twin explain of columns (m, c, p), weighed by (m, c).

    It is their projection onto those of the twin, all balances at once (two-stage least squares).
    """
    count = twin.shape[2]
    gram, against = np.zeros((count, count)), np.zeros((count, columns.shape[2]))
    for channel in range(columns.shape[1]):
        own = weight[:, channel, None]
        theirs, ours = (np.where(own > 0.0, some[:, channel] * own, 0.0)    # no number elsewhere
                        for some in (twin, columns))
        shown, own_shown = (np.flatnonzero(some.any(axis=0)) for some in (theirs, ours))
        gram[np.ix_(shown, shown)] += theirs[:, shown].T @ theirs[:, shown]
        against[np.ix_(shown, own_shown)] += theirs[:, shown].T @ ours[:, own_shown]
    size = np.sqrt(np.maximum(np.diag(gram), TINY))
    scaled = gram / np.outer(size, size) + RIDGE * np.eye(count)
    shares = np.linalg.solve(scaled, against / size[:, None]) / size[:, None]
    return np.asarray(twin @ shares)


def _spectra(values: Array) -> NDArray[np.complex128]:
    """Return the spectra of columns (m, ...)."""
    return np.asarray(np.fft.rfft(values, axis=0))


def _edges(count: int) -> NDArray[np.intp]:
    """Return where each band of so many frequencies begins, and the last ends."""
    return np.linspace(0, count, _BANDS + 1).astype(np.intp)


def _in_bands(values: NDArray[Any]) -> NDArray[Any]:
    """Return the sums over bands (b, ...) of what was made of spectra (f, ...)."""
    return np.asarray(np.add.reduceat(values, _edges(len(values))[:-1], axis=0))


def _by_bin(values: NDArray[Any], count: int) -> NDArray[Any]:
    """Return values of bands (b, p) at all frequencies, so many (f, p)."""
    return np.repeat(values, np.diff(_edges(count)), axis=0)
