"""The low-pass of all filters of the estimator."""

from hda_arm_sim.foundation.compiled import inlined
import numpy as np


@inlined
def share_of(bandwidth: float, dt: float) -> float:
    """Return the share of a new value in a low-pass of this bandwidth [Hz], (eq:low-pass)."""
    return 1.0 - np.exp(-2.0 * np.pi * bandwidth * dt)


@inlined
def lateness(bandwidth: float, dt: float) -> float:
    """Return by how much a low-pass is late for what changes steadily, dt (1 - s) / s [s]."""
    share = share_of(bandwidth, dt)
    return dt * (1.0 - share) / share
