"""Many messages in one buffer, taken apart by layout: a block for all that are laid out alike."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Generic, NamedTuple, TypeVar

from hda_msgs_json.cdr_fields import CdrError, NANOSECONDS
from hda_msgs_json.cdr_layout import JointState, Layout, Wrench
from hda_msgs_json.samples import Floats, Stamps
from hda_msgs_json.strided import Bytes, Indices, structures
import numpy as np
from numpy.typing import NDArray

MOST_LAYOUTS = 16
"""More layouts than this in one batch are read field by field."""

Message = TypeVar('Message', JointState, Wrench)


class Batch(NamedTuple):
    """Hold messages that lie anywhere in one buffer of bytes: where they start, their sizes."""

    buffer: Bytes
    starts: Indices
    sizes: Indices

    def message(self, index: int) -> bytes:
        """Return the bytes of one message."""
        start = int(self.starts[index])
        return self.buffer[start:start + int(self.sizes[index])].tobytes()

    def records(self, chosen: Indices, layout: Layout) -> NDArray[np.void]:
        """Return messages of the size of a layout as its fields."""
        return structures(self.buffer, self.starts[chosen], layout.record)


@dataclass(frozen=True)
class MessageBlock(Generic[Message]):
    """Hold messages of one layout: where they stood, the first of them, stamps and numbers."""

    chosen: Indices
    first: Message
    stamps: Stamps
    numbers: tuple[Floats, ...]


def batch_of(messages: Sequence[bytes | memoryview]) -> Batch:
    """Return the messages one after another in one buffer."""
    sizes = np.fromiter((len(message) for message in messages), np.int64, len(messages))
    buffer = np.frombuffer(b''.join(messages), np.uint8)
    return Batch(buffer, np.cumsum(sizes) - sizes, sizes)


def by_layout(
        batch: Batch, number: int, read: Callable[[bytes], tuple[Message, Layout]],
        check: Callable[[Message], None]) -> Iterator[MessageBlock[Message]]:
    """Yield the messages layout by layout, and what is left after `MOST_LAYOUTS` one by one."""
    left = np.arange(len(batch.starts))
    layouts = 0
    while len(left):
        try:
            first, layout = read(batch.message(left[0]))
            check(first)
        except CdrError as error:
            raise CdrError(f'message {number + left[0]}: {error}') from None
        if layout.little_endian and layouts < MOST_LAYOUTS:
            layouts += 1
            block, left = _same_layout(batch, left, first, layout)
        else:
            block, left = _single(first, left[:1]), left[1:]
        yield block


def _same_layout(
        batch: Batch, left: Indices, first: Message, layout: Layout,
) -> tuple[MessageBlock[Message], Indices]:
    """Return the messages of one layout as a block, and which ones are left."""
    same = batch.sizes[left] == layout.size
    records = batch.records(left[same], layout)
    fits = layout.fit(records)
    if not fits.all():
        records = records[fits]
        same[same] = fits
    numbers = tuple(records[f'numbers{index}'] for index in range(len(layout.doubles)))
    return MessageBlock(left[same], first, stamps_of(records), numbers), left[~same]


def _single(first: Message, chosen: Indices) -> MessageBlock[Message]:
    """Return one message as a block."""
    numbers = tuple(values[np.newaxis] for values in first.numbers)
    return MessageBlock(chosen, first, np.array([first.stamp_ns]), numbers)


def stamps_of(records: NDArray[np.void]) -> Stamps:
    """Return the stamps [ns] of the messages in their fields."""
    return np.asarray(
        records['seconds'].astype(np.int64) * NANOSECONDS + records['nanoseconds'], np.int64)
