"""
The messages of a topic to arrays: parts decoded in any order, each into its place.

The arrays are made once, as long as the indexes say. What is not as they say, or of another layout
than the first message, is decoded on its own and joined.
"""

from collections.abc import Callable
from dataclasses import dataclass
from threading import Lock
from typing import cast, Generic, TypeVar

from hda_msgs_json.cdr_arrays import (ArrayLayout, decode_joint_batch, decode_wrench_batch, fill,
                                      joint_form, wrench_form)
from hda_msgs_json.cdr_batch import Batch
from hda_msgs_json.cdr_fields import CdrError
from hda_msgs_json.mcap_records import Messages
from hda_msgs_json.samples import (
    join_joint_samples, join_wrench_samples, JointSamples, WrenchSamples)
from hda_msgs_json.strided import Indices
from hda_msgs_json.topics import JOINT_STATE, WRENCH_STAMPED

Samples = TypeVar('Samples', JointSamples, WrenchSamples)

ROOMIEST = 64
"""Arrays that take more bytes than this for each byte on the disk are not made ahead."""


@dataclass(frozen=True)
class Kind(Generic[Samples]):
    """Say how messages of a type become samples."""

    message_type: str
    decode: Callable[[Batch, int], Samples]
    join: Callable[[list[Samples]], Samples]
    learn: Callable[[bytes], ArrayLayout[Samples]]


JOINT_MESSAGES = Kind(JOINT_STATE, decode_joint_batch, join_joint_samples, joint_form)
WRENCH_MESSAGES = Kind(WRENCH_STAMPED, decode_wrench_batch, join_wrench_samples, wrench_form)


class Gathering(Generic[Samples]):
    """Gather the messages of a topic; several threads may hand over parts at once."""

    def __init__(self, kind: Kind[Samples], count: int, stored: int) -> None:
        """Expect so many messages in so many bytes of the disk."""
        self._kind: Kind[Samples] = kind
        self._count = count
        self._most = ROOMIEST * stored
        self._lock = Lock()
        self._form: ArrayLayout[Samples] | None = None
        self._room: Samples | None = None
        self._found: list[Samples | slice] = []
        self._total = 0

    def decode(self, messages: Messages, rows: slice) -> tuple[Indices, Samples | Batch | slice]:
        """
        Return the log times of a part, and its samples, or the rows that they have been put to.

        Where a message is broken, the bytes come back.
        """
        batch = messages.batch
        room = self._prepared(batch)
        if room is not None and self._form and fill(self._form.layout, batch, room.rows(rows)):
            return messages.log_times, rows
        try:
            return messages.log_times, self._kind.decode(batch, 0)
        except CdrError:
            return messages.log_times, batch

    def add(self, found: Samples | Batch | slice, count: int) -> None:
        """Take the next part in order; raise CdrError for a broken message of its bytes."""
        self._found.append(self._kind.decode(found, self._total) if isinstance(found, Batch)
                           else found)
        self._total += count

    def joined(self) -> Samples:
        """Return all messages in order; raise SamplesError if they do not fit together."""
        room, end = self._room, 0
        for found in self._found:
            if room is None or not isinstance(found, slice) or found.start != end:
                return self._kind.join([
                    cast(Samples, room).rows(part) if isinstance(part, slice) else part
                    for part in self._found])
            end = found.stop
        return self._kind.join([]) if room is None else room.rows(slice(0, end))

    def _prepared(self, batch: Batch) -> Samples | None:
        """Return the arrays for all messages, made when the first one comes, or None."""
        with self._lock:
            if self._form is None and self._count:
                self._make_room(batch.message(0))
            return self._room

    def _make_room(self, message: bytes) -> None:
        """Learn the layout; arrays that could not be meant stay unmade."""
        try:
            self._form = self._kind.learn(message)
        except CdrError:
            self._count = 0
            return
        if self._count * self._form.row_size <= self._most:
            self._room = self._form.room(self._count)
