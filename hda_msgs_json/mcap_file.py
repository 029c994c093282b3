"""Where the chunks of an MCAP file lie: read from its data section alone, whole or cut off."""

from dataclasses import dataclass, field
from pathlib import Path
import struct
from typing import BinaryIO

from hda_msgs_json.mcap_chunk import decompress, LARGEST, salvage
from hda_msgs_json.mcap_records import (
    BagError, INDEX_ENTRY, Indices, MAGIC, parse, RECORD_HEAD, record_starts, Records)
from mcap.opcode import Opcode
from mcap.records import Metadata
import numpy as np

METADATA_NAME = 'hda'
WINDOW = 1 << 20
LOOSE = (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE)
SUMMARY = (Opcode.DATA_END, Opcode.FOOTER)
CHUNK_HEAD = struct.Struct('<QQQII')
INDEX_HEAD = struct.Struct('<HI')
SQLITE = b'SQLite format 3'


@dataclass(frozen=True)
class Times:
    """Summarise the messages of a channel: how many, the first and the last log time [ns]."""

    count: int
    first: int
    last: int


@dataclass(frozen=True)
class Stretch:
    """
    Name a part of a file that holds messages: a chunk, or records outside of any chunk.

    `times` says what each channel has in it, or is None where that has to be read from the
    messages. A chunk that the end of the file cuts off has `cut` set.
    """

    offset: int
    stored: int
    size: int
    compression: str = ''
    crc: int = 0
    times: dict[int, Times] | None = None
    cut: bool = False


@dataclass
class Contents:
    """Collect what a pass over the top level of a file finds."""

    stretches: list[Stretch] = field(default_factory=list)
    metadata: dict[str, str] = field(default_factory=dict)
    warnings: list[str] = field(default_factory=list)


def read_stretch(path: Path, stretch: Stretch) -> Records:
    """Return the records of a part of a file; raise BagError if it is damaged."""
    with path.open('rb') as stream:
        stream.seek(stretch.offset)
        stored = stream.read(stretch.stored)
    if stretch.cut:
        return Records(salvage(stored, stretch.compression, stretch.size))
    return Records(decompress(stored, stretch.compression, stretch.size, stretch.crc))


def scan(path: Path) -> Contents:
    """
    Return where the messages of a file are; raise BagError if it is no MCAP file.

    The summary at the end of the file is not needed and not read, so that a file which was cut
    off is read in the same way as a whole one.
    """
    try:
        with path.open('rb') as stream:
            return _Scanner(path, stream).scan()
    except OSError as error:
        raise BagError(f'{path} cannot be read: {error.strerror}') from None


class _Scanner:
    """Walk over the top level of one file."""

    def __init__(self, path: Path, stream: BinaryIO) -> None:
        self._path = path
        self._stream = stream
        self._size = stream.seek(0, 2)
        self._found = Contents()

    def scan(self) -> Contents:
        self._check_magic()
        at = len(MAGIC)
        while (head := self._head(at)) is not None:
            opcode, length = head
            if opcode in SUMMARY:
                self._check_end()
                return self._found
            at = self._loose(at) if opcode in LOOSE else self._other(at, opcode, length)
        return self._found

    def _check_magic(self) -> None:
        start = self._read(0, len(SQLITE))
        if start == SQLITE:
            raise BagError(
                f'{self._path} is an SQLite bag; `ros2 bag convert` makes an MCAP bag of it')
        if not start:
            raise BagError(f'{self._path} is empty')
        if start[:len(MAGIC)] != MAGIC:
            raise BagError(f'{self._path} is not an MCAP file: it starts with {start[:8]!r}')

    def _check_end(self) -> None:
        if self._read(self._size - len(MAGIC), len(MAGIC)) != MAGIC:
            self._warn('its summary is cut off; no message is missing')

    def _head(self, at: int) -> tuple[int, int] | None:
        """Return opcode and length of a record, or None where the file ends before its end."""
        head = self._read(at, RECORD_HEAD.size)
        if len(head) < RECORD_HEAD.size:
            self._warn(f'it was cut off at byte {self._size}')
            return None
        opcode, length = RECORD_HEAD.unpack(head)
        if at + RECORD_HEAD.size + length <= self._size or opcode in SUMMARY:
            return opcode, length
        if opcode == Opcode.CHUNK:
            self._chunk(at, self._size - at - RECORD_HEAD.size, cut=True)
        self._warn(f'it was cut off or is damaged: the record at byte {at} claims {length} bytes '
                   f'and {self._size - at - RECORD_HEAD.size} follow')
        return None

    def _other(self, at: int, opcode: int, length: int) -> int:
        """Take note of a record that is not a message, and return where the next one starts."""
        if opcode == Opcode.CHUNK:
            self._chunk(at, length, cut=False)
        elif opcode == Opcode.MESSAGE_INDEX:
            self._index(at + RECORD_HEAD.size, length)
        elif opcode == Opcode.METADATA and length <= WINDOW:
            record = parse(Metadata, self._read(at + RECORD_HEAD.size, length))
            if record.name == METADATA_NAME:
                self._found.metadata.update(record.metadata)
        return at + RECORD_HEAD.size + length

    def _chunk(self, at: int, length: int, *, cut: bool) -> None:
        """Take note of a chunk; the length is what the file has of it."""
        start = at + RECORD_HEAD.size
        head = self._read(start, min(length, CHUNK_HEAD.size))
        if len(head) < CHUNK_HEAD.size:
            return
        _, _, size, crc, name_size = CHUNK_HEAD.unpack(head)
        name = self._read(start + CHUNK_HEAD.size, min(name_size, 16))
        offset = start + CHUNK_HEAD.size + name_size + 8
        stored = int.from_bytes(self._read(offset - 8, 8), 'little')
        left = start + length - offset
        if name_size > 16 or left < 0 or (stored > left and not cut):
            self._warn(f'the chunk at byte {at} is damaged and left out')
            return
        self._found.stretches.append(Stretch(
            offset, min(stored, left), size, name.decode('ascii', 'replace'), crc, cut=cut,
            times=None if cut else {}))

    def _index(self, start: int, length: int) -> None:
        """Add what a message index says about a channel to the chunk before it."""
        body = self._read(start, min(length, LARGEST))
        if not self._found.stretches or len(body) < INDEX_HEAD.size:
            return
        times = self._found.stretches[-1].times
        channel, size = INDEX_HEAD.unpack_from(body)
        entries = (len(body) - INDEX_HEAD.size) // INDEX_ENTRY.itemsize
        log_times = np.frombuffer(body, INDEX_ENTRY, entries, INDEX_HEAD.size)['log_time']
        if times is not None and size == entries * INDEX_ENTRY.itemsize:
            times[channel] = summarise(log_times.astype(np.int64))

    def _loose(self, at: int) -> int:
        """Take note of records outside of any chunk, and return where they end."""
        length = RECORD_HEAD.unpack(self._read(at, RECORD_HEAD.size))[1]
        content = self._read(at, max(WINDOW, RECORD_HEAD.size + length))
        starts, end = record_starts(content)
        opcodes = np.frombuffer(content, np.uint8)[starts]
        foreign = np.flatnonzero(~np.isin(opcodes, LOOSE))
        stop = int(starts[foreign[0]]) if len(foreign) else end
        self._found.stretches.append(Stretch(at, stop, stop))
        return at + stop

    def _read(self, at: int, size: int) -> bytes:
        self._stream.seek(at)
        return self._stream.read(size)

    def _warn(self, what: str) -> None:
        self._found.warnings.append(f'{self._path.name}: {what}')


def summarise(log_times: Indices) -> Times:
    """Return how many messages were recorded, the first and the last time."""
    if not len(log_times):
        return Times(0, 0, 0)
    return Times(len(log_times), int(log_times.min()), int(log_times.max()))
