"""What a fit leaves at low frequency, where arms move and the noise of readings is small."""

from hda_arm_sim.foundation.arrays import Array
import numpy as np
from scipy.signal import filtfilt, firwin

from ..balances.balance import RATE
from ..fitting.fit import Fit, Fitter

# Numerics; choices unless stated otherwise.
_TAPS = 101             # of the low-pass, at the balances' rate


def power_below(fitter: Fitter, fit: Fit, frequency: float) -> Array:
    """Return the power (c,) of what a fit leaves below a frequency [Hz], a mean [N^2*m^2]."""
    valid = fitter.valid(fit.balance)
    slow = filtfilt(firwin(_TAPS, frequency, fs=RATE), [1.0],
                    np.where(valid, fit.balance.residual, 0.0), axis=0)
    count = np.maximum(valid.sum(axis=0), 1)
    return np.maximum((slow ** 2).sum(axis=0, where=valid), 1e-300) / count


def gain_below(fitter: Fitter, fit: Fit, better: Fit, frequency: float) -> float:
    """Return the score that another fit gains below a frequency [Hz]."""
    independent = fitter.effective * fitter.valid(better.balance).sum(axis=0) * (
        2.0 * frequency / RATE)
    return float(independent @ np.log(power_below(fitter, fit, frequency)
                                      / power_below(fitter, better, frequency)))
