"""
Where an arm moves faster than the samples of its log resolve.

Between the samples of a slow log readings follow a spline. A loop that shakes its arm at a fifth
of the rate moves on otherwise, and each balance feels that at all frequencies. So the spline is
sampled again, halfway between its samples, and laid anew (eq:unresolved). Of a motion that samples
resolve that changes next to nothing: noise of readings, as much as in a healthy twin.
"""

from dataclasses import replace
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array, Mask
from hda_arm_sim.model.arm import Arm
import numpy as np
from scipy.interpolate import CubicSpline

from .balance import Balancer, RATE
from ...measurements.measurement import Measurement
from ...significance import HARDLY, LOUD

# Numerics; choices unless stated otherwise.
_WINDOW = 1.0           # of a recording, in which its motion is resolved or not [s]
_LEAST = 1e-300         # power of a balance that holds nowhere


class _Changes(NamedTuple):
    """What balances change by in each window, sums over its rows (w, c)."""

    power: Array            # of the changes [N^2*m^2]
    noise: Array            # power of the balances themselves [N^2*m^2]
    rows: Array             # that are valid


def unresolved(balancer: Balancer, arm: Arm, twin: Measurement,
               noise: Array) -> tuple[int, ...]:
    """
    Return the samples about which balances of an arm are off by more than noise makes them.

    Over their `noise` (c,) [N*m] they change far more there than those of a healthy `twin` do,
    and by more than a little. One joint that shakes does so to all.
    """
    if balancer.measurement.parts == 1:
        return ()
    ours, theirs = _changes(balancer, arm), _changes(balancer.like(twin), arm)
    usual = np.sqrt(theirs.power.sum(axis=0) / np.maximum(theirs.noise.sum(axis=0), _LEAST))
    share = np.sqrt(ours.power / np.maximum(ours.rows, 1.0)) / noise
    is_off = (share > np.maximum(LOUD * usual, HARDLY)).any(axis=1)
    window = (balancer.measurement.time / _WINDOW).astype(np.intp)
    return tuple(np.flatnonzero(is_off[np.minimum(window, len(is_off) - 1)]).tolist())


def _changes(balancer: Balancer, arm: Arm) -> _Changes:
    """Return by how much balances change in each window if splines are laid anew."""
    plain = balancer(arm)
    change = balancer.like(_laid_anew(balancer.measurement))(arm).residual - plain.residual
    starts = np.arange(0, len(change), round(_WINDOW * RATE))
    return _Changes(*(np.add.reduceat(np.where(plain.valid, values, 0.0), starts, axis=0)
                      for values in (change ** 2, plain.residual ** 2, np.ones_like(change))))


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
