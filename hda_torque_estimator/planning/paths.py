"""
Candidate paths: how far the links go from a centre, over time, always back to where they began.

A path is legs of constant speed with rounded corners, one of the project's motions, or nothing,
plus a Fourier series as Swevers et al. (1997) excite robots.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.motions import HOME, Motion, motion
import numpy as np
from scipy.ndimage import gaussian_filter1d

Legs = tuple[tuple[float, float], ...]      # distances, in amplitudes, and shares of the time
# Choices unless stated otherwise.
_CORNER = 0.1           # over which a corner is rounded, standard deviation [s]
_EDGE = 0.5             # at rest at both ends, so that corners are complete [s]
_EASE = 1.5             # over which a wave is faded in and out [s]
_LOWEST = 0.1           # frequency of a Fourier series, about [Hz]
_TURN = 2.9             # each way: nearly a full turn [rad]


class ChainPaths(NamedTuple):
    """
    What a chain has of its own: where its motions start, and how its links may turn.

    Limits of an angle are those about the middle of what a joint may do.
    """

    home: Sequence[float]                       # (n,) [rad]
    rates: Sequence[float]                      # (n,) [rad/s]
    middle: Array                               # (n,) [rad]


LEGS: dict[str, Legs] = {
    'full turn': ((1.0, 1.0), (-2.0, 2.0), (1.0, 1.0)),
    'two speeds': ((1.0, 5.0), (-1.0, 5.0), (-1.0, 5.0), (1.0, 5.0),
                   (1.0, 1.0), (-2.0, 2.0), (2.0, 2.0), (-1.0, 1.0)),
    'reversals': ((1.0, 4.0), (-1.0, 4.0), (0.5, 2.0), (-0.5, 2.0), (0.25, 1.0), (-0.25, 1.0),
                  (0.12, 0.5), (-0.12, 0.5), (0.06, 0.3), (-0.06, 0.3), (0.03, 0.2),
                  (-0.03, 0.2)),
    'dwells': ((0.5, 1.0), (0.0, 1.0), (0.5, 1.0), (0.0, 1.0), (-1.0, 2.0), (0.0, 1.0),
               (-0.5, 1.0), (0.0, 1.0), (0.5, 1.0), (0.0, 1.0)),
}


@dataclass(frozen=True)
class Path:
    """A path by its numbers, which a search may change."""

    shape: str                                  # of LEGS, of the project's motions, or 'wave'
    amplitude: tuple[float, ...]                # of each joint [rad], or factors of a motion
    cycles: tuple[int, ...] = (1, 1)            # how often legs are run through, in turn
    wave: float = 0.0                           # excursion of a series on top of a shape [rad]
    harmonics: tuple[int, int] = (1, 12)        # the lowest and the highest of the series
    seed: int = 0                               # of its coefficients

    @property
    def label(self) -> str:
        """Return what the path is made of, for people."""
        series = f'Fourier series up to {self.harmonics[1] * _LOWEST:g} Hz'
        if self.shape == 'wave':
            return series
        return f'{self.shape} with {series}' if self.wave else self.shape

    def scaled(self, *, amplitude: Sequence[float] | float = 1.0, wave: float = 1.0) -> 'Path':
        """Return the path with other excursions."""
        factors = np.broadcast_to(amplitude, len(self.amplitude))
        sizes = tuple(float(a * f) for a, f in zip(self.amplitude, factors))
        return replace(self, amplitude=sizes, wave=float(self.wave * wave))

    def motion(self, joints: int, duration: float, dt: float, limits: Sequence[float],
               chain: 'ChainPaths | None' = None) -> Motion:
        """
        Return the path as a motion of some duration [s], sampled every dt [s].

        It goes on about HOME, or as near to it as angles up to `limits` [rad] allow. That of a
        chain goes on about its own home. Each of its joints goes as far as its limits allow.
        """
        time: Array = dt * np.arange(round(duration / dt) + 1, dtype=np.float64)
        away = np.stack([self._away(time, joint, joints) for joint in range(joints)], axis=1)
        room = np.asarray(limits)
        if chain is not None:
            away = away * _share(away, room, np.asarray(chain.rates), dt)
        low, high = away.min(axis=0), away.max(axis=0)
        home, middle = (HOME[:joints], 0.0) if chain is None else (chain.home, chain.middle)
        lowest = middle - room - low
        centre = np.clip(home, lowest, np.maximum(middle + room - high, lowest))
        angle = centre + away
        return Motion(time, angle, np.gradient(angle, dt, axis=0), np.zeros((len(time), 2)))

    def _away(self, time: Array, joint: int, joints: int) -> Array:
        """Return how far one joint is from its centre (k,) [rad]."""
        size = self.amplitude[joint]
        series = _series(time, self.harmonics, self.seed + 1000 * joint)
        if self.shape == 'wave':
            return size * series
        series *= self.wave
        if self.shape in LEGS:
            mirrored = -1.0 if joint else 1.0
            cycles = self.cycles[joint % len(self.cycles)]
            return series + mirrored * size * _along(time, LEGS[self.shape], cycles)
        dt = float(time[1] - time[0])
        made = motion(self.shape, joints, float(time[-1]), dt, self.seed)
        return series + size * (made.angle[:, joint] - made.angle[0, joint])


def _share(away: Array, room: Array, rates: Array, dt: float) -> Array:
    """Return by how much each joint's way (k, n) must shrink to keep angles and rates (n,)."""
    with np.errstate(divide='ignore'):
        fits = np.minimum(room / (0.5 * np.ptp(away, axis=0)),
                          rates / np.abs(np.gradient(away, dt, axis=0)).max(axis=0))
    return np.minimum(fits, 1.0)


def _along(time: Array, legs: Legs, cycles: int) -> Array:
    """Return legs run through some times (k,), back at 0 in the end, at amplitude 1."""
    distance = np.tile([leg[0] for leg in legs], cycles)
    share = np.tile([leg[1] for leg in legs], cycles)
    corners = np.concatenate([[0.0], np.cumsum(share)]) / share.sum()
    moments = _EDGE + corners * (time[-1] - 2.0 * _EDGE)
    places = np.concatenate([[0.0], np.cumsum(distance)])
    sharp = np.interp(time, moments, places)
    return gaussian_filter1d(sharp, _CORNER / (time[1] - time[0]), mode='nearest')


def _series(time: Array, harmonics: tuple[int, int], seed: int) -> Array:
    """Return a Fourier series of random phases (k,) with largest value 1, faded at the ends."""
    orders = np.arange(harmonics[0], harmonics[1] + 1)
    random = np.random.default_rng(seed)
    size = random.uniform(0.5, 1.0, len(orders)) / orders
    phase = random.uniform(0.0, 2.0 * np.pi, len(orders))
    lowest = max(1, round(_LOWEST * time[-1])) / time[-1]
    wave = (size * np.sin(2.0 * np.pi * lowest * np.outer(time, orders) + phase)).sum(axis=1)
    edge = np.clip(np.minimum(time, time[-1] - time) / _EASE, 0.0, 1.0)
    faded = wave * edge ** 3 * (10.0 - 15.0 * edge + 6.0 * edge ** 2)
    return np.asarray(faded / np.abs(faded).max())


def candidates(joints: int) -> tuple[Path, ...]:
    """Return the paths from which a search starts, for an arm with so many joints."""
    one, turn = (0.6,) * joints, (_TURN,) * joints
    return (
        Path('rich', (0.65,) * joints),
        Path('full turn', turn, wave=0.02, harmonics=(15, 60)),
        Path('wave', (0.3,) * joints, harmonics=(1, 25), seed=2),
        Path('two speeds', one, (1, 2), wave=0.2),
        Path('two speeds', one),
        Path('full turn', turn),
        Path('reversals', one, (2, 1)),
        Path('reversals', (0.2,) * joints, (3, 2), wave=0.02, harmonics=(10, 40)),
        Path('dwells', one, (2, 1), wave=0.05, harmonics=(5, 20)),
        Path('dwells', one, (1, 2)),
        Path('wave', (0.8,) * joints, harmonics=(1, 8), seed=1),
    )
