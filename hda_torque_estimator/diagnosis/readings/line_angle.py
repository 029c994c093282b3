"""
The angle behind readings of a link encoder that err with its lines (eq:line-angle).

A wave that is steep shows one reading at several angles. Which of them it was, the motor knows:
gears twist slowly. So what they twist by is made as smooth as local polynomials are. Where a steep
wave hardly passes, readings do not show the angle.
"""

from collections.abc import Sequence

from hda_arm_sim.foundation.arrays import Array, Mask
from hda_arm_sim.model.effects import EncoderInterpolationError
import numpy as np
from scipy.linalg import solveh_banded
from scipy.ndimage import binary_dilation
from scipy.signal import savgol_filter

from .line_alias import passes
from .local_rest import DEGREE, local_speed, window_of

# Numerics; choices unless stated otherwise.
_STEPS = 10             # of Gauss and Newton, to an angle
_DIFFERENCES = (1.0, -2.0, 1.0)         # of three neighbours, the second
_LEAST = 1e-6           # weight of a reading that shows nothing


def turned_by_motor(motor: Array, dt: float) -> Array:
    """Return the angle (k,) that a motor shows, over the ratio, without its counts [rad]."""
    return np.asarray(savgol_filter(motor, window_of(dt), DEGREE))


def angle_behind(link: Array, turned: Array, dt: float,
                 waves: Sequence[EncoderInterpolationError] = ()) -> Array:
    """
    Return the angle (k,) at which an encoder with these waves shows the readings `link` [rad].

    Where each reading is of one angle, that is known. Else it is `turned` by the motor, and twists
    more slowly than polynomials follow, as far as that is known without any wave.
    """
    smooth = float((window_of(dt) // 2) ** 4)
    angle = _nearer(link, link, turned, (), smooth)
    weight = np.where(hidden(angle, dt, waves), _LEAST, 1.0)
    for _ in range(_STEPS if waves else 0):
        angle = _nearer(angle, link, turned, waves, smooth * _are_steep(waves), weight)
    return angle


def hidden(angle: Array, dt: float, waves: Sequence[EncoderInterpolationError]) -> Mask:
    """Return where readings hide an angle (k,): waves are steep, and the first is not whole."""
    if not _are_steep(waves):
        return np.zeros(len(angle), bool)
    window = window_of(dt)
    seen = passes(local_speed(angle, dt) * dt, waves[0].lines, window)
    return np.asarray(binary_dilation(~seen, iterations=window // 2))


def _are_steep(waves: Sequence[EncoderInterpolationError]) -> bool:
    """Return whether readings with these waves may be of several angles each."""
    return sum(wave.amplitude * wave.lines for wave in waves) >= 1.0


def _nearer(angle: Array, link: Array, turned: Array, waves: Sequence[EncoderInterpolationError],
            smooth: float, weight: Array | float = 1.0) -> Array:
    """Return a nearer angle (k,): so `smooth` are twists, of such a `weight` (k,) readings."""
    slope = 1.0 + sum((_slope(wave, angle) for wave in waves), np.zeros_like(link))
    miss = weight * slope * (link - angle - errors_at(angle, waves))
    bend = np.convolve(angle - turned, _DIFFERENCES, 'valid')
    return np.asarray(angle + solveh_banded(_bands(weight * slope ** 2, smooth),
                                            miss - smooth * np.convolve(bend, _DIFFERENCES)))


def errors_at(angle: Array, waves: Sequence[EncoderInterpolationError]) -> Array:
    """Return by how much readings with these waves are off at angles (k,) [rad]."""
    return np.asarray(sum((wave(angle=angle) for wave in waves), np.zeros_like(angle)))


def _slope(wave: EncoderInterpolationError, angle: Array) -> Array:
    """Return how a wave changes with the angle (k,)."""
    return np.asarray(wave.amplitude * wave.lines * np.cos(wave.lines * angle + wave.phase))


def _bands(own: Array, smooth: float) -> Array:
    """Return the upper bands (3, k) of normal equations, of readings and of smoothness."""
    bands = np.zeros((3, len(own)))
    for place, first in enumerate(_DIFFERENCES):
        for other in range(place, len(_DIFFERENCES)):
            ends = slice(other, len(own) - len(_DIFFERENCES) + 1 + other)
            bands[2 - (other - place), ends] += smooth * first * _DIFFERENCES[other]
    bands[2] += own
    return bands
