"""A fleet as a terminal shows it: a line for each recording, then a table of the devices."""

from collections.abc import Sequence
import shutil
import sys
from typing import NamedTuple

from hda_msgs_json.printable import printable

from ..fleet.history import Device, devices, GROWING
from ..fleet.lines import BagLine, FAILED

ALARM = 2.0             # times the error that noise leaves, from which an alarm is (choice)
MOST_LISTED = 5         # of what was skipped (choice)
MOST_LINES = 40         # recordings beyond which the table alone is shown (choice)
_DATE = len('2026-01-01')
_PLAIN = 100            # columns of a table that nobody looks at on a terminal


class _Row(NamedTuple):
    """One row of the table."""

    device: str
    date: str
    verdict: str
    times: str
    causes: str


def table_text(lines: Sequence[BagLine], skipped: Sequence[str], raised: Sequence[str],
               fresh: int) -> str:
    """Return the lines of a fleet, and its devices with the most severe first."""
    parts = [line.sentence() for line in lines] if len(lines) <= MOST_LINES else []
    parts += ['', f'{len(lines)} recordings of {len(devices(lines))} devices, {fresh} diagnosed '
              'now; the most severe first:', '', *_table(devices(lines))]
    parts += [f'skipped: {printable(words)}' for words in skipped[:MOST_LISTED]]
    if len(skipped) > MOST_LISTED:
        parts.append(f'skipped: {len(skipped) - MOST_LISTED} more, listed in fleet.json')
    parts += [f'ALARM: {words}' for words in raised]
    return '\n'.join(parts)


def alarms(lines: Sequence[BagLine], least: float | None) -> list[str]:
    """Return in words what is alarming about the latest recording of each device, if asked."""
    if least is None:
        return []
    return [f'{printable(device.name)}: {reason}' for device in devices(lines)
            if (reason := _reason(device, least))]


def _reason(device: Device, least: float) -> str:
    latest = device.lines[-1]
    if latest.error is not None:
        return f'{latest.directory} is {FAILED}: {latest.error}'
    if latest.severity is None or latest.severity < least:
        return ''
    growing = [course.words() for course in device.courses() if course.trend == GROWING]
    said = f'its simulation errs {latest.severity:.3g} times as much as noise in {latest.bag}'
    return '; '.join([said, *growing])


def _table(found: Sequence[Device]) -> list[str]:
    rows = [_Row('device', 'latest', 'verdict', 'x noise', 'causes, size, trend'),
            *(row for device in found for row in _rows(device))]
    width = shutil.get_terminal_size().columns if sys.stdout.isatty() else _PLAIN
    from rich.console import Console        # a quarter of a second that only a table waits for
    from rich.table import Table
    table = Table(box=None, padding=(0, 2, 0, 0), pad_edge=False, show_header=False)
    for name in _Row._fields:
        table.add_column(name, no_wrap=name in ('date', 'times'),
                         justify='right' if name == 'times' else 'left', overflow='fold')
    for row in rows:
        table.add_row(*(_escaped(cell) for cell in row))
    console = Console(width=width, color_system=None, force_terminal=False)
    with console.capture() as shown:
        console.print(table)
    return [line.rstrip() for line in shown.get().splitlines()]


def _escaped(cell: str) -> str:
    from rich.markup import escape
    return escape(printable(cell))


def _rows(device: Device) -> list[_Row]:
    latest = device.latest
    if latest.error is not None:
        return [_Row(device.name, '', FAILED, '', latest.error)]
    courses = [course.words() for course in device.courses()] or ['']
    first = _Row(device.name, (latest.date or latest.directory.rpartition('/')[2])[:_DATE],
                 (latest.verdict or '').replace('_', ' '),
                 '' if latest.severity is None else f'{latest.severity:.2g}', courses[0])
    return [first, *(_Row('', '', '', '', words) for words in courses[1:])]
