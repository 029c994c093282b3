"""Bags: what goes in comes out, here and in the tools of others, and damage costs what it hits."""

from collections.abc import Callable, Iterator
from pathlib import Path
import random
import struct

from hda_msgs_json.bag import BagError, BagWriter, open_recording, Recording
from hda_msgs_json.cdr import encode_joint_state, encode_string, encode_wrench
from hda_msgs_json.samples import JointSamples, TextSamples, WrenchSamples
from hda_msgs_json.schemas import schema_text
from hda_msgs_json.topics import (
    CLOCK, DIAGNOSTICS, ESTIMATOR_STATE, JOINT_STATES, joint_torque, TIP_WRENCH, Topic)
from mcap.writer import CompressionType, IndexType, Writer
import numpy as np
import pytest
import yaml

START = 1_700_000_000_000_000_000
NAMES = ('joint1', 'joint1_motor')
JOINT_STATE = JOINT_STATES.message_type
FRAMED = Topic('tip/wrench', TIP_WRENCH.message_type, 10, 'best_effort', reason='a test')
Message = tuple[str, int, bytes]


def joint_samples(count: int, *, step: int = 1_000_000) -> JointSamples:
    """Return samples with distinct numbers and some NaN."""
    rng = np.random.default_rng(count)
    position, velocity, effort = rng.normal(size=(3, count, len(NAMES)))
    velocity[:, 1] = np.nan
    stamps = START + step * np.arange(count)
    return JointSamples(stamps, NAMES, position, velocity, effort, 'base')


def wrench_samples(count: int, *, offset: int = 0, step: int = 1_000_000) -> WrenchSamples:
    """Return samples with distinct numbers."""
    force, torque = np.random.default_rng(count).normal(size=(2, count, 3))
    return WrenchSamples(START + offset + step * np.arange(count), 'base', force, torque)


def assert_same(found: JointSamples | WrenchSamples, expected: object) -> None:
    """Compare all fields of samples, NaN equal to NaN."""
    for name, value in vars(expected).items():
        np.testing.assert_array_equal(getattr(found, name), value)


def some_messages(count: int) -> list[Message]:
    """Return messages of three topics in log time order, the last one of varying size."""
    messages: list[Message] = []
    for n in range(count):
        time = START + 1000 * n
        messages.append(('/joint_states', time, encode_joint_state(
            time, 'base', NAMES, (n, -n), (np.nan, 0.5), (1.0, 2.0))))
        messages.append(('/tip/wrench', time + 1, encode_wrench(
            time, 'base', (n, 0, 1), (0, 0, n))))
        if n % 3 == 0:
            messages.append(('/estimator_state', time + 2, encode_string('x' * (n % 7))))
    return messages


TYPES = {'/joint_states': JOINT_STATE, '/tip/wrench': TIP_WRENCH.message_type,
         '/estimator_state': ESTIMATOR_STATE.message_type}


def write_mcap(path: Path, messages: list[Message], **options: object) -> None:
    """Write a loose file with the writer of the mcap project."""
    with path.open('wb') as stream:
        writer = Writer(stream, **options)
        writer.start('ros2', 'test')
        channels = {}
        for topic, message_type in TYPES.items():
            number = writer.register_schema(
                message_type, 'ros2msg', schema_text(message_type).encode())
            channels[topic] = writer.register_channel(topic, 'cdr', number)
        for topic, time, message in messages:
            writer.add_message(channels[topic], time, message, time)
        writer.finish()


def write_ours(path: Path, messages: list[Message], **options: object) -> Path:
    """Write a bag message by message, and return its file."""
    with BagWriter(path, {'seed': '7'}, **options) as bag:
        for topic, time, message in messages:
            bag.write(Topic(topic, TYPES[topic], 10), time, message)
    return path / f'{path.name}_0.mcap'


def contents(recording: Recording) -> list[Message]:
    """Return all messages by log time, as they went in."""
    found = [(name, int(time), message) for name in recording.topics
             for time, message in zip(*recording.raw(name))]
    return sorted(found, key=lambda message: message[1])


# What goes in comes out


@pytest.mark.parametrize('compression', ['zstd', 'lz4', 'none'])
def test_samples_come_back(tmp_path: Path, compression: str) -> None:
    """Arrays survive to the last bit, over several chunks, with texts and metadata."""
    joints, wrenches = joint_samples(9000), wrench_samples(4500, offset=500, step=2_000_000)
    texts = TextSamples(wrenches.stamps[:3], ('', 'ä', '{"a": 1}'))
    with BagWriter(tmp_path / 'bag', {'seed': '7'}, compression=compression) as bag:
        bag.write_wrenches(TIP_WRENCH, wrenches)
        bag.write_joint_states(JOINT_STATES, joints)
        bag.write_texts(ESTIMATOR_STATE, texts)
    recording = open_recording(tmp_path / 'bag')
    assert_same(recording.joint_states(), joints)
    assert_same(recording.wrenches('tip/wrench'), wrenches)
    assert recording.texts('/estimator_state').texts == texts.texts
    np.testing.assert_array_equal(recording.texts('estimator_state').stamps, texts.stamps)
    assert recording.metadata == {'seed': '7'}
    assert recording.warnings == []
    assert recording.duration == pytest.approx(8.999, abs=1e-9)
    summary = recording.topics['/tip/wrench']
    assert (summary.message_type, summary.count) == (TIP_WRENCH.message_type, 4500)
    assert (summary.first, summary.last) == (wrenches.stamps[0], wrenches.stamps[-1])


@pytest.mark.parametrize('whole', [True, False])
def test_messages_come_back(tmp_path: Path, whole: bool) -> None:
    """Messages written one by one come back as they went in, whole or live."""
    messages = some_messages(500)
    write_ours(tmp_path / 'bag', messages, whole=whole)
    assert contents(open_recording(tmp_path / 'bag')) == messages


def test_topics_are_merged_by_log_time(tmp_path: Path) -> None:
    """The file holds the messages of all topics in time order, equal ones as they were written."""
    reader = pytest.importorskip('mcap.stream_reader')
    records = pytest.importorskip('mcap.records')
    first, second = wrench_samples(300), wrench_samples(100, step=3_000_000)
    with BagWriter(tmp_path / 'bag', {}) as bag:
        bag.write_wrenches(joint_torque('joint2'), first)
        bag.write_wrenches(joint_torque('joint1'), second)
    with (tmp_path / 'bag' / 'bag_0.mcap').open('rb') as stream:
        found = [(record.log_time, record.channel_id, record.sequence)
                 for record in reader.StreamReader(stream).records
                 if isinstance(record, records.Message)]
    expected = sorted([(int(time), 1, n) for n, time in enumerate(first.stamps)]
                      + [(int(time), 2, n) for n, time in enumerate(second.stamps)])
    assert found == expected


def test_stamps_that_go_back_keep_their_order(tmp_path: Path) -> None:
    """A clock that jumps is evidence: the messages stay in the order of the samples."""
    samples = wrench_samples(5)
    jumping = WrenchSamples(samples.stamps[[0, 1, 4, 2, 3]], 'base', samples.force, samples.torque)
    with BagWriter(tmp_path / 'bag', {}) as bag:
        bag.write_wrenches(TIP_WRENCH, jumping)
    assert_same(open_recording(tmp_path / 'bag').wrenches('tip/wrench'), jumping)


def test_messages_out_of_order_are_sorted(tmp_path: Path) -> None:
    """Messages come back by log time, those of equal time in the order of the file."""
    order = [3, 1, 2, 1, 0]
    messages = [('/estimator_state', START + time, encode_string(str(n)))
                for n, time in enumerate(order)]
    write_ours(tmp_path / 'bag', messages)
    recording = open_recording(tmp_path / 'bag')
    assert recording.texts('estimator_state').texts == ('4', '1', '3', '2', '0')
    assert recording.topics['/estimator_state'].first == START


def test_empty_bag(tmp_path: Path) -> None:
    """A bag without messages is a valid recording; a topic without messages is listed."""
    with BagWriter(tmp_path / 'bag', {'a': 'b'}) as bag:
        bag.write_wrenches(TIP_WRENCH, wrench_samples(0))
    recording = open_recording(tmp_path / 'bag')
    assert recording.duration == 0.0
    assert recording.topics['/tip/wrench'].count == 0
    assert len(recording.wrenches('tip/wrench')) == 0


def test_two_drivers_on_a_topic(tmp_path: Path) -> None:
    """Joints that come in separate messages get a column each."""
    messages = [('/joint_states', START + n, encode_joint_state(n, '', (f'joint{n % 2}',), (n,)))
                for n in range(20)]
    write_ours(tmp_path / 'bag', messages)
    samples = open_recording(tmp_path / 'bag').joint_states()
    np.testing.assert_array_equal(samples.position[::2, 0], range(0, 20, 2))
    assert np.isnan(samples.position[::2, 1]).all()
    assert samples.select(['joint1']).position[3, 0] == 3


# Others open our bags


@pytest.mark.parametrize('compression', ['zstd', 'none'])
def test_rosbags_reads_our_bags(tmp_path: Path, compression: str) -> None:
    """The strict reader of rosbags finds the same messages, types and quality of service."""
    rosbag2 = pytest.importorskip('rosbags.rosbag2')
    messages = some_messages(300)
    with BagWriter(tmp_path / 'bag', {}, compression=compression) as bag:
        bag.write(FRAMED, START - 1, messages[1][2])
        for topic, time, message in messages:
            bag.write(Topic(topic, TYPES[topic], 10), time, message)
    with rosbag2.Reader(tmp_path / 'bag') as reader:
        found = [(connection.topic, time, bytes(message))
                 for connection, time, message in reader.messages()]
        assert sorted(found[1:]) == sorted(messages)
        assert reader.message_count == len(messages) + 1
        assert (reader.start_time, reader.duration) == (START - 1, messages[-1][1] - START + 2)
        (profile,) = reader.connections[0].ext.offered_qos_profiles
        assert (profile.depth, profile.reliability.name) == (10, 'BEST_EFFORT')


def test_rosbags_decodes_our_bags(tmp_path: Path) -> None:
    """A decoder that knows only the schemas in the bag gives the same numbers."""
    highlevel = pytest.importorskip('rosbags.highlevel')
    joints, wrenches = joint_samples(200), wrench_samples(200)
    with BagWriter(tmp_path / 'bag', {}) as bag:
        bag.write_joint_states(JOINT_STATES, joints)
        bag.write_wrenches(TIP_WRENCH, wrenches)
    with highlevel.AnyReader([tmp_path / 'bag' / 'bag_0.mcap']) as reader:
        found = [reader.deserialize(message, connection.msgtype)
                 for connection, _, message in reader.messages()]
    np.testing.assert_array_equal([m.velocity for m in found[::2]], joints.velocity)
    np.testing.assert_array_equal([m.wrench.force.y for m in found[1::2]], wrenches.force[:, 1])


def test_mcap_reads_our_bags(tmp_path: Path) -> None:
    """The indexed reader of the mcap project and its ROS decoder find the same content."""
    reader = pytest.importorskip('mcap.reader')
    ros2 = pytest.importorskip('mcap_ros2.decoder')
    messages = some_messages(300)
    file = write_ours(tmp_path / 'bag', messages)
    with file.open('rb') as stream:
        mcap = reader.make_reader(stream, validate_crcs=True, decoder_factories=[
            ros2.DecoderFactory()])
        found = list(mcap.iter_decoded_messages())
        summary = mcap.get_summary()
        assert {record.name for record in mcap.iter_metadata()} == {'hda', 'rosbag2'}
    assert [(channel.topic, message.log_time, message.data)
            for _, channel, message, _ in found] == messages
    assert [m.wrench.force.x for _, channel, _, m in found if channel.topic == '/tip/wrench'] == [
        float(n) for n in range(300)]
    assert summary.statistics.message_count == len(messages)


def test_metadata_is_that_of_rosbag2(tmp_path: Path) -> None:
    """The description of the bag has the fields of version 9 and counts the messages."""
    write_ours(tmp_path / 'bag', some_messages(6))
    about = yaml.safe_load((tmp_path / 'bag' / 'metadata.yaml').read_text())[
        'rosbag2_bagfile_information']
    assert about['version'] == 9 and about['storage_identifier'] == 'mcap'
    assert about['relative_file_paths'] == ['bag_0.mcap'] == [f['path'] for f in about['files']]
    assert about['message_count'] == 14
    topics = {entry['topic_metadata']['name']: entry for entry in
              about['topics_with_message_count']}
    assert topics['/joint_states']['message_count'] == 6
    assert topics['/joint_states']['topic_metadata']['type_description_hash'].startswith('RIHS01_')
    (profile,) = topics['/joint_states']['topic_metadata']['offered_qos_profiles']
    assert profile['history'] == 'keep_last'


# We open the bags of others


@pytest.mark.parametrize('options', [
    {}, {'compression': CompressionType.NONE}, {'compression': CompressionType.LZ4},
    {'use_chunking': False}, {'chunk_size': 500}, {'index_types': IndexType.NONE},
    {'index_types': IndexType.MESSAGE, 'repeat_channels': False, 'use_statistics': False},
    {'enable_crcs': False}, {'index_types': IndexType.CHUNK, 'use_summary_offsets': False},
], ids=str)
def test_files_of_mcap_are_read(tmp_path: Path, options: dict[str, object]) -> None:
    """Loose files open whatever compression, chunks, indexes and summary they have."""
    messages = some_messages(400)
    write_mcap(tmp_path / 'loose.mcap', messages, **options)
    recording = open_recording(tmp_path / 'loose.mcap')
    assert contents(recording) == messages
    assert recording.warnings == []
    samples = recording.joint_states()
    np.testing.assert_array_equal(samples.position[:, 0], range(400))


@pytest.mark.parametrize('mode', ['NONE', 'MESSAGE', 'FILE', 'STORAGE'])
@pytest.mark.parametrize('version', [8, 9])
def test_bags_of_rosbags_are_read(tmp_path: Path, mode: str, version: int) -> None:
    """Bags of another writer open, in both current versions and with each compression."""
    rosbag2 = pytest.importorskip('rosbags.rosbag2')
    typesys = pytest.importorskip('rosbags.typesys')
    store = typesys.get_typestore(typesys.Stores.ROS2_JAZZY)
    writer = rosbag2.Writer(
        tmp_path / 'bag', version=version, storage_plugin=rosbag2.StoragePlugin.MCAP)
    writer.set_compression(rosbag2.CompressionMode[mode], rosbag2.CompressionFormat.ZSTD)
    messages = some_messages(200)
    with writer:
        connections = {topic: writer.add_connection(topic, message_type, typestore=store)
                       for topic, message_type in TYPES.items()}
        for topic, time, message in messages:
            writer.write(connections[topic], time, message)
    recording = open_recording(tmp_path / 'bag')
    assert contents(recording) == messages
    assert recording.warnings == []
    np.testing.assert_array_equal(recording.joint_states().position[:, 0], range(200))


def test_split_bags_are_one_recording(tmp_path: Path) -> None:
    """The files of a bag are read in the order of metadata.yaml, or by number without it."""
    messages = some_messages(60)
    names = [f'bag_{n}.mcap' for n in range(12)]
    for n, name in enumerate(names):
        write_mcap(tmp_path / name, messages[12 * n:12 * (n + 1)])
    recording = open_recording(tmp_path)
    assert recording.warnings == ['metadata.yaml is missing']
    assert contents(recording) == messages[:144]
    about = {'storage_identifier': 'mcap',
             'relative_file_paths': [names[1], 'gone.mcap', names[0]]}
    (tmp_path / 'metadata.yaml').write_text(yaml.safe_dump({'rosbag2_bagfile_information': about}))
    recording = open_recording(tmp_path / 'metadata.yaml')
    assert recording.warnings == ['metadata.yaml names files that are missing: gone.mcap']
    assert contents(recording) == messages[:24]


# What cannot be read, and what cannot be written


def foreign(directory: Path) -> Iterator[tuple[str, Callable[[Path], object], str]]:
    """Yield paths that are no recordings, how to make them, and what must be said."""
    yield 'none', lambda path: None, 'there is no recording at'
    yield 'empty.mcap', lambda path: path.write_bytes(b''), 'is empty'
    yield 'text.mcap', lambda path: path.write_text('hello world'), "starts with b'hello wo'"
    yield 'bag.db3', lambda path: path.write_bytes(b'SQLite format 3\0'), 'is an SQLite bag'
    yield 'folder', lambda path: path.mkdir(), 'it has no .mcap file'
    yield 'n' * 300, lambda path: None, 'File name too long'
    yield 'a.mcap.zstd', lambda path: path.write_bytes(b'no'), 'is not compressed with zstd'


@pytest.mark.parametrize('name, make, error', foreign(Path()), ids=lambda value: str(value)[:12])
def test_foreign_paths_are_named(
        tmp_path: Path, name: str, make: Callable[[Path], object], error: str) -> None:
    """What is no recording is refused in one sentence with its path."""
    make(tmp_path / name)
    with pytest.raises(BagError, match=error) as caught:
        open_recording(tmp_path / name)
    assert name in str(caught.value) and '\n' not in str(caught.value)


@pytest.mark.parametrize('text', [
    '{', 'a: [', '[]', 'rosbag2_bagfile_information: 3', '[' * 5000, '\x00', '2001-99-99',
    'rosbag2_bagfile_information: {storage_identifier: mcap, relative_file_paths: 5}'])
def test_damaged_metadata_is_a_warning(tmp_path: Path, text: str) -> None:
    """The messages do not depend on metadata.yaml."""
    messages = some_messages(3)
    write_ours(tmp_path / 'bag', messages)
    (tmp_path / 'bag' / 'metadata.yaml').write_text(text)
    recording = open_recording(tmp_path / 'bag')
    assert recording.warnings == ['metadata.yaml is damaged']
    assert contents(recording) == messages


def test_sqlite_bags_are_named(tmp_path: Path) -> None:
    """The other storage of rosbag2 is recognised, and what would help is said."""
    write_ours(tmp_path / 'bag', [])
    file = tmp_path / 'bag' / 'metadata.yaml'
    file.write_text(file.read_text().replace('mcap', 'sqlite3'))
    with pytest.raises(BagError, match='is an SQLite bag; `ros2 bag convert`'):
        open_recording(tmp_path / 'bag')


def test_missing_topics_and_wrong_types_are_named(tmp_path: Path) -> None:
    """The error names the topics that are there, or the type that was found."""
    write_ours(tmp_path / 'bag', some_messages(3))
    recording = open_recording(tmp_path / 'bag')
    with pytest.raises(BagError, match='has no topic torque; it has /estimator_state, /joint_sta'):
        recording.wrenches('torque')
    with pytest.raises(BagError, match='must be geometry_msgs/msg/WrenchStamped, got sensor_msgs'):
        recording.wrenches('joint_states')


def test_broken_messages_are_named(tmp_path: Path) -> None:
    """A message that is not of its type is named with its number in the topic."""
    good = encode_joint_state(0, '', NAMES, (1, 2))
    messages = [('/joint_states', START + n, good) for n in range(7)]
    write_ours(tmp_path / 'bag', [*messages, ('/joint_states', START + 9, good[:-9])])
    with pytest.raises(BagError, match='topic /joint_states: message 7: position needs'):
        open_recording(tmp_path / 'bag').joint_states()


def test_a_taken_place_is_refused(tmp_path: Path) -> None:
    """Nothing is overwritten: neither a directory with something in it, nor a file."""
    (tmp_path / 'file').write_text('')
    (tmp_path / 'full').mkdir()
    (tmp_path / 'full' / 'precious').write_text('')
    (tmp_path / 'empty').mkdir()
    for whole in (True, False):
        with pytest.raises(BagError, match='exists and is not empty'):
            BagWriter(tmp_path / 'full', {}, whole=whole)
        with pytest.raises(BagError, match='is a file'):
            BagWriter(tmp_path / 'file', {}, whole=whole)
    with BagWriter(tmp_path / 'empty', {}):
        pass
    assert sorted(p.name for p in tmp_path.rglob('*')) == [
        'empty', 'empty_0.mcap', 'file', 'full', 'metadata.yaml', 'precious']


def test_a_failure_leaves_nothing(tmp_path: Path) -> None:
    """A bag that should be whole does not appear when its writing fails."""
    with pytest.raises(KeyError), BagWriter(tmp_path / 'bag', {}) as bag:
        bag.write_wrenches(TIP_WRENCH, wrench_samples(5))
        raise KeyError
    assert list(tmp_path.iterdir()) == []


def test_samples_that_cannot_be_written_leave_nothing(tmp_path: Path) -> None:
    """Stamps before 1970 have no log time: the error comes before anything is written."""
    with pytest.raises(BagError, match='must not be negative'), BagWriter(
            tmp_path / 'bag', {}) as bag:
        bag.write_wrenches(TIP_WRENCH, wrench_samples(3, offset=-2 * START))
    assert list(tmp_path.iterdir()) == []


def test_a_live_bag_is_there_from_the_start(tmp_path: Path) -> None:
    """Directory and metadata exist at once, and a flush makes the messages readable."""
    messages = some_messages(50)
    bag = BagWriter(tmp_path / 'bag', {'seed': '7'}, whole=False)
    assert yaml.safe_load((tmp_path / 'bag' / 'metadata.yaml').read_text())
    for topic, time, message in messages:
        bag.write(Topic(topic, TYPES[topic], 10), time, message)
    bag.flush()
    recording = open_recording(tmp_path / 'bag')
    assert contents(recording) == messages
    assert recording.metadata == {'seed': '7'}
    assert 'cut off' in recording.warnings[0]
    bag.close()
    assert open_recording(tmp_path / 'bag').warnings == []


def test_a_live_bag_survives_an_error(tmp_path: Path) -> None:
    """A recorder that fails keeps what it has."""
    messages = some_messages(5)
    with pytest.raises(KeyError), BagWriter(tmp_path / 'bag', {}, whole=False) as bag:
        for topic, time, message in messages:
            bag.write(Topic(topic, TYPES[topic], 10), time, message)
        raise KeyError
    assert contents(open_recording(tmp_path / 'bag')) == messages


def test_log_times_outside_of_the_range_are_refused(tmp_path: Path) -> None:
    """A bag has no room for times before 1970; what came before the error is kept."""
    bag = BagWriter(tmp_path / 'bag', {}, whole=False)
    bag.write(ESTIMATOR_STATE, 5, encode_string('a'))
    for time in (-1, 2 ** 64):
        with pytest.raises(BagError, match='a log time must lie in 0 to'):
            bag.write(ESTIMATOR_STATE, time, encode_string('b'))
    bag.close()
    assert open_recording(tmp_path / 'bag').texts('estimator_state').texts == ('a',)


def test_unknown_types_are_named(tmp_path: Path) -> None:
    """A type that is neither of this system nor installed cannot be written."""
    with pytest.raises(ValueError, match='no share directory has made_up/Thing.msg'), BagWriter(
            tmp_path / 'bag', {}) as bag:
        bag.write(Topic('thing', 'made_up/msg/Thing', 1), 0, b'')
    with pytest.raises(BagError, match='one of zstd, lz4, none'):
        BagWriter(tmp_path / 'bag', {}, compression='rar')


def test_other_types_come_from_the_installation(tmp_path: Path) -> None:
    """A type of an installed package is written with its definition and those in it."""
    share = tmp_path / 'share'
    for name, text in {'Outer': 'Inner[2] parts\nstring<=5 name\nstd_msgs/Header header # stamp',
                       'Inner': 'uint8 ONE=1\nfloat32 value'}.items():
        path = share / 'made_up' / 'msg' / f'{name}.msg'
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    text = schema_text('made_up/msg/Outer', share)
    assert text.count('MSG: ') == 3 and 'float32 value' in text
    with BagWriter(tmp_path / 'bag', {}, share_directories=[share]) as bag:
        bag.write(Topic('thing', 'made_up/msg/Outer', 1), START, b'\0\1\0\0')
    recording = open_recording(tmp_path / 'bag')
    assert recording.topics['/thing'].message_type == 'made_up/msg/Outer'
    assert recording.raw('thing')[1] == [b'\0\1\0\0']


@pytest.mark.parametrize('topic', [JOINT_STATES, TIP_WRENCH, ESTIMATOR_STATE, DIAGNOSTICS, CLOCK])
def test_schemas_are_those_of_ros(topic: Topic) -> None:
    """Our definitions have the hash that an independent reader of schemas computes."""
    typesys = pytest.importorskip('rosbags.typesys')
    schemas = pytest.importorskip('hda_msgs_json.schemas')
    store = typesys.get_typestore(typesys.Stores.EMPTY)
    store.register(typesys.get_types_from_msg(
        schema_text(topic.message_type), topic.message_type))
    assert store.hash_rihs01(topic.message_type) == schemas.schema(topic.message_type).type_hash


# Damage


def complete(messages: list[Message], found: list[Message]) -> bool:
    """Return whether messages were found in order from the first, none changed."""
    return found == messages[:len(found)]


@pytest.mark.parametrize('compression', ['none', 'zstd', 'lz4'])
def test_cut_off_bags_keep_all_complete_messages(tmp_path: Path, compression: str) -> None:
    """Wherever a file ends, what was complete is there; uncompressed, to the message."""
    messages = some_messages(150)
    file = write_ours(tmp_path / 'bag', messages, compression=compression)
    content = file.read_bytes()
    ends = [0]
    for _, _, message in messages:
        ends.append(content.find(message, ends[-1]) + len(message))
    for cut in [*range(len(content) - 1, 8, -97), 8]:
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
