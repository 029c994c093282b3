"""What the files of a bag hold: channels, parts with their messages, and topics over all files."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from hda_msgs_json.mcap_file import (Content, FileStretch, NO_HINTS, read_stretch, scan, summarise,
                                     Times)
from hda_msgs_json.mcap_records import BagError, Records
from hda_msgs_json.printable import printable
from hda_msgs_json.schemas import SchemaError, short_name
from mcap.records import Schema


@dataclass(frozen=True)
class TopicSummary:
    """Summarise a topic: its type, number of messages, first and last log time [ns]."""

    message_type: str
    count: int
    first: int
    last: int


class Channel(NamedTuple):
    """Name what a channel of one file carries."""

    topic: str
    message_type: str
    quality: str = ''


class BagPart(NamedTuple):
    """Name a part of a file, and what its channels have in it."""

    path: Path
    stretch: FileStretch
    times: dict[int, Times]


@dataclass
class ScannedFile:
    """Collect channels and parts of one file, and what was found; channels are its own numbers."""

    channels: dict[int, Channel] = field(default_factory=dict)
    parts: list[BagPart] = field(default_factory=list)
    metadata: dict[str, str] = field(default_factory=dict)
    warnings: list[str] = field(default_factory=list)


def scan_file(path: Path) -> ScannedFile:
    """Find the messages of one file, and what its channels carry; raise BagError if it is none."""
    contents = scan(path)
    file = ScannedFile(metadata=contents.metadata, warnings=list(contents.warnings))
    schemas: dict[int, str] = {}
    for stretch in contents.stretches:
        times = {number: index.times for number, index in stretch.indexes.items()}
        part = BagPart(path, stretch, times)
        if not times or not times.keys() <= file.channels.keys():
            part = part._replace(times=_look_into(part, schemas, file))
        file.parts.append(part)
    return file


def _look_into(part: BagPart, schemas: dict[int, str], file: ScannedFile) -> dict[int, Times]:
    """Add what the records of a part define, and return what its channels have in it."""
    content, warning = content_of(part)
    if warning and warning not in file.warnings:
        file.warnings.append(warning)
    records = Records(*content)
    try:
        for record in records.definitions():
            if isinstance(record, Schema):
                schemas[record.id] = _full_type(record.name)
            else:
                file.channels.setdefault(record.id, Channel(
                    printable(record.topic), schemas.get(record.schema_id, 'no type'),
                    record.metadata.get('offered_qos_profiles', '')))
    except BagError as error:
        file.warnings.append(f'{part.path.name}: {error}')
    return {number: summarise(times) for number, times in records.log_times().items()
            if number in file.channels}


def content_of(part: BagPart) -> tuple[Content, str]:
    """Return the content of a part of a file; if it is damaged, none and a warning."""
    try:
        return read_stretch(part.path, part.stretch), ''
    except BagError as error:
        return Content(b'', NO_HINTS), (
            f'{part.path.name}: the chunk at byte {part.stretch.offset} is left out: {error}')


def summaries(files: Iterable[ScannedFile]) -> dict[str, TopicSummary]:
    """Return a summary of every topic of all files, by name."""
    found: dict[str, TopicSummary] = {}
    for file in files:
        for number, channel in sorted(file.channels.items()):
            times = [part.times[number] for part in file.parts if number in part.times]
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


def _full_type(name: str) -> str:
    """Return 'package/msg/Name' for a type that is named with or without 'msg'."""
    try:
        return short_name(name).replace('/', '/msg/')
    except SchemaError:
        return printable(name)
