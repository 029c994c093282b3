"""
JointState, WrenchStamped, String and Float64 as CDR bytes, one message at a time.

`JointStateDecoder`, `JointStateEncoder` and `WrenchEncoder` are the fast paths of the nodes. They
learn the layout of a message once and touch only its stamp and its numbers afterwards. Whole
recordings go through `decode_joint_states` and its like, re-exported from `cdr_arrays`.
"""

from collections.abc import Sequence
import struct

from hda_msgs_json.cdr_arrays import decode_joint_states, decode_wrenches
from hda_msgs_json.cdr_fields import (
    CdrError, FieldReader, FieldWriter, LITTLE_ENDIAN, pack_stamp)
from hda_msgs_json.cdr_layout import (
    encode_joint_state, encode_wrench, JointState, Layout, read_joint_state, read_wrench, STAMP_AT,
    Wrench)
import numpy as np
from numpy.typing import NDArray

__all__ = [
    'CdrError', 'decode_joint_state', 'decode_joint_states', 'decode_number', 'decode_string',
    'decode_wrench', 'decode_wrenches', 'encode_joint_state', 'encode_number', 'encode_string',
    'encode_wrench', 'JointState', 'JointStateDecoder', 'JointStateEncoder', 'Wrench',
    'WrenchEncoder']

LARGEST_JOINT_STATE = 1 << 20
"""Bytes of the largest JointState that a node looks at: thousands of joints."""

STAMP = struct.Struct('<iI')
"""The stamp of a little-endian message with a header, at `STAMP_AT`."""
DOUBLE = np.dtype('<f8')
NUMBER = struct.Struct('<4sd')
"""A whole little-endian Float64."""
WORD = 4


def decode_joint_state(message: bytes) -> JointState:
    """Return a JointState; velocity and effort may be empty. Raise CdrError if it is not one."""
    return read_joint_state(message)[0]


def decode_wrench(message: bytes) -> Wrench:
    """Return a WrenchStamped; raise CdrError if the bytes are not one."""
    return read_wrench(message)[0]


def decode_string(message: bytes) -> str:
    """Return the text of a String; raise CdrError if the bytes are not one."""
    fields = FieldReader(message)
    text = fields.string('data')
    fields.finish()
    return text


def encode_string(text: str) -> bytes:
    """
    Return the bytes of a String; raise CdrError if ROS could not carry the text.

    They are filled up with zeros to whole words, as DDS does on the way to who hears them.
    """
    fields = FieldWriter()
    fields.string(text, 'data')
    message = bytes(fields)
    return message + bytes(-len(message) % WORD)


def decode_number(message: bytes) -> float:
    """Return the number of a Float64; raise CdrError if the bytes are not one."""
    fields = FieldReader(message)
    number = fields.values(fields.doubles('data', 1))
    fields.finish()
    return float(number[0])


def encode_number(number: float) -> bytes:
    """Return the bytes of a Float64."""
    return NUMBER.pack(LITTLE_ENDIAN, number)


class JointStateDecoder:
    """Decode a stream of JointStates that keep their layout, with a check of every message."""

    def __init__(self) -> None:
        """Learn the layout from the first message."""
        self._layout: Layout | None = None
        self._names: tuple[str, ...] = ()
        self._frame_id = ''

    def __call__(self, message: bytes) -> JointState:
        """Return the message, its arrays read-only; raise CdrError if it is not a JointState."""
        layout = self._layout
        if layout is None or not layout.fits(message):
            return self._learn(message)
        seconds, nanoseconds = STAMP.unpack_from(message, STAMP_AT)
        position, velocity, effort = (
            np.frombuffer(message, DOUBLE, part.count, part.start) for part in layout.doubles)
        return JointState(
            seconds * 1_000_000_000 + nanoseconds, self._frame_id, self._names,
            position, velocity, effort)

    def _learn(self, message: bytes) -> JointState:
        if len(message) > LARGEST_JOINT_STATE:
            raise CdrError(
                f'a JointState must not exceed {LARGEST_JOINT_STATE} bytes, got {len(message)}')
        state, self._layout = read_joint_state(message)
        self._names, self._frame_id = state.names, state.frame_id
        return state


class JointStateEncoder:
    """Encode JointStates of fixed names, each with the same of its three arrays."""

    def __init__(
            self, names: Sequence[str], frame_id: str = '', *, position: bool = True,
            velocity: bool = True, effort: bool = True) -> None:
        """Prepare the bytes; the flags say which arrays the messages carry."""
        zeros, empty = np.zeros(len(names)), np.empty(0)
        message = encode_joint_state(
            0, frame_id, names, *(zeros if used else empty for used in
                                  (position, velocity, effort)))
        self._fill = _Filler(message, read_joint_state(message)[1])

    def __call__(
            self, stamp_ns: int, position: Sequence[float] | NDArray[np.float64] = (),
            velocity: Sequence[float] | NDArray[np.float64] = (),
            effort: Sequence[float] | NDArray[np.float64] = ()) -> bytes:
        """Return the bytes of one message; raise CdrError if a length does not fit."""
        return self._fill(stamp_ns, position, velocity, effort)


class WrenchEncoder:
    """Encode WrenchStampeds of a fixed frame."""

    def __init__(self, frame_id: str) -> None:
        """Prepare the bytes."""
        message = encode_wrench(0, frame_id, np.zeros(3), np.zeros(3))
        self._fill = _Filler(message, read_wrench(message)[1])

    def __call__(
            self, stamp_ns: int, force: Sequence[float] | NDArray[np.float64],
            torque: Sequence[float] | NDArray[np.float64]) -> bytes:
        """Return the bytes of one message: force [N] (3,), torque [N*m] (3,)."""
        return self._fill(stamp_ns, force, torque)


class _Filler:
    """Fill the stamp and the numbers of a message, all in one step."""

    def __init__(self, message: bytes, layout: Layout) -> None:
        self._counts = [part.count for part in layout.doubles]
        self._head = message[:STAMP_AT]
        begins = [STAMP_AT + STAMP.size, *(part.stop for part in layout.doubles)]
        self._between = [message[begin:part.start]
                         for begin, part in zip(begins, layout.doubles)]
        self._struct = struct.Struct(f'<{STAMP_AT}siI' + ''.join(
            f'{len(between)}s{count}d' for between, count in zip(self._between, self._counts)))

    def __call__(
            self, stamp_ns: int, *arrays: Sequence[float] | NDArray[np.float64]) -> bytes:
        values = [self._head, *divmod(stamp_ns, 1_000_000_000)]
        for between, array in zip(self._between, arrays):
            values.append(between)
            values.extend(array)
        try:
            return self._struct.pack(*values)
        except struct.error:
            pack_stamp(stamp_ns)
            raise CdrError(
                f'the arrays of this message must hold {self._counts} numbers, '
                f'got {[len(array) for array in arrays]}') from None
