"""Turn trajectory points into a smooth reference that can be asked at any time."""

from collections.abc import Sequence

from hda_arm_sim.model.arm import Arm
import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline, PchipInterpolator

Array = NDArray[np.float64]
LARGEST_STEP = 0.05     # of the reference at its first point [rad]


class TrajectoryError(ValueError):
    """A trajectory that the arm cannot follow."""


class Reference:
    """
    A reference of the link angles over time since its start; it holds its last point.

    Cubic in every piece: through given velocities, or with the shape-preserving slopes of
    Fritsch and Carlson where none are given, which do not overshoot.
    """

    def __init__(self, times: Array, angles: Array, rates: Array | None = None) -> None:
        """Join points at `times` (k,) [s], `angles` (k, n) [rad], `rates` (k, n) [rad/s]."""
        self.end = float(times[-1])
        self._held = angles[-1]
        self._curve = None
        if len(times) > 1:
            self._curve = (PchipInterpolator(times, angles) if rates is None
                           else CubicHermiteSpline(times, angles, rates))
            self._slope = self._curve.derivative()

    def at(self, time: float) -> Array:
        """Return link angles and rates (n, 2) at a time since the start [rad, rad/s]."""
        if self._curve is None or time >= self.end:
            return np.stack([self._held, np.zeros_like(self._held)], axis=1)
        time = max(time, 0.0)
        return np.stack([self._curve(time), self._slope(time)], axis=1)


def hold(angles: Array) -> Reference:
    """Return a reference that stays at these link angles (n,) [rad]."""
    return Reference(np.zeros(1), np.asarray(angles, float)[None, :])


def reference_from(arm: Arm, names: Sequence[str], times: Sequence[float],
                   angles: Sequence[Sequence[float]], rates: Sequence[Sequence[float]],
                   now: Array) -> Reference:
    """
    Return the reference of trajectory points that starts where the arm's reference is now.

    `names` may stand in any order; rates may be empty for all points. `now` (n, 2) is the
    present reference. Raises TrajectoryError naming the point that cannot be followed.
    """
    order = _order(arm, names)
    moments = _times(times)
    path = _table(angles, 'positions', len(moments), order)
    slopes = _table(rates, 'velocities', len(moments), order) if any(rates) else None
    _check_limits(arm, path)
    if moments[0] > 0.0:
        moments = np.insert(moments, 0, 0.0)
        path = np.vstack([now[:, 0], path])
        slopes = None if slopes is None else np.vstack([now[:, 1], slopes])
    elif np.abs(path[0] - now[:, 0]).max() > LARGEST_STEP:
        raise TrajectoryError(
            f'the first point, at time 0, is {np.abs(path[0] - now[:, 0]).max():.3g} rad from the '
            f'present reference; it must be within {LARGEST_STEP} rad, or have a later time')
    return Reference(moments, path, slopes)


def _order(arm: Arm, names: Sequence[str]) -> list[int]:
    if sorted(names) != sorted(arm.labels):
        raise TrajectoryError(f'joint_names must be {", ".join(arm.labels)} in any order, got '
                              f'{", ".join(names) or "none"}')
    return [list(names).index(label) for label in arm.labels]


def _times(times: Sequence[float]) -> Array:
    moments = np.asarray(times, float)
    if not len(moments):
        raise TrajectoryError('a trajectory needs at least one point, got none')
    if moments[0] < 0.0 or np.any(np.diff(moments) <= 0.0):
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
    for column, joint in zip(path.T, arm.joints):
        worst = column[np.argmax(np.abs(column))]
        if abs(worst) > joint.angle_limit:
            raise TrajectoryError(f'{joint.label} must stay within +-{joint.angle_limit:g} rad, '
                                  f'got {worst:g} rad')
