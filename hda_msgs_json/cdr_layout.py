"""Where the numbers of a JointState or a WrenchStamped lie: found once, checked ever after."""

from collections.abc import Sequence
from functools import cached_property, lru_cache
from typing import NamedTuple

from hda_msgs_json.cdr_fields import CdrError, Doubles, FieldReader, FieldWriter, LITTLE_ENDIAN
import numpy as np
from numpy.typing import ArrayLike, NDArray

STAMP_AT = 4
"""Where the eight bytes of the stamp of every message with a header start."""
ALL_BITS = np.uint64(2 ** 64 - 1)


class JointState(NamedTuple):
    """Hold one JointState: stamp [ns], arrays (k,) or empty where the message has none."""

    stamp_ns: int
    frame_id: str
    names: tuple[str, ...]
    position: NDArray[np.float64]
    velocity: NDArray[np.float64]
    effort: NDArray[np.float64]

    @property
    def numbers(self) -> tuple[NDArray[np.float64], ...]:
        """Return the arrays in the order of the message."""
        return self.position, self.velocity, self.effort


class Wrench(NamedTuple):
    """Hold one WrenchStamped: stamp [ns], force [N] (3,), torque [N*m] (3,)."""

    stamp_ns: int
    frame_id: str
    force: NDArray[np.float64]
    torque: NDArray[np.float64]

    @property
    def numbers(self) -> tuple[NDArray[np.float64], ...]:
        """Return the vectors in the order of the message."""
        return self.force, self.torque


class Layout:
    """
    Separate the numbers of a message from its structure.

    Two messages have the same layout when all their counts and texts are equal. Then their numbers
    mean the same and lie in the same place. A mask leaves time, numbers and padding out of the
    comparison. It serves all bytes of one message at once, or many messages word by word.
    """

    def __init__(
            self, message: bytes, structure: Sequence[slice], doubles: Sequence[Doubles]) -> None:
        """Remember the structure of a message that has been read."""
        self.size = len(message)
        self.doubles = tuple(doubles)
        self.little_endian = message[:2] == LITTLE_ENDIAN[:2]
        self._message = message
        self._structure = structure

    def fits(self, message: bytes) -> bool:
        """Return whether a message has this layout, and its numbers are little-endian."""
        mask, value = self._masked
        return (len(message) == self.size and self.little_endian
                and int.from_bytes(message, 'little') & mask == value)

    def fit(self, records: NDArray[np.void]) -> NDArray[np.bool_]:
        """Return which of many messages of the same size have this layout (n,)."""
        fits = np.ones(len(records), bool)
        for word in self._words:
            found = records[word.name]
            fits &= (found if word.mask == ALL_BITS else found & word.mask) == word.value
        return fits

    @cached_property
    def record(self) -> np.dtype[np.void]:
        """Return the message as fields: its time, its numbers, and the words of its structure."""
        fields: dict[str, tuple[object, int]] = {
            'seconds': ('<i4', STAMP_AT), 'nanoseconds': ('<u4', STAMP_AT + 4)}
        for index, part in enumerate(self.doubles):
            fields[f'numbers{index}'] = (('<f8', (part.count,)), part.start)
            fields[f'bytes{index}'] = (f'V{8 * part.count}', part.start)
        for word in self._words:
            fields[word.name] = ('<u8', word.start)
        return np.dtype({
            'names': list(fields), 'formats': [kind for kind, _ in fields.values()],
            'offsets': [start for _, start in fields.values()], 'itemsize': self.size})

    @cached_property
    def _mask(self) -> NDArray[np.uint8]:
        mask = np.zeros(self.size, np.uint8)
        for part in self._structure:
            mask[part] = 0xFF
        return mask

    @cached_property
    def _masked(self) -> tuple[int, int]:
        """Return the mask and what it leaves of the message as one number each."""
        mask = int.from_bytes(self._mask.tobytes(), 'little')
        return mask, int.from_bytes(self._message, 'little') & mask

    @property
    def _words(self) -> tuple['_Word', ...]:
        mask, value = self._masked
        return _words(*(number.to_bytes(self.size, 'little') for number in (mask, value)))


class _Word(NamedTuple):
    """Compare eight bytes of a message with what they should be."""

    name: str
    start: int
    mask: np.uint64
    value: np.uint64


@lru_cache
def _words(mask: bytes, message: bytes) -> tuple[_Word, ...]:
    """Return words that together compare every byte that the mask keeps."""
    words, covered = [], 0
    masks, values = np.frombuffer(mask, np.uint8), np.frombuffer(message, np.uint8)
    for at in np.flatnonzero(masks).tolist():
        if at >= covered:
            start = min(at, len(mask) - 8)
            covered = start + 8
            words.append(_Word(f'word{start}', start, *(
                part[start:covered].view('<u8')[0] for part in (masks, values))))
    return tuple(words)


def read_joint_state(message: bytes) -> tuple[JointState, Layout]:
    """Read a JointState and find its layout; raise CdrError if the bytes are not one."""
    fields = FieldReader(message)
    stamp, frame_id = fields.stamp(), fields.string('frame_id')
    names = fields.strings('name')
    doubles = [fields.doubles(what) for what in ('position', 'velocity', 'effort')]
    fields.finish()
    values = [fields.values(part) for part in doubles]
    layout = Layout(message, fields.structure, doubles)
    return JointState(stamp, frame_id, names, *values), layout


def read_wrench(message: bytes) -> tuple[Wrench, Layout]:
    """Read a WrenchStamped and find its layout; raise CdrError if the bytes are not one."""
    fields = FieldReader(message)
    stamp, frame_id = fields.stamp(), fields.string('frame_id')
    doubles = [fields.doubles(what, 3) for what in ('force', 'torque')]
    fields.finish()
    force, torque = (fields.values(part) for part in doubles)
    return Wrench(stamp, frame_id, force, torque), Layout(message, fields.structure, doubles)


def encode_joint_state(
        stamp_ns: int, frame_id: str, names: Sequence[str], position: ArrayLike,
        velocity: ArrayLike = (), effort: ArrayLike = ()) -> bytes:
    """Return the bytes of a JointState; raise CdrError if ROS could not carry it."""
    fields = FieldWriter()
    fields.stamp(stamp_ns)
    fields.string(frame_id, 'frame_id')
    fields.uint32(len(names))
    for name in names:
        fields.string(name, 'name')
    for values in (position, velocity, effort):
        numbers = np.asarray(values, np.float64).ravel()
        fields.uint32(len(numbers))
        fields.doubles(numbers)
    return bytes(fields)


def encode_wrench(stamp_ns: int, frame_id: str, force: ArrayLike, torque: ArrayLike) -> bytes:
    """Return the bytes of a WrenchStamped: force [N] (3,), torque [N*m] (3,)."""
    fields = FieldWriter()
    fields.stamp(stamp_ns)
    fields.string(frame_id, 'frame_id')
    for what, values in (('force', force), ('torque', torque)):
        vector = np.asarray(values, np.float64)
        if vector.shape != (3,):
            raise CdrError(f'{what} must have three components, got the shape {vector.shape}')
        fields.doubles(vector)
    return bytes(fields)
