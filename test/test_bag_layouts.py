"""Recordings whose layouts vary: arrays in bulk equal the messages read one by one."""

from pathlib import Path
import struct
from typing import NamedTuple

from bag_content import START, write_mcap
from hda_msgs_json.bag import BagError, open_recording, Recording
from hda_msgs_json.cdr import decode_joint_state, encode_joint_state
from hda_msgs_json.mcap_walk import record_starts
from hda_msgs_json.samples import JointSamples
from hypothesis import given, settings, strategies as st
from mcap.opcode import Opcode
from mcap.writer import CompressionType, IndexType
import numpy as np
import pytest

INDEX = struct.Struct('<BQHI')
FIELDS = ('position', 'velocity', 'effort')


class Driver(NamedTuple):
    """Publish some JointStates in a row, all of one layout."""

    frame: str
    names: tuple[str, ...]
    present: tuple[bool, ...]
    count: int

    def messages(self, first: int) -> list[tuple[str, int, bytes]]:
        """Return the messages with their log times, numbered from the first."""
        return [('/joint_states', START + n, encode_joint_state(
            START + 1000 * n, self.frame, self.names,
            *([n + 0.25 * place for place in range(len(self.names))] if there else []
              for there in self.present))) for n in range(first, first + self.count)]


DRIVERS = st.lists(st.builds(
    Driver, st.sampled_from(['', 'base', 'a_longer_frame']),
    st.lists(st.sampled_from(['a', 'bb', 'ccc', 'dddd', 'e' * 9]), unique=True).map(tuple),
    st.tuples(st.booleans(), st.booleans(), st.booleans()),
    st.integers(1, 12)), min_size=1, max_size=30)
WAYS = st.fixed_dictionaries({
    'chunk_size': st.integers(100, 5000), 'use_chunking': st.booleans(),
    'compression': st.sampled_from(CompressionType),
    'index_types': st.sampled_from([IndexType.ALL, IndexType.NONE, IndexType.CHUNK])})


def one_by_one(recording: Recording) -> JointSamples:
    """Return what the messages hold, decoded singly; what one lacks is NaN."""
    states = [decode_joint_state(message) for message in recording.raw('joint_states')[1]]
    names = tuple(dict.fromkeys(name for state in states for name in state.names))
    arrays = np.full((len(FIELDS), len(states), len(names)), np.nan)
    for row, state in enumerate(states):
        for field, values in enumerate(state.numbers):
            for name, value in zip(state.names, values):
                arrays[field, row, names.index(name)] = value
    stamps = np.array([state.stamp_ns for state in states], np.int64)
    return JointSamples(stamps, names, *arrays, states[0].frame_id if states else '')


def assert_same(found: JointSamples, expected: JointSamples) -> None:
    """Compare all fields, NaN equal to NaN."""
    assert (found.names, found.frame_id) == (expected.names, expected.frame_id)
    for name in ('stamps', *FIELDS):
        np.testing.assert_array_equal(getattr(found, name), getattr(expected, name))


@settings(deadline=None)
@given(drivers=DRIVERS, way=WAYS)
def test_arrays_hold_what_the_messages_hold(
        drivers: list[Driver], way: dict[str, object],
        tmp_path_factory: pytest.TempPathFactory) -> None:
    """Whatever the layouts, the chunks and the indexes are, bulk and single reading agree."""
    messages: list[tuple[str, int, bytes]] = []
    for driver in drivers:
        messages += driver.messages(len(messages))
    path = tmp_path_factory.getbasetemp() / 'layouts.mcap'
    write_mcap(path, messages, **way)
    recording = open_recording(path)
    assert recording.raw('joint_states')[1] == [message for _, _, message in messages]
    assert_same(recording.joint_states(), one_by_one(recording))
    assert recording.warnings == []


def test_one_layout_is_decoded_in_place(tmp_path: Path) -> None:
    """Arrays of a whole recording are made once: they are no copies of parts."""
    write_mcap(tmp_path / 'a.mcap', Driver('', ('a', 'b'), (True, False, True), 900).messages(0),
               chunk_size=2000)
    samples = open_recording(tmp_path / 'a.mcap').joint_states()
    assert samples.position.base is not None
    np.testing.assert_array_equal(samples.position, samples.effort)
    assert np.isnan(samples.velocity).all()
    assert_same(samples, one_by_one(open_recording(tmp_path / 'a.mcap')))


@pytest.mark.parametrize('claimed', [0, 1, 39, 41, 10 ** 6])
def test_indexes_that_lie_change_nothing(tmp_path: Path, claimed: int) -> None:
    """An index that claims other messages than its chunk has costs time, and nothing else."""
    messages = Driver('base', ('a', 'b'), (True, True, True), 200).messages(0)
    write_mcap(tmp_path / 'a.mcap', messages, chunk_size=40 * len(messages[0][2]))
    content = (tmp_path / 'a.mcap').read_bytes()
    expected = open_recording(tmp_path / 'a.mcap').joint_states()
    at = next(8 + at for at in record_starts(content[8:])[0].tolist()
              if content[8 + at] == Opcode.MESSAGE_INDEX)
    _, _, channel, size = INDEX.unpack_from(content, at)
    entries = content[at + INDEX.size:][:size]
    lies = (entries * (16 * claimed // size + 1))[:16 * claimed]
    (tmp_path / 'a.mcap').write_bytes(
        content[:at] + INDEX.pack(Opcode.MESSAGE_INDEX, 6 + len(lies), channel, len(lies)) + lies
        + content[at + INDEX.size + size:])
    recording = open_recording(tmp_path / 'a.mcap')
    assert_same(recording.joint_states(), expected)


def test_a_broken_message_is_named_by_its_number(tmp_path: Path) -> None:
    """The number counts the messages of the whole recording, in whatever chunk it is."""
    messages = Driver('base', ('a', 'b'), (True, True, True), 100).messages(0)
    topic, time, message = messages[77]
    messages[77] = (topic, time, message[:40])
    write_mcap(tmp_path / 'a.mcap', messages, chunk_size=1000)
    with pytest.raises(BagError, match='topic /joint_states: message 77: '):
        open_recording(tmp_path / 'a.mcap').joint_states()


def test_a_first_message_that_is_broken_is_named_as_well(tmp_path: Path) -> None:
    """The layout of all is learnt from the first message, sound or not."""
    messages = Driver('base', ('a', 'b'), (True, True, True), 100).messages(0)
    messages[0] = (*messages[0][:2], b'')
    write_mcap(tmp_path / 'a.mcap', messages, chunk_size=1000)
    with pytest.raises(BagError, match='message 0: '):
        open_recording(tmp_path / 'a.mcap').joint_states()
