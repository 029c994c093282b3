"""The page of the reproduction: one HTML file that needs no network and no other file."""

from collections.abc import Mapping
import math
from typing import Any

from .catalogue import FIGURES
from .report import file_name
from .rig.exhibit import Exhibit, PaperNumber
from ..pages.badge import Badge
from ..pages.render import render
from ..pages.wording import unit

REPRODUCED = Badge('done', 'Reproduced', 'made again by computation')
_TITLE = 'The paper, reproduced and corrected'
PAPER = 'Torque Estimation Technique for a Harmonic Drive Robotic Arm'
_LEAD = (f'The paper is "{PAPER}"; its text at hand names no authors, year or journal. '
         'Every figure and table of it that a computer can give is made by the simulator, the '
         'estimator and the controller of this package. "Printed" is what the equations give '
         'as they stand in the paper, "consistent" what they give once signs, sides and units '
         'agree. The derivations are in docs/errata.md. Fig. 1, 4, 8 and 13 are drawings and '
         'photographs.')
_WRITTEN = (('N*m', 'N·m'), ('·m*s', '·m·s'), ('urad', 'µrad'), ('^2', '²'), (' um', ' µm'))
_HEADS = ('quantity', 'unit', 'paper', 'printed', 'consistent', 'remark')


def page(made: Mapping[str, Exhibit], inline: Mapping[str, str], version: str) -> str:
    """Return the exhibits as one HTML document; `inline` are SVG elements by file name."""
    return render('reproduction.html', title=_TITLE, badge=REPRODUCED, lead=_LEAD, heads=_HEADS,
                  version=version,
                  shown=[_shown(name, exhibit, inline) for name, exhibit in made.items()])


def _shown(name: str, exhibit: Exhibit, inline: Mapping[str, str]) -> dict[str, Any]:
    """Return the section of one figure: what the paper says, what is found, pictures, numbers."""
    entry = FIGURES[name]
    return {'name': name, 'title': entry.title, 'said': entry.said,
            'findings': [_prose(finding) for finding in exhibit.findings],
            'drawings': [(inline[file_name(name, drawing.name)], drawing.caption)
                         for drawing in exhibit.drawings],
            'rows': [_row(number) for number in exhibit.numbers],
            'not_computed': [_prose(reason) for reason in exhibit.not_computed]}


def _row(number: PaperNumber) -> list[str]:
    return [_prose(number.name), _prose(unit(number.unit)),
            *map(_value, (number.paper, number.printed, number.consistent)),
            _prose(number.remark)]


def _value(value: float | None) -> str:
    """Return a number with four figures, a dash where there is none."""
    if value is None:
        return '–'
    if not math.isfinite(value):
        return 'unbounded'
    return f'{value:,.0f}' if abs(value) >= 1e4 else f'{value:.4g}'


def _prose(text: str) -> str:
    """Return text with units as people write them."""
    for typed, written in _WRITTEN:
        text = text.replace(typed, written)
    return text
