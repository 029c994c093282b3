"""Turn trajectory points into a smooth reference that can be asked at any time."""

from collections.abc import Sequence
from typing import NamedTuple, TYPE_CHECKING

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
from hda_msgs_json.errors import HdaError
import numpy as np

from .followable import within, worst

if TYPE_CHECKING:
    from scipy.interpolate import PPoly

# Choices unless stated otherwise.
LARGEST_STEP = 0.05     # of the reference at its first point [rad]
MOST_POINTS = 100_000   # eight minutes at 200 Hz; read and checked in seconds, in a thread
_TICK, _LONGEST = 1e-9, 2.0 ** 31     # what a duration of ROS can say [s]
_ENDS = 1e-3            # rate at the last point that is rest, as rounded as people write [rad/s]


class TrajectoryError(HdaError):
    """A trajectory that the arm cannot follow."""


class Reference:
    """
    A reference of the link angles over time since its start; it holds its last point.

    Cubic in every piece: through given velocities, or with the shape-preserving slopes of
    Fritsch and Carlson where none are given, which do not overshoot. Without velocities it ends
    at rest, and begins with `begin`.
    """

    def __init__(self, times: Array, angles: Array, rates: Array | None = None, *,
                 begin: Array | None = None) -> None:
        """Join points at `times` (k,) [s], `angles` (k, n) [rad], `rates` (k, n) [rad/s]."""
        self.end = float(times[-1])
        self._held = angles[-1]
        self.curve: PPoly | None = None
        if len(times) > 1:
            from scipy.interpolate import CubicHermiteSpline    # slow, and few need it
            with np.errstate(all='ignore'):     # what overflows is no reference for any arm
                slopes = _slopes(times, angles, begin) if rates is None else rates
                self.curve = CubicHermiteSpline(times, angles, slopes)
                self._slope = self.curve.derivative()

    def at(self, time: float) -> Array:
        """Return link angles and rates (n, 2) at a time since the start [rad, rad/s]."""
        if self.curve is None or time >= self.end:
            return np.stack([self._held, np.zeros_like(self._held)], axis=1)
        time = max(time, 0.0)
        return np.stack([self.curve(time), self._slope(time)], axis=1)


def hold(angles: Array) -> Reference:
    """Return a reference that stays at these link angles (n,) [rad]."""
    return Reference(np.zeros(1), np.asarray(angles, float)[None, :])


class Way(NamedTuple):
    """Points that an arm may be sent to: seconds (k,), link angles and rates (k, n) if given."""

    moments: Array
    path: Array
    slopes: Array | None


def reference_from(arm: Arm, names: Sequence[str], times: Sequence[float],
                   angles: Sequence[Sequence[float]], rates: Sequence[Sequence[float]],
                   now: Array) -> Reference:
    """
    Return the reference of trajectory points that starts where the arm's reference is now.

    `names` may stand in any order; rates may be empty for all points. `now` (n, 2) is the
    present reference. Raises TrajectoryError naming what cannot be followed, at the points or
    between them.
    """
    return joined(arm, way_of(arm, names, times, angles, rates), now)


def way_of(arm: Arm, names: Sequence[str], times: Sequence[float],
           angles: Sequence[Sequence[float]], rates: Sequence[Sequence[float]]) -> Way:
    """Return trajectory points that are well formed and within the limits; as `reference_from`."""
    if len(times) > MOST_POINTS:
        raise too_many(len(times))
    order = _order(arm, names)
    moments = _times(times)
    path = _table(angles, 'positions', len(moments), order)
    given = any(len(row) for row in rates)
    slopes = _table(rates, 'velocities', len(moments), order) if given else None
    _check_limits(arm, path)
    if slopes is not None and np.abs(slopes[-1]).max() > _ENDS:
        raise TrajectoryError('the last point must have velocities of 0, for the arm stays there, '
                              f'got {", ".join(f"{rate:g}" for rate in slopes[-1])} rad/s')
    return Way(moments, path, slopes)


def too_many(points: int) -> TrajectoryError:
    """Return the error of a trajectory with too many points."""
    return TrajectoryError(f'a trajectory may have {MOST_POINTS} points, got {points}; '
                           'send it in parts, or with fewer points')


def joined(arm: Arm, way: Way, now: Array, *, pieces: int | None = None) -> Reference:
    """
    Return the reference along a way from `now` (n, 2); raises TrajectoryError as above.

    With `pieces` only so many are checked: the others do not depend on where it begins.
    """
    moments, path, slopes = way
    if moments[0] > 0.0:
        moments = np.insert(moments, 0, 0.0)
        path = np.vstack([now[:, 0], path])
        slopes = None if slopes is None else np.vstack([now[:, 1], slopes])
    elif np.abs(path[0] - now[:, 0]).max() > LARGEST_STEP:
        raise TrajectoryError(
            f'the first point, at time 0, is {np.abs(path[0] - now[:, 0]).max():.3g} rad from the '
            f'present reference; it must be within {LARGEST_STEP} rad, or have a later time')
    made = Reference(moments, path, slopes, begin=now[:, 1])
    beyond = None if made.curve is None else worst(arm, made.curve, pieces)
    if beyond is not None:
        raise TrajectoryError(f'the arm cannot follow the trajectory; {beyond}')
    return made


def _slopes(times: Array, angles: Array, begin: Array | None) -> Array:
    """Return rates (k, n) that do not overshoot, from a rate `begin` (n,) to rest [rad/s]."""
    from scipy.interpolate import PchipInterpolator     # slow, and few need it
    slopes = np.asarray(PchipInterpolator(times, angles).derivative()(times))
    slopes[0] = 0.0 if begin is None else begin
    slopes[-1] = 0.0
    return slopes


def _order(arm: Arm, names: Sequence[str]) -> list[int]:
    if sorted(names) != sorted(arm.labels):
        raise TrajectoryError(f'joint_names must be {", ".join(arm.labels)} in any order, got '
                              f'{", ".join(names) or "none"}')
    return [list(names).index(label) for label in arm.labels]


def _times(times: Sequence[float]) -> Array:
    moments = np.asarray(times, float)
    if not len(moments):
        raise TrajectoryError('a trajectory needs at least one point, got none')
    steps = np.diff(moments, prepend=-_TICK)
    if not (moments[0] >= 0.0 and np.all(steps >= 0.5 * _TICK) and moments[-1] < _LONGEST):
        raise TrajectoryError('time_from_start must begin at 0 or later and grow from point to '
                              f'point, got {", ".join(f"{t:g}" for t in moments[:8])}')
    return moments


def _table(rows: Sequence[Sequence[float]], what: str, points: int, order: list[int]) -> Array:
    for index, row in enumerate(rows):
        if len(row) != len(order):
            raise TrajectoryError(f'point {index} must have {len(order)} {what}, got {len(row)}')
    table = np.array(rows, float).reshape(points, len(order))[:, order]
    if not np.isfinite(table).all():
        raise TrajectoryError(f'{what} must be finite numbers, got '
                              f'{table[~np.isfinite(table)][0]}')
    return table


def _check_limits(arm: Arm, path: Array) -> None:
    for column, label, (low, high) in zip(path.T, arm.labels, arm.ranges().tolist()):
        worst = column[np.argmax(np.abs(column - 0.5 * (low + high)))]
        if not low <= worst <= high:
            raise TrajectoryError(f'{label} must stay within {within(low, high)} rad, '
                                  f'got {worst:g} rad')
