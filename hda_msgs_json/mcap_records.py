"""
Records of an MCAP file, as bytes in memory.

The many small message records of a chunk are found and read as arrays. The rare others go through
the `mcap` library.
"""

from collections.abc import Iterator, Sequence
from io import BytesIO
import struct
from typing import NamedTuple, TypeVar

from hda_msgs_json.cdr_arrays import Batch
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Metadata, Schema
import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

MAGIC = b'\x89MCAP0\r\n'
RECORD_HEAD = struct.Struct('<BQ')
MESSAGE_HEAD = np.dtype([
    ('opcode', 'u1'), ('length', '<u8'), ('channel', '<u2'), ('sequence', '<u4'),
    ('log_time', '<u8'), ('publish_time', '<u8')])
INDEX_ENTRY = np.dtype([('log_time', '<u8'), ('offset', '<u8')])

FEWEST_PROBED = 64
LONGEST_CYCLE = 16

Bytes = NDArray[np.uint8]
Indices = NDArray[np.int64]
Record = TypeVar('Record', Channel, Metadata, Schema)


class BagError(ValueError):
    """Raised when a recording cannot be read or written."""


class Messages(NamedTuple):
    """Hold messages of a chunk: when they were recorded [ns] (n,), and where they are."""

    log_times: Indices
    batch: Batch


class Records:
    """Give access to the records of one stretch of an MCAP file."""

    def __init__(self, content: bytes) -> None:
        """Find all complete records; whatever follows the last of them is left out."""
        self._content = content
        self._buffer = np.frombuffer(content, np.uint8)
        self.starts, self.end = record_starts(content)
        self.opcodes = self._buffer[self.starts]
        sizes = np.diff(self.starts, append=self.end)
        sound = (self.opcodes == Opcode.MESSAGE) & (sizes >= MESSAGE_HEAD.itemsize)
        self._message_starts, self._message_sizes = self.starts[sound], sizes[sound]
        self._heads = gather(self._buffer, self._message_starts, MESSAGE_HEAD)

    def definitions(self) -> Iterator[Schema | Channel]:
        """Yield the schemas and channels; raise BagError if one is broken."""
        for at in np.flatnonzero(np.isin(self.opcodes, (Opcode.SCHEMA, Opcode.CHANNEL))):
            start = int(self.starts[at])
            stop = int(self.starts[at + 1]) if at + 1 < len(self.starts) else self.end
            body = self._content[start + RECORD_HEAD.size:stop]
            yield (parse(Schema, body) if self.opcodes[at] == Opcode.SCHEMA
                   else parse(Channel, body))

    def log_times(self) -> dict[int, Indices]:
        """Return when the messages of each channel were recorded [ns]."""
        channels = self._heads['channel']
        times = self._heads['log_time'].astype(np.int64)
        return {int(channel): times[channels == channel] for channel in np.unique(channels)}

    def messages(self, channels: Sequence[int]) -> Messages:
        """Return the messages of some channels."""
        chosen = np.isin(self._heads['channel'], channels)
        starts, sizes = self._message_starts, self._message_sizes
        times = self._heads['log_time']
        if not chosen.all():
            starts, sizes, times = starts[chosen], sizes[chosen], times[chosen]
        head = MESSAGE_HEAD.itemsize
        return Messages(times.astype(np.int64), Batch(self._buffer, starts + head, sizes - head))


def parse(kind: type[Record], body: bytes) -> Record:
    """Return a record of the `mcap` library; raise BagError if the bytes are not one."""
    try:
        return kind.read(ReadDataStream(BytesIO(body)))
    except (McapError, struct.error, UnicodeDecodeError):
        raise BagError(f'a {kind.__name__.lower()} record is broken') from None


def gather(buffer: Bytes, starts: Indices, kind: np.dtype[np.void]) -> NDArray[np.void]:
    """Return the structures (n,) that lie at these offsets, none beyond the end."""
    if not len(starts):
        return np.empty(0, kind)
    return sliding_window_view(buffer, kind.itemsize)[starts].view(kind)[:, 0]


def record_starts(content: bytes) -> tuple[Indices, int]:
    """
    Return where the complete records start, and where the last of them ends.

    Records must be followed one by one, but recordings repeat themselves: where the sizes of the
    records have a short period, the next periods are checked all at once.
    """
    found, at, probed = [], 0, FEWEST_PROBED
    while True:
        starts, at = _follow(content, at, probed)
        found.append(np.array(starts, np.int64))
        if len(starts) < probed:
            return np.concatenate(found), at
        cycle = _cycle(np.diff(found[-1][-2 * LONGEST_CYCLE:], append=at))
        repeated = _repeat(content, at, cycle)
        probed = FEWEST_PROBED if len(repeated) else 2 * probed
        found.append(repeated)
        at += len(repeated) // max(len(cycle), 1) * int(cycle.sum())


def _follow(content: bytes, at: int, most: int) -> tuple[list[int], int]:
    """Return the starts of the next records, and where the last of them ends."""
    starts: list[int] = []
    last = len(content) - RECORD_HEAD.size
    while at <= last and len(starts) < most:
        stop = at + RECORD_HEAD.size + RECORD_HEAD.unpack_from(content, at)[1]
        if stop > len(content):
            break
        starts.append(at)
        at = stop
    return starts, at


def _cycle(sizes: Indices) -> Indices:
    """Return the shortest run of sizes that repeats itself, or nothing."""
    for period in range(1, LONGEST_CYCLE + 1):
        if np.array_equal(sizes[period:], sizes[:-period]):
            return sizes[-period:]
    return sizes[:0]


def _repeat(content: bytes, at: int, cycle: Indices) -> Indices:
    """Return the starts of the records that follow as long as their sizes repeat a cycle."""
    stride = int(cycle.sum())
    count = (len(content) - at) // stride if stride else 0
    if not count:
        return cycle[:0]
    offsets = np.cumsum(cycle) - cycle
    same = np.ones(count, bool)
    for offset, size in zip(offsets.tolist(), cycle.tolist()):
        lengths = np.ndarray(count, '<u8', content, at + offset + 1, (stride,))
        same &= lengths == size - RECORD_HEAD.size
    count = count if same.all() else int(same.argmin())
    return np.asarray((at + stride * np.arange(count)[:, np.newaxis] + offsets).ravel(), np.int64)
