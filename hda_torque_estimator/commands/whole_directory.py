"""What goes into a directory that appears whole or not at all: reports and figures."""

from collections.abc import Mapping
import json
from pathlib import Path
from typing import Any

from hda_msgs_json.outputs import check_directory, whole_directory
import matplotlib
from matplotlib.figure import Figure

from ..pages.drawing import inline_svg, STYLE

__all__ = ['check_directory', 'elements', 'save_figures', 'whole_directory', 'write_json']


def write_json(path: Path, document: Mapping[str, Any]) -> None:
    """Write a report for machines; raises ValueError for numbers that JSON does not have."""
    path.write_text(json.dumps(document, indent=1, allow_nan=False) + '\n', encoding='utf-8')


def save_figures(figures: Mapping[str, Figure], out: Path, *, vectors: bool = True) -> None:
    """Save figures as PNG, with `vectors` as SVG too."""
    for name, figure in figures.items():
        figure.savefig(out / f'{name}.png', dpi=150)
        if vectors:
            with matplotlib.rc_context(STYLE):      # with its salt, names are those of last time
                figure.savefig(out / f'{name}.svg', metadata={'Date': None})


def elements(figures: Mapping[str, Figure]) -> dict[str, str]:
    """Return figures as elements for a page, by their names."""
    return {name: inline_svg(figure, name) for name, figure in figures.items()}
