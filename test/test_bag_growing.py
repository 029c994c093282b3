"""Bags that grow: several files, and disks that take no more."""

from itertools import count
import resource
import tracemalloc

from bag_content import contents, some_messages, START, TYPES, write_ours
from hda_msgs_json.bag import BagError, BagWriter, open_recording
from hda_msgs_json.bag_writer import Files
from hda_msgs_json.mcap_records import MAGIC
from hda_msgs_json.mcap_spool import MOST_HELD, Spool
from hda_msgs_json.mcap_writer import McapWriter
from hda_msgs_json.topics import Topic
from mcap.reader import make_reader
import pytest
from rosbags.rosbag2 import Reader
import yaml

MESSAGES = some_messages(200)


def described(bag):
    """Return what metadata.yaml says."""
    return yaml.safe_load((bag / 'metadata.yaml').read_text())['rosbag2_bagfile_information']


def test_a_bag_goes_on_in_another_file_by_time(tmp_path):
    write_ours(tmp_path / 'bag', MESSAGES, files=Files(time=50_000))
    assert contents(open_recording(tmp_path / 'bag')) == MESSAGES
    about = described(tmp_path / 'bag')
    assert about['relative_file_paths'] == [f'bag_{n}.mcap' for n in range(4)]
    assert sum(file['message_count'] for file in about['files']) == len(MESSAGES)
    assert about['message_count'] == len(MESSAGES)
    assert about['files'][1]['starting_time']['nanoseconds_since_epoch'] == START + 50_000
    assert {topic['topic_metadata']['name']: topic['message_count']
            for topic in about['topics_with_message_count']} == {
                name: sum(topic == name for topic, _, _ in MESSAGES) for name in TYPES}
    for file in about['relative_file_paths']:
        assert open_recording(tmp_path / 'bag' / file).metadata == {'seed': '7'}
        assert (tmp_path / 'bag' / file).read_bytes().endswith(MAGIC)


def test_a_bag_goes_on_in_another_file_by_size(tmp_path):
    write_ours(tmp_path / 'bag', MESSAGES, files=Files('none', size=10_000))
    assert contents(open_recording(tmp_path / 'bag')) == MESSAGES
    sizes = [(tmp_path / 'bag' / name).stat().st_size
             for name in described(tmp_path / 'bag')['relative_file_paths']]
    assert len(sizes) > 5
    assert all(size < 20_000 for size in sizes)         # and its summary


def test_others_open_a_bag_of_several_files(tmp_path):
    write_ours(tmp_path / 'bag', MESSAGES, files=Files(time=70_000))
    with Reader(tmp_path / 'bag') as reader:
        found = [(connection.topic, time, bytes(content))
                 for connection, time, content in reader.messages()]
    assert found == MESSAGES


@pytest.fixture
def limited():
    """Return a function that limits the size of files, until the test ends."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    yield lambda size: resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


@pytest.mark.parametrize('room', [5_000, 9_000, 14_000, 20_000])
@pytest.mark.parametrize('every', [1, 10, 80])
def test_a_disk_that_takes_no_more_keeps_what_it_has(tmp_path, limited, room, every):
    """The bag opens, holds a beginning of what came, and counts it rightly."""
    bag = BagWriter(tmp_path / 'bag', {'seed': '7'}, whole=False, files=Files('none'))
    limited(room)
    numbers = count(1)
    with pytest.raises(BagError, match='bag cannot be written: File too large'):
        for topic, time, message in MESSAGES:
            bag.write(Topic(topic, TYPES[topic], 10), time, message)
            if next(numbers) % every == 0:
                bag.flush()
    bag.close()
    limited(resource.RLIM_INFINITY)
    recording = open_recording(tmp_path / 'bag')
    found = contents(recording)
    assert found == MESSAGES[:len(found)]
    assert len(found) > 0 or room < 20_000
    assert described(tmp_path / 'bag')['message_count'] == len(found) == bag.messages
    assert not (tmp_path / 'bag' / '.metadata.yaml').exists()


def test_a_recorder_that_flushes_for_hours_stays_small(tmp_path):
    """Every flush is a chunk, and every chunk has an index that the end of the file repeats."""
    path, used = tmp_path / 'file.mcap', []
    with path.open('xb', buffering=0) as stream:
        mcap = McapWriter(stream, 'zstd')
        channels = [mcap.add_channel(f'/{n}', ('std_msgs/msg/String', 'ros2msg', b''), 'cdr', {})
                    for n in range(12)]
        tracemalloc.start()
        for flush in range(3000):
            for channel in channels:
                mcap.write(channel, flush, b'x')
            mcap.close_chunk()
            if flush in (999, 2999):
                used.append(tracemalloc.get_traced_memory()[0])
        tracemalloc.stop()
        mcap.finish()
        mcap.close()
    assert used[1] - used[0] < 2 * MOST_HELD            # 2000 indexes are 500 kB and more
    with path.open('rb') as stream:
        summary = make_reader(stream, validate_crcs=True).get_summary()
    assert len(summary.chunk_indexes) == summary.statistics.chunk_count == 3000
    assert [index.message_start_time for index in summary.chunk_indexes] == [*range(3000)]


def test_what_a_disk_does_not_take_stays_in_memory(tmp_path, limited):
    pieces = [bytes([n]) * 5000 for n in range(100)]
    spool = Spool(tmp_path)
    limited(200_000)
    for piece in pieces:
        spool.add(piece)
    assert b''.join(spool) == b''.join(pieces)
    assert spool.count == 100
    assert list(tmp_path.iterdir()) == []
    spool.close()
