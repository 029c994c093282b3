"""What a plot shows: lines over a common axis, thinned to what a screen can show."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .columns import column

Array = NDArray[np.float64]
# Choices unless stated otherwise.
MOST = 8000             # points of a line: four for each pixel of a wide screen


@dataclass(frozen=True, eq=False)
class PlotLine:
    """A line (k,) of a plot; its `look` says what it is: measured, before, after or floor."""

    name: str
    values: Array
    look: str
    low: Array | None = None        # of the band around it (k,), if it has one
    high: Array | None = None


@dataclass(frozen=True, eq=False)
class Plot:
    """Lines over one axis; `scale` is linear, log (both axes), log_x, turn or time."""

    x_label: str
    y_label: str
    x: Array                        # (k,) rising
    lines: Sequence[PlotLine]
    scale: str = 'linear'
    focus: tuple[float, float] | None = None        # of x, what is shown at first; None for all

    @property
    def each(self) -> float:
        """Return of how many samples the least and the largest are drawn; 1 draws all."""
        return max(1.0, 2.0 * len(self.x) / MOST) if len(self.x) > MOST else 1.0

    def document(self) -> dict[str, Any]:
        """Return the plot as the script of a page reads it, thinned to `MOST` points."""
        columns = [values for line in self.lines for values in (line.values, line.low, line.high)
                   if values is not None]
        x, thin = thinned(self.x, columns)
        rest = (column(values, is_log=self.scale == 'log') for values in thin)
        return {'x_label': self.x_label, 'y_label': self.y_label, 'scale': self.scale,
                'focus': self.focus, 'count': len(x), 'x': column(x, is_axis=True),
                'lines': [self._line(line, rest) for line in self.lines]}

    @staticmethod
    def _line(line: PlotLine, rest: Any) -> dict[str, Any]:
        document: dict[str, Any] = {'name': line.name, 'look': line.look, 'y': next(rest)}
        if line.low is not None:
            document['low'], document['high'] = next(rest), next(rest)
        return document


@dataclass(frozen=True, eq=False)
class PlotGroup:
    """Plots of one kind under names that a reader switches between, with one caption."""

    title: str
    caption: str
    plots: Mapping[str, Plot]

    @property
    def thinning(self) -> str:
        """Return how the plots are thinned, in a sentence; '' where every sample is drawn."""
        each = max((plot.each for plot in self.plots.values()), default=1.0)
        return '' if each == 1.0 else (
            f'Of every {each:.0f} samples the least and the largest are drawn.')

    def document(self) -> dict[str, Any]:
        """Return all plots as the script of a page reads them."""
        return {name: plot.document() for name, plot in self.plots.items()}


def documents(charts: Mapping[str, PlotGroup]) -> tuple[dict[str, Any], list[Any]]:
    """
    Return charts as the script of a page reads them, and the packed columns of all.

    Each column stands once, however many plots show it: a plot states its place by `at`.
    """
    places: dict[str, int] = {}
    plots = {name: chart.document() for name, chart in charts.items()}
    for plot in (plot for chart in plots.values() for plot in chart.values()):
        for part in (plot, *plot['lines']):
            part |= {key: {'at': places.setdefault(json.dumps(value), len(places))}
                     for key, value in part.items()
                     if isinstance(value, dict) and 'data' in value}
    return plots, [json.loads(text) for text in places]


def thinned(x: Array, columns: Sequence[Array]) -> tuple[Array, list[Array]]:
    """
    Return columns (k,) with at most `MOST` points, each with its extremes.

    Each bucket of samples gives two points, its least and its largest value in their order in
    time. No spike that a screen can show is lost. NaN is a gap where a whole bucket is NaN.
    """
    count = len(x)
    if count <= MOST:
        return x, list(columns)
    cuts = np.linspace(0, count, MOST // 2 + 1).astype(int)
    middle = (cuts[:-1] + cuts[1:]) // 2
    places = np.stack([cuts[:-1], middle], axis=1).ravel()
    return x[places], [_extremes(column, cuts) for column in columns]


def _extremes(column: Array, cuts: NDArray[np.int64]) -> Array:
    low, high = (reduce.reduceat(column, cuts[:-1]) for reduce in (np.fmin, np.fmax))
    first, last = column[cuts[:-1]], column[cuts[1:] - 1]
    falls = first > last
    return np.stack([np.where(falls, high, low), np.where(falls, low, high)], axis=1).ravel()
