"""The strongest wave in a residual, of any frequency, and how much of it a wave explains."""

import math
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

# Numerics; choices unless stated otherwise.
# (source: one turn in rad)
TURN = 2.0 * math.pi    # one turn [rad]
_FINER = 4              # points of a spectrum in the width of a line


class StrongestWave(NamedTuple):
    """The strongest wave in a residual."""

    frequency: float
    share: float                    # of the power, in [0, 1]


def strongest_wave(time: Array, rest: Array, valid: NDArray[np.bool_]) -> StrongestWave:
    """Return the sine over time [Hz] that explains most of a residual (m,), 0 where invalid."""
    count = _FINER * len(time)
    step = float(time[1] - time[0])
    power = np.abs(np.fft.rfft(rest, count)) ** 2
    power[:2 * _FINER] = 0.0        # a trend is no line
    peak, width = np.argmax(power) / (count * step), 1.0 / (count * step)
    moments, chosen = time[valid], rest[valid]
    found = minimize_scalar(lambda place: -wave_share(TURN * place * moments, chosen),
                            bounds=(peak - width, peak + width), method='bounded')
    return StrongestWave(float(found.x), -float(found.fun))


def wave_share(phase: Array, rest: Array, weight: Array | float = 1.0) -> float:
    """Return the share of a residual (k,) that a wave of this phase explains, with a level."""
    columns = np.stack([np.ones_like(phase), np.cos(phase), np.sin(phase)], axis=1)
    columns *= np.reshape(weight, (-1, 1))
    against = columns.T @ rest
    explained = against @ np.linalg.lstsq(columns.T @ columns, against, rcond=1e-9)[0]
    return float(explained / max(float(rest @ rest), 1e-300))
