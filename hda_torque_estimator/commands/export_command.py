"""`hda export`: a bag becomes one table, CSV or Parquet."""

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import BinaryIO

from hda_msgs_json.bag import open_recording, Recording
from hda_msgs_json.cdr_dynamic import decode_dynamic_joint_states
from hda_msgs_json.cdr_fields import CdrError
from hda_msgs_json.errors import HdaError
from hda_msgs_json.outputs import check_file, whole_file
from hda_msgs_json.samples import Stamps
from hda_msgs_json.topics import JOINT_STATE, JOINT_STATES, NUMBER, WRENCH_STAMPED
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet

from .out_option import add_out
from .outcome import Outcome
from .progress import progress
from ..importing.exported import (
    at_stamps, Columns, joint_columns, time_columns, wrench_columns)

DYNAMIC_JOINT_STATE = 'control_msgs/msg/DynamicJointState'
NUMBERS = (JOINT_STATE, WRENCH_STAMPED, NUMBER, DYNAMIC_JOINT_STATE)
WRITE: dict[str, Callable[[pa.Table, BinaryIO], None]] = {
    '.csv': pyarrow.csv.write_csv,
    '.parquet': pyarrow.parquet.write_table,
}
EXAMPLES = (
    'hda export bag --out table.parquet',
    'hda export bag --topic /drive --topic /load --out table.csv')


class ExportError(HdaError):
    """Raised for a place whose name does not say what to write, or a bag without rows."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument('bag', type=Path, metavar='BAG', help='bag directory, .mcap or .db3 file')
    parser.add_argument('--topic', action='append', metavar='TOPIC',
                        help='only this topic, a row for each of its messages; given again: '
                             'this one too, in the rows of the first')
    add_out(parser, 'FILE', f'table to write: {" or ".join(WRITE)}')


def execute(options: argparse.Namespace) -> Outcome:
    """Write the table; raises the project's errors."""
    with progress(f'exporting {options.bag.name}', quiet=options.json):
        return _exported(options)


def _exported(options: argparse.Namespace) -> Outcome:
    write = WRITE.get(options.out.suffix.lower())
    if write is None:
        raise ExportError(f'{options.out} must end in {" or ".join(WRITE)}')
    check_file(options.out, force=options.force, reads=[options.bag])
    recording = open_recording(options.bag)
    columns = _table(recording, options.topic or _topics(recording))
    rows = len(columns['stamp'])
    if not rows:
        raise ExportError(f'{options.bag} has no messages to export')
    with whole_file(options.out, force=options.force) as stream:
        write(pa.table(columns), stream.buffer)
    left_out = [] if options.topic else sorted(
        name for name, topic in recording.topics.items()
        if topic.count and topic.message_type not in NUMBERS)
    lines = [f'{options.out}: {rows} rows, {len(columns)} columns']
    lines += [f'  left out: {", ".join(left_out)}'] if left_out else []
    lines += [f'  warning: {sentence}' for sentence in recording.warnings]
    return Outcome('\n'.join(lines), {
        'out': str(options.out), 'rows': rows, 'columns': list(columns), 'left_out': left_out,
        'warnings': recording.warnings})


def _topics(recording: Recording) -> list[str]:
    """Return the joint states and, behind them, all other topics that have numbers."""
    return [JOINT_STATES.name, *(
        name for name, topic in recording.topics.items()
        if topic.message_type in NUMBERS and name.rpartition('/')[2] != JOINT_STATES.name)]


def _table(recording: Recording, topics: Sequence[str]) -> Columns:
    """Return the first topic at its own stamps, and all others at the same ones."""
    grid, found = _numbers(recording, topics[0], '')
    columns = {**time_columns(grid), **found}
    for topic in topics[1:]:
        stamps, found = _numbers(recording, topic, topic.strip('/'))
        columns |= at_stamps(found, stamps, grid)
    return columns


def _numbers(recording: Recording, topic: str, prefix: str) -> tuple[Stamps, Columns]:
    """Return the stamps of a topic and its columns; names of joints stand behind the prefix."""
    name = topic.strip('/')
    kind = next((summary.message_type for other, summary in recording.topics.items()
                 if other.strip('/') == name), '')
    if kind == WRENCH_STAMPED:
        wrenches = recording.wrenches(topic)
        return wrenches.stamps, wrench_columns(wrenches, name)
    if kind == NUMBER:
        single = recording.numbers(topic)
        return single.stamps, {name: single.values}
    if kind == DYNAMIC_JOINT_STATE:
        try:
            stamps, columns = decode_dynamic_joint_states(recording.raw(topic)[1])
        except CdrError as error:
            raise ExportError(f'{recording.path}, topic {topic}: {error}') from None
        return stamps, {f'{prefix}{"." * bool(prefix)}{key}': values
                        for key, values in columns.items()}
    states = recording.joint_states(topic)
    return states.stamps, joint_columns(states, prefix)
