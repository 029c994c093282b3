"""CDR bytes: what ROS writes is read, what is read is what was written, and damage is named."""

from types import ModuleType

from hda_msgs_json.cdr import (
    CdrError, decode_joint_state, decode_joint_states, decode_number, decode_string,
    decode_wrench, decode_wrenches, encode_joint_state, encode_number, encode_string,
    encode_wrench, JointState, JointStateDecoder, JointStateEncoder, WrenchEncoder)
from hda_msgs_json.cdr_arrays import encode_joint_rows, encode_wrench_rows
from hda_msgs_json.cdr_batch import batch_of
from hda_msgs_json.cdr_layout import read_joint_state
from hda_msgs_json.samples import JointSamples, WrenchSamples
from hypothesis import given, strategies as st
import numpy as np
import pytest

FLOATS = st.floats(allow_nan=True, allow_infinity=True, width=64)
TEXTS = st.text(st.characters(exclude_characters='\0', exclude_categories=['Cs']), max_size=12)
STAMPS = st.integers(-(2 ** 31) * 10 ** 9, 2 ** 31 * 10 ** 9 - 1)
NAMES = ('joint1', 'joint1_motor', 'joint2', 'gelenk_ü')


@st.composite
def joint_states(draw: st.DrawFn) -> tuple:
    """Draw the arguments of a JointState, any of its arrays empty."""
    names = draw(st.lists(TEXTS, max_size=5, unique=True))
    arrays = [draw(st.one_of(st.just([]), st.lists(FLOATS, min_size=len(names),
                                                   max_size=len(names)))) for _ in range(3)]
    return draw(STAMPS), draw(TEXTS), names, *arrays


def assert_same_state(state: JointState, expected: tuple) -> None:
    """Compare a JointState with the arguments it was made of, NaN equal to NaN."""
    assert (state.stamp_ns, state.frame_id, list(state.names)) == (*expected[:2],
                                                                   list(expected[2]))
    for values, wanted in zip(state[3:], expected[3:]):
        np.testing.assert_array_equal(values, np.asarray(wanted, float))


def assert_same_samples(samples: JointSamples, expected: JointSamples) -> None:
    """Compare two sets of samples, NaN equal to NaN."""
    assert (samples.names, samples.frame_id) == (expected.names, expected.frame_id)
    for field in ('stamps', 'position', 'velocity', 'effort'):
        np.testing.assert_array_equal(getattr(samples, field), getattr(expected, field))


def some_states(names: tuple[str, ...], count: int, *, start: int = 0) -> list[bytes]:
    """Return messages with distinct numbers, the velocity of the first name unknown."""
    return [
        encode_joint_state(
            start + n, 'base', names, np.arange(len(names)) + n,
            [np.nan] + [0.5 * n] * (len(names) - 1), -np.arange(len(names)) * n)
        for n in range(count)]


def big_endian(message: bytes) -> bytes:
    """Return a JointState of the names 'a' and 'b' with only positions, byte order turned."""
    size = {'stamp': 4, 'count': 4, 'double': 8}
    layout = ([(4, size['stamp']), (8, size['stamp']), (12, size['count']), (20, size['count']),
               (24, size['count']), (32, size['count']), (40, size['count'])]
              + [(44, size['double']), (52, size['double']), (60, size['count']),
                 (64, size['count'])])
    turned = bytearray(message)
    turned[1] = 0
    for at, width in layout:
        turned[at:at + width] = turned[at:at + width][::-1]
    return bytes(turned)


@pytest.fixture(scope='module')
def serialization() -> ModuleType:
    """Return the serializer of ROS itself."""
    return pytest.importorskip('rclpy.serialization')


@given(joint_states())
def test_joint_state_round_trip(arguments: tuple) -> None:
    """What was encoded is decoded, slowly and twice by the fast decoder."""
    message = encode_joint_state(*arguments)
    decode = JointStateDecoder()
    for state in (decode_joint_state(message), decode(message), decode(message)):
        assert_same_state(state, arguments)


@given(joint_states())
def test_joint_state_equals_ros(serialization: ModuleType, arguments: tuple) -> None:
    """ROS reads our bytes and we read those of ROS."""
    messages = pytest.importorskip('sensor_msgs.msg')
    theirs = messages.JointState(
        name=arguments[2], position=arguments[3], velocity=arguments[4], effort=arguments[5])
    theirs.header.frame_id = arguments[1]
    theirs.header.stamp.sec, theirs.header.stamp.nanosec = divmod(arguments[0], 10 ** 9)
    ours = encode_joint_state(*arguments)
    assert repr(serialization.deserialize_message(ours, messages.JointState)) == repr(theirs)
    message = serialization.serialize_message(theirs)
    assert_same_state(decode_joint_state(message), arguments)
    assert 0 <= len(message) - len(ours) < 16


@given(STAMPS, TEXTS, st.lists(FLOATS, min_size=6, max_size=6))
def test_wrench_equals_ros(
        serialization: ModuleType, stamp: int, frame: str, numbers: list[float]) -> None:
    """ROS reads the bytes of both encoders and we read those of ROS."""
    theirs = pytest.importorskip('geometry_msgs.msg').WrenchStamped()
    theirs.header.frame_id = frame
    theirs.header.stamp.sec, theirs.header.stamp.nanosec = divmod(stamp, 10 ** 9)
    force, torque = theirs.wrench.force, theirs.wrench.torque
    force.x, force.y, force.z, torque.x, torque.y, torque.z = numbers
    ours = encode_wrench(stamp, frame, numbers[:3], numbers[3:])
    assert repr(serialization.deserialize_message(ours, type(theirs))) == repr(theirs)
    assert ours == WrenchEncoder(frame)(stamp, numbers[:3], numbers[3:])
    for message in (ours, serialization.serialize_message(theirs)):
        wrench = decode_wrench(message)
        assert (wrench.stamp_ns, wrench.frame_id) == (stamp, frame)
        np.testing.assert_array_equal([*wrench.force, *wrench.torque], numbers)


@given(TEXTS)
def test_string_equals_ros(serialization: ModuleType, text: str) -> None:
    """ROS reads our text and we read that of ROS."""
    theirs = pytest.importorskip('std_msgs.msg').String(data=text)
    ours = encode_string(text)
    assert serialization.deserialize_message(ours, type(theirs)) == theirs
    assert decode_string(ours) == decode_string(serialization.serialize_message(theirs)) == text


@given(FLOATS)
def test_number_equals_ros(serialization: ModuleType, number: float) -> None:
    """ROS reads our number and we read that of ROS, to the last bit."""
    theirs = pytest.importorskip('std_msgs.msg').Float64(data=number)
    ours = encode_number(number)
    assert ours == serialization.serialize_message(theirs)[:len(ours)]
    np.testing.assert_array_equal(decode_number(ours), number)


@pytest.mark.parametrize('message', [b'', encode_number(1.0)[:-1], encode_number(1.0) + bytes(20)])
def test_what_is_no_number_is_refused(message: bytes) -> None:
    """Bytes that are missing, or too many, are named."""
    with pytest.raises(CdrError):
        decode_number(message)


@given(joint_states())
def test_joint_state_equals_rosbags(arguments: tuple) -> None:
    """An independent decoder reads the same numbers and names."""
    typesys = pytest.importorskip('rosbags.typesys')
    store = typesys.get_typestore(typesys.Stores.ROS2_JAZZY)
    theirs = store.deserialize_cdr(encode_joint_state(*arguments), 'sensor_msgs/msg/JointState')
    assert (theirs.header.frame_id, theirs.name) == (arguments[1], arguments[2])
    for field, wanted in zip(('position', 'velocity', 'effort'), arguments[3:]):
        np.testing.assert_array_equal(getattr(theirs, field), np.asarray(wanted, float))


def test_fixed_encoder_equals_general_encoder() -> None:
    """The template of a fixed set of names gives the same bytes as the general encoder."""
    encode = JointStateEncoder(NAMES, 'base', velocity=False)
    numbers = np.array([1.0, np.nan, -np.inf, 0.1])
    assert encode(7, numbers, (), 2 * numbers) == encode_joint_state(
        7, 'base', NAMES, numbers, (), 2 * numbers)


def test_fixed_encoder_refuses_wrong_lengths() -> None:
    """A missing number and a stamp beyond the range of ROS are named."""
    encode = JointStateEncoder(('a', 'b'))
    with pytest.raises(CdrError, match=r'must hold \[2, 2, 2\] numbers, got \[2, 1, 2\]'):
        encode(0, (1.0, 2.0), (1.0,), (1.0, 2.0))
    with pytest.raises(CdrError, match=r'must hold \[2, 2, 2\] numbers, got \[2, 0, 0\]'):
        encode(0, (1.0, 2.0))
    with pytest.raises(CdrError, match='32 bits of seconds'):
        encode(2 ** 63, (1.0, 2.0), (1.0, 2.0), (1.0, 2.0))


def test_fast_decoder_follows_a_change_of_layout() -> None:
    """Names in another order, of equal length, are not mistaken for the old ones."""
    decode = JointStateDecoder()
    for names in (('a', 'b'), ('b', 'a'), ('a', 'b', 'c'), ('a', 'b')):
        message = encode_joint_state(5, 'f', names, range(len(names)))
        for _ in range(2):
            assert_same_state(decode(message), (5, 'f', names, range(len(names)), [], []))


def test_fast_decoder_refuses_absurd_sizes() -> None:
    """A message of a million joints is refused before it is looked at."""
    with pytest.raises(CdrError, match='must not exceed'):
        JointStateDecoder()(bytes(2 ** 21))


def test_padding_is_not_structure() -> None:
    """ROS leaves what it finds in the padding: that must not cost the fast path."""
    message = encode_joint_state(5, 'ab', ('a', 'b'), (1.0, 2.0))
    dirty = bytearray(message)
    for at in (19, 30, 31, 38, 39):
        assert dirty[at] == 0
        dirty[at] = 0xEE
    _, layout = read_joint_state(message)
    assert layout.fits(bytes(dirty)) and not layout.fits(message[:28] + b'c' + message[29:])
    assert_same_samples(decode_joint_states([message, bytes(dirty)]),
                        decode_joint_states([message, message]))


def test_big_endian_is_read() -> None:
    """A message in the other byte order gives the same values, alone and in bulk."""
    message = encode_joint_state(3 * 10 ** 9 + 5, '', ('abc', 'def'), (1.5, -2.5))
    turned = big_endian(message)
    decode = JointStateDecoder()
    for state in (decode_joint_state(turned), decode(turned), decode(turned)):
        assert_same_state(state, (3 * 10 ** 9 + 5, '', ('abc', 'def'), (1.5, -2.5), [], []))
    assert_same_samples(decode_joint_states([turned] * 3), decode_joint_states([message] * 3))


def test_bulk_equals_single_messages() -> None:
    """Arrays of a recording hold what the messages hold one by one."""
    messages = some_states(NAMES, 50)
    samples = decode_joint_states(messages)
    assert samples.names == NAMES
    for row, message in enumerate(messages):
        state = decode_joint_state(message)
        assert samples.stamps[row] == state.stamp_ns
        np.testing.assert_array_equal(samples.position[row], state.position)
        np.testing.assert_array_equal(samples.velocity[row], state.velocity)
        np.testing.assert_array_equal(samples.effort[row], state.effort)


@pytest.mark.parametrize('layouts', [2, 40])
def test_changing_layouts_give_the_same_as_one_layout(layouts: int) -> None:
    """Two drivers on a topic, or names that never settle, end in the columns they belong to."""
    rng = np.random.default_rng(layouts)
    orders = [rng.permutation(5)[:rng.integers(1, 6)] for _ in range(layouts)]
    names = np.array(['a', 'b', 'c', 'd', 'e'])
    numbers = rng.normal(size=(200, 5))
    chosen = [orders[n % layouts] for n in range(200)]
    samples = decode_joint_states([
        encode_joint_state(n, '', names[order], numbers[n, order])
        for n, order in enumerate(chosen)])
    for n, order in enumerate(chosen):
        row = dict(zip(samples.names, samples.position[n]))
        expected = dict(zip(names[order], numbers[n, order]))
        assert {k: v for k, v in row.items() if not np.isnan(v)} == expected
    assert np.isnan(samples.velocity).all()
    np.testing.assert_array_equal(samples.stamps, range(200))


@given(st.lists(joint_states(), max_size=6))
def test_bulk_of_anything_equals_single_messages(states: list[tuple]) -> None:
    """Any mixture of messages gives for every name its value or NaN."""
    samples = decode_joint_states([encode_joint_state(*state) for state in states])
    for n, (stamp, _, names, *arrays) in enumerate(states):
        assert samples.stamps[n] == stamp
        for values, columns in zip(arrays, (samples.position, samples.velocity, samples.effort)):
            expected = dict(zip(names, values or [np.nan] * len(names)))
            wanted = [expected.get(name, np.nan) for name in samples.names]
            np.testing.assert_array_equal(columns[n], wanted)


def test_bulk_encoding_equals_single_messages() -> None:
    """Arrays become the same bytes as messages made one by one."""
    messages = some_states(NAMES, 20, start=-5)
    samples = decode_joint_states(messages)
    assert [row.tobytes() for row in encode_joint_rows(samples)] == messages
    wrenches = WrenchSamples(
        np.array([-1, 2 * 10 ** 9]), 'tool', np.eye(3)[:2], np.full((2, 3), np.nan))
    rows = encode_wrench_rows(wrenches)
    assert [row.tobytes() for row in rows] == [
        encode_wrench(int(stamp), 'tool', force, torque)
        for stamp, force, torque in zip(wrenches.stamps, wrenches.force, wrenches.torque)]
    np.testing.assert_array_equal(decode_wrenches(list(rows)).force, wrenches.force)


def test_no_messages_are_no_samples() -> None:
    """An empty recording is a valid one."""
    assert len(decode_joint_states([])) == len(decode_wrenches([])) == 0


@pytest.mark.parametrize('messages, error', [
    ([b''], 'message 0: .* got nothing'),
    ([b'\x07\x01\x00\x00'], 'message 0: .* got 07 01 00 00'),
    (some_states(('a',), 2) + [b'\0\1\0\0\0\0'], 'message 2: stamp needs 8 bytes'),
    ([encode_joint_state(0, '', ('a', 'b'), (1.0,))], 'position has 1 values for 2 names'),
    ([encode_joint_state(0, '', ('a', 'a'), (1.0, 2.0))], 'named twice'),
    ([encode_joint_state(0, '', ('a',), (1.0,)) + bytes(16)], '16 bytes follow the end'),
    ([encode_joint_state(0, '', ('a',), ())[:-12] + b'\xff\xff\xff\xff'], 'position needs'),
    ([encode_joint_state(0, '', [f'j{n}' for n in range(1001)], ())], 'names 1001 joints, more'),
    ([encode_joint_state(0, '', [f'{n}_{m}' for m in range(200)], ()) for n in range(6)],
     'name more than 1000 joints'),
    ([encode_joint_state(0, '', [str(n)], ()) for n in range(900)] * 20,
     'joints change from message'),
    ([encode_wrench(0, 'base', np.ones(3), np.ones(3))], 'velocity needs'),
    ([encode_joint_state(0, '', (), ())[:20] + b'\0\0\0\1'], 'more than the message has room for'),
])
def test_broken_joint_states_are_named(messages: list[bytes], error: str) -> None:
    """Each kind of damage gives one sentence that says where it is."""
    with pytest.raises(CdrError, match=error):
        decode_joint_states(messages)


def test_wrenches_in_two_frames_are_refused() -> None:
    """Forces of two frames are no one signal."""
    vectors = np.zeros(3), np.zeros(3)
    with pytest.raises(CdrError, match="message 1 is in the frame 'tool', .* 'base'"):
        decode_wrenches([encode_wrench(0, 'base', *vectors), encode_wrench(0, 'tool', *vectors)])


@pytest.mark.parametrize('arguments, error', [
    ((0, '', ('a\0b',), (1.0,)), 'zero byte'),
    ((0, '\ud800', ('a',), (1.0,)), 'must be Unicode text'),
    ((2 ** 62, '', ('a',), (1.0,)), '32 bits of seconds'),
])
def test_what_ros_cannot_carry_is_refused(arguments: tuple, error: str) -> None:
    """A text that ROS would cut, or a stamp that it would wrap, is an error."""
    with pytest.raises(CdrError, match=error):
        encode_joint_state(*arguments)


@given(st.data())
def test_mutated_messages_are_decoded_or_refused(data: st.DataObject) -> None:
    """Flipped, cut and appended bytes give a value or a CdrError, in every decoder."""
    source = data.draw(st.sampled_from([
        *some_states(('a', 'b'), 2), encode_wrench(1, 'base', (1, 2, 3), (4, 5, 6)),
        encode_string('text')]))
    message = bytearray(source)
    for _ in range(data.draw(st.integers(0, 4))):
        message[data.draw(st.integers(0, len(message) - 1))] = data.draw(st.integers(0, 255))
    mutant = bytes(message[:data.draw(st.integers(0, len(message)))])
    mutant += data.draw(st.binary(max_size=9))
    fast = JointStateDecoder()
    fast(some_states(('a', 'b'), 1)[0])
    for decode in (decode_joint_state, decode_wrench, decode_string, fast,
                   lambda m: decode_joint_states([m, source, m]),
                   lambda m: decode_wrenches([m, source])):
        try:
            decode(mutant)
        except CdrError as error:
            assert '\n' not in str(error)


def test_a_batch_gives_its_messages_back() -> None:
    """Messages of any size lie in the buffer where the batch says."""
    messages = [b'abc', b'', b'de']
    batch = batch_of(messages)
    assert [batch.message(n) for n in range(3)] == messages
