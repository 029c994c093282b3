"""The page of the reproduction: one HTML file that needs no network, script or other file."""

from collections.abc import Mapping
from html import escape
import math

from .catalogue import Entry, FIGURES
from .report import file_name
from .rig.exhibit import Exhibit, Number
from ..pages.document import captioned, code, document, section, table, unit

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
    parts = [f'<h1>{escape(_TITLE)}</h1>', f'<p class="lead">{escape(_LEAD)}</p>',
             _contents(made), *(_exhibit(name, FIGURES[name], exhibit, inline)
                                for name, exhibit in made.items()),
             f'<p>Made by version {escape(version)}.</p>']
    return document(_TITLE, parts)


def _contents(made: Mapping[str, Exhibit]) -> str:
    return '<p>' + ' · '.join(f'<a href="#{name}">{escape(FIGURES[name].title)}</a>'
                              for name in made) + '</p>'


def _exhibit(name: str, entry: Entry, exhibit: Exhibit, inline: Mapping[str, str]) -> str:
    """Return the section of one figure: what the paper says, what is found, pictures, numbers."""
    content = [f'<p id="{name}">The paper: {escape(entry.said)} Made by '
               f'{code(f"hda reproduce {name} --out DIR")}.</p>',
               *(f'<p>{_prose(finding)}</p>' for finding in exhibit.findings),
               *(captioned(inline[file_name(name, drawing.name)], drawing.caption)
                 for drawing in exhibit.drawings),
               table(_HEADS, map(_row, exhibit.numbers)),
               *(f'<p>Not computed: {_prose(reason)}</p>' for reason in exhibit.not_computed)]
    return section(entry.title, '\n'.join(content))


def _row(number: Number) -> list[str]:
    return [_prose(number.name), _prose(unit(number.unit)),
            *(f'<span class="number">{_value(value)}</span>'
              for value in (number.paper, number.printed, number.consistent)),
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
    return escape(text)
