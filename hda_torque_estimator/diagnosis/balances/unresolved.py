"""
Where an arm moves faster than the samples of its log resolve.

Between the samples of a slow log readings follow a spline. A loop that shakes its arm at a fifth
of the rate moves on otherwise, and each balance feels that at all frequencies. So the spline is
sampled again, halfway between its samples, and laid anew (eq:unresolved). Of a motion that samples
resolve that changes next to nothing: what it changes of the noise of readings. A healthy twin
would not tell, for its loop shakes as well.
"""

from dataclasses import replace

from hda_arm_sim.foundation.arrays import Array, Mask
from hda_arm_sim.model.arm import Arm
import numpy as np
from scipy.interpolate import CubicSpline

from .balance import Balancer, RATE
from ...measurements.measurement import Measurement
from ...significance import HARDLY, LOUD

# Numerics; choices unless stated otherwise.
_WINDOW = 1.0           # of a recording, in which its motion is resolved or not [s]


def unresolved(balancer: Balancer, arm: Arm, noise: Array) -> tuple[int, ...]:
    """
    Return the samples about which balances of an arm are off by more than noise makes them.

    Over their `noise` (c,) [N*m] they change far more there than noise of the readings does, and
    by more than a little. One joint that shakes does so to all.
    """
    if balancer.measurement.parts == 1:
        return ()
    ours = _change(balancer, arm)
    of_noise = _change(balancer.noisier, arm) - ours
    valid, starts = balancer(arm).valid, np.arange(0, len(ours), round(_WINDOW * RATE))
    rows = np.add.reduceat(valid, starts, axis=0, dtype=np.float64)
    power = np.add.reduceat(np.where(valid, ours ** 2, 0.0), starts, axis=0)
    share = np.sqrt(power / np.maximum(rows, 1.0)) / noise
    usual = (of_noise ** 2).sum(axis=0, where=valid)
    made = np.sqrt(usual / np.maximum(rows.sum(axis=0), 1.0)) / noise
    is_off = (share > np.maximum(LOUD * made, HARDLY)).any(axis=1)
    window = (balancer.measurement.time / _WINDOW).astype(np.intp)
    return tuple(np.flatnonzero(is_off[np.minimum(window, len(is_off) - 1)]).tolist())


def _change(balancer: Balancer, arm: Arm) -> Array:
    """Return by how much balances (m, c) change if splines are laid anew [N*m]."""
    anew = balancer.like(_laid_anew(balancer.measurement))
    return np.asarray(anew(arm).residual - balancer(arm).residual)


def _laid_anew(measurement: Measurement) -> Measurement:
    """Return readings along splines through what splines have halfway between the samples."""
    parts, reading = measurement.parts, measurement.reading.copy()
    for piece in measurement.pieces():
        recorded = measurement.reading[piece][::parts]
        ticks = np.arange(len(recorded), dtype=np.float64)
        halfway = ticks[:-1] + 0.5
        anew = CubicSpline(halfway, CubicSpline(ticks, recorded)(halfway))
        grid = np.arange(len(reading[piece])) / parts
        inner: Mask = (grid >= halfway[0]) & (grid <= halfway[-1])
        reading[piece][inner] = anew(grid[inner])
    return replace(measurement, reading=reading)
