"""Repair of recordings: all that is complete in one that was cut off, as a whole bag."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from hda_msgs_json.bag_files import find_files
from hda_msgs_json.bag_writer import BagWriter
from hda_msgs_json.mcap_file import Contents, LOOSE, read_stretch, scan
from hda_msgs_json.mcap_records import BagError, parse
from hda_msgs_json.mcap_walk import RECORD_HEAD, record_starts
from hda_msgs_json.mcap_writer import MESSAGE
from hda_msgs_json.schemas import Schema as Definition
from hda_msgs_json.topics import SAMPLED_DEPTH, Topic
from hda_msgs_json.yaml_text import yaml_document
from mcap.opcode import Opcode
from mcap.records import Channel, Schema
import numpy as np

POLICIES = {'reliability': ('reliable', 'best_effort'),
            'durability': ('volatile', 'transient_local')}


class Repaired(NamedTuple):
    """Say what a repair has kept, and what was wrong."""

    messages: int
    topics: int
    warnings: list[str]


@dataclass
class _Channels:
    """Collect what the channels of one file carry."""

    schemas: dict[int, Schema] = field(default_factory=dict)
    topics: dict[int, Topic] = field(default_factory=dict)
    unknown: int = 0


def repair(path: Path, out: Path, *, force: bool = False) -> Repaired:
    """
    Write every complete message of a recording to a new bag, which appears whole or not at all.

    The recording is only read. A chunk that was cut gives the messages that are complete in it,
    one with a wrong checksum none. Raise BagError if nothing can be read or written.
    """
    if out.absolute() == path.absolute():
        raise BagError(f'{path} is left as it is; name another place for the repaired bag')
    files = find_files(path)
    warnings = list(files.warnings)
    scanned = [(file, found) for file in files.paths
               if (found := _scanned(file, warnings)) is not None]
    if not scanned:
        raise BagError(f'{path} has nothing to repair: {warnings[-1]}')
    metadata = {key: value for _, found in scanned for key, value in found.metadata.items()}
    count, topics = 0, set()
    with BagWriter(out, metadata, force=force) as bag:
        for file, found in scanned:
            warnings += found.warnings
            for topic, time, message in _messages(file, found, bag, warnings):
                bag.write(topic, time, message)
                topics.add(topic)
                count += 1
    return Repaired(count, len(topics), warnings)


def _scanned(file: Path, warnings: list[str]) -> Contents | None:
    """Return what a file holds, or None and a warning."""
    try:
        return scan(file)
    except BagError as error:
        warnings.append(str(error))
        return None


def _messages(
        file: Path, found: Contents, bag: BagWriter, warnings: list[str]
        ) -> Iterator[tuple[Topic, int, bytes]]:
    """Yield topic, log time [ns] and bytes of the messages of a file, in its order."""
    channels = _Channels()
    for stretch in found.stretches:
        try:
            content = read_stretch(file, stretch).records
        except BagError as error:
            warnings.append(
                f'{file.name}: the chunk at byte {stretch.offset} is left out: {error}')
            continue
        yield from _records(content, channels, bag, f'{file.name}: ', warnings)
    if channels.unknown:
        warnings.append(f'{file.name}: {channels.unknown} messages are left out: the definition '
                        'of their channel is missing')


def _records(
        content: bytes, channels: _Channels, bag: BagWriter, place: str, warnings: list[str]
        ) -> Iterator[tuple[Topic, int, bytes]]:
    """Yield the messages of a stretch, and take note of the channels that it defines."""
    starts, _ = record_starts(content)
    opcodes = np.frombuffer(content, np.uint8)[starts]
    for start in starts[np.isin(opcodes, LOOSE)]:
        opcode, length = RECORD_HEAD.unpack_from(content, start)
        stop = int(start) + RECORD_HEAD.size + length
        if opcode == Opcode.MESSAGE and stop - start >= MESSAGE.size:
            _, _, number, _, time, _ = MESSAGE.unpack_from(content, start)
            if number in channels.topics:
                yield channels.topics[number], time, content[start + MESSAGE.size:stop]
            else:
                channels.unknown += 1
        elif opcode != Opcode.MESSAGE:
            try:
                _define(opcode, content[start + RECORD_HEAD.size:stop], channels, bag)
            except BagError as error:
                warnings.append(f'{place}{error} and left out')


def _define(opcode: int, body: bytes, channels: _Channels, bag: BagWriter) -> None:
    """Take note of a schema or a channel."""
    if opcode == Opcode.SCHEMA:
        schema = parse(Schema, body)
        channels.schemas.setdefault(schema.id, schema)
        return
    channel = parse(Channel, body)
    if channel.id in channels.topics or channel.schema_id not in channels.schemas:
        return
    schema = channels.schemas[channel.schema_id]
    topic = _topic(channel, schema.name)
    bag.define(topic, Definition(schema.data.decode(errors='replace'),
                                 channel.metadata.get('topic_type_hash', '')))
    channels.topics[channel.id] = topic


def _topic(channel: Channel, message_type: str) -> Topic:
    """Return the topic of a channel, with the quality of service that was noted with it."""
    try:
        profile = yaml_document(channel.metadata.get('offered_qos_profiles', ''))[0]
        depth = int(profile['depth'])
        kept = {name: profile[name] for name, allowed in POLICIES.items()
                if profile[name] in allowed}
    except (ValueError, LookupError, TypeError):
        depth, kept = SAMPLED_DEPTH, {}
    return Topic(channel.topic, message_type, depth, **kept)
