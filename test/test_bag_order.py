"""Messages of all topics in the order of their log times, however they are stored."""

from bag_content import some_messages, START, write_mcap, write_ours
from hda_msgs_json.bag import open_recording
from hda_msgs_json.bag_order import in_order, Message, Source
from hda_msgs_json.worker_threads import drawn_ahead
from hypothesis import given, strategies as st
import pytest


def played(path, topics=None, start=0):
    """Return what comes of a recording, as it went in."""
    recording = open_recording(path)
    return [(m.topic, m.log_time, m.content)
            for m in recording.messages(topics or recording.topics, start)]


@pytest.mark.parametrize('options', [{}, {'chunk_size': 300}, {'use_chunking': False}], ids=str)
def test_messages_of_equal_time_come_as_they_are_stored(tmp_path, options):
    messages = [(topic, START + n // 50 * 10, content)
                for n, (topic, _, content) in enumerate(some_messages(100))]
    shuffled = messages[100:150] + messages[:100] + messages[150:]
    write_mcap(tmp_path / 'loose.mcap', shuffled, **options)
    assert played(tmp_path / 'loose.mcap') == sorted(shuffled, key=lambda message: message[1])
    assert played(tmp_path / 'loose.mcap', ['/joint_states'], START + 10) == [
        message for message in messages[50:] if message[0] == '/joint_states']


def test_our_own_bags_come_as_they_were_written(tmp_path):
    messages = some_messages(300)
    write_ours(tmp_path / 'bag', messages)
    assert played(tmp_path / 'bag') == messages


@given(st.lists(st.lists(st.integers(0, 20), min_size=1), max_size=5))
def test_sources_that_overlap_are_merged(parts):
    """The order is that of a stable sort of all messages as they are stored."""
    sources, stored = [], []
    for number, times in enumerate(parts):
        messages = [Message(time, (number, at), '/t', b'') for at, time in enumerate(times)]
        stored += messages
        sources.append(Source(min(times), lambda own=messages: iter(sorted(own))))
    assert list(in_order(sources)) == sorted(stored, key=lambda message: message.log_time)


def test_a_source_is_not_read_before_its_time():
    read = []

    def source(first):
        read.append(first)
        yield Message(first, (first, 0), '/t', b'')

    messages = in_order([Source(first, lambda first=first: source(first)) for first in (5, 1, 9)])
    for first in (1, 5, 9):
        assert next(messages).log_time == first
        assert max(read) <= first


@pytest.mark.parametrize('count', [0, 1, 7, 8, 100])
def test_drawing_ahead_keeps_order_and_number(count):
    assert list(drawn_ahead(iter(range(count)), 4, 2)) == list(range(count))


def test_an_error_comes_where_it_belongs():
    def items():
        yield from range(5)
        raise KeyError('broken')

    drawn = drawn_ahead(items(), 5)
    assert [next(drawn) for _ in range(5)] == list(range(5))
    with pytest.raises(KeyError, match='broken'):
        next(drawn)


def test_quality_of_service_is_kept(tmp_path):
    write_ours(tmp_path / 'bag', some_messages(3))
    quality, = open_recording(tmp_path / 'bag').qualities('/joint_states')
    assert 'reliability: reliable' in quality
    assert open_recording(tmp_path / 'bag').qualities('/nothing') == []
