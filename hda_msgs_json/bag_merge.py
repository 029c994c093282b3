"""Whole recordings of several topics to chunks of message records in log time order."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from hda_msgs_json.cdr import encode_number, encode_string
from hda_msgs_json.cdr_arrays import encode_joint_rows, encode_wrench_rows
from hda_msgs_json.mcap_pack import ChannelCount
from hda_msgs_json.mcap_records import BagError, INDEX_ENTRY, MESSAGE_HEAD
from hda_msgs_json.mcap_walk import RECORD_HEAD
from hda_msgs_json.mcap_writer import CHUNK_SIZE
from hda_msgs_json.samples import JointSamples, NumberSamples, Stamps, TextSamples, WrenchSamples
from hda_msgs_json.strided import Bytes, Indices, place
from mcap.opcode import Opcode
import numpy as np
from numpy.typing import NDArray

HEAD = MESSAGE_HEAD.itemsize


@dataclass(frozen=True, eq=False)
class PendingMessages:
    """
    Hold the messages of a channel that wait to be written: log times [ns] and sizes [bytes] (n,).

    `encode` returns some of the messages as bytes: (k, HEAD + size) with room for their heads
    where all have one size, else one after another.
    """

    channel: int
    log_times: Indices
    sizes: Indices
    encode: Callable[[slice], Bytes]


def joint_column(channel: int, samples: JointSamples) -> PendingMessages:
    """Return JointStates that wait to be written."""
    size = encode_joint_rows(samples.rows(slice(0, 0))).shape[1]
    return PendingMessages(
        channel, _log_times(samples.stamps), np.full(len(samples), size),
        lambda rows: encode_joint_rows(samples.rows(rows), HEAD))


def wrench_column(channel: int, samples: WrenchSamples) -> PendingMessages:
    """Return WrenchStampeds that wait to be written."""
    size = encode_wrench_rows(samples.rows(slice(0, 0))).shape[1]
    return PendingMessages(
        channel, _log_times(samples.stamps), np.full(len(samples), size),
        lambda rows: encode_wrench_rows(samples.rows(rows), HEAD))


def text_column(channel: int, samples: TextSamples) -> PendingMessages:
    """Return Strings that wait to be written."""
    messages = [encode_string(text) for text in samples.texts]
    return PendingMessages(
        channel, _log_times(samples.stamps), np.array([len(m) for m in messages], np.int64),
        lambda rows: np.frombuffer(b''.join(messages[rows]), np.uint8))


def number_column(channel: int, samples: NumberSamples) -> PendingMessages:
    """Return Float64s that wait to be written."""
    head = encode_number(0.0)[:-samples.values.itemsize]

    def encode(rows: slice) -> Bytes:
        values = np.ascontiguousarray(samples.values[rows], '<f8').view(np.uint8)
        begin = np.frombuffer(bytes(HEAD) + head, np.uint8)
        body = values.reshape(-1, samples.values.itemsize)
        return np.hstack([np.tile(begin, (len(body), 1)), body])

    return PendingMessages(channel, _log_times(samples.stamps),
                           np.full(len(samples), len(encode_number(0.0))), encode)


class Chunk:
    """Fill a chunk with message records, some messages of a column at a time."""

    def __init__(self, size: int) -> None:
        """Make room for so many bytes."""
        self.content = np.empty(size, np.uint8)
        self.indexes: dict[int, NDArray[np.void]] = {}

    def add(self, column: PendingMessages, rows: slice, starts: Indices, number: int) -> None:
        """Place messages of a column at these offsets, and number them from a number on."""
        messages = column.encode(rows)
        sizes, times = column.sizes[rows], column.log_times[rows]
        heads = np.zeros(len(starts), MESSAGE_HEAD)
        heads['opcode'], heads['channel'] = Opcode.MESSAGE, column.channel
        heads['length'] = sizes + HEAD - RECORD_HEAD.size
        heads['sequence'] = number + np.arange(len(starts))
        heads['log_time'] = heads['publish_time'] = times
        if messages.ndim == 2:
            messages[:, :HEAD] = heads.view(np.uint8).reshape(-1, HEAD)
            place(self.content, starts, messages)
        else:
            place(self.content, starts, heads.view(np.uint8).reshape(-1, HEAD))
            for start, size, end in zip(starts + HEAD, sizes, np.cumsum(sizes)):
                self.content[start:start + size] = messages[end - size:end]
        self._index(column.channel, times, starts)

    def _index(self, channel: int, times: Indices, starts: Indices) -> None:
        entries = np.empty(len(starts), INDEX_ENTRY)
        entries['log_time'], entries['offset'] = times, starts
        if channel in self.indexes:
            entries = np.concatenate([self.indexes[channel], entries])
        self.indexes[channel] = entries


def merged(columns: Sequence[PendingMessages],
           counts: Mapping[int, ChannelCount]) -> Iterator[Chunk]:
    """
    Yield chunks of message records in log time order, with their indexes by channel.

    Messages of equal log time come in the order of the columns. The counts, which the caller
    keeps up to date, number the messages of each channel.
    """
    times, sizes, owners = _in_order(columns)
    ends = np.cumsum(sizes)
    done = [0] * len(columns)
    numbers = {channel: counted.count for channel, counted in counts.items()}
    first = filled = 0
    while first < len(times):
        last = max(int(np.searchsorted(ends, filled + CHUNK_SIZE, 'right')), first + 1)
        chunk = Chunk(int(ends[last - 1]) - filled)
        starts = ends[first:last] - sizes[first:last] - filled
        for owner in np.flatnonzero(np.bincount(owners[first:last])).tolist():
            column, at = columns[owner], starts[owners[first:last] == owner]
            rows = slice(done[owner], done[owner] + len(at))
            chunk.add(column, rows, at, numbers[column.channel])
            numbers[column.channel] += len(at)
            done[owner] = rows.stop
        yield chunk
        first, filled = last, int(ends[last - 1])


def _in_order(columns: Sequence[PendingMessages]) -> tuple[Indices, Indices, Indices]:
    """Return log times, record sizes and owning columns of all messages in log time order."""
    nothing = np.empty(0, np.int64)
    times = np.concatenate([nothing, *(column.log_times for column in columns)])
    sizes = np.concatenate([nothing, *(column.sizes + HEAD for column in columns)])
    owners = np.repeat(np.arange(len(columns)), [len(column.sizes) for column in columns])
    order = np.argsort(times, kind='stable')
    return times[order], sizes[order], owners[order]


def _log_times(stamps: Stamps) -> Indices:
    """Return stamps as log times, which never go back so that the messages keep their order."""
    if len(stamps) and stamps.min() < 0:
        raise BagError(f'log times must not be negative, got {stamps.min()} ns')
    return np.maximum.accumulate(stamps)
