"""An MCAP file that grows: whole chunks with their indexes, and a summary at the end."""

from array import array
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from io import FileIO
import os
from pathlib import Path
import struct
import zlib

from hda_msgs_json.disk_flush import DiskPush
from hda_msgs_json.mcap_pack import ChannelCount, laid_out, pack, Packed
from hda_msgs_json.mcap_records import INDEX_ENTRY, MAGIC
from hda_msgs_json.mcap_spool import Spool
from hda_msgs_json.mcap_walk import RECORD_HEAD
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Channel, DataEnd, Footer, Header, McapRecord, Metadata, MetadataIndex, Schema, Statistics)
import numpy as np

PROFILE = 'ros2'
LIBRARY = 'hda_msgs_json'
CHUNK_SIZE = 1 << 20
"""Bytes after which a chunk is closed, before compression."""

MESSAGE = struct.Struct('<BQHIQQ')


@dataclass
class _Summary:
    """Collect what the end of the file repeats; the indexes of chunks, as bytes, grow for ever."""

    chunks: Spool
    schemas: list[Schema] = field(default_factory=list)
    channels: list[Channel] = field(default_factory=list)
    metadata: list[MetadataIndex] = field(default_factory=list)


class McapWriter:
    """
    Write one MCAP file to a stream without a buffer, chunk by chunk.

    The file always ends with a complete record: what the disk does not take whole is taken back
    before OSError is raised. `counts` are the messages in the file, by channel.
    """

    def __init__(self, stream: FileIO, compression: str) -> None:
        """Write the head of the file; the compression is '', 'lz4' or 'zstd'."""
        self.counts: dict[int, ChannelCount] = {}
        self._stream, self._disk = stream, DiskPush(stream)
        self.compression = compression
        self._at = 0
        self._summary = _Summary(Spool(Path(os.fsdecode(stream.name)).parent))
        self.first: int | None = None           # log time that was written first [ns]
        self._chunk = bytearray()
        self._indexes: dict[int, array[int]] = {}
        self._write([MAGIC, _encoded(Header(PROFILE, LIBRARY))])

    @property
    def size(self) -> int:
        """Return the size of the file and of the chunk that is being filled [bytes]."""
        return self._at + len(self._chunk)

    def add_channel(
            self, topic: str, schema: tuple[str, str, bytes], encoding: str,
            metadata: Mapping[str, str]) -> int:
        """Add a channel of a schema (name, encoding, content), and return its number."""
        name, schema_encoding, content = schema
        known = {found.name: found.id for found in self._summary.schemas}
        if name not in known:
            known[name] = len(known) + 1
            record = Schema(
                id=known[name], name=name, encoding=schema_encoding, data=content)
            self._write([_encoded(record)])
            self._summary.schemas.append(record)
        channel = Channel(
            id=len(self._summary.channels) + 1, topic=topic, message_encoding=encoding,
            schema_id=known[name], metadata=dict(metadata))
        self._write([_encoded(channel)])
        self._summary.channels.append(channel)
        self.counts[channel.id] = ChannelCount()
        return channel.id

    def add_metadata(self, name: str, content: Mapping[str, str]) -> None:
        """Write a metadata record."""
        record, start = _encoded(Metadata(name=name, metadata=dict(content))), self._at
        self._write([record])
        self._summary.metadata.append(MetadataIndex(offset=start, length=len(record), name=name))

    def write(self, channel: int, log_time: int, message: bytes) -> None:
        """Add a message to the chunk, and close the chunk if it is full."""
        entries = self._indexes.setdefault(channel, array('Q'))
        entries.append(log_time)
        entries.append(len(self._chunk))
        self._chunk += MESSAGE.pack(
            Opcode.MESSAGE, MESSAGE.size - RECORD_HEAD.size + len(message), channel,
            (self.counts[channel].count + len(entries) // 2 - 1) & 0xFFFFFFFF, log_time, log_time)
        self._chunk += message
        if self.first is None:
            self.first = log_time
        if len(self._chunk) >= CHUNK_SIZE:
            self.close_chunk()

    def write_packed(self, chunk: Packed) -> None:
        """Write a chunk that is packed already."""
        self.close_chunk()
        self._write_chunk(chunk)

    def close_chunk(self) -> None:
        """Write the chunk that is being filled, if there is anything in it."""
        if self._chunk:
            indexes = {channel: np.frombuffer(entries.tobytes(), INDEX_ENTRY)
                       for channel, entries in self._indexes.items()}
            self._write_chunk(pack(bytes(self._chunk), indexes, self.compression))
            self.drop_chunk()

    def drop_chunk(self) -> None:
        """Forget the messages that are not in the file yet."""
        self._chunk.clear()
        self._indexes.clear()

    def flush(self) -> None:
        """Write what has come so far, and have the disk take it in its own time."""
        self.close_chunk()
        self._disk.begin()

    def finish(self) -> None:
        """Write the summary and the end of the file, and wait until the disk has all."""
        self.close_chunk()
        self._write(self._ending())
        self._disk.complete()

    def close(self) -> None:
        """Close the stream as it is."""
        self._disk.end()
        self._summary.chunks.close()
        self._stream.close()

    def _ending(self) -> Iterator[bytes]:
        """Yield what stands behind the data, piece by piece: hours of indexes are large."""
        end = _encoded(DataEnd(0))
        yield end
        crc = 0
        for piece in self._repeated():
            crc = zlib.crc32(piece, crc)
            yield piece
        footer = _encoded(Footer(
            summary_start=self._at + len(end), summary_offset_start=0, summary_crc=0))[:-4]
        yield footer + struct.pack('<I', zlib.crc32(footer, crc)) + MAGIC

    def _repeated(self) -> Iterator[bytes]:
        """Yield the records of the summary."""
        yield from map(_encoded, (*self._summary.schemas, *self._summary.channels,
                                  self._statistics()))
        yield from self._summary.chunks
        yield from map(_encoded, self._summary.metadata)

    def _write(self, pieces: Iterable[bytes]) -> None:
        """Write all bytes, or none of them and raise OSError."""
        end = self._at
        try:
            for piece in pieces:
                left = memoryview(piece)
                while left:
                    left = left[self._stream.write(left):]
                end += len(piece)
        except OSError:
            self._stream.truncate(self._at)
            self._stream.seek(self._at)
            raise
        self._at = end

    def _write_chunk(self, chunk: Packed) -> None:
        """Write a chunk, its message indexes, count both and remember them for the summary."""
        records, index = laid_out(chunk, self.compression, self._at)
        self._write([records])
        for channel, entries in chunk.indexes.items():
            self.counts[channel].add(len(entries), *chunk.spans[channel])
        self._summary.chunks.add(_encoded(index))

    def _statistics(self) -> Statistics:
        filled = [counted for counted in self.counts.values() if counted.count]
        return Statistics(
            message_count=sum(counted.count for counted in filled),
            schema_count=len(self._summary.schemas), channel_count=len(self._summary.channels),
            attachment_count=0, metadata_count=len(self._summary.metadata),
            chunk_count=self._summary.chunks.count,
            message_start_time=min((counted.first for counted in filled), default=0),
            message_end_time=max((counted.last for counted in filled), default=0),
            channel_message_counts={
                channel: counted.count for channel, counted in self.counts.items()})


def _encoded(record: McapRecord) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    return bytes(builder.end())
