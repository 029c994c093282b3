"""Where the chunks of an MCAP file lie: read from its data section alone, whole or cut off."""

from dataclasses import dataclass, field
from pathlib import Path
import struct
from typing import BinaryIO, NamedTuple

from hda_msgs_json.mcap_chunk import decompress, LARGEST, salvage
from hda_msgs_json.mcap_records import BagError, INDEX_ENTRY, MAGIC, parse
from hda_msgs_json.mcap_walk import RECORD_HEAD, record_starts
from hda_msgs_json.strided import Indices
from mcap.opcode import Opcode
from mcap.records import Metadata
import numpy as np

METADATA_NAME = 'hda'
WINDOW = 1 << 20
LOOSE = (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE)
SUMMARY = (Opcode.DATA_END, Opcode.FOOTER)
CHUNK_HEAD = struct.Struct('<QQQII')
INDEX_HEAD = struct.Struct('<HI')
LONGEST_NAME = 16
NO_HINTS = np.empty(0, np.int64)


@dataclass(frozen=True)
class Times:
    """Summarise messages: how many, the first and the last log time [ns]."""

    count: int
    first: int
    last: int


@dataclass(frozen=True)
class Index:
    """Name the index of a channel in a chunk: where its entries are, and what they say."""

    offset: int
    times: Times


@dataclass(frozen=True)
class FileStretch:
    """
    Name a part of a file that holds messages: a chunk, or records outside of any chunk.

    The indexes, by channel, are those that follow a chunk. A chunk that the end of the file cuts
    off has `cut` set.
    """

    offset: int
    stored: int
    size: int
    compression: str = ''
    crc: int = 0
    cut: bool = False
    indexes: dict[int, Index] = field(default_factory=dict)


@dataclass
class Contents:
    """Collect what a pass over the top level of a file finds."""

    stretches: list[FileStretch] = field(default_factory=list)
    metadata: dict[str, str] = field(default_factory=dict)
    warnings: list[str] = field(default_factory=list)


def scan(path: Path) -> Contents:
    """
    Return where the messages of a file are; raise BagError if it is no MCAP file.

    The summary at the end of the file is not needed and not read. So a file that was cut off
    is read in the same way as a whole one.
    """
    try:
        with path.open('rb') as stream:
            return _Scanner(path, stream).scan()
    except OSError as error:
        raise BagError(f'{path} cannot be read: {error.strerror}') from None


class Content(NamedTuple):
    """Hold the records of a part of a file as bytes, and where the indexes say that some start."""

    records: bytes
    hints: Indices


def read_stretch(path: Path, stretch: FileStretch) -> Content:
    """Return the content of a part of a file; raise BagError if it is damaged."""
    try:
        with path.open('rb') as stream:
            stream.seek(stretch.offset)
            stored = stream.read(stretch.stored)
            indexed = [_offsets(stream, index) for index in stretch.indexes.values()]
    except OSError as error:
        raise BagError(f'{path} cannot be read: {error.strerror}') from None
    if stretch.cut:
        return Content(salvage(stored, stretch.compression, stretch.size), NO_HINTS)
    content = decompress(stored, stretch.compression, stretch.size, stretch.crc)
    hints = np.concatenate([NO_HINTS, *indexed])
    hints.sort(kind='stable')
    return Content(content, hints)


def summarise(log_times: Indices) -> Times:
    """Return how many messages were recorded, the first and the last time."""
    if not len(log_times):
        return Times(0, 0, 0)
    return Times(len(log_times), int(log_times.min()), int(log_times.max()))


def _offsets(stream: BinaryIO, index: Index) -> Indices:
    """Return where an index says that messages start."""
    stream.seek(index.offset)
    found = stream.read(index.times.count * INDEX_ENTRY.itemsize)
    entries = np.frombuffer(found, INDEX_ENTRY, len(found) // INDEX_ENTRY.itemsize)
    return entries['offset'].astype(np.int64)


class _Scanner:
    """Walk over the top level of one file."""

    def __init__(self, path: Path, stream: BinaryIO) -> None:
        self._path = path
        self._stream = stream
        self._size = stream.seek(0, 2)
        self._found = Contents()

    def scan(self) -> Contents:
        """Return what the file holds."""
        self._check_magic()
        at = len(MAGIC)
        while (head := self._head(at)) is not None:
            opcode, length = head
            if opcode in SUMMARY:
                self._check_end()
                return self._found
            if opcode in LOOSE:
                at = self._loose(at, length)
            else:
                self._take(opcode, at, length)
                at += RECORD_HEAD.size + length
        if self._found.stretches:
            # Some of its indexes may be beyond the end.
            self._found.stretches[-1].indexes.clear()
        return self._found

    def _check_magic(self) -> None:
        start = self._read(0, len(MAGIC))
        if not start:
            raise BagError(f'{self._path} is empty')
        if start != MAGIC:
            raise BagError(f'{self._path} is not an MCAP file: it starts with {start!r}')

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
        left = max(self._size - at - RECORD_HEAD.size, 0)       # it may have grown meanwhile
        if length <= left or opcode in SUMMARY:
            return opcode, length
        self._warn(f'it was cut off or is damaged: the record at byte {at} should have {length} '
                   f'bytes, {left} are left')
        if opcode == Opcode.CHUNK:
            self._chunk(at + RECORD_HEAD.size, left, cut=True)
        return None

    def _take(self, opcode: int, at: int, length: int) -> None:
        """Take note of a whole record that is not a message."""
        start = at + RECORD_HEAD.size
        if opcode == Opcode.CHUNK:
            self._chunk(start, length, cut=False)
        elif opcode == Opcode.MESSAGE_INDEX:
            self._index(start, length)
        elif opcode == Opcode.METADATA and length <= WINDOW:
            self._metadata(self._read(start, length))

    def _chunk(self, start: int, length: int, *, cut: bool) -> None:
        """Take note of a chunk, of which the file has so many bytes."""
        head = self._read(start, min(length, CHUNK_HEAD.size))
        if len(head) < CHUNK_HEAD.size:
            return
        _, _, size, crc, name_size = CHUNK_HEAD.unpack(head)
        name = self._read(start + CHUNK_HEAD.size, min(name_size, LONGEST_NAME))
        offset = start + CHUNK_HEAD.size + name_size + 8
        left = start + length - offset
        stored = int.from_bytes(self._read(offset - 8, 8), 'little') if left >= 0 else 0
        if left < 0 or (stored > left and not cut):
            self._warn(f'the chunk at byte {start - RECORD_HEAD.size} is damaged and left out')
            return
        self._found.stretches.append(FileStretch(
            offset, min(stored, left), size, name.decode('ascii', 'replace'), crc, cut))

    def _index(self, start: int, length: int) -> None:
        """Add the index of a channel to the chunk before it."""
        body = self._read(start, min(length, LARGEST))
        if not self._found.stretches or len(body) < INDEX_HEAD.size:
            return
        channel, size = INDEX_HEAD.unpack_from(body)
        count = (len(body) - INDEX_HEAD.size) // INDEX_ENTRY.itemsize
        if size == count * INDEX_ENTRY.itemsize and count:
            entries = np.frombuffer(body, INDEX_ENTRY, count, INDEX_HEAD.size)
            self._found.stretches[-1].indexes[channel] = Index(
                start + INDEX_HEAD.size, summarise(entries['log_time'].astype(np.int64)))

    def _metadata(self, body: bytes) -> None:
        try:
            record = parse(Metadata, body)
        except BagError as error:
            self._warn(f'{error} and left out')
            return
        if record.name == METADATA_NAME:
            self._found.metadata.update(record.metadata)

    def _loose(self, at: int, length: int) -> int:
        """Take note of records outside of any chunk, and return where they end."""
        content = self._read(at, max(WINDOW, RECORD_HEAD.size + length))
        starts, end = record_starts(content)
        opcodes = np.frombuffer(content, np.uint8)[starts]
        foreign = np.flatnonzero(~np.isin(opcodes, LOOSE))
        stop = int(starts[foreign[0]]) if len(foreign) else end
        self._found.stretches.append(FileStretch(at, stop, stop))
        return at + stop

    def _read(self, at: int, size: int) -> bytes:
        self._stream.seek(at)
        return self._stream.read(size)

    def _warn(self, what: str) -> None:
        self._found.warnings.append(f'{self._path.name}: {what}')
