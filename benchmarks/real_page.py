"""
The page of the real recordings: its template, filled with the numbers that stand beside it.

What a sentence says of a result is held against the numbers: where it is not so any more, no page
is written, and an error says which sentence must be written anew.
"""

from collections.abc import Iterable, Mapping, Sequence
import json
import math
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from real_commands import Numbers

DOCS = Path(__file__).resolve().parents[1] / 'docs'
PAGE, NUMBERS = DOCS / 'real_data.md', DOCS / 'real_data.json'
TEMPLATE = 'real_data.md.j2'
DIGITS = 6              # of the numbers in the file beside the page


class ProseError(AssertionError):
    """Raised when a sentence of the page does not hold for the numbers."""


def page(numbers: Numbers) -> str:
    """Return the page; raises ProseError where a sentence of it is not true."""
    made = Environment(loader=FileSystemLoader(Path(__file__).parent), undefined=StrictUndefined,
                       trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True,
                       autoescape=False, extensions=['jinja2.ext.do'])  # Markdown, no HTML
    made.filters.update(fixed=fixed, figures=figures, percent=percent, small=small, listed=listed,
                        hundreds=hundreds, span=span)
    made.globals.update(holds=holds)
    return made.get_template(TEMPLATE).render(numbers)


def document(numbers: Numbers) -> str:
    """Return the file of the numbers, as many digits as a page ever shows and some more."""
    return json.dumps(_rounded(numbers), indent=1) + '\n'


def _rounded(value: Any) -> Any:
    """Return numbers with the digits of the file, within whatever holds them."""
    if isinstance(value, Mapping):
        return {key: _rounded(each) for key, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [_rounded(each) for each in value]
    if isinstance(value, float):
        return float(f'{value:.{DIGITS}g}') if math.isfinite(value) else None
    return value


def holds(true: object, words: str) -> None:
    """Go on if a sentence of the template is true of the numbers."""
    if not true:
        raise ProseError(f'no longer true, write the sentence anew: {words}')


def fixed(value: float, places: int = 2) -> str:
    """Return a number with so many decimal places."""
    return f'{value:.{places}f}'


def figures(value: float, count: int = 2) -> str:
    """Return a number with so many significant figures, and without an exponent."""
    if value == 0.0:
        return '0'
    places = count - 1 - math.floor(math.log10(abs(float(f'{value:.{count - 1}e}'))))
    return f'{round(value, places):.{max(places, 0)}f}'


def percent(share: float) -> str:
    """Return a share in percent, without the sign of it."""
    return f'{100.0 * share:.0f}'


def small(value: float, places: int = 1) -> str:
    """Return a small number with its power of ten, as in 1.8e-4."""
    head, power = f'{value:.{places}e}'.split('e')
    return f'{head}e{int(power)}'


def hundreds(order: float, ratio: float) -> str:
    """Return the waves in a turn of the output, to ten, of an order in a turn of the motor."""
    return f'{10 * round(0.1 * ratio * order)}'


def span(values: Iterable[float], places: int = 2) -> str:
    """Return the least and the largest of some numbers."""
    every = list(values)
    return f'{fixed(min(every), places)} to {fixed(max(every), places)}'


def listed(parts: Iterable[object]) -> str:
    """Return parts as words are listed: a, b and c."""
    words: Sequence[str] = [str(part) for part in parts]
    return ' and '.join(filter(None, (', '.join(words[:-1]), *words[-1:]))) or 'none'
