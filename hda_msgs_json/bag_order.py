"""Messages of several topics one after another, in the order of their log times."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from heapq import heappop, heappush, heapreplace
from typing import NamedTuple

from hda_msgs_json.mcap_chunk import expanded
from hda_msgs_json.mcap_records import Records
import numpy as np


class Message(NamedTuple):
    """
    Hold one message: when it was recorded [ns], where it is stored, and its bytes.

    The place is the number of the part of the recording, and the byte there.
    """

    log_time: int
    place: tuple[int, int]
    topic: str
    content: bytes


class Source(NamedTuple):
    """Promise messages in order, none of them before a log time [ns]."""

    first: int
    read: Callable[[], Iterator[Message]]


def in_order(sources: Sequence[Source]) -> Iterator[Message]:
    """
    Yield the messages of all sources by log time, those of equal time as they are stored.

    A source is read when its first time has come, so that few are in memory at once.
    """
    read: list[tuple[Message, Iterator[Message]]] = []
    for source in sorted(sources, key=lambda source: source.first):
        while read and read[0][0].log_time < source.first:
            yield _taken(read)
        messages = source.read()
        if (message := next(messages, None)) is not None:
            heappush(read, (message, messages))
    while read:
        yield _taken(read)


def part_messages(number: int, records: Records, topics: Mapping[int, str],
                  start: int) -> Iterator[Message]:
    """Yield messages of a part of this number, by channel and topic, from a log time [ns] on."""
    found = [records.messages([channel]) for channel in topics]
    batches = [expanded(messages.batch) for messages in found]
    nothing = np.empty(0, np.int64)
    times = np.concatenate([nothing, *(messages.log_times for messages in found)])
    places = np.concatenate([nothing, *(messages.batch.starts for messages in found)])
    owners = np.repeat(np.arange(len(found)), [len(messages.log_times) for messages in found])
    rows = np.concatenate([nothing, *(np.arange(len(batch.sizes)) for batch in batches)])
    names = list(topics.values())
    order = np.lexsort((places, times))
    order = order[times[order] >= start]
    for time, place, owner, row in zip(times[order].tolist(), places[order].tolist(),
                                       owners[order].tolist(), rows[order].tolist()):
        yield Message(time, (number, place), names[owner], batches[owner].message(row))


def _taken(read: list[tuple[Message, Iterator[Message]]]) -> Message:
    """Take the first message of all, and have the next one of its source wait."""
    message, messages = read[0]
    if (following := next(messages, None)) is not None:
        heapreplace(read, (following, messages))
    else:
        heappop(read)
    return message
