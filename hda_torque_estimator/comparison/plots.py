"""The figures of a comparison: a signal of both bags, what differs, and its spectrum."""

from hda_arm_sim.foundation.arrays import Array
import matplotlib
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter
import numpy as np

from .compare import Comparison, Difference
from .report import drawn
from ..pages.drawing import AFTER, band, BEFORE, INK, plain, STYLE
from ..pages.wording import unit

_DEEPEST = 1e-5                     # of the highest: below it a spectrum shows arithmetic
_BINS = 600                         # of a spectrum: as many as can be seen


def figures(found: Comparison) -> dict[str, Figure]:
    """Return a figure by name for each of the largest differences."""
    return {f'signal_{number}': signal_figure(each)
            for number, each in enumerate(drawn(found), 1)}


def signal_figure(found: Difference) -> Figure:
    """Draw a signal of both bags, their difference over time, and its spectrum."""
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(7.6, 4.4), layout='constrained')
        panels = figure.subplot_mosaic([['both', 'both', 'both'],
                                        ['difference', 'difference', 'spectrum']])
        scale = f' [{unit(found.unit)}]'
        _both(panels['both'], found)
        panels['both'].set_title(plain(found.name))
        panels['both'].set_ylabel('value' + scale)
        _difference(panels['difference'], found)
        panels['difference'].set_ylabel('difference' + scale)
        _spectrum(panels['spectrum'], found)
        panels['spectrum'].set_ylabel(f'density [{unit(found.unit)}/√Hz]')
        both, rest = (panels[name].get_legend_handles_labels() for name in ('both', 'difference'))
        figure.legend([*both[0], *rest[0]], [*both[1], *rest[1]], ncols=4, borderpad=0.0,
                      loc='outside lower left')
    return figure


def _both(axes: Axes, found: Difference) -> None:
    band(axes, found.laid.time, found.laid.first, BEFORE, 'first', width=2.5)
    band(axes, found.laid.time, found.laid.second, AFTER, 'second', width=0.7)
    axes.set_xlabel('time since the start of the first [s]')


def _difference(axes: Axes, found: Difference) -> None:
    """Draw what the second has more, the level of noise, and where it is left."""
    band(axes, found.laid.time, found.laid.difference, AFTER, None, width=0.7)
    for level in (-2.0 * found.noise, 2.0 * found.noise):
        axes.axhline(level, color=INK, linestyle=(0, (4, 3)), linewidth=0.8,
                     label='twice the noise' if level > 0.0 else None)
    if found.start is not None:
        axes.axvline(found.start, color=BEFORE, linewidth=1.4, label='leaves the noise')
    axes.set_title('second minus first')
    axes.set_xlabel('time since the start of the first [s]')


def _spectrum(axes: Axes, found: Difference) -> None:
    """Draw the spectrum of the difference, its lines marked."""
    seen = (found.spectrum.frequency > 0.0) & (found.spectrum.density > 0.0)
    if seen.any():
        frequency, density = _thinned(found.spectrum.frequency[seen], found.spectrum.density[seen])
        axes.loglog(frequency, density, color=AFTER, linewidth=0.8)
        axes.set_ylim(bottom=max(density.min(), density.max() * _DEEPEST))
        axes.yaxis.set_minor_formatter(NullFormatter())
        for line in found.spectrum.lines:
            top = float(np.interp(line.frequency, frequency, density))
            axes.plot(line.frequency, top, 'v', color=BEFORE, markersize=4.5)
            axes.annotate(f'{line.frequency:.1f} Hz', (line.frequency, top), (0, 5),
                          textcoords='offset points', ha='center', fontsize=7)
    axes.set_title('its spectrum')
    axes.set_xlabel('frequency [Hz]')


def _thinned(frequency: Array, density: Array) -> tuple[Array, Array]:
    """Return the highest of each few bins, for they lie dense at the fast end."""
    cuts = np.unique(np.geomspace(1, len(density), _BINS).astype(int)) - 1
    highest = np.maximum.reduceat(density, cuts)
    bins = np.searchsorted(cuts, np.arange(len(density)), 'right') - 1
    chosen = np.flatnonzero(density == highest[bins])
    return frequency[chosen], density[chosen]
