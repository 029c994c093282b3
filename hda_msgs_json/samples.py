"""Recorded messages as arrays: one row per message, time in integer nanoseconds."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

from hda_msgs_json.errors import HdaError
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Stamps = NDArray[np.int64]


MOST_NAMES = 1000
"""More joints than this on one topic are a broken recording, and would not fit in memory."""
THINNEST = 16
"""More places for numbers than this many times the numbers are a broken recording too."""
FEW = 1_000_000
"""So many places are never too many."""


class SamplesError(HdaError):
    """Raised when samples do not fit together or lack what is asked of them."""


@dataclass(frozen=True, eq=False)
class JointSamples:
    """
    Hold JointState messages: stamps [ns] (n,), a column per name in the arrays (n, k).

    Position [rad], velocity [rad/s] and effort [N*m] are NaN where a message had no value. They
    have no columns (n, 0) where messages shall be written without that array.
    """

    stamps: Stamps
    names: tuple[str, ...]
    position: Floats
    velocity: Floats
    effort: Floats
    frame_id: str = ''

    def __post_init__(self) -> None:
        """Raise SamplesError unless all arrays have one row per stamp and a column per name."""
        expected = (len(self.stamps), len(self.names))
        for field in ('position', 'velocity', 'effort'):
            shape = getattr(self, field).shape
            if shape not in (expected, (len(self.stamps), 0)):
                raise SamplesError(
                    f'JointSamples.{field} must have the shape {expected} (stamps, names), '
                    f'got {shape}')

    def __len__(self) -> int:
        """Return the number of messages."""
        return len(self.stamps)

    @property
    def numbers(self) -> tuple[Floats, ...]:
        """Return the arrays in the order of the message."""
        return self.position, self.velocity, self.effort

    def rows(self, chosen: slice | Stamps) -> 'JointSamples':
        """Return some of the messages, a view of them for a slice."""
        return JointSamples(
            self.stamps[chosen], self.names, self.position[chosen], self.velocity[chosen],
            self.effort[chosen], self.frame_id)

    def select(self, names: Sequence[str]) -> 'JointSamples':
        """Return the columns of these names in this order; raise SamplesError if one is absent."""
        if missing := [name for name in names if name not in self.names]:
            raise SamplesError(
                f'the joint states have no {_quoted(missing)}; '
                f'they name {_quoted(self.names) or "nothing"}')
        columns = [self.names.index(name) for name in names]
        return JointSamples(
            self.stamps, tuple(names), self.position[:, columns], self.velocity[:, columns],
            self.effort[:, columns], self.frame_id)


@dataclass(frozen=True, eq=False)
class WrenchSamples:
    """Hold WrenchStamped messages: stamps [ns] (n,), force [N] (n, 3), torque [N*m] (n, 3)."""

    stamps: Stamps
    frame_id: str
    force: Floats
    torque: Floats

    def __post_init__(self) -> None:
        """Raise SamplesError unless both arrays have three components per stamp."""
        expected = (len(self.stamps), 3)
        for field in ('force', 'torque'):
            shape = getattr(self, field).shape
            if shape not in (expected, (len(self.stamps), 0)):
                raise SamplesError(
                    f'WrenchSamples.{field} must have the shape {expected} (stamps, x y z), '
                    f'got {shape}')

    def __len__(self) -> int:
        """Return the number of messages."""
        return len(self.stamps)

    @property
    def numbers(self) -> tuple[Floats, ...]:
        """Return the arrays in the order of the message."""
        return self.force, self.torque

    def rows(self, chosen: slice | Stamps) -> 'WrenchSamples':
        """Return some of the messages, a view of them for a slice."""
        return WrenchSamples(
            self.stamps[chosen], self.frame_id, self.force[chosen], self.torque[chosen])


@dataclass(frozen=True, eq=False)
class TextSamples:
    """Hold String messages: log times [ns] (n,), since they have no stamp, and n texts."""

    stamps: Stamps
    texts: tuple[str, ...]

    def __post_init__(self) -> None:
        """Raise SamplesError unless there is one text per stamp."""
        if len(self.stamps) != len(self.texts):
            raise SamplesError(
                f'TextSamples.texts must have one text for each of {len(self.stamps)} stamps, '
                f'got {len(self.texts)}')

    def __len__(self) -> int:
        """Return the number of messages."""
        return len(self.stamps)


@dataclass(frozen=True, eq=False)
class NumberSamples:
    """Hold Float64 messages: log times [ns] (n,), since they have no stamp, and values (n,)."""

    stamps: Stamps
    values: Floats

    def __post_init__(self) -> None:
        """Raise SamplesError unless there is one value per stamp."""
        if self.values.shape != self.stamps.shape:
            raise SamplesError(
                f'NumberSamples.values must have one value for each of {len(self.stamps)} '
                f'stamps, got the shape {self.values.shape}')

    def __len__(self) -> int:
        """Return the number of messages."""
        return len(self.stamps)


def join_joint_samples(parts: Sequence[JointSamples]) -> JointSamples:
    """
    Return the messages of all parts in their order, with the names of all of them.

    Raise SamplesError if the names change so much that the arrays would hold little but NaN.

    The names come in the order in which they first appear, the frame is that of the first message.
    """
    names = tuple(dict.fromkeys(name for part in parts for name in part.names))
    _check_thickness(parts, names)
    stamps = np.concatenate([np.empty(0, np.int64), *(part.stamps for part in parts)])
    position, velocity, effort = (
        _join_columns([(part.names, getattr(part, field)) for part in parts], names)
        for field in ('position', 'velocity', 'effort'))
    return JointSamples(
        stamps, names, position, velocity, effort,
        next((part.frame_id for part in parts if len(part)), ''))


def join_wrench_samples(parts: Sequence[WrenchSamples]) -> WrenchSamples:
    """Return the messages of all parts in their order; raise SamplesError if the frames differ."""
    if len(frames := {part.frame_id for part in parts if len(part)}) > 1:
        raise SamplesError(f'wrenches of one topic must be in one frame, got {_quoted(frames)}')
    return WrenchSamples(
        np.concatenate([np.empty(0, np.int64), *(part.stamps for part in parts)]),
        frames.pop() if frames else '',
        np.concatenate([np.empty((0, 3)), *(part.force for part in parts)]),
        np.concatenate([np.empty((0, 3)), *(part.torque for part in parts)]))


def _check_thickness(parts: Sequence[JointSamples], names: tuple[str, ...]) -> None:
    """Raise SamplesError if the arrays of all parts together would be absurdly large."""
    if len(names) > MOST_NAMES:
        raise SamplesError(
            f'the messages name more than {MOST_NAMES} joints, such as {names[-1]!r}')
    places = sum(map(len, parts)) * len(names)
    numbers = sum(len(part) * len(part.names) for part in parts)
    if places > max(FEW, THINNEST * numbers):
        raise SamplesError(
            f'the joints change from message to message: {len(names)} names in '
            f'{sum(map(len, parts))} messages with {numbers} numbers')


def _join_columns(
        parts: Sequence[tuple[tuple[str, ...], Floats]], names: tuple[str, ...]) -> Floats:
    """Return the rows of all parts with a column per name, NaN where a part lacks it."""
    joined = np.empty((sum(len(values) for _, values in parts), len(names)))
    first = 0
    for present, values in parts:
        rows = joined[first:first + len(values)]
        if present == names:
            rows[:] = values
        else:
            rows[:] = np.nan
            rows[:, [names.index(name) for name in present]] = values
        first += len(values)
    return joined


def _quoted(names: Collection[str]) -> str:
    return ', '.join(repr(name) for name in names)
