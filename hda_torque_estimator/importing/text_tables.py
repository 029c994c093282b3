"""
Find the table in lines of text: its names, its mark between columns, its decimal point.

A line of nothing but numbers is data. The line before it has the names, after a `#` or a `%` as
well, and one of units may stand between. Where no line has names, columns are numbered.
"""

from collections.abc import Callable, Iterator, Sequence
import csv
import re
from typing import NamedTuple

from .headings import UNITS, WORD

MARKS = ',;\t|'
COMMENT = re.compile(r'\s*(?:#|%|//)\s*')
NUMBER = re.compile(r'[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|[+-]?(?:nan|inf)', re.IGNORECASE)
DECIMAL_COMMA = re.compile(r'[+-]?\d*,\d+(?:[eE][+-]?\d+)?')
POINTED = re.compile(r'[+-]?\d*\.\d+(?:[eE][+-]?\d+)?')
BOTTLE = re.compile(r'[()]|\[[^\]]*\]|"[^"]*"')
SPELLED = {spelling for units in UNITS.values() for spellings in units.values()
           for spelling in spellings}
UNITLESS = ('', '-', '1')
YARP_NAMES = ('packet', 'time')
WHITESPACE = ' '


class TableFormat(NamedTuple):
    """Say how a text holds its table; `skipped` lines stand before the first row."""

    names: list[str]
    skipped: int
    mark: str               # between columns, a space for any white space
    decimal_point: str


def form_of(lines: Sequence[str], *, yarp: bool = False) -> TableFormat:
    """
    Return the form of a table by its first lines.

    With `yarp`, rows without names are those of a yarp data dumper: packet, time and values.
    """
    written = [(number, line) for number, line in enumerate(lines) if line.strip()]
    first = next(((number, line) for number, line in written if _is_data(line)), None)
    plain = next(((number, line) for number, line in written if not COMMENT.match(line)), None)
    if first is None or plain is None:
        number, line = plain or (0, '')
        mark = _mark(line)
        below = [cells_of(other, mark) for other in lines[number + 1:]]
        return TableFormat(cells_of(line, mark), number + 1, mark, _decimal_point(below))
    mark = _mark(first[1])
    rows = [cells_of(line, mark) for line in lines[first[0]:]]
    names = _names([line for number, line in written if number < first[0]], mark, len(rows[0]))
    if names is not None:
        return TableFormat(names, first[0], mark, _decimal_point(rows))
    if plain == first:
        return TableFormat(_numbered(rows[0], yarp), first[0], mark, _decimal_point(rows))
    mark = _mark(plain[1])
    below = [cells_of(line, mark) for line in lines[plain[0] + 1:]]
    return TableFormat(cells_of(plain[1], mark), plain[0] + 1, mark, _decimal_point(below))


def cells_of(line: str, mark: str) -> list[str]:
    """Return what stands between the marks of a line."""
    if mark == WHITESPACE:
        return line.split()
    return [cell.strip() for cell in next(csv.reader([line], delimiter=mark), [])]


def table_lines(lines: Sequence[str], form: TableFormat) -> Iterator[str]:
    """Yield the rows, one space for white space, without comments or a last row cut off."""
    tidy: Callable[[str], str] = (
        (lambda line: WHITESPACE.join(line.split())) if form.mark == WHITESPACE else str)
    for number, line in enumerate(lines[form.skipped:], start=form.skipped + 1):
        is_row = line.strip() and not COMMENT.match(line)
        is_cut = number == len(lines) and len(cells_of(line, form.mark)) < len(form.names)
        if is_row and not is_cut:
            yield tidy(line)


def without_brackets(line: str) -> str:
    """Return a line of a yarp log without the brackets of its lists, its vocabs and texts."""
    return BOTTLE.sub(' ', line)


def _is_data(line: str) -> bool:
    """Return whether a line holds numbers alone."""
    cells = cells_of(line, _mark(line))
    known = [cell for cell in cells if cell]
    return bool(known) and all(_is_number(cell) for cell in known)


def _is_number(cell: str) -> bool:
    return bool(NUMBER.fullmatch(cell) or DECIMAL_COMMA.fullmatch(cell))


def _mark(line: str) -> str:
    """Return what stands between the columns of a line."""
    words = line.split()
    if len(words) > 1 and all(map(_is_number, words)):
        return '\t' if '\t' in line and len(line.split('\t')) == len(words) else WHITESPACE
    for mark in MARKS[1:]:
        if mark in line and all(not cell or _is_number(cell) for cell in cells_of(line, mark)):
            return mark
    mark = max(MARKS, key=line.count)
    return mark if mark in line else WHITESPACE


def _names(above: Sequence[str], mark: str, count: int) -> list[str] | None:
    """Return the names in the lines above the data, with the units below them, or None."""
    split = [cells_of(COMMENT.sub('', line, count=1), mark) for line in above]
    alike = [cells for cells in split if len(cells) == count]
    if not alike:
        return None
    if len(alike) > 1 and _are_units(alike[-1]):
        names, units = alike[-2:]
        return [name if unit in UNITLESS else f'{name} [{unit}]'
                for name, unit in zip(names, (unit.strip('[]()') for unit in units))]
    # Rows of texts and numbers are data: then the names stand in the first line of all.
    return None if any(map(_is_number, alike[-1])) else alike[-1]


def _are_units(cells: Sequence[str]) -> bool:
    return all(cell in UNITLESS or ' '.join(WORD.findall(cell)).lower() in SPELLED
               for cell in cells)


def _numbered(row: Sequence[str], yarp: bool) -> list[str]:
    if yarp and len(row) > len(YARP_NAMES) and row[0].isdecimal():
        return [*YARP_NAMES, *(f'value_{place}' for place in range(1, len(row) - 1))]
    return [f'column_{place}' for place in range(1, len(row) + 1)]


def _decimal_point(rows: Sequence[Sequence[str]]) -> str:
    cells = [cell for row in rows for cell in row]
    has_comma = any(map(DECIMAL_COMMA.fullmatch, cells))
    return ',' if has_comma and not any(map(POINTED.fullmatch, cells)) else '.'
