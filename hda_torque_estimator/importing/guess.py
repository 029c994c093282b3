"""Guess a column map from the names and the numbers of a table."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from os.path import commonprefix
from types import MappingProxyType

import numpy as np

from .column_map import ColumnMapError
from .guess_by_numbers import Settling
from .guess_by_rates import entries_by_rates
from .headings import Heading, read_heading
from .number_clues import (
    Columns, Floats, is_dead, is_even, is_whole, numbers, splits, time_step, time_unit)
from .places import entries_by_name, MapEntry, patterns_of
from .units import TIME

NANO = 1e-9
BY_STEPS = 'unit by its steps'
LONGEST_NAMES = 200             # letters of two columns that a formula has room for
SPLITTERS = ('run', 'sample', 'trial', 'episode', 'experiment', 'recording', 'segment', 'seq',
             'test', 'id', 'index')
"""Words of columns that separate recordings, the likeliest first."""


@dataclass(frozen=True)
class TimeEntry:
    """The column of the time, or none where no column grows like a time."""

    column: str | None = None
    unit: str = 's'
    reason: str = 'no column grows like a time'
    from_first: bool = False
    split: str | None = None
    parts: str | None = None        # column of nanoseconds, beside one of whole seconds

    def seconds(self, columns: Columns) -> Floats:
        """Return the time of every row [s], nothing where no column states it."""
        if self.column is None:
            return np.empty(0)
        seconds = numbers(columns, self.column) * TIME.units[self.unit].factor
        return seconds if self.parts is None else seconds + NANO * numbers(columns, self.parts)


@dataclass(frozen=True)
class Guess:
    """A guessed map: entries by their place, gear ratios that show, columns without use."""

    time: TimeEntry
    entries: Mapping[str, MapEntry]
    ratios: Mapping[int, float]
    unused: tuple[str, ...]

    @property
    def ratio(self) -> float | None:
        """Return the gear ratio of all joints, None where they differ or do not show."""
        shown = set(self.ratios.values())
        return shown.pop() if len(shown) == 1 and {*self.joints} <= {*self.ratios} else None

    @property
    def joints(self) -> tuple[int, ...]:
        """Return the numbers of the joints in the names, 0 where names have none."""
        return tuple(sorted({number for entry in self.entries.values()
                             for pattern in entry.patterns for number in pattern.columns}))


def guess(columns: Columns, tables: Mapping[str, str] = MappingProxyType({})) -> Guess:
    """
    Return what the columns of a table most likely mean; raises ColumnMapError for nothing.

    The names of `tables`, by column, count for columns that state no quantity.
    """
    headings = _alive(_headings(columns, tables), columns)
    entries = entries_by_name(patterns_of(headings))
    time = _time(headings, columns)
    entries = entries or entries_by_rates(headings, columns, time.seconds(columns))
    if not entries:
        some = ', '.join(repr(name) for name in list(columns)[:4])
        raise ColumnMapError(f'no column looks like an angle, a speed or a torque of a joint, '
                             f'got {some or "no columns"}; write the map by hand, or '
                             'name the columns in a first line, such as t,q_1,qd_1,current_1')
    time = _by_speeds(time, columns, entries)
    settling = Settling(columns, time.seconds(columns), entries)
    ratios = settling.settle()
    used = {time.column, time.parts, time.split} | {
        column for entry in settling.entries.values() for pattern in entry.patterns
        for column in pattern.columns.values()}
    return Guess(time, settling.entries, ratios,
                 tuple(name for name in columns if name not in used))


def _headings(columns: Columns, tables: Mapping[str, str]) -> list[Heading]:
    """Return what the names say, without the struct in which all columns are: it says nothing."""
    parts = commonprefix([name.split('.')[:-1] for name in columns])
    prefix = ''.join(f'{part}.' for part in parts)
    if '{' in prefix:
        prefix = ''
    headings = [read_heading(name.removeprefix(prefix), tables.get(name, ''))
                for name in columns]
    return [replace(heading, column=name, pattern=prefix + heading.pattern)
            for name, heading in zip(columns, headings)]


def _alive(headings: Sequence[Heading], columns: Columns) -> list[Heading]:
    """
    Return the headings but for those of columns that hold zeros alone: nobody measured them.

    A speed or a torque may be zero where a joint stands at an angle, if it is not at every joint.
    """
    dead = {heading.column for heading in headings if is_dead(columns[heading.column])}
    alive = [heading for heading in headings if heading.column not in dead]
    patterns = {heading.pattern for heading in alive}
    standing = {heading.number for heading in alive if heading.kind == 'position'}
    return [heading for heading in headings if heading.column not in dead or (
        heading.kind != 'position' and heading.pattern in patterns
        and heading.number in standing)]


def _time(headings: Sequence[Heading], columns: Columns) -> TimeEntry:
    """Return the column that grows like a time, by its name, else by its even steps."""
    if (stamp := _of_messages(headings, columns)) is not None:
        return stamp
    for heading in headings:
        values = numbers(columns, heading.column)
        if heading.kind != 'time' or heading.number is not None or (
                step := time_step(values)) is None:
            continue
        return _entry(heading, step, values, columns)
    for heading in headings:
        values = numbers(columns, heading.column)
        if heading.kind is None and is_even(values):
            return _entry(heading, float(np.median(np.diff(values))), values, columns)
    return TimeEntry()


def _by_speeds(time: TimeEntry, columns: Columns, entries: dict[str, MapEntry]) -> TimeEntry:
    """Return a time whose unit the steps told in that in which speeds are the rates of angles."""
    if time.column is None or not time.reason.endswith(BY_STEPS):
        return time
    for unit in dict.fromkeys((time.unit, *TIME.units)):
        other = replace(time, unit=unit)
        seconds = other.seconds(columns)
        if Settling(columns, seconds, entries).fits_speeds():
            rate = 1.0 / float(np.median(np.diff(seconds)))
            reason = f'{rate:.4g} Hz, {BY_STEPS if unit == time.unit else "unit by the speeds"}'
            return replace(other, reason=reason)
    return time


def _of_messages(headings: Sequence[Heading], columns: Columns) -> TimeEntry | None:
    """Return the stamp of ROS messages: whole seconds in one column, nanoseconds in another."""
    by_unit = {unit: [heading.column for heading in headings if heading.kind == 'time'
                      and heading.unit == unit] for unit in ('s', 'ns')}
    for whole, parts in zip(by_unit['s'], by_unit['ns']):
        if len(whole + parts) > LONGEST_NAMES or '`' in whole + parts:
            continue
        entry = TimeEntry(whole, from_first=True, parts=parts)
        if is_whole(numbers(columns, whole)) and (
                step := time_step(entry.seconds(columns))) is not None:
            return replace(entry, reason=f'{1.0 / step:.4g} Hz, seconds and nanoseconds',
                           split=_split(entry.seconds(columns), columns))
    return None


def _entry(heading: Heading, step: float, values: Floats, columns: Columns) -> TimeEntry:
    """Return the time of a column with its usual step."""
    unit = heading.unit if heading.kind == 'time' else None
    how = ('unit by its name' if unit else
           BY_STEPS if heading.kind == 'time' else 'it grows in even steps')
    unit = unit or time_unit(step)
    rate = 1.0 / (step * TIME.units[unit].factor)
    return TimeEntry(heading.column, unit, f'{rate:.4g} Hz, {how}', bool(values.min() < 0.0),
                     _split(values, columns))


def _split(times: Floats, columns: Columns) -> str | None:
    """Return the column that separates recordings, where the time starts again."""
    if (np.diff(times) > 0.0).all():
        return None
    named = [name for word in SPLITTERS for name in columns if word in read_heading(name).words]
    return next((name for name in named if splits(times, columns[name])), None)
