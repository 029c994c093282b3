"""Bags of this project open in the tools of others, and theirs here, with equal content."""

from pathlib import Path

from bag_content import (
    contents, joint_samples, some_messages, START, TYPES, wrench_samples, write_mcap, write_ours)
from hda_msgs_json.bag import BagWriter, open_recording
from hda_msgs_json.schemas import schema, schema_text
from hda_msgs_json.topics import (
    CLOCK, DIAGNOSTICS, ESTIMATOR_STATE, JOINT_REFERENCE, JOINT_STATES, TIP_WRENCH, Topic)
from mcap.writer import CompressionType, IndexType
import numpy as np
import pytest
import yaml

FRAMED = Topic('tip/wrench', TIP_WRENCH.message_type, 10, 'best_effort', reason='a test')


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


@pytest.mark.parametrize('topic', [
    JOINT_STATES, TIP_WRENCH, ESTIMATOR_STATE, JOINT_REFERENCE, DIAGNOSTICS, CLOCK])
def test_schemas_are_those_of_ros(topic: Topic) -> None:
    """Our definitions have the hash that an independent reader of schemas computes."""
    typesys = pytest.importorskip('rosbags.typesys')
    store = typesys.get_typestore(typesys.Stores.EMPTY)
    store.register(typesys.get_types_from_msg(
        schema_text(topic.message_type), topic.message_type))
    assert store.hash_rihs01(topic.message_type) == schema(topic.message_type).type_hash
