"""Recordings: rosbag2 directories and loose MCAP files, whole or cut off, as arrays."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from hda_msgs_json.cdr import CdrError, decode_string
from hda_msgs_json.cdr_arrays import Batch, decode_joint_batch, decode_wrench_batch
from hda_msgs_json.mcap_file import Contents, read_stretch, scan, Stretch, summarise, Times
from hda_msgs_json.mcap_records import BagError, Indices, Messages, Records
from hda_msgs_json.samples import (
    join_joint_samples, join_wrench_samples, JointSamples, SamplesError, TextSamples,
    WrenchSamples)
from hda_msgs_json.schemas import SchemaError, short_name
from hda_msgs_json.topics import JOINT_STATE, JOINT_STATES, STRING, WRENCH_STAMPED
from mcap.records import Schema
import numpy as np
import yaml

METADATA_FILE = 'metadata.yaml'
LARGEST_METADATA = 16 << 20
ENCODING = 'cdr'

Samples = TypeVar('Samples', JointSamples, WrenchSamples)


@dataclass(frozen=True)
class TopicSummary:
    """Summarise a topic: its type, number of messages, first and last log time [ns]."""

    message_type: str
    count: int
    first: int
    last: int


class _Channel(NamedTuple):
    """Name what a channel of one file carries."""

    topic: str
    message_type: str
    encoding: str


@dataclass(frozen=True)
class _File:
    """Hold what a pass over the top level of one file of a recording found."""

    path: Path
    contents: Contents
    channels: dict[int, _Channel]
    times: list[dict[int, Times]]


def open_recording(path: Path | str) -> 'Recording':
    """
    Return the recording at a path: a rosbag2 directory, or a loose MCAP file.

    A file that was cut off gives every complete message, and a warning. Raise BagError if there is
    no recording.
    """
    path = Path(path)
    if path.name == METADATA_FILE:
        path = path.parent
    if not path.exists():
        raise BagError(f'there is no recording at {path}')
    if not path.is_dir():
        return Recording(path, [path], [])
    files, warnings = _files(path)
    return Recording(path, files, warnings)


class Recording:
    """Read one recording; its messages stay on the disk until they are asked for."""

    def __init__(self, path: Path, files: list[Path], warnings: list[str]) -> None:
        """Find the messages in the files; `open_recording` does this for a path."""
        self.path = path
        self.warnings = warnings
        self._files = [self._scan(file) for file in files]
        self.metadata: dict[str, str] = {}
        for file in self._files:
            self.metadata.update(file.contents.metadata)
        self.topics = self._summaries()

    @property
    def duration(self) -> float:
        """Return the time [s] between the first and the last message of all topics."""
        filled = [topic for topic in self.topics.values() if topic.count]
        if not filled:
            return 0.0
        return (max(topic.last for topic in filled) - min(topic.first for topic in filled)) / 1e9

    def joint_states(self, topic: str = JOINT_STATES.name) -> JointSamples:
        """Return the JointStates of a topic in log time order; raise BagError."""
        return self._samples(topic, JOINT_STATE, decode_joint_batch, join_joint_samples)

    def wrenches(self, topic: str) -> WrenchSamples:
        """Return the WrenchStampeds of a topic in log time order; raise BagError."""
        return self._samples(topic, WRENCH_STAMPED, decode_wrench_batch, join_wrench_samples)

    def texts(self, topic: str) -> TextSamples:
        """Return the Strings of a topic at their log times; raise BagError."""
        name = self._find(topic, STRING)
        times, messages = self.raw(name)
        try:
            return TextSamples(times, tuple(decode_string(message) for message in messages))
        except CdrError as error:
            raise BagError(f'{self.path}, topic {name}: {error}') from None

    def raw(self, topic: str) -> tuple[Indices, list[bytes]]:
        """Return the log times [ns] (n,) and the bytes of all messages of a topic, in order."""
        parts = list(self._messages(self._find(topic)))
        times = np.concatenate([np.empty(0, np.int64), *(part.log_times for part in parts)])
        messages = [part.batch.message(index) for part in parts
                    for index in range(len(part.log_times))]
        order = _order(times)
        return (times, messages) if order is None else (
            times[order], [messages[at] for at in order])

    def _samples(
            self, topic: str, message_type: str, decode: Callable[[Batch, int], Samples],
            join: Callable[[list[Samples]], Samples]) -> Samples:
        name = self._find(topic, message_type)
        times, parts = [np.empty(0, np.int64)], []
        try:
            for messages in self._messages(name):
                parts.append(decode(messages.batch, sum(map(len, times))))
                times.append(messages.log_times)
            samples = join(parts)
        except (CdrError, SamplesError) as error:
            raise BagError(f'{self.path}, topic {name}: {error}') from None
        order = _order(np.concatenate(times))
        return samples if order is None else samples.rows(order)

    def _find(self, topic: str, message_type: str | None = None) -> str:
        """Return the name that a topic has in this recording, and check its type."""
        alike = [name for name in self.topics if name.strip('/') == topic.strip('/')]
        if not alike:
            raise BagError(
                f'{self.path} has no topic {topic}; it has '
                f'{", ".join(sorted(self.topics)) or "none at all"}')
        name = topic if topic in alike else alike[0]
        found = self.topics[name].message_type
        if message_type is not None and found != message_type:
            raise BagError(
                f'{self.path}, topic {name}: the type must be {message_type}, got {found}')
        return name

    def _messages(self, name: str) -> Iterator[Messages]:
        """Yield the messages of a topic chunk by chunk, in the order of the files."""
        for file in self._files:
            channels = [number for number, channel in file.channels.items()
                        if channel.topic == name]
            for stretch, times in zip(file.contents.stretches, file.times):
                if times.keys().isdisjoint(channels):
                    continue
                if (records := self._read(file.path, stretch)) is not None:
                    yield records.messages(channels)

    def _read(self, path: Path, stretch: Stretch) -> Records | None:
        """Return the records of a part of a file, or None and a warning if it is damaged."""
        try:
            return read_stretch(path, stretch)
        except BagError as error:
            warning = f'{path.name}: the chunk at byte {stretch.offset} is left out: {error}'
        if warning not in self.warnings:
            self.warnings.append(warning)
        return None

    def _scan(self, path: Path) -> _File:
        """Find the messages of one file, and what its channels carry."""
        contents = scan(path)
        self.warnings.extend(contents.warnings)
        file = _File(path, contents, {}, [])
        schemas: dict[int, str] = {}
        for stretch in contents.stretches:
            times = stretch.times
            if not times or not times.keys() <= file.channels.keys():
                times = {}
                if (records := self._read(path, stretch)) is not None:
                    _define(records, schemas, file.channels)
                    times = {number: summarise(found) for number, found
                             in records.log_times().items() if number in file.channels}
            file.times.append(times)
        return file

    def _summaries(self) -> dict[str, TopicSummary]:
        """Return a summary of every topic of all files, by name."""
        found: dict[str, TopicSummary] = {}
        for file in self._files:
            for number, channel in sorted(file.channels.items()):
                times = [part[number] for part in file.times if number in part]
                summary = _summary(channel.message_type, times, found.get(channel.topic))
                found[channel.topic] = summary
        return dict(sorted(found.items()))


def _summary(
        message_type: str, times: list[Times], before: TopicSummary | None) -> TopicSummary:
    """Return the summary of a topic with more messages; no type where there are several."""
    filled = [part for part in times if part.count]
    if before is not None:
        filled += [Times(before.count, before.first, before.last)] if before.count else []
        message_type = message_type if message_type == before.message_type else 'several types'
    return TopicSummary(
        message_type, sum(part.count for part in filled),
        min((part.first for part in filled), default=0),
        max((part.last for part in filled), default=0))


def _define(records: Records, schemas: dict[int, str], channels: dict[int, _Channel]) -> None:
    """Add the schemas and channels that the records define."""
    for record in records.definitions():
        if isinstance(record, Schema):
            schemas[record.id] = _full_type(record.name)
        else:
            channels.setdefault(record.id, _Channel(
                record.topic, schemas.get(record.schema_id, 'no type'),
                record.message_encoding))


def _full_type(name: str) -> str:
    """Return 'package/msg/Name' for a type that is named with or without 'msg'."""
    try:
        return short_name(name).replace('/', '/msg/')
    except SchemaError:
        return name


def _order(times: Indices) -> Indices | None:
    """Return the order of the log times, equal ones as they came, or None if it is kept."""
    if (np.diff(times) >= 0).all():
        return None
    return np.argsort(times, kind='stable')


def _files(directory: Path) -> tuple[list[Path], list[str]]:
    """Return the files of a rosbag2 directory, and what is wrong with it."""
    present = sorted(directory.glob('*.mcap'), key=_natural)
    names, warning = _listed(directory)
    if warning is None:
        listed = [directory / Path(name).name for name in names]
        missing = [file.name for file in listed if not file.is_file()]
        present = [file for file in listed if file.is_file()]
        warning = f'{METADATA_FILE} names files that are missing: {missing}' if missing else None
    if not present:
        raise BagError(f'{directory} is not a recording: it has no .mcap file')
    return present, [] if warning is None else [warning]


def _listed(directory: Path) -> tuple[list[str], str | None]:
    """Return the files that metadata.yaml names, or why it names none."""
    try:
        with (directory / METADATA_FILE).open('rb') as stream:
            text = stream.read(LARGEST_METADATA)
        about: Any = yaml.safe_load(text)['rosbag2_bagfile_information']
        storage, names = about['storage_identifier'], about['relative_file_paths']
    except FileNotFoundError:
        return [], f'{METADATA_FILE} is missing'
    except (OSError, yaml.YAMLError, ValueError, LookupError, TypeError, RecursionError):
        return [], f'{METADATA_FILE} is damaged'
    if storage != 'mcap':
        raise BagError(
            f'{directory} is a bag of the storage {storage!r}; `ros2 bag convert` makes an MCAP '
            f'bag of it')
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        return [], f'{METADATA_FILE} is damaged'
    return names, None


def _natural(path: Path) -> tuple[int, str]:
    """Return a key that sorts the files of a split bag by number: bag_2 before bag_10."""
    number = path.stem.rpartition('_')[2]
    return (int(number) if number.isdecimal() else 0, path.name)
