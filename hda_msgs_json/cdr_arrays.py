"""
Many messages at once: JointStates and WrenchStampeds to arrays and back.

Messages of one layout are the rows of a matrix of bytes, and their numbers are columns of it. A
recording with a few layouts (two drivers on one topic) is decoded layout by layout, one with many
falls back to the field-by-field reader. The result is the same in every case.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Generic, TypeVar

from hda_msgs_json.cdr_batch import Batch, batch_of, by_layout, MessageBlock, stamps_of
from hda_msgs_json.cdr_fields import CdrError, NANOSECONDS
from hda_msgs_json.cdr_layout import (
    encode_joint_state, encode_wrench, JointState, Layout, read_joint_state, read_wrench, Wrench)
from hda_msgs_json.samples import (
    join_joint_samples, JointSamples, MOST_NAMES, SamplesError, WrenchSamples)
from hda_msgs_json.strided import Bytes, structures
import numpy as np

LITTLE_ENDIAN = np.dtype('<f8')

Samples = TypeVar('Samples', JointSamples, WrenchSamples)


@dataclass(frozen=True)
class ArrayLayout(Generic[Samples]):
    """Know the layout of messages, and how to make arrays for many of them."""

    layout: Layout
    row_size: int
    room: Callable[[int], Samples]


def decode_joint_states(messages: Sequence[bytes | memoryview]) -> JointSamples:
    """Return the messages as arrays; raise CdrError if one is not a sound JointState."""
    return decode_joint_batch(batch_of(messages))


def decode_wrenches(messages: Sequence[bytes | memoryview]) -> WrenchSamples:
    """Return the messages as arrays; raise CdrError if one is not a WrenchStamped."""
    return decode_wrench_batch(batch_of(messages))


def decode_joint_batch(batch: Batch, number: int = 0) -> JointSamples:
    """
    Return a batch of JointStates as arrays, the names in the order of their appearance.

    Errors count the messages from the given number on.
    """
    blocks = list(by_layout(batch, number, read_joint_state, _check_joint_state))
    if len(blocks) == 1:
        return _joint_samples(blocks[0])
    try:
        samples = join_joint_samples([_joint_samples(block) for block in blocks])
    except SamplesError as error:
        raise CdrError(str(error)) from None
    chosen = np.concatenate([np.empty(0, np.int64), *(block.chosen for block in blocks)])
    return samples.rows(np.argsort(chosen))


def decode_wrench_batch(batch: Batch, number: int = 0) -> WrenchSamples:
    """
    Return a batch of WrenchStampeds as arrays; raise CdrError if their frames differ.

    Errors count the messages from the given number on.
    """
    stamps = np.zeros(len(batch.starts), np.int64)
    force, torque = np.zeros((2, len(stamps), 3))
    frame_id = None
    for block in by_layout(batch, number, read_wrench, _check_nothing):
        frame_id = block.first.frame_id if frame_id is None else frame_id
        if block.first.frame_id != frame_id:
            raise CdrError(
                f'message {number + block.chosen[0]} is in the frame {block.first.frame_id!r}, '
                f'those before it in {frame_id!r}')
        stamps[block.chosen] = block.stamps
        force[block.chosen], torque[block.chosen] = block.numbers
    return WrenchSamples(stamps, frame_id or '', force, torque)


def joint_form(message: bytes) -> ArrayLayout[JointSamples]:
    """Return what a JointState shows of others like it; raise CdrError if it is not sound."""
    state, layout = read_joint_state(message)
    _check_joint_state(state)

    def room(count: int) -> JointSamples:
        position, velocity, effort = np.empty((3, count, len(state.names)))
        return JointSamples(np.empty(count, np.int64), state.names, position, velocity, effort,
                            state.frame_id)

    return ArrayLayout(layout, 8 + 24 * len(state.names), room)


def wrench_form(message: bytes) -> ArrayLayout[WrenchSamples]:
    """Return what a WrenchStamped shows of others like it; raise CdrError if it is none."""
    wrench, layout = read_wrench(message)

    def room(count: int) -> WrenchSamples:
        force, torque = np.empty((2, count, 3))
        return WrenchSamples(np.empty(count, np.int64), wrench.frame_id, force, torque)

    return ArrayLayout(layout, 56, room)


def fill(layout: Layout, batch: Batch, samples: JointSamples | WrenchSamples) -> bool:
    """Put messages into samples if there are as many and all have the layout, and say so."""
    if (len(batch.starts) != len(samples) or not layout.little_endian
            or not (batch.sizes == layout.size).all()):
        return False
    records = structures(batch.buffer, batch.starts, layout.record)
    if not layout.fit(records).all():
        return False
    samples.stamps[:] = stamps_of(records)
    for index, values in enumerate(samples.numbers):
        if not layout.doubles[index].count:
            values[:] = np.nan
        elif values.dtype == LITTLE_ENDIAN and values.flags.c_contiguous:
            values.view(f'V{8 * values.shape[1]}')[:, 0] = records[f'bytes{index}']
        else:
            values[:] = records[f'numbers{index}']
    return True


def encode_joint_rows(samples: JointSamples, room: int = 0) -> Bytes:
    """Return the bytes of the messages (n, room + size), all of one layout, behind some room."""
    counts = tuple(values.shape[1] for values in samples.numbers)
    return _fill(*_joint_template(samples.frame_id, samples.names, counts), samples, room)


def encode_wrench_rows(samples: WrenchSamples, room: int = 0) -> Bytes:
    """Return the bytes of the messages (n, room + size), all of one layout, behind some room."""
    return _fill(*_wrench_template(samples.frame_id), samples, room)


@lru_cache
def _joint_template(frame_id: str, names: tuple[str, ...],
                    counts: tuple[int, ...]) -> tuple[bytes, Layout]:
    message = encode_joint_state(0, frame_id, names, *map(np.zeros, counts))
    return message, read_joint_state(message)[1]


@lru_cache
def _wrench_template(frame_id: str) -> tuple[bytes, Layout]:
    message = encode_wrench(0, frame_id, np.zeros(3), np.zeros(3))
    return message, read_wrench(message)[1]


def _joint_samples(block: MessageBlock[JointState]) -> JointSamples:
    """Return the messages of one layout as arrays; what they lack is NaN."""
    names = block.first.names
    position, velocity, effort = (
        np.ascontiguousarray(values) if values.shape[1] else np.full(
            (len(values), len(names)), np.nan) for values in block.numbers)
    return JointSamples(
        block.stamps, names, position, velocity, effort, block.first.frame_id)


def _check_joint_state(state: JointState) -> None:
    """Raise CdrError unless each array is empty or has one value per name."""
    if len(state.names) > MOST_NAMES:
        raise CdrError(f'it names {len(state.names)} joints, more than {MOST_NAMES}')
    if len(set(state.names)) < len(state.names):
        raise CdrError(f'a joint is named twice in {state.names}')
    for what, values in zip(('position', 'velocity', 'effort'), state.numbers):
        if len(values) not in (0, len(state.names)):
            raise CdrError(f'{what} has {len(values)} values for {len(state.names)} names')


def _check_nothing(wrench: Wrench) -> None:
    """Accept every wrench: its length is fixed."""


def _fill(message: bytes, layout: Layout, samples: JointSamples | WrenchSamples,
          room: int) -> Bytes:
    """Return a message once per stamp with its stamp and its numbers filled in."""
    stamps = samples.stamps
    seconds, nanoseconds = np.divmod(stamps, NANOSECONDS)
    if len(stamps) and not np.array_equal(seconds, seconds.astype(np.int32)):
        raise CdrError(
            f'stamps must fit in 32 bits of seconds, got {stamps.min()} to {stamps.max()} ns')
    rows = np.tile(np.frombuffer(bytes(room) + message, np.uint8), (len(stamps), 1))
    records = rows[:, room:].view(layout.record)[:, 0]
    records['seconds'], records['nanoseconds'] = seconds, nanoseconds
    for index, values in enumerate(samples.numbers):
        if values.size:
            plain = np.ascontiguousarray(values, LITTLE_ENDIAN)
            records[f'bytes{index}'] = plain.view(f'V{8 * values.shape[1]}')[:, 0]
    return rows
