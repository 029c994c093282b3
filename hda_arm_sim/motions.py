"""
Motions that excite the arm, each with what it can show.

A motion is a reference of the link angles, closed in itself up to its start, and a push at the
tip. Both are within what the nominal arm's motors can do.
"""

from collections.abc import Callable
from typing import NamedTuple

from hda_msgs_json.errors import HdaError
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
HOME = (0.3, 1.2)               # link angles where every motion starts [rad]
_EASE = 1.0                     # time over which a motion is faded in and out [s]


class MotionError(HdaError):
    """A motion that does not exist or has no time to be made."""


class Motion(NamedTuple):
    """A reference over time: link angles and rates (k, n), force on the tip (k, 2) in base."""

    time: Array
    angle: Array
    rate: Array
    force: Array


class _Recipe(NamedTuple):
    meaning: str
    angle: Callable[[Array, int, np.random.Generator], Array]
    force: Callable[[Array], Array]


def motion(name: str, joints: int, duration: float, dt: float, seed: int) -> Motion:
    """
    Return the motion `name` for an arm with 1 or 2 joints, sampled every dt [s].

    Raises MotionError with the valid names, or for a duration shorter than 2 s.
    """
    if name not in MOTIONS:
        raise MotionError(f'no motion is named {name!r}; valid names: {", ".join(MOTIONS)}')
    if not 2.0 * _EASE <= duration <= 86400.0:
        raise MotionError(f'a motion lasts from {2.0 * _EASE:g} s to a day, got {duration:g} s')
    time: Array = dt * np.arange(round(duration / dt) + 1, dtype=np.float64)
    random = np.random.default_rng(seed)
    columns = [MOTIONS[name].angle(time, joint, random) for joint in range(joints)]
    away: Array = np.stack(columns, axis=1) * _window(time, duration)[:, None]
    angle = np.asarray(HOME[:joints]) + away
    return Motion(time, angle, np.gradient(angle, dt, axis=0), MOTIONS[name].force(time))


def _window(time: Array, duration: float) -> Array:
    """Return a smooth window that is 1 but for its ends, with continuous acceleration."""
    edge = np.clip(np.minimum(time, duration - time) / _EASE, 0.0, 1.0)
    return edge ** 3 * (10.0 - 15.0 * edge + 6.0 * edge ** 2)


def _triangle(time: Array, period: float, amplitude: float) -> Array:
    """Return a triangle wave with rounded corners: constant speed nearly all the time."""
    return amplitude * np.arcsin(0.98 * np.sin(2.0 * np.pi * time / period)) / np.arcsin(0.98)


def _rich(time: Array, joint: int, random: np.random.Generator) -> Array:
    """Slow triangles of two periods, and bursts of a multi-sine from 0.1 to 2.9 Hz."""
    slow = _triangle(time, (11.0, 13.7)[joint], 0.45) + _triangle(time, (4.3, 3.6)[joint], 0.12)
    tones = np.linspace(0.1, 2.9, 15) + 0.05 * joint
    phases = random.uniform(0.0, 2.0 * np.pi, len(tones))
    size = 0.25 / (1.0 + (tones / 0.4) ** 2) + 0.002
    wave = (size * np.sin(2.0 * np.pi * np.outer(time, tones) + phases)).sum(axis=1)
    burst = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.clip((time % 20.0 - 4.0) / 12.0, 0.0, 1.0))
    return slow + burst * wave


def _sine(time: Array, joint: int, random: np.random.Generator) -> Array:
    return 0.5 * np.sin(2.0 * np.pi * 0.25 * time + joint)


def _slow_sine(time: Array, joint: int, random: np.random.Generator) -> Array:
    return 0.3 * np.sin(2.0 * np.pi * 0.05 * time + joint)


def _turn(time: Array, joint: int, random: np.random.Generator) -> Array:
    return _triangle(time, (16.0, 12.0)[joint], 1.2)


def _still(time: Array, joint: int, random: np.random.Generator) -> Array:
    return np.zeros_like(time)


def _no_force(time: Array) -> Array:
    return np.zeros((len(time), 2))


def _pushes(time: Array) -> Array:
    """Two pushes of a second with soft edges, one along each axis of the base."""
    force = np.zeros((len(time), 2))
    for axis, (begin, size) in enumerate(((3.0, 20.0), (5.5, -15.0))):
        edge = np.clip(np.minimum(time - begin, begin + 1.2 - time) / 0.15, 0.0, 1.0)
        force[:, axis] = size * edge ** 2 * (3.0 - 2.0 * edge)
    return force


MOTIONS = {
    'rich': _Recipe('slow triangles and multi-sine bursts: shows every effect', _rich, _no_force),
    'sine': _Recipe('one sine of 0.25 Hz: friction and inertia', _sine, _no_force),
    'slow_sine': _Recipe('one sine of 0.05 Hz: kinematics, hardly dynamics', _slow_sine,
                         _no_force),
    'turn': _Recipe('constant speed both ways: kinematics and friction', _turn, _no_force),
    'standstill': _Recipe('no motion: noise and resolution only', _still, _no_force),
    'push': _Recipe('a sine with two pushes at the tip: torque and force', _sine, _pushes),
}
