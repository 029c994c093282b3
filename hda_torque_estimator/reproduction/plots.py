"""Draw the exhibits: one style for all, whatever a figure is of."""

from collections.abc import Sequence
from typing import Any

import matplotlib
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure

from .diagram_plots import draw_diagram
from .rig.exhibit import Bars, Content, Diagram, Drawing, Look, Map, Panel, Trace
from ..pages.drawing import AFTER, BEFORE, FLOOR, INK, plain, STYLE

_STYLES: dict[Look, dict[str, Any]] = {
    Look.TRUTH: {'color': INK, 'linewidth': 2.2, 'alpha': 0.8},
    Look.PRINTED: {'color': BEFORE, 'linewidth': 1.4},
    Look.CONSISTENT: {'color': AFTER, 'linewidth': 1.2},
    Look.THIRD: {'color': '#2f855a', 'linewidth': 1.2},
    Look.FOURTH: {'color': '#97266d', 'linewidth': 1.2},
    Look.PLAIN: {'color': INK, 'linewidth': 1.2},
    Look.MARK: {'color': FLOOR, 'linewidth': 1.0, 'linestyle': (0, (4, 3))},
}
_WIDTH = 7.6                        # [inch]
_HEIGHTS: dict[type, float] = {Panel: 2.6, Bars: 3.4, Map: 3.2, Diagram: 3.1}


def draw(drawing: Drawing) -> Figure:
    """Return the picture of a drawing, its lines named below each row, or once where alike."""
    heights = [max(_HEIGHTS[type(content)] for content in row) for row in drawing.rows]
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(_WIDTH, sum(heights)), layout='constrained')
        bands = figure.subfigures(len(heights), 1, height_ratios=heights, squeeze=False)[:, 0]
        named = [_row(band, row) for band, row in zip(bands, drawing.rows)]
        alike = all(names.keys() == named[0].keys() for names in named)
        for band, names in zip(bands[-1:] if alike else bands, named[-1:] if alike else named):
            _legend(band, names)
    return figure


def _row(band: SubFigure, row: Sequence[Content]) -> dict[str, Any]:
    """Draw a row of panels and return the handle of every name in it."""
    panels = band.subplots(1, len(row), squeeze=False)[0]
    for axes, content in zip(panels, row):
        _DRAWN[type(content)](axes, content)
    return {name: handle for axes in panels
            for handle, name in zip(*axes.get_legend_handles_labels())}


def _legend(band: SubFigure, named: dict[str, Any]) -> None:
    if named:
        band.legend(list(named.values()), list(named), ncols=min(len(named), 4), fontsize=7.5,
                    loc='outside lower left', borderpad=0.1)


def _panel(axes: Axes, panel: Panel) -> None:
    for begin, end in panel.shaded:
        axes.axvspan(begin, end, color=FLOOR, alpha=0.15, linewidth=0.0)
    for trace in panel.traces:
        _trace(axes, trace)
    axes.set_xscale('log' if panel.log_x else 'linear')
    axes.set_yscale('log' if panel.log_y else 'linear')
    axes.set_ylim(panel.bottom, panel.top)
    _label(axes, panel)


def _trace(axes: Axes, trace: Trace) -> None:
    style = dict(_STYLES[trace.look])
    if trace.points:
        style = {'color': style['color'], 'linestyle': 'none', 'marker': '.', 'markersize': 2.0}
    axes.plot(trace.x, trace.y, label=plain(trace.name) or None, rasterized=trace.points, **style)


def _bars(axes: Axes, bars: Bars) -> None:
    """Draw bars from left to right, the first name on top."""
    height = 0.8 / len(bars.groups)
    for place, (name, look, values) in enumerate(bars.groups):
        rows = [row + (place - 0.5 * (len(bars.groups) - 1)) * height
                for row in range(len(bars.names))]
        drawn = axes.barh(rows, values, height, color=_STYLES[look]['color'], label=plain(name))
        axes.bar_label(drawn, [f'{value:.2f}' for value in values], padding=2, fontsize=6.5)
    axes.set_yticks(range(len(bars.names)), [plain(name) for name in bars.names])
    axes.invert_yaxis()
    axes.margins(x=0.1)
    axes.grid(visible=False, axis='y')
    axes.set_title(plain(bars.title))
    axes.set_xlabel(plain(bars.x_label))


def _map(axes: Axes, chart: Map) -> None:
    drawn = axes.pcolormesh(chart.x, chart.y, chart.value, vmin=0.0, vmax=chart.top,
                            cmap='magma_r', shading='nearest', rasterized=True)
    axes.figure.colorbar(drawn, ax=axes, label=plain(chart.value_label), extend='max')
    axes.grid(visible=False)
    _label(axes, chart)


def _diagram(axes: Axes, diagram: Diagram) -> None:
    axes.set_axis_off()
    axes.set_title(plain(diagram.title))
    draw_diagram(axes, diagram)


def _label(axes: Axes, content: Panel | Map) -> None:
    axes.set_title(plain(content.title))
    axes.set_xlabel(plain(content.x_label))
    axes.set_ylabel(plain(content.y_label))


_DRAWN: dict[type, Any] = {Panel: _panel, Bars: _bars, Map: _map, Diagram: _diagram}
