"""What polynomials over a few samples leave of readings: all that is quicker than a motion."""

from hda_arm_sim.foundation.arrays import Array
import numpy as np
from scipy.signal import savgol_filter

# Numerics; choices unless stated otherwise.
_WINDOW, DEGREE = 0.021, 5      # of the polynomials [s]


def window_of(dt: float) -> int:
    """Return the samples of a polynomial, at a sample period [s]."""
    return max(DEGREE + 2, 2 * round(0.5 * _WINDOW / dt) + 1)


def local_rest(signal: Array, dt: float) -> Array:
    """Return what local polynomials leave of signals (k, ...), in their units."""
    return np.asarray(signal - savgol_filter(signal, window_of(dt), DEGREE, axis=0))


def local_speed(angle: Array, dt: float) -> Array:
    """Return the speed of readings (k,) by the same polynomials [rad/s]."""
    return np.asarray(savgol_filter(angle, window_of(dt), DEGREE, deriv=1, delta=dt))
