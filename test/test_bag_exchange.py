"""Bags of this project open in the tools of others, and theirs here, with equal content."""

from pathlib import Path
from typing import Any

from bag_content import (
    assert_same, contents, joint_samples, some_messages, START, TYPES, wrench_samples, write_mcap,
    write_ours)
from hda_msgs_json.bag import BagWriter, open_recording
from hda_msgs_json.bag_writer import Files
from hda_msgs_json.cdr_arrays import encode_joint_rows, encode_wrench_rows
from hda_msgs_json.schemas import schema, schema_text
from hda_msgs_json.topics import (
    CLOCK, DIAGNOSTICS, ESTIMATOR_STATE, JOINT_REFERENCE, JOINT_STATES, state_number, TIP_WRENCH,
    Topic)
from mcap.writer import CompressionType, IndexType
import numpy as np
import pytest
import yaml

FRAMED = Topic('tip/wrench', TIP_WRENCH.message_type, 10, 'best_effort', reason='a test')


BARE = {'index_types': IndexType.NONE, 'repeat_channels': False, 'repeat_schemas': False,
        'use_statistics': False, 'use_summary_offsets': False}
"""What leaves a file without summary and without any index."""


@pytest.mark.parametrize('compression', ['zstd', 'lz4', 'none'])
def test_rosbags_reads_our_bags(tmp_path: Path, compression: str) -> None:
    """The strict reader of rosbags finds the same messages, types and quality of service."""
    rosbag2 = pytest.importorskip('rosbags.rosbag2')
    messages = some_messages(300)
    with BagWriter(tmp_path / 'bag', {}, files=Files(compression)) as bag:
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


def numbers_of(message: Any) -> list[float]:
    """Return the numbers of a decoded JointState or WrenchStamped in the order of its fields."""
    if type(message).__name__.rpartition('__')[2] == 'JointState':
        return [*message.position, *message.velocity, *message.effort]
    return [getattr(vector, axis) for vector in (message.wrench.force, message.wrench.torque)
            for axis in 'xyz']


@pytest.mark.parametrize('compression', ['zstd', 'lz4', 'none'])
@pytest.mark.parametrize('in_bulk', [True, False], ids=['samples', 'messages'])
def test_all_decoders_find_our_numbers(tmp_path: Path, compression: str, in_bulk: bool) -> None:
    """Whichever library decodes a bag, whole or its file alone, finds the same numbers as we."""
    highlevel = pytest.importorskip('rosbags.highlevel')
    ros2 = pytest.importorskip('mcap_ros2.reader')
    joints, wrenches = joint_samples(3000), wrench_samples(3000)
    with BagWriter(tmp_path / 'bag', {}, files=Files(compression)) as bag:
        if in_bulk:
            bag.write_joint_states(JOINT_STATES, joints)
            bag.write_wrenches(TIP_WRENCH, wrenches)
        else:
            for row in range(3000):
                time, at = int(joints.stamps[row]), slice(row, row + 1)
                bag.write(JOINT_STATES, time, encode_joint_rows(joints.rows(at)).tobytes())
                bag.write(TIP_WRENCH, time, encode_wrench_rows(wrenches.rows(at)).tobytes())
    expected = [row for pair in zip(np.hstack(joints.numbers), np.hstack(wrenches.numbers))
                for row in pair]
    file = tmp_path / 'bag' / 'bag_0.mcap'
    for path in (tmp_path / 'bag', file):
        with highlevel.AnyReader([path]) as reader:
            found = [reader.deserialize(message, connection.msgtype)
                     for connection, _, message in reader.messages()]
        for message, numbers in zip(found, expected, strict=True):
            np.testing.assert_array_equal(numbers_of(message), numbers)
    for view, numbers in zip(ros2.read_ros2_messages(file), expected, strict=True):
        np.testing.assert_array_equal(numbers_of(view.ros_msg), numbers)


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
    {'enable_crcs': False}, BARE, {**BARE, 'use_chunking': False},
    {**BARE, 'compression': CompressionType.LZ4, 'enable_crcs': False},
    {'index_types': IndexType.CHUNK, 'use_summary_offsets': False},
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


@pytest.mark.parametrize('compression', [
    CompressionType.NONE, CompressionType.LZ4, CompressionType.ZSTD], ids=str)
@pytest.mark.parametrize('loose', [True, False], ids=['loose', 'directory'])
def test_bags_of_mcap_ros2_are_read(
        tmp_path: Path, compression: CompressionType, loose: bool) -> None:
    """Messages that mcap-ros2-support encodes by the schemas alone give the same samples."""
    ros2 = pytest.importorskip('mcap_ros2.writer')
    joints = joint_samples(500)
    file = tmp_path / 'bag.mcap'
    writer = ros2.Writer(str(file), chunk_size=4000, compression=compression)
    kind = writer.register_msgdef(
        JOINT_STATES.message_type, schema_text(JOINT_STATES.message_type))
    for n, stamp in enumerate(joints.stamps.tolist()):
        time = {'sec': stamp // 10 ** 9, 'nanosec': stamp % 10 ** 9}
        writer.write_message('/joint_states', kind, {
            'header': {'stamp': time, 'frame_id': 'base'}, 'name': list(joints.names),
            **{field: getattr(joints, field)[n].tolist()
               for field in ('position', 'velocity', 'effort')}}, stamp, stamp)
    writer.finish()
    recording = open_recording(file if loose else tmp_path)
    assert_same(recording.joint_states(), joints)
    assert recording.warnings == ([] if loose else ['metadata.yaml is missing'])


@pytest.mark.parametrize('mode', ['NONE', 'MESSAGE', 'FILE', 'STORAGE'])
def test_split_bags_of_rosbags_are_one_recording(tmp_path: Path, mode: str) -> None:
    """Two files of another writer, compressed or not, are one recording in the order of time."""
    rosbag2 = pytest.importorskip('rosbags.rosbag2')
    typesys = pytest.importorskip('rosbags.typesys')
    store = typesys.get_typestore(typesys.Stores.ROS2_JAZZY)
    messages = some_messages(120)
    names = []
    for part, some in enumerate((messages[:100], messages[100:])):
        writer = rosbag2.Writer(tmp_path / f'bag_{part}', version=9,
                                storage_plugin=rosbag2.StoragePlugin.MCAP)
        writer.set_compression(rosbag2.CompressionMode[mode], rosbag2.CompressionFormat.ZSTD)
        with writer:
            connections = {topic: writer.add_connection(topic, message_type, typestore=store)
                           for topic, message_type in TYPES.items()}
            for topic, time, message in some:
                writer.write(connections[topic], time, message)
        (file,) = (tmp_path / f'bag_{part}').glob('*.mcap*')
        names.append(file.name)
        file.rename(tmp_path / file.name)
    about = yaml.safe_load((tmp_path / 'bag_0' / 'metadata.yaml').read_text())
    about['rosbag2_bagfile_information']['relative_file_paths'] = names
    (tmp_path / 'metadata.yaml').write_text(yaml.safe_dump(about))
    recording = open_recording(tmp_path)
    assert contents(recording) == messages
    assert recording.warnings == []
    assert len(recording.joint_states()) == 120


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


@pytest.mark.parametrize('topic', [
    JOINT_STATES, TIP_WRENCH, ESTIMATOR_STATE, JOINT_REFERENCE, DIAGNOSTICS, CLOCK,
    state_number('payload')])
def test_schemas_are_those_of_ros(topic: Topic) -> None:
    """Our definitions have the hash that an independent reader of schemas computes."""
    typesys = pytest.importorskip('rosbags.typesys')
    store = typesys.get_typestore(typesys.Stores.EMPTY)
    store.register(typesys.get_types_from_msg(
        schema_text(topic.message_type), topic.message_type))
    assert store.hash_rihs01(topic.message_type) == schema(topic.message_type).type_hash
