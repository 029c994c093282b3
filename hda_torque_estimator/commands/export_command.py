"""`hda export`: a bag becomes one table, CSV or Parquet."""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO

from hda_msgs_json.bag import open_recording, Recording
from hda_msgs_json.errors import HdaError
from hda_msgs_json.outputs import check_file, whole_file
from hda_msgs_json.topics import JOINT_STATE, JOINT_STATES, WRENCH_STAMPED
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet

from .out_option import add_out
from .outcome import Outcome
from ..importing.exported import (
    at_stamps, Columns, joint_columns, time_columns, wrench_columns)

WRITE: dict[str, Callable[[pa.Table, BinaryIO], None]] = {
    '.csv': pyarrow.csv.write_csv,
    '.parquet': pyarrow.parquet.write_table,
}


class ExportError(HdaError):
    """Raised for a place whose name does not say what to write, or a bag without rows."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument('bag', type=Path, metavar='BAG', help='bag directory, .mcap or .db3 file')
    parser.add_argument('--topic', metavar='TOPIC',
                        help='only this topic, one row for each of its messages')
    add_out(parser, 'FILE', f'table to write: {" or ".join(WRITE)}')


def execute(options: argparse.Namespace) -> Outcome:
    """Write the table; raises the project's errors."""
    write = WRITE.get(options.out.suffix.lower())
    if write is None:
        raise ExportError(f'{options.out} must end in {" or ".join(WRITE)}')
    check_file(options.out, force=options.force, reads=[options.bag])
    recording = open_recording(options.bag)
    columns = (_whole_table(recording) if options.topic is None else
               _topic_table(recording, options.topic))
    rows = len(columns['stamp'])
    if not rows:
        raise ExportError(f'{options.bag} has no messages to export')
    with whole_file(options.out, force=options.force) as stream:
        write(pa.table(columns), stream.buffer)
    left_out = [] if options.topic else sorted(
        name for name, topic in recording.topics.items()
        if topic.count and topic.message_type not in (JOINT_STATE, WRENCH_STAMPED))
    lines = [f'{options.out}: {rows} rows, {len(columns)} columns']
    lines += [f'  left out: {", ".join(left_out)}'] if left_out else []
    lines += [f'  warning: {sentence}' for sentence in recording.warnings]
    return Outcome('\n'.join(lines), {
        'out': str(options.out), 'rows': rows, 'columns': list(columns), 'left_out': left_out,
        'warnings': recording.warnings})


def _topic_table(recording: Recording, topic: str) -> Columns:
    """Return one topic at its own stamps."""
    name = topic.strip('/')
    if _type_of(recording, name) == WRENCH_STAMPED:
        wrenches = recording.wrenches(topic)
        return {**time_columns(wrenches.stamps), **wrench_columns(wrenches, name)}
    states = recording.joint_states(topic)
    return {**time_columns(states.stamps), **joint_columns(states)}


def _whole_table(recording: Recording) -> Columns:
    """Return the joint states, and all else that has numbers at their stamps."""
    states = recording.joint_states()
    columns = {**time_columns(states.stamps), **joint_columns(states)}
    for topic, summary in recording.topics.items():
        name = topic.strip('/')
        if summary.message_type == WRENCH_STAMPED:
            wrenches = recording.wrenches(topic)
            columns |= at_stamps(wrench_columns(wrenches, name), wrenches.stamps, states.stamps)
        elif summary.message_type == JOINT_STATE and name.split('/')[-1] != JOINT_STATES.name:
            others = recording.joint_states(topic)
            columns |= at_stamps(joint_columns(others, name), others.stamps, states.stamps)
    return columns


def _type_of(recording: Recording, name: str) -> str:
    return next((summary.message_type for topic, summary in recording.topics.items()
                 if topic.strip('/') == name), '')
