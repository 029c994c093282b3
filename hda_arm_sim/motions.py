"""
Motions that excite the arm, each with what it can show.

A motion is a reference of the link angles, closed in itself up to its start, and a push at the
tip. Both are within what the nominal arm's motors can do.
"""

from collections.abc import Callable
from typing import NamedTuple

from hda_msgs_json.errors import HdaError
from hda_msgs_json.nearest import did_you_mean
import numpy as np

from .foundation.arrays import Array
from .model.arm import Arm
from .model.chain_links import ChainLinks

HOME = (0.3, 1.2)               # link angles where every motion of two links starts [rad]
_EASE = 1.0                     # time over which a motion is faded in and out [s]
# Of a chain, unless its file says where: bent in every joint, so near no singular pose [rad].
_BENT = (0.3, 0.6, -0.3, -1.2, 0.4, 0.9, 0.2, -0.7, 0.5, 0.8, -0.4, 0.6)
_ROOM = 0.25                    # share of a joint's range that a chosen home leaves at either end
_SHARE = 0.5                    # of a joint's declared speed that a motion takes
# For each joint its own, so that joints can be distinguished: periods [s], shifts of tones [Hz].
_SLOW = (11.0, 13.7, 12.1, 9.7, 14.9, 10.3, 8.9, 12.7, 9.1, 13.1, 10.9, 11.9)
_QUICK = (4.3, 3.6, 3.9, 4.7, 3.3, 4.1, 5.1, 3.5, 4.5, 3.7, 4.9, 3.1)
_TURNS = (16.0, 12.0, 14.0, 11.0, 17.0, 13.0, 10.0, 15.0, 9.0, 18.0, 12.5, 10.5)
_SHIFT = (0.0, 0.05, 0.1, 0.15, 0.025, 0.075, 0.125, 0.175, 0.0125, 0.0625, 0.1125, 0.1625)


class MotionError(HdaError):
    """A motion that does not exist or has no time to be made."""


class Motion(NamedTuple):
    """
    A reference over time: link angles and rates (k, n), force on the tip (k, 2) in base.

    With `pushed` the force acts at the end of this link of a chain instead, counted from 1.
    """

    time: Array
    angle: Array
    rate: Array
    force: Array
    pushed: int = 0


class _Recipe(NamedTuple):
    meaning: str
    angle: Callable[[Array, int, np.random.Generator], Array]
    force: Callable[[Array], Array]


def home_of(arm: Arm) -> tuple[float, ...]:
    """Return the link angles (n,) where motions of an arm start [rad]."""
    joints = len(arm.joints)
    if not isinstance(arm.links, ChainLinks):
        return HOME[:joints]
    if arm.links.home:
        return arm.links.home
    found = []
    for (low, high), bent in zip(arm.ranges().tolist(), _BENT):
        room = _ROOM * (high - low)
        found.append(min(max(bent, low + room), high - room))
    return tuple(found)


def pushed_link(arm: Arm, motion: Motion) -> int:
    """Return the link of a chain that a motion pushes at its end, 0 for the tip; MotionError."""
    joints = len(arm.joints)
    if motion.pushed and not isinstance(arm.links, ChainLinks):
        raise MotionError('links of a chain alone can be pushed; this arm is pushed at its tip')
    if not 0 <= motion.pushed <= joints:
        raise MotionError(f'the pushed link is a number from 1 to {joints}, got {motion.pushed}')
    return motion.pushed


def motion_of(arm: Arm, name: str, duration: float, dt: float, seed: int) -> Motion:
    """
    Return the motion `name` about the home of an arm, sampled every dt [s].

    Each joint of a chain goes as far as arm file and description allow, at half of its declared
    speed at most. Raises MotionError.
    """
    made = motion(name, len(arm.joints), duration, dt, seed)
    if not isinstance(arm.links, ChainLinks):
        return made
    home = np.array(home_of(arm))
    away = made.angle - made.angle[0]
    low, high = arm.ranges().T
    room = np.maximum(np.minimum(high - home, home - low), 0.0)
    speed = [_SHARE * joint.velocity_limit / joint.ratio for joint in arm.joints]
    with np.errstate(divide='ignore'):
        share = np.minimum(np.minimum(room / np.abs(away).max(axis=0),
                                      speed / np.abs(made.rate).max(axis=0)), 1.0)
    return made._replace(angle=home + share * away, rate=share * made.rate)


def motion(name: str, joints: int, duration: float, dt: float, seed: int) -> Motion:
    """
    Return the motion `name` for an arm with so many joints, sampled every dt [s].

    Raises MotionError with the valid names, or for a duration shorter than 2 s.
    """
    if name not in MOTIONS:
        raise MotionError(f'no motion is named {name!r}{did_you_mean(name, MOTIONS) or ";"} '
                          f'valid names: {", ".join(MOTIONS)}')
    if not 2.0 * _EASE <= duration <= 86400.0:
        raise MotionError(f'a motion lasts from {2.0 * _EASE:g} s to a day, got {duration:g} s')
    time: Array = dt * np.arange(round(duration / dt) + 1, dtype=np.float64)
    random = np.random.default_rng(seed)
    columns = [MOTIONS[name].angle(time, joint, random) for joint in range(joints)]
    away: Array = np.stack(columns, axis=1) * _window(time, duration)[:, None]
    angle = np.asarray(HOME[:joints] if joints <= 2 else _BENT[:joints]) + away
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
    slow = _triangle(time, _SLOW[joint], 0.45) + _triangle(time, _QUICK[joint], 0.12)
    tones = np.linspace(0.1, 2.9, 15) + _SHIFT[joint]
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
    return _triangle(time, _TURNS[joint], 1.2)


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
