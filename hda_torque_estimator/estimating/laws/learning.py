"""
One step of a Kalman filter for errors whose covariance starts as the identity (eq:learning).

Kept is the covariance less the identity, `gain`: memory of zeros means that nothing is learnt.
"""

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.compiled import compiled
import numpy as np

# Choices unless stated otherwise.
_LARGEST = 3.0          # deviations at which a difference is cut off


@compiled
def fade(learnt: Array, gain: Array, fading: float) -> None:
    """Let what was learnt fade by a factor."""
    learnt *= fading
    gain *= fading * fading


@compiled
def renew(learnt: Array, gain: Array, spread: Array, difference: float, variance: float) -> Array:
    """
    Learn from a difference of this variance; returns the change of the errors.

    `spread` is the covariance times the effects of the errors on the difference.
    """
    largest = _LARGEST * np.sqrt(variance)
    change = spread * (min(max(difference, -largest), largest) / variance)
    learnt += change
    for i in range(len(spread)):
        for k in range(len(spread)):
            gain[i, k] -= spread[i] * spread[k] / variance
    return change
