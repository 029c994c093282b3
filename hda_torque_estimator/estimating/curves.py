"""The plots of estimates as data: torques and the force on the tip, over time."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
import numpy as np
from numpy.typing import NDArray

from .estimates import Estimates
from ..pages.plot import Plot, PlotGroup, PlotLine
from ..pages.wording import spoken

_TIME = 'time since the first sample [s]'


class ReferenceSignal(NamedTuple):
    """A signal (m,) that is known at stamps [ns], to stand beside an estimate."""

    stamps: NDArray[np.int64]
    values: Array

    def at(self, stamps: NDArray[np.int64]) -> Array:
        """Return the signal at other stamps (k,), NaN where it is not known."""
        known = np.isfinite(self.values)
        if not known.any():
            return np.full(len(stamps), np.nan)
        times, start = self.stamps[known], self.stamps[known][0]
        return np.interp(stamps - start, times - start, self.values[known], np.nan, np.nan)


def charts(labels: Sequence[str], found: Estimates,
           beside: Mapping[str, Mapping[str, ReferenceSignal]]) -> dict[str, PlotGroup]:
    """
    Return the charts of an estimate; `beside` holds known signals by name, for each plot.

    Its keys are the joints' labels, `x` and `y` of the base frame.
    """
    time = (found.stamps - found.stamps[0]) * 1e-9 if len(found.stamps) else np.empty(0)
    torques = {spoken(label): _with_band(
        time, 'torque, output [N·m]', found.torque[:, place], found.torque_deviation[:, place],
        _known(beside, label, found)) for place, label in enumerate(labels)}
    groups = {'torque': PlotGroup('Joint torque',
                                  'Torque through the gear, at the output. The band is '
                                  'two standard deviations to both sides.', torques)}
    if np.isfinite(found.external_torque).any():
        groups['external'] = PlotGroup(
            'External torque', 'Torque of the environment on each joint. The band is two standard '
            'deviations to both sides.', {
                spoken(label): _with_band(
                    time, 'external torque, output [N·m]', found.external_torque[:, place],
                    found.external_torque_deviation[:, place], [])
                for place, label in enumerate(labels)})
    if np.isfinite(found.tip_force).any():
        groups['tip'] = PlotGroup(
            'Force on the tip', 'Force of the environment on the tip, in the base frame. The band '
            'is two standard deviations to both sides. Gaps are where it is not observed.', {
                f'along {letter}': _with_band(
                    time, 'tip force, base frame [N]', force, found.tip_force_deviation[:, axis],
                    _known(beside, letter, found))
                for axis, (letter, force) in enumerate(zip('xyz', found.tip_force.T))})
    return groups


def _known(beside: Mapping[str, Mapping[str, ReferenceSignal]], name: str,
           found: Estimates) -> list[PlotLine]:
    return [PlotLine(said, one.at(found.stamps), 'measured')
            for said, one in beside.get(name, {}).items()]


def _with_band(time: Array, label: str, values: Array, deviation: Array,
               known: list[PlotLine]) -> Plot:
    return Plot(_TIME, label, time, [*known, PlotLine(
        'estimated', values, 'after', values - 2.0 * deviation, values + 2.0 * deviation)],
        'time')
