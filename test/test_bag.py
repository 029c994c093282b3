"""Bags: what goes in comes out, and what cannot be read or written is named."""

from collections.abc import Callable, Iterator
from pathlib import Path

from bag_content import (
    assert_same, contents, joint_samples, NAMES, some_messages, START, TYPES, wrench_samples,
    write_ours)
from hda_msgs_json.bag import BagError, BagWriter, open_recording
from hda_msgs_json.bag_writer import Files
from hda_msgs_json.cdr import encode_joint_state, encode_string
from hda_msgs_json.samples import NumberSamples, TextSamples, WrenchSamples
from hda_msgs_json.schemas import schema_text
from hda_msgs_json.topics import (
    ESTIMATOR_STATE, JOINT_STATES, joint_torque, state_number, TIP_WRENCH, Topic)
import numpy as np
import pytest
import yaml


@pytest.mark.parametrize('compression', ['zstd', 'lz4', 'none'])
def test_samples_come_back(tmp_path: Path, compression: str) -> None:
    """Arrays survive to the last bit, over several chunks, with texts and metadata."""
    joints, wrenches = joint_samples(9000), wrench_samples(4500, offset=500, step=2_000_000)
    texts = TextSamples(wrenches.stamps[:3], ('', 'ä', '{"a": 1}'))
    numbers = NumberSamples(joints.stamps[::2], joints.position[::2, 0])
    with BagWriter(tmp_path / 'bag', {'seed': '7'}, files=Files(compression)) as bag:
        bag.write_wrenches(TIP_WRENCH, wrenches)
        bag.write_joint_states(JOINT_STATES, joints)
        bag.write_texts(ESTIMATOR_STATE, texts)
        bag.write_numbers(state_number('payload'), numbers)
    recording = open_recording(tmp_path / 'bag')
    assert_same(recording.joint_states(), joints)
    assert_same(recording.wrenches('tip/wrench'), wrenches)
    assert recording.texts('/estimator_state').texts == texts.texts
    np.testing.assert_array_equal(recording.texts('estimator_state').stamps, texts.stamps)
    found = recording.numbers('estimator_state/payload')
    np.testing.assert_array_equal(found.stamps, numbers.stamps)
    np.testing.assert_array_equal(found.values, numbers.values)
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


def foreign() -> Iterator[tuple[str, Callable[[Path], object], str]]:
    """Yield paths that are no recordings, how to make them, and what must be said."""
    yield 'none', lambda path: None, 'there is no recording at'
    yield 'empty.mcap', lambda path: path.write_bytes(b''), 'is empty'
    yield 'text.mcap', lambda path: path.write_text('hello world'), "starts with b'hello wo'"
    yield 'bag.db3', lambda path: path.write_bytes(b'SQLite format 3\0'), 'is an SQLite bag'
    yield 'folder', lambda path: path.mkdir(), 'it has no .mcap file'
    yield 'n' * 300, lambda path: None, 'File name too long'
    yield 'a.mcap.zstd', lambda path: path.write_bytes(b'no'), 'is not compressed with zstd'


@pytest.mark.parametrize('name, make, error', foreign(), ids=lambda value: str(value)[:12])
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
        BagWriter(tmp_path / 'bag', {}, files=Files('rar'))


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
