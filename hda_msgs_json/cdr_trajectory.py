"""
Read a trajectory_msgs/msg/JointTrajectory from its bytes, point by point.

Generated code makes an object of every number while nothing else runs. This reader lets other
threads run between two points, and knows how many there are before it reads the first.
"""

from typing import NamedTuple

from .cdr_fields import CdrError, FieldReader


class TrajectoryPoints(NamedTuple):
    """Names of joints, and by point: seconds from the start, angles [rad], rates [rad/s]."""

    names: tuple[str, ...]
    times: list[float]
    angles: list[list[float]]
    rates: list[list[float]]


def count_points(message: bytes) -> int:
    """Return how many points a trajectory says that it has; raises CdrError."""
    return _begin(message)[2]


def decode_trajectory(message: bytes) -> TrajectoryPoints:
    """Read a trajectory; raises CdrError for bytes that are none."""
    reader, names, count = _begin(message)
    made = TrajectoryPoints(names, [], [], [])
    for _ in range(count):
        angles, rates, *_ = [reader.doubles(what) for what in (
            'positions', 'velocities', 'accelerations', 'effort')]
        made.angles.append(reader.values(angles).tolist())
        made.rates.append(reader.values(rates).tolist())
        made.times.append(reader.stamp() * 1e-9)
    reader.finish()
    return made


def _begin(message: bytes) -> tuple[FieldReader, tuple[str, ...], int]:
    """Return a reader before the first point, the names and the number of points."""
    reader = FieldReader(message)
    reader.stamp()
    reader.string('frame_id')
    names = reader.strings('joint_names')
    count = reader.uint32('points')
    if count * 24 > len(message):           # four empty sequences and a time each
        raise CdrError(f'points claims {count} entries, more than the message has room for')
    return reader, names, count
