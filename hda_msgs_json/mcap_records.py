"""
Records of an MCAP file, as bytes in memory.

The many small message records of a chunk are found and read as arrays. The rare others go through
the `mcap` library.
"""

from collections.abc import Iterator, Sequence
from functools import cached_property
from io import BytesIO
import struct
from typing import NamedTuple, TypeVar

from hda_msgs_json.cdr_batch import Batch
from hda_msgs_json.errors import HdaError
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


class BagError(HdaError):
    """Raised when a recording cannot be read or written."""


class Messages(NamedTuple):
    """Hold messages of a chunk: when they were recorded [ns] (n,), and where they are."""

    log_times: Indices
    batch: Batch


class _Heads(NamedTuple):
    """Hold the heads of message records and where they start (n,)."""

    starts: Indices
    heads: NDArray[np.void]


class Records:
    """Give access to the records of one stretch of an MCAP file."""

    def __init__(self, content: bytes, hints: Indices | None = None) -> None:
        """Find all complete records; hints of where some of them start save time."""
        self._content = content
        self._buffer = np.frombuffer(content, np.uint8)
        self._starts, self._end = record_starts(content, hints)
        self._opcodes = self._buffer[self._starts]

    def definitions(self) -> Iterator[Schema | Channel]:
        """Yield the schemas and channels, each once; raise BagError if one is broken."""
        stops = np.append(self._starts[1:], self._end)
        seen = set()
        for at in np.flatnonzero(
                (self._opcodes == Opcode.SCHEMA) | (self._opcodes == Opcode.CHANNEL)):
            record = self._content[self._starts[at]:stops[at]]
            if record not in seen:
                seen.add(record)
                body = record[RECORD_HEAD.size:]
                yield (parse(Schema, body) if record[0] == Opcode.SCHEMA
                       else parse(Channel, body))

    def log_times(self) -> dict[int, Indices]:
        """Return when the messages of each channel were recorded [ns]."""
        heads = self._messages.heads
        channels, times = heads['channel'].copy(), heads['log_time'].astype(np.int64)
        return {int(channel): times[channels == channel] for channel in np.unique(channels)}

    def messages(self, chosen: Sequence[int]) -> Messages:
        """Return the messages of some channels, in the order of the file."""
        starts, heads = self._messages
        mine = np.zeros(len(starts), bool)
        for channel in chosen:
            mine |= heads['channel'] == channel
        if not mine.all():
            starts = starts[mine]
            heads = structures(self._buffer, starts, MESSAGE_HEAD)
        sizes = heads['length'].astype(np.int64) + (RECORD_HEAD.size - MESSAGE_HEAD.itemsize)
        batch = Batch(self._buffer, starts + MESSAGE_HEAD.itemsize, sizes)
        return Messages(heads['log_time'].astype(np.int64), batch)

    @cached_property
    def _messages(self) -> _Heads:
        """Return where complete message records start, and what precedes the messages."""
        sizes = np.diff(self._starts, append=self._end)
        sound = (self._opcodes == Opcode.MESSAGE) & (sizes >= MESSAGE_HEAD.itemsize)
        starts = self._starts if sound.all() else self._starts[sound]
        return _Heads(starts, structures(self._buffer, starts, MESSAGE_HEAD))


def parse(kind: type[Record], body: bytes) -> Record:
    """Return a record of the `mcap` library; raise BagError if the bytes are not one."""
    try:
        return kind.read(ReadDataStream(BytesIO(body)))
    except (McapError, struct.error, UnicodeDecodeError):
        raise BagError(f'a {kind.__name__.lower()} record is broken') from None
