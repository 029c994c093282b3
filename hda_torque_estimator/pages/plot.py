"""What a plot shows: lines over a common axis, thinned to what a screen can show."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
# Choices unless stated otherwise.
MOST = 4000             # points of a line: two for each pixel of a wide screen
_FIGURES = 5            # of a number in a page: a ten-thousandth of the largest


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

    def document(self) -> dict[str, Any]:
        """Return the plot as the script of a page reads it, thinned to `MOST` points."""
        columns = [column for line in self.lines for column in (line.values, line.low, line.high)
                   if column is not None]
        x, thin = thinned(self.x, columns)
        rest = iter(thin)
        return {'x_label': self.x_label, 'y_label': self.y_label, 'scale': self.scale,
                'focus': self.focus, 'x': written(x),
                'lines': [self._line(line, rest) for line in self.lines]}

    @staticmethod
    def _line(line: PlotLine, rest: Any) -> dict[str, Any]:
        document: dict[str, Any] = {'name': line.name, 'look': line.look, 'y': written(next(rest))}
        if line.low is not None:
            document['low'], document['high'] = written(next(rest)), written(next(rest))
        return document


@dataclass(frozen=True, eq=False)
class PlotGroup:
    """Plots of one kind under names that a reader switches between, with one caption."""

    title: str
    caption: str
    plots: Mapping[str, Plot]

    def document(self) -> dict[str, Any]:
        """Return all plots as the script of a page reads them."""
        return {name: plot.document() for name, plot in self.plots.items()}


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


def written(values: Array) -> list[float | None]:
    """Return numbers to be written, with as many decimals as the largest needs; NaN is None."""
    known = np.abs(values[np.isfinite(values)])
    largest = float(known.max()) if known.size else 0.0
    if largest == 0.0:
        return [0.0 if math.isfinite(value) else None for value in values]
    decimals = _FIGURES - 1 - math.floor(math.log10(largest))
    return [round(value, decimals) if math.isfinite(value) else None for value in values.tolist()]
