"""
SQLite bags of rosbag2 (.db3): copied to MCAP files, so that all else reads one kind of file.

A stranger's file may hold anything: only tables of plain columns are read, so that no expression
in it is ever evaluated.
"""

from collections.abc import Iterator
from contextlib import closing
import os
from pathlib import Path
import re
import shutil
import sqlite3

from hda_msgs_json.bag_file import ENCODING, SCHEMA_ENCODING
from hda_msgs_json.mcap_chunk import expanded_message
from hda_msgs_json.mcap_records import BagError
from hda_msgs_json.mcap_writer import McapWriter
from hda_msgs_json.schemas import schema, SchemaError

MAGIC = b'SQLite format 3\0'
SIZE_AT = 16            # where two bytes hold the size of a page
JOURNALS = ('-wal', '-journal')
"""What SQLite keeps beside a file whose recorder was killed."""
PLAIN = re.compile(r'CREATE TABLE\s+[\w"\'`]+\s*\([\w\s,"\'`]*\)', re.IGNORECASE)
NEEDED = {'topics': {'id', 'name', 'type', 'serialization_format'},
          'messages': {'id', 'topic_id', 'timestamp', 'data'}}
LARGEST_MESSAGE = 1 << 26
COMPRESSION = 'lz4'     # quick: the copy lives as long as the recording is looked at


def is_sqlite(path: Path) -> bool:
    """Return whether a file is an SQLite data base; raises OSError."""
    with path.open('rb') as stream:
        return stream.read(len(MAGIC)) == MAGIC


def to_mcap(path: Path, directory: Path) -> tuple[Path, list[str]]:
    """
    Copy the messages of an SQLite file to an MCAP file in a directory.

    Returns its path and what is wrong with the file. Raises BagError where it is no bag, and
    OSError where the disk does not take the copy.
    """
    target = directory / f'{path.name}.mcap'
    try:
        with closing(_opened(path, directory)) as bag:
            for table, columns in NEEDED.items():
                _check_table(bag, table, columns)
            return target, _copy(bag, path, target)
    except sqlite3.Error as error:
        raise BagError(f'{path} is an SQLite bag that cannot be read: {error}') from None


def _opened(path: Path, directory: Path) -> sqlite3.Connection:
    """Open a file so that nothing beside it changes; what its journals hold is read as well."""
    journals = [beside for ending in JOURNALS
                if (beside := path.with_name(path.name + ending)).is_file()]
    beyond = path.stat().st_size % _page_size(path)
    if journals or beyond:
        for file in (path, *journals):
            if file.parent != directory:
                shutil.copyfile(file, directory / file.name)
        path = directory / path.name
        os.truncate(path, path.stat().st_size - beyond)     # SQLite would fill up with zeros
    else:
        path = path.absolute()
    bag = sqlite3.connect(f'{path.as_uri()}?mode={"rw" if journals else "ro&immutable=1"}',
                          uri=True)
    bag.execute('PRAGMA writable_schema = ON')              # pages may be missing at the end
    return bag


def _page_size(path: Path) -> int:
    with path.open('rb') as stream:
        size = int.from_bytes(stream.read(SIZE_AT + 2)[SIZE_AT:], 'big')
    return size if size > 1 else 1 << 16


def _check_table(bag: sqlite3.Connection, name: str, columns: set[str]) -> None:
    """Raise sqlite3.Error unless there is a table of plain columns, and these are among them."""
    found = bag.execute("SELECT sql FROM sqlite_master WHERE type = 'table' AND name = ?",
                        (name,)).fetchone()
    if found is None:
        raise sqlite3.DatabaseError(f'it has no table {name!r}')
    if not PLAIN.fullmatch(str(found[0])):
        raise sqlite3.DatabaseError(f'its table {name!r} is not one of plain columns')
    if missing := columns - _columns(bag, name):
        raise sqlite3.DatabaseError(f'its table {name!r} has no column {min(missing)!r}')


def _columns(bag: sqlite3.Connection, table: str) -> set[str]:
    return {row[1] for row in bag.execute(f'PRAGMA table_info({table})')}


def _copy(bag: sqlite3.Connection, path: Path, target: Path) -> list[str]:
    """Write all messages as they came, and return what is wrong."""
    with target.open('xb', buffering=0) as stream:
        writer = McapWriter(stream, COMPRESSION)
        try:
            channels = {topic: writer.add_channel(name, (kind, SCHEMA_ENCODING, _schema(kind)),
                                                  ENCODING, {'offered_qos_profiles': quality})
                        for topic, name, kind, quality in _topics(bag)}
            warnings = list(_write(bag, path, writer, channels))
            writer.finish()
        finally:
            writer.close()
    return warnings


def _topics(bag: sqlite3.Connection) -> list[tuple[int, str, str, str]]:
    """Return number, name, type and quality of service of every topic in CDR."""
    quality = ('offered_qos_profiles' if 'offered_qos_profiles' in _columns(bag, 'topics')
               else "''")
    return bag.execute(
        f'SELECT id, CAST(name AS TEXT), CAST(type AS TEXT), CAST({quality} AS TEXT) FROM topics '
        "WHERE serialization_format = 'cdr' AND name IS NOT NULL AND type IS NOT NULL "
        f'AND {quality} IS NOT NULL').fetchall()


def _schema(message_type: str) -> bytes:
    """Return the definition of a type, or nothing: messages of others are carried as they are."""
    try:
        return schema(message_type).text.encode()
    except SchemaError:
        return b''


def _write(bag: sqlite3.Connection, path: Path, writer: McapWriter,
           channels: dict[int, int]) -> Iterator[str]:
    """Write messages, and yield what ends them before their time."""
    left_out = 0
    try:
        for topic, time, message in bag.execute(
                "SELECT topic_id, timestamp, CASE WHEN typeof(data) = 'blob' AND "
                f'length(data) <= {LARGEST_MESSAGE} THEN data END '
                'FROM messages NOT INDEXED ORDER BY id'):
            if message is None or topic not in channels or not (
                    isinstance(time, int) and time >= 0):
                left_out += 1
            else:
                writer.write(channels[topic], time, expanded_message(message))
    except (sqlite3.Error, BagError) as error:
        yield f'{path.name}: it is damaged, later messages are missing: {error}'
    if left_out:
        yield f'{path.name}: {left_out} messages without topic, time or content are left out'
