"""
Records of an MCAP file, as bytes in memory.

The many small message records of a chunk are found and read as arrays. The rare others go through
the `mcap` library.
"""

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from io import BytesIO
import struct
from typing import NamedTuple, TypeVar

from hda_msgs_json.cdr_arrays import Batch
from hda_msgs_json.mcap_walk import RECORD_HEAD, record_starts
from hda_msgs_json.strided import Indices, structures
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Metadata, Schema
import numpy as np
from numpy.typing import NDArray

MAGIC = b'\x89MCAP0\r\n'
MESSAGE_HEAD = np.dtype([
    ('opcode', 'u1'), ('length', '<u8'), ('channel', '<u2'), ('sequence', '<u4'),
    ('log_time', '<u8'), ('publish_time', '<u8')])
INDEX_ENTRY = np.dtype([('log_time', '<u8'), ('offset', '<u8')])

Record = TypeVar('Record', Channel, Metadata, Schema)


class BagError(ValueError):
    """Raised when a recording cannot be read or written."""


class Messages(NamedTuple):
    """Hold messages of a chunk: when they were recorded [ns] (n,), and where they are."""

    log_times: Indices
    batch: Batch


class Records:
    """
    Give access to the records of one stretch of an MCAP file.

    The indexes, by channel, come from the file. They are believed where the messages are what they
    say; otherwise the records are followed one by one.
    """

    def __init__(self, content: bytes, indexes: Mapping[int, NDArray[np.void]]) -> None:
        """Look at nothing yet."""
        self._content = content
        self._buffer = np.frombuffer(content, np.uint8)
        self._indexes = indexes

    def definitions(self) -> Iterator[Schema | Channel]:
        """Yield the schemas and channels; raise BagError if one is broken."""
        starts, end = self._walked
        opcodes = self._buffer[starts]
        stops = np.append(starts[1:], end)
        for at in np.flatnonzero(np.isin(opcodes, (Opcode.SCHEMA, Opcode.CHANNEL))):
            body = self._content[starts[at] + RECORD_HEAD.size:stops[at]]
            yield parse(Schema, body) if opcodes[at] == Opcode.SCHEMA else parse(Channel, body)

    def log_times(self) -> dict[int, Indices]:
        """Return when the messages of each channel were recorded [ns]."""
        heads = structures(self._buffer, self._message_starts, MESSAGE_HEAD)
        times = heads['log_time'].astype(np.int64)
        return {int(channel): times[heads['channel'] == channel]
                for channel in np.unique(heads['channel'])}

    def messages(self, channels: Sequence[int]) -> Messages:
        """Return the messages of some channels, in the order of the file."""
        indexed = self._indexed(channels)
        if indexed is None:
            starts = self._message_starts
            heads = structures(self._buffer, starts, MESSAGE_HEAD)
            chosen = np.isin(heads['channel'], channels)
            starts, heads = starts[chosen], heads[chosen]
        else:
            starts, heads = indexed
        sizes = heads['length'].astype(np.int64) + (RECORD_HEAD.size - MESSAGE_HEAD.itemsize)
        batch = Batch(self._buffer, starts + MESSAGE_HEAD.itemsize, sizes)
        return Messages(heads['log_time'].astype(np.int64), batch)

    @cached_property
    def _walked(self) -> tuple[Indices, int]:
        return record_starts(self._content)

    @property
    def _message_starts(self) -> Indices:
        """Return where complete message records start."""
        starts, end = self._walked
        sizes = np.diff(starts, append=end)
        return starts[
            (self._buffer[starts] == Opcode.MESSAGE) & (sizes >= MESSAGE_HEAD.itemsize)]

    def _indexed(self, channels: Sequence[int]) -> tuple[Indices, NDArray[np.void]] | None:
        """Return starts and heads that the indexes give, or None if they are not true."""
        if not self._indexes:
            return None
        present = [channel for channel in channels if channel in self._indexes]
        entries = np.concatenate([
            np.empty(0, INDEX_ENTRY), *(self._indexes[channel] for channel in present)])
        numbers = np.repeat(present, [len(self._indexes[channel]) for channel in present])
        starts = entries['offset'].astype(np.int64)
        last = len(self._buffer) - MESSAGE_HEAD.itemsize
        if len(starts) and (starts.min() < 0 or starts.max() > last):
            return None
        if (np.diff(starts) <= 0).any():
            order = np.argsort(starts, kind='stable')
            starts, entries, numbers = starts[order], entries[order], numbers[order]
        heads = structures(self._buffer, starts, MESSAGE_HEAD)
        room = (len(self._buffer) - starts - RECORD_HEAD.size).astype(np.uint64)
        true = (
            (heads['opcode'] == Opcode.MESSAGE) & (heads['channel'] == numbers)
            & (heads['log_time'] == entries['log_time']) & (heads['length'] <= room)
            & (heads['length'] >= MESSAGE_HEAD.itemsize - RECORD_HEAD.size))
        return (starts, heads) if true.all() else None


def parse(kind: type[Record], body: bytes) -> Record:
    """Return a record of the `mcap` library; raise BagError if the bytes are not one."""
    try:
        return kind.read(ReadDataStream(BytesIO(body)))
    except (McapError, struct.error, UnicodeDecodeError):
        raise BagError(f'a {kind.__name__.lower()} record is broken') from None
