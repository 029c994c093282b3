"""Recordings: rosbag2 directories and loose MCAP files, whole or cut off, as arrays."""

from collections.abc import Callable, Collection, Iterator
from functools import partial
from pathlib import Path
from typing import NamedTuple, TypeVar

from hda_msgs_json.bag_files import BagFiles, find_files
from hda_msgs_json.bag_gather import Gathering, JOINT_MESSAGES, Kind, WRENCH_MESSAGES
from hda_msgs_json.bag_order import in_order, Message, part_messages, Source
from hda_msgs_json.bag_parts import BagPart, content_of, scan_file, ScannedFile, summaries
from hda_msgs_json.cdr import CdrError, decode_number, decode_string
from hda_msgs_json.mcap_chunk import expanded
from hda_msgs_json.mcap_file import Content
from hda_msgs_json.mcap_records import BagError, Messages, Records
from hda_msgs_json.samples import (
    JointSamples, NumberSamples, SamplesError, TextSamples, WrenchSamples)
from hda_msgs_json.strided import Indices
from hda_msgs_json.topics import JOINT_STATES, NUMBER, STRING
from hda_msgs_json.worker_threads import ahead
import numpy as np

Samples = TypeVar('Samples', JointSamples, WrenchSamples)
Result = TypeVar('Result')

MOST_LISTED = 20
"""Topics that an error names."""


class _Slot(NamedTuple):
    """Name channels of a part, and which of all messages of the topic they have."""

    part: BagPart
    channels: list[int]
    rows: slice


def open_recording(path: Path | str) -> 'Recording':
    """
    Return the recording at a path: a rosbag2 directory, or a loose MCAP file.

    A file that was cut off gives every complete message, and a warning. Raise BagError if there is
    no recording.
    """
    return Recording(Path(path), find_files(Path(path)))


class Recording:
    """Read one recording; its messages stay on the disk until they are asked for."""

    def __init__(self, path: Path, files: BagFiles) -> None:
        """Find the messages in the files; `open_recording` does this for a path."""
        self.path = path
        self.warnings = files.warnings
        self.metadata: dict[str, str] = {}
        self._expanded = files.expanded
        self._files = [self._scan(file) for file in files.paths]
        self.topics = summaries(self._files)

    @property
    def duration(self) -> float:
        """Return the time [s] between the first and the last message of all topics."""
        filled = [topic for topic in self.topics.values() if topic.count]
        if not filled:
            return 0.0
        return (max(topic.last for topic in filled) - min(topic.first for topic in filled)) / 1e9

    def joint_states(self, topic: str = JOINT_STATES.name) -> JointSamples:
        """Return the JointStates of a topic in log time order; raise BagError."""
        return self._samples(topic, JOINT_MESSAGES)

    def wrenches(self, topic: str) -> WrenchSamples:
        """Return the WrenchStampeds of a topic in log time order; raise BagError."""
        return self._samples(topic, WRENCH_MESSAGES)

    def texts(self, topic: str) -> TextSamples:
        """Return the Strings of a topic at their log times; raise BagError."""
        name = self._find(topic, STRING)
        times, messages = self.raw(name)
        try:
            return TextSamples(times, tuple(decode_string(message) for message in messages))
        except CdrError as error:
            raise BagError(f'{self.path}, topic {name}: {error}') from None

    def numbers(self, topic: str) -> NumberSamples:
        """Return the Float64s of a topic at their log times; raise BagError."""
        name = self._find(topic, NUMBER)
        times, messages = self.raw(name)
        try:
            return NumberSamples(times, np.array([decode_number(message) for message in messages],
                                                 np.float64))
        except CdrError as error:
            raise BagError(f'{self.path}, topic {name}: {error}') from None

    def raw(self, topic: str, message_type: str | None = None
            ) -> tuple[Indices, list[bytes]]:
        """
        Return the log times [ns] (n,) and the bytes of all messages of a topic, in order.

        Raise BagError where the topic is not there, or of another type than is asked for.
        """
        parts = list(self._each(self._find(topic, message_type), _singly))
        times = np.concatenate([np.empty(0, np.int64), *(times for times, _ in parts)])
        messages = [message for _, part in parts for message in part]
        order = _order(times)
        return (times, messages) if order is None else (
            times[order], [messages[at] for at in order])

    def messages(self, topics: Collection[str], start: int = 0) -> Iterator[Message]:
        """
        Yield the messages of topics from a log time [ns] on, in its order, bit by bit.

        Messages of equal time come as they are stored. Raise BagError at a broken one.
        """
        parts = [(file, part) for file in self._files for part in file.parts]
        sources = []
        for number, (file, part) in enumerate(parts):
            filled = [times for times in part.times.values() if times.count]
            if filled and max(times.last for times in filled) >= start:
                chosen = {channel: carried.topic for channel, carried in file.channels.items()
                          if carried.topic in topics}
                sources.append(Source(
                    min(times.first for times in filled),
                    partial(self._part_messages, number, part, chosen, start)))
        return in_order(sources)

    def qualities(self, topic: str) -> list[str]:
        """Return what rosbag2 keeps of the quality of service of a topic, as YAML texts."""
        found = [channel.quality for file in self._files for channel in file.channels.values()
                 if channel.topic == topic and channel.quality]
        return list(dict.fromkeys(found))

    def _part_messages(self, number: int, part: BagPart, topics: dict[int, str],
                       start: int) -> Iterator[Message]:
        return part_messages(number, Records(*self._read(part)), topics, start)

    def _samples(self, topic: str, kind: Kind[Samples]) -> Samples:
        name = self._find(topic, kind.message_type)
        stored = sum(part.stretch.stored for file in self._files for part in file.parts)
        gathering = Gathering(kind, self.topics[name].count, stored)
        times = [np.empty(0, np.int64)]
        try:
            for log_times, found in self._each(name, gathering.decode):
                gathering.add(found, len(log_times))
                times.append(log_times)
            samples = gathering.joined()
        except (CdrError, SamplesError) as error:
            raise BagError(f'{self.path}, topic {name}: {error}') from None
        order = _order(np.concatenate(times))
        return samples if order is None else samples.rows(order)

    def _find(self, topic: str, message_type: str | None = None) -> str:
        """Return the name that a topic has in this recording, and check its type."""
        alike = [name for name in self.topics if name.strip('/') == topic.strip('/')]
        alike = alike or self._in_namespace(topic.strip('/'))
        if not alike:
            some = ', '.join(list(self.topics)[:MOST_LISTED]) or 'none at all'
            more = ', ...' * (len(self.topics) > MOST_LISTED)
            raise BagError(f'{self.path} has no topic {topic}; it has {some}{more}')
        name = topic if topic in alike else alike[0]
        types = {channel.message_type for file in self._files
                 for channel in file.channels.values() if channel.topic == name}
        if message_type is not None and types != {message_type}:
            raise BagError(f'{self.path}, topic {name}: the type must be {message_type}, got '
                           f'{" and ".join(sorted(types))}')
        return name

    def _in_namespace(self, topic: str) -> list[str]:
        """Return the name of a topic in the namespace that the joint states have, if only one."""
        spaces = [name.removesuffix(JOINT_STATES.name) for name in self.topics
                  if name.endswith(f'/{JOINT_STATES.name}')]
        return [f'{space}{topic}' for space in spaces
                if len(spaces) == 1 and f'{space}{topic}' in self.topics]

    def _each(self, name: str, work: Callable[[Messages, slice], Result]) -> Iterator[Result]:
        """
        Yield what work makes of the messages of a topic, chunk by chunk in their order.

        The slice says which of all messages they are, if the indexes are right.
        """
        for slots in self._slots(name):
            # The indexes could show which parts have none of them, but they may be damaged.
            for found, warning in ahead(partial(_worked, work=work), slots):
                self._warn(warning)
                if found is not None:
                    yield found

    def _slots(self, name: str) -> Iterator[list[_Slot]]:
        """Yield the parts of each file that has a topic, and where they stand."""
        first = 0
        for file in self._files:
            channels = [number for number, channel in file.channels.items()
                        if channel.topic == name]
            slots = []
            for part in file.parts if channels else []:
                last = first + sum(
                    part.times[number].count for number in channels if number in part.times)
                slots.append(_Slot(part, channels, slice(first, last)))
                first = last
            yield slots

    def _read(self, part: BagPart) -> Content:
        """Return the content of a part of a file; if it is damaged, none and a warning."""
        content, warning = content_of(part)
        self._warn(warning)
        return content

    def _warn(self, warning: str) -> None:
        if warning and warning not in self.warnings:
            self.warnings.append(warning)

    def _scan(self, path: Path) -> ScannedFile:
        """Find the messages of one file; keep what it says of itself and what is wrong with it."""
        file = scan_file(path)
        self.warnings.extend(file.warnings)
        self.metadata.update(file.metadata)
        return file


def _worked(
        slot: _Slot, work: Callable[[Messages, slice], Result]) -> tuple[Result | None, str]:
    """Return what work makes of some channels of a part, None without messages, and a warning."""
    content, warning = content_of(slot.part)
    messages = Records(*content).messages(slot.channels)
    if not len(messages.log_times):
        return None, warning
    return work(messages._replace(batch=expanded(messages.batch)), slot.rows), warning


def _singly(messages: Messages, _: slice) -> tuple[Indices, list[bytes]]:
    """Return log times and messages one by one."""
    return messages.log_times, [
        messages.batch.message(index) for index in range(len(messages.log_times))]


def _order(times: Indices) -> Indices | None:
    """Return the order of the log times, equal ones as they came, or None if it is kept."""
    if (np.diff(times) >= 0).all():
        return None
    return np.argsort(times, kind='stable')
