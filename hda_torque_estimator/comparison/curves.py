"""The plots of a comparison as data: a signal of both bags, what differs, and its spectrum."""

import numpy as np
from numpy.typing import NDArray

from .compare import Comparison, Difference
from .report import drawn, start_text
from ..pages.plot import Plot, PlotGroup, PlotLine
from ..pages.wording import unit

Array = NDArray[np.float64]
_BINS = 600                         # of a spectrum: as many as can be seen
_TIME = 'time since the start of the first [s]'


def charts(found: Comparison) -> dict[str, PlotGroup]:
    """Return a chart by name for each of the largest differences."""
    return {f'signal_{number}': _chart(each) for number, each in enumerate(drawn(found), 1)}


def _chart(found: Difference) -> PlotGroup:
    starts = ('It does not leave the noise for good.' if found.start is None else
              f'It leaves the noise at {start_text(found)}.')
    return PlotGroup(found.name, (
        'Both bags on common times, what the second has more than the first, and the spectrum of '
        f'that. {starts} Dashed: twice the noise, which is what changes within 40 ms.'), {
            'both bags': _both(found), 'second minus first': _difference(found),
            'spectrum of the difference': _spectrum(found)})


def _both(found: Difference) -> Plot:
    return Plot(_TIME, f'value [{unit(found.unit)}]', found.laid.time, [
        PlotLine('first', found.laid.first, 'before'),
        PlotLine('second', found.laid.second, 'after')],
        'time')


def _difference(found: Difference) -> Plot:
    count = len(found.laid.time)
    return Plot(_TIME, f'difference [{unit(found.unit)}]', found.laid.time, [
        PlotLine('second minus first', found.laid.difference, 'after'),
        PlotLine('twice the noise', np.full(count, 2.0 * found.noise), 'floor'),
        PlotLine('', np.full(count, -2.0 * found.noise), 'floor')], 'time')


def _spectrum(found: Difference) -> Plot:
    seen = (found.spectrum.frequency > 0.0) & (found.spectrum.density > 0.0)
    frequency, density = _thinned(found.spectrum.frequency[seen], found.spectrum.density[seen])
    return Plot('frequency [Hz]', f'density [{unit(found.unit)}/√Hz]', frequency,
                [PlotLine('density', density, 'after')], 'log')


def _thinned(frequency: Array, density: Array) -> tuple[Array, Array]:
    """Return the highest of each few bins, for they lie dense at the fast end."""
    if not len(density):
        return frequency, density
    cuts = np.unique(np.geomspace(1, len(density), _BINS).astype(int)) - 1
    return frequency[cuts], np.maximum.reduceat(density, cuts)
