"""Two signals on common times: what both say at moments that both have seen."""

from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
import numpy as np
from scipy.interpolate import CubicSpline

from .align import Alignment
from .signals import Signal

_GAP = 2.5                          # usual periods between samples that show nothing of between


class Overlay(NamedTuple):
    """Hold a signal of both bags at times (k,) of the first, from its start [s]."""

    time: Array
    first: Array
    second: Array
    slack: Array                    # deviation that the uncertain alignment alone makes

    @property
    def difference(self) -> Array:
        """Return by how much the second is larger."""
        return self.second - self.first

    @property
    def period(self) -> float:
        """Return the usual time between two samples [s]."""
        return float(np.median(np.diff(self.time)))


def overlay(first: Signal, second: Signal, alignment: Alignment) -> Overlay:
    """
    Return a signal of both bags at the samples of the sparser one.

    The other is interpolated there by a cubic spline, which damps what is faster than a third of
    its rate. Where it has a gap or has ended, nothing is left.
    """
    if second.period > first.period:
        own = second.time
        time = alignment.to_first(own)
        one, two = _at(first, time), second.values
    else:
        time = first.time
        own = alignment.to_second(time)
        one, two = first.values, _at(second, own)
    seen = np.isfinite(one) & np.isfinite(two)
    time, one, two = time[seen], one[seen], two[seen]
    slope = np.gradient(one, time) if len(time) > 1 else np.zeros(len(time))
    return Overlay(time, one, two, np.abs(slope) * alignment.deviation(own[seen]))


def _at(signal: Signal, time: Array) -> Array:
    """Return a signal at some times, NaN outside of it and in its gaps."""
    after = np.clip(np.searchsorted(signal.time, time), 1, len(signal.time) - 1)
    wide = signal.time[after] - signal.time[after - 1] > _GAP * signal.period
    # A sample that stands beside a gap is no guess, though rounding may put it just inside.
    near = np.minimum(np.abs(time - signal.time[after]), np.abs(time - signal.time[after - 1]))
    lost = wide & (near > 1e-6 * signal.period)
    inside = (time >= signal.time[0]) & (time <= signal.time[-1])
    return np.where(inside & ~lost, CubicSpline(signal.time, signal.values)(time), np.nan)
