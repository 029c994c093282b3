"""How all figures look, and how they get into a page."""

import io
import re
from typing import Any

from hda_arm_sim.foundation.arrays import Array
import matplotlib
from matplotlib.axes import Axes
from matplotlib.figure import Figure
import numpy as np

INK = '#1a1a1e'                     # becomes the colour of the text around an inline figure
BEFORE, AFTER, FLOOR = '#e08214', '#2b6cb0', '#7f7f85'
_BUCKETS = 600                      # of a trace over time: as many as can be seen
STYLE: dict[Any, Any] = {
    'font.size': 8.5, 'axes.titlesize': 9.0, 'axes.titlelocation': 'left',
    'axes.spines.top': False, 'axes.spines.right': False, 'axes.grid': True,
    'axes.axisbelow': True, 'grid.alpha': 0.25,
    'grid.color': FLOOR, 'grid.linewidth': 0.5, 'axes.linewidth': 0.6, 'axes.xmargin': 0.01,
    'legend.frameon': False, 'text.color': INK, 'axes.labelcolor': INK, 'axes.edgecolor': INK,
    'xtick.color': INK, 'ytick.color': INK, 'axes.formatter.useoffset': False,
    'svg.hashsalt': 'hda', 'svg.fonttype': 'path',
}


def inline_svg(figure: Figure, name: str) -> str:
    """
    Return a figure as an SVG element to stand in a page with others.

    Its names are made its own by `name`, its ink is the colour of the text around it.
    """
    stream = io.StringIO()
    with matplotlib.rc_context(STYLE):
        figure.savefig(stream, format='svg', transparent=True, metadata={'Date': None})
    text = stream.getvalue()
    text = text[text.index('<svg'):].replace(INK, 'currentColor')
    text = re.sub(r'<metadata>.*?</metadata>', '', text, flags=re.DOTALL)
    return re.sub(r'(\bid="|xlink:href="#|url\(#)', rf'\g<1>{name}-', text)


def band(axes: Axes, time: Array, values: Array, colour: str, name: str | None, *,
         width: float = 0.7, alpha: float = 1.0) -> None:
    """Draw the band in which dense values lie: vector graphics stay small."""
    cuts = np.unique(np.linspace(0, len(time), min(_BUCKETS, len(time)) + 1).astype(int))[:-1]
    low, high = np.fmin.reduceat(values, cuts), np.fmax.reduceat(values, cuts)
    axes.fill_between(time[cuts], low, high, color=colour, linewidth=width, alpha=alpha,
                      label=name)


def plain(text: str) -> str:
    """Return text in which a dollar sign starts no formula."""
    return text.replace('$', r'\$')
