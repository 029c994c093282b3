"""Damaged bags: damage costs what it hits, changes no number, and gives one clear line."""

from pathlib import Path
import random
import struct

from bag_content import (
    contents, Message, NAMES, some_messages, START, TYPES, write_mcap, write_ours)
from hda_msgs_json.bag import BagError, BagWriter, open_recording
from hda_msgs_json.bag_writer import Files
from hda_msgs_json.cdr import encode_joint_state
from hda_msgs_json.mcap_walk import record_starts
from hda_msgs_json.topics import Topic
from mcap.writer import CompressionType, Writer
import pytest
import zstandard


def complete(messages: list[Message], found: list[Message]) -> bool:
    """Return whether messages were found in order from the first, none changed."""
    return found == messages[:len(found)]


@pytest.mark.parametrize('compression', ['none', 'zstd', 'lz4'])
def test_cut_off_bags_keep_all_complete_messages(tmp_path: Path, compression: str) -> None:
    """Wherever a file ends, what was complete is there; uncompressed, to the message."""
    messages = some_messages(150)
    file = write_ours(tmp_path / 'bag', messages, files=Files(compression))
    content = file.read_bytes()
    ends = [0]
    for _, _, message in messages:
        ends.append(content.find(message, ends[-1]) + len(message))
    for cut in [*range(len(content) - 1, 8, -197), 8]:
        file.write_bytes(content[:cut])
        recording = open_recording(tmp_path / 'bag')
        found = contents(recording)
        assert complete(messages, found) and recording.warnings
        if compression == 'none':
            assert len(found) == sum(end <= cut for end in ends[1:])
    assert len(found) == 0


def test_cut_off_live_bags_keep_all_closed_chunks(tmp_path: Path) -> None:
    """Each flush is a point from which nothing is lost, wherever the file ends after it."""
    messages = some_messages(120)
    bag = BagWriter(tmp_path / 'bag', {}, whole=False)
    file, safe = tmp_path / 'bag' / 'bag_0.mcap', [(0, 0)]
    for n, (topic, time, message) in enumerate(messages):
        bag.write(Topic(topic, TYPES[topic], 10), time, message)
        if n % 40 == 39:
            bag.flush()
            safe.append((file.stat().st_size, n + 1))
    bag.close()
    content = file.read_bytes()
    for cut in random.Random(1).sample(range(8, len(content)), 60):
        file.write_bytes(content[:cut])
        found = contents(open_recording(tmp_path / 'bag'))
        assert complete(messages, found)
        assert len(found) >= max(count for size, count in safe if size <= cut)


def test_a_flipped_bit_never_changes_a_number(tmp_path: Path) -> None:
    """A chunk with a wrong checksum is left out with a warning; the other chunks stay."""
    messages = [('/joint_states', START + n, encode_joint_state(n, '', NAMES, (n, n)))
                for n in range(50)]
    write_mcap(tmp_path / 'a.mcap', messages, chunk_size=500, compression=CompressionType.NONE)
    content = bytearray((tmp_path / 'a.mcap').read_bytes())
    content[content.find(struct.pack('<dd', 25, 25)) + 3] ^= 1
    (tmp_path / 'a.mcap').write_bytes(content)
    recording = open_recording(tmp_path / 'a.mcap')
    found = recording.joint_states()
    assert 25 not in found.position[:, 0] and len(found) > 40
    assert 'its checksum is wrong' in recording.warnings[0]


@pytest.mark.parametrize('options', [
    {}, {'compression': CompressionType.NONE, 'enable_crcs': False, 'chunk_size': 2000},
    {'compression': CompressionType.LZ4}, {'use_chunking': False}], ids=str)
def test_random_damage_gives_a_recording_or_one_error(
        tmp_path: Path, options: dict[str, object]) -> None:
    """Flipped bits, cuts, doubled and exchanged parts: no other exception, no hang."""
    rng = random.Random(str(options))
    path = tmp_path / 'a.mcap'
    write_mcap(path, some_messages(40), **options)
    content = path.read_bytes()
    for _ in range(150):
        damaged = bytearray(content)
        for _ in range(rng.randint(1, 5)):
            at, size = rng.randrange(len(damaged)), rng.randrange(1, 60)
            kind = rng.randrange(5)
            if kind <= 1:
                damaged[at] ^= 1 << rng.randrange(8)
            elif kind == 2:
                damaged[at:at + 8] = struct.pack('<Q', rng.choice([2**63, 2**64 - 1, 2**32, 0]))
            elif kind == 3:
                del damaged[at:at + size]
            else:
                damaged[at:at] = damaged[rng.randrange(len(damaged)):][:size]
        path.write_bytes(damaged)
        look_at_everything(path)


def look_at_everything(path: Path) -> None:
    """Read all of a recording in every way; only BagError may come of it."""
    try:
        recording = open_recording(path)
    except BagError as error:
        assert '\n' not in str(error)
        return
    for name in recording.topics:
        for read in (recording.raw, recording.joint_states, recording.wrenches, recording.texts):
            try:
                read(name)
            except BagError as error:
                assert '\n' not in str(error)
    assert all('\n' not in warning for warning in recording.warnings)


def test_lying_indexes_are_not_believed(tmp_path: Path) -> None:
    """An index that points elsewhere costs time, not messages."""
    messages = some_messages(30)
    write_mcap(tmp_path / 'a.mcap', messages, compression=CompressionType.NONE)
    content = bytearray((tmp_path / 'a.mcap').read_bytes())
    entry = struct.pack('<Q', messages[3][1])
    content[content.rfind(entry) + 8] ^= 1
    (tmp_path / 'a.mcap').write_bytes(content)
    assert contents(open_recording(tmp_path / 'a.mcap')) == messages


def test_names_that_would_break_a_line_are_escaped(tmp_path: Path) -> None:
    """A topic with control characters cannot forge the output of a command."""
    with (tmp_path / 'a.mcap').open('wb') as stream:
        writer = Writer(stream)
        writer.start('ros2', 'test')
        schema = writer.register_schema('a\nb', 'ros2msg', b'')
        channel = writer.register_channel('/x\n\x1b[31m', 'cdr', schema)
        writer.add_message(channel, 1, b'', 1)
        writer.finish()
    recording = open_recording(tmp_path / 'a.mcap')
    (name, summary), = recording.topics.items()
    assert name.isprintable() and summary.message_type.isprintable()
    assert recording.raw(name)[1] == [b'']


@pytest.mark.parametrize('compression', [CompressionType.ZSTD, CompressionType.LZ4])
def test_bombs_are_refused(tmp_path: Path, compression: CompressionType) -> None:
    """A small chunk that claims to become gigabytes is left out before it grows."""
    write_mcap(tmp_path / 'a.mcap', some_messages(30), compression=compression)
    content = bytearray((tmp_path / 'a.mcap').read_bytes())
    at = content.find(b'\x06', 8 + 9 + 8)
    assert content[at + 9 + 28:].startswith((b'\x04\0\0\0zstd', b'\x03\0\0\0lz4'))
    content[at + 9 + 16:at + 9 + 24] = struct.pack('<Q', 2 ** 40)
    (tmp_path / 'a.mcap').write_bytes(content)
    recording = open_recording(tmp_path / 'a.mcap')
    assert recording.topics == {}
    assert 'which is more than is read' in recording.warnings[0]


def test_no_record_follows_a_zero(tmp_path: Path) -> None:
    """A chunk that becomes millions of zeros is no swarm of records: 0 begins none."""
    messages = some_messages(30)
    write_mcap(tmp_path / 'a.mcap', messages, compression=CompressionType.NONE, chunk_size=10 ** 6)
    sound = (tmp_path / 'a.mcap').read_bytes()
    stored = zstandard.ZstdCompressor().compress(bytes(1 << 20))
    body = (struct.pack('<QQQII', 0, 0, 1 << 20, 0, 4) + b'zstd'
            + struct.pack('<Q', len(stored)) + stored)
    bomb = struct.pack('<BQ', 6, len(body)) + body
    (tmp_path / 'a.mcap').write_bytes(sound[:8] + bomb + sound[8:])
    assert contents(open_recording(tmp_path / 'a.mcap')) == messages
    assert record_starts(b'\1' + bytes(8) + bytes(900))[0].tolist() == [0]
    assert record_starts((b'\1' + bytes(8)) * 900 + bytes(900))[1] == 9 * 900


def test_an_error_names_some_topics_only(tmp_path: Path) -> None:
    """A bag with hundreds of topics gives one line that can be read."""
    with (tmp_path / 'a.mcap').open('wb') as stream:
        writer = Writer(stream)
        writer.start('ros2', 'test')
        schema = writer.register_schema('std_msgs/msg/String', 'ros2msg', b'')
        for number in range(300):
            channel = writer.register_channel(f'/topic{number}', 'cdr', schema)
            writer.add_message(channel, 1, b'', 1)
        writer.finish()
    with pytest.raises(BagError, match=r'it has /topic0, .*, \.\.\.$') as caught:
        open_recording(tmp_path / 'a.mcap').joint_states()
    assert len(str(caught.value)) < 1000
