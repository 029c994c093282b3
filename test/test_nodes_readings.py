"""Readings are found by name, in any order, and what is missing is named."""

from hda_arm_sim.health import Refused
from hda_arm_sim.inputs import EffortReader, tip_force
from hda_arm_sim.model.files import read_arm
from hda_msgs_json.cdr import (
    decode_joint_states, encode_joint_state, encode_wrench, JointStateDecoder)
from hda_msgs_json.columns import LengthsError, NamesError
from hda_torque_estimator.samples.readings import reading_names, ReadingFinder, readings
from hda_torque_estimator.samples.sample_reader import SampleReader
from hypothesis import given, strategies as st
import numpy as np
import pytest

LABELS = ('joint1', 'joint2')
NAMES = reading_names(LABELS)
EXTRA = ('gripper', 'joint3')
ANGLE = dict(zip((*NAMES, *EXTRA), (30.0, 0.3, 120.0, 1.2, 9.0, 8.0)))
RATE = dict(zip((*NAMES, *EXTRA), (3.0, 0.03, 12.0, 0.12, 0.9, 0.8)))
READING = [[30.0, 0.3, 3.0, 0.03], [120.0, 1.2, 12.0, 0.12]]


def message(names, *, velocity=True):
    """Return a joint state in which every name has its value."""
    return encode_joint_state(5, '', names, [ANGLE[name] for name in names],
                              [RATE[name] for name in names] if velocity else [])


def found(names, **options):
    """Return the reading that is found in such a joint state."""
    return ReadingFinder(LABELS)(JointStateDecoder()(message(names, **options)))


@given(st.permutations((*NAMES, *EXTRA)))
def test_order_and_extra_names_do_not_matter(names):
    np.testing.assert_array_equal(found(names), READING)


def test_missing_velocities_are_nan():
    reading = found(NAMES, velocity=False)
    np.testing.assert_array_equal(reading[:, :2], np.array(READING)[:, :2])
    assert np.isnan(reading[:, 2:]).all()


@given(st.lists(st.permutations((*NAMES, *EXTRA)), min_size=1, max_size=5), st.booleans())
def test_a_recording_gives_the_readings_of_its_messages(orders, velocity):
    messages = [message(names, velocity=velocity) for names in orders]
    decode, find = JointStateDecoder(), ReadingFinder(LABELS)
    one_by_one = np.array([find(decode(each)).copy() for each in messages])
    np.testing.assert_array_equal(readings(LABELS, decode_joint_states(messages)), one_by_one)


@pytest.mark.parametrize(('names', 'said'), [
    (NAMES[1:], 'joint1_motor not found in joint1, joint2_motor, joint2'),
    ((), 'not found in nothing'),
    ((*NAMES, 'joint1'), 'must hold joint1 once, got it 2 times'),
])
def test_names_that_do_not_fit_are_reported(names, said):
    with pytest.raises(NamesError, match=said):
        found(names)


def test_the_message_after_a_refused_one_is_read():
    decode, find = JointStateDecoder(), ReadingFinder(LABELS)
    with pytest.raises(NamesError):
        find(decode(message(NAMES[1:])))
    np.testing.assert_array_equal(find(decode(message(NAMES))), READING)


@pytest.mark.parametrize(('arrays', 'said'), [
    (([1.0, 2.0], [], []), 'position must have one value for each of the 4 names, got 2'),
    (([], [], [0.0] * 4), 'position must have one value for each of the 4 names, got 0'),
    (([0.0] * 4, [0.0], []), 'velocity must have one value for each of the 4 names, or none'),
    (([0.0] * 4, [], [0.0] * 5), 'effort must have one value'),
])
def test_lengths_that_do_not_fit_are_reported(arrays, said):
    with pytest.raises(LengthsError, match=said):
        ReadingFinder(LABELS)(JointStateDecoder()(encode_joint_state(5, '', NAMES, *arrays)))


@pytest.mark.parametrize(('sent', 'reason'), [
    (b'', 'malformed message'), (b'\x00\x01\x00\x00' + b'\xff' * 40, 'malformed message'),
    (encode_joint_state(5, '', ['joint1'], [0.0]), 'wrong names'),
    (encode_joint_state(5, '', NAMES, [0.0]), 'wrong lengths'),
])
def test_every_fault_of_a_sample_has_a_reason(sent, reason):
    with pytest.raises(Refused) as caught:
        SampleReader(read_arm('hda_arm.yaml'))(sent)
    assert caught.value.reason == reason


def test_efforts_are_found_by_name():
    read = EffortReader(['b', 'a'])
    stamp, effort = read(encode_joint_state(7, '', ['a', 'x', 'b'], [], [], [1.0, 2.0, 3.0]))
    assert (stamp, effort.tolist()) == (7, [3.0, 1.0])
    with pytest.raises(Refused, match='effort must have one value for each of the 2 names, got 0'):
        read(encode_joint_state(7, '', ['a', 'b'], [1.0, 2.0]))


@pytest.mark.parametrize(('frame', 'taken'), [('base', True), ('', True), ('tool', False)])
def test_force_must_be_in_the_base_frame(frame, taken):
    sent = encode_wrench(0, frame, [1.0, 2.0, 3.0], [0.0] * 3)
    if taken:
        assert tip_force(sent).tolist() == [1.0, 2.0]
    else:
        with pytest.raises(Refused, match="the frame must be 'base', got 'tool'"):
            tip_force(sent)
