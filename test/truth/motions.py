"""
The motions of worlds: what people let an arm do while they record it.

Each is a reference of two link angles and rates about HOME, within the speeds and accelerations
(2,) that an arm can follow. A joint that an arm does not have stands still.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .arms import HOME

Array = NDArray[np.float64]
REACH = 0.9                     # largest travel to either side [rad]
EASE = 1.0                      # time over which a periodic motion sets in [s]
REST = (0.3, 1.0)               # how long an arm stands at a point [s]


class Motion(NamedTuple):
    """A reference (k, 2) [rad], its rates, and how the arm is moved along it."""

    angle: Array
    rate: Array
    powered: bool = True        # or led by hand, with the motors off
    pushed: bool = False        # by somebody, while it stands


class Limits(NamedTuple):
    """What a joint can follow: rate [rad/s] and acceleration [rad/s^2]."""

    rate: float
    acceleration: float


Maker = Callable[[Array, Limits, np.random.Generator], Array]


def made(name: str, time: Array, limits: tuple[Limits, ...], rng: np.random.Generator) -> Motion:
    """Return a motion of the joints that have limits, at even times from 0 on [s]."""
    angle = np.tile(HOME, (len(time), 1))
    for joint, limit in enumerate(limits):
        angle[:, joint] += MOTIONS[name](time, limit, rng)
    return Motion(angle, np.gradient(angle, time[1], axis=0), name != 'hand_guided',
                  name == 'standstill')


def fitting(away: Array, time: Array, limits: Limits, share: float = 1.0) -> Array:
    """Return a motion eased in from rest, as large as limits and reach allow [rad]."""
    edge = np.clip(np.minimum(time, time[-1] - time) / EASE, 0.0, 1.0)
    away = away * edge ** 3 * (10.0 - 15.0 * edge + 6.0 * edge ** 2)
    rate = np.gradient(away, time[1])
    largest = max(np.abs(away).max() / REACH, np.abs(rate).max() / limits.rate,
                  np.abs(np.gradient(rate, time[1])).max() / limits.acceleration)
    return share * away / max(largest, 1e-12)


def rich(time: Array, limits: Limits, rng: np.random.Generator) -> Array:
    """Return slow passes at nearly constant speed, and bursts of waves up to 3 Hz."""
    period = rng.uniform(9.0, 14.0)
    slow = fitting(np.arcsin(0.98 * np.sin(2.0 * np.pi * time / period)), time, limits, 0.6)
    tones = np.linspace(0.15, 3.0, 14) * rng.uniform(0.9, 1.1)
    phases = rng.uniform(0.0, 2.0 * np.pi, len(tones))
    wave = (np.sin(2.0 * np.pi * np.outer(time, tones) + phases)
            / (1.0 + (tones / 0.4) ** 2)).sum(axis=1)
    burst = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.clip((time % 20.0 - 4.0) / 12.0, 0.0, 1.0))
    return slow + fitting(burst * wave, time, limits, 0.5)


def fourier(time: Array, limits: Limits, rng: np.random.Generator) -> Array:
    """Return a sum of five harmonics of 0.1 Hz, as identification of robots uses it."""
    sizes, phases = rng.uniform(0.3, 1.0, 5), rng.uniform(0.0, 2.0 * np.pi, 5)
    turns = 2.0 * np.pi * 0.1 * np.outer(time, np.arange(1, 6)) + phases
    return fitting((sizes / np.arange(1, 6) * np.sin(turns)).sum(axis=1), time, limits)


def chirp(time: Array, limits: Limits, rng: np.random.Generator) -> Array:
    """Return a sine whose frequency rises from 0.1 to 4 Hz, smaller where it is quicker."""
    low, high = 0.1, 4.0
    rise = np.log(high / low) / time[-1]
    frequency = low * np.exp(rise * time)
    phase = 2.0 * np.pi * (frequency - low) / rise + rng.uniform(0.0, 2.0 * np.pi)
    return fitting(np.sin(phase) / (1.0 + (frequency / 0.5) ** 2), time, limits)


def sine(time: Array, limits: Limits, rng: np.random.Generator) -> Array:
    """Return one sine."""
    return fitting(np.sin(2.0 * np.pi * rng.uniform(0.15, 0.5) * time), time, limits, 0.8)


def standstill(time: Array, limits: Limits, rng: np.random.Generator) -> Array:
    """Return no motion at all."""
    return np.zeros_like(time)


def hand_guided(time: Array, limits: Limits, rng: np.random.Generator) -> Array:
    """Return the way of a hand: slow, without a period."""
    tones, phases = rng.uniform(0.05, 0.4, 8), rng.uniform(0.0, 2.0 * np.pi, 8)
    wave = np.sin(2.0 * np.pi * np.outer(time, tones) + phases).sum(axis=1)
    return fitting(wave, time, limits, 0.7)


def travel(time: Array, begin: float, distance: float, rate: float,
           acceleration: float) -> tuple[Array, float]:
    """Return a travel with straight flanks of its rate, from rest to rest, and its end [s]."""
    size = abs(distance)
    rate = min(rate, np.sqrt(size * acceleration))
    ramp = rate / acceleration
    end = size / rate + ramp
    t = np.clip(time - begin, 0.0, end)
    late = np.minimum(end - t, ramp)
    early = np.minimum(t, ramp)
    gone = (0.5 * acceleration * early ** 2 + rate * np.clip(t - ramp, 0.0, end - 2.0 * ramp)
            + 0.5 * acceleration * (ramp ** 2 - late ** 2))
    return np.sign(distance) * gone, begin + end


def constant(time: Array, limits: Limits, rng: np.random.Generator) -> Array:
    """Return travels to and fro, each pair at a constant speed of its own."""
    away, now, where, side = np.zeros_like(time), 0.5, 0.0, 1.0
    speeds = limits.rate * np.array([0.15, 0.3, 0.5, 0.75, 1.0]) * rng.uniform(0.9, 1.0)
    pair = 0
    while now < time[-1]:
        speed = speeds[rng.permutation(5)[0] if pair > 9 else (pair // 2) % 5]
        goal = side * REACH * 0.8
        step, now = travel(time, now, goal - where, max(speed, 0.02), limits.acceleration)
        away, where, side, pair = away + step, goal, -side, pair + 1
    return away


def trapezoid(time: Array, limits: Limits, rng: np.random.Generator) -> Array:
    """Return travels from point to point, with rests."""
    away, now, where = np.zeros_like(time), 0.5, 0.0
    while now < time[-1]:
        goal = rng.uniform(-REACH, REACH)
        step, now = travel(time, now, goal - where, limits.rate * rng.uniform(0.4, 1.0),
                           limits.acceleration * rng.uniform(0.5, 1.0))
        away, where, now = away + step, goal, now + rng.uniform(*REST)
    return away


def pick_and_place(time: Array, limits: Limits, rng: np.random.Generator) -> Array:
    """Return one cycle again and again: smooth travels between three points."""
    points, rests = rng.uniform(-REACH, REACH, 3), rng.uniform(*REST, 3)
    away, now, where, turn = np.zeros_like(time), 0.5, 0.0, 0
    while now < time[-1]:
        goal = points[turn % 3]
        size = abs(goal - where)
        lasts = max(1.875 * size / limits.rate, np.sqrt(5.774 * size / limits.acceleration), 0.2)
        s = np.clip((time - now) / lasts, 0.0, 1.0)
        away = away + (goal - where) * s ** 3 * (10.0 - 15.0 * s + 6.0 * s ** 2)
        now, where, turn = now + lasts + rests[turn % 3], goal, turn + 1
    return away


MOTIONS: dict[str, Maker] = {
    'rich': rich, 'constant': constant, 'trapezoid': trapezoid, 'fourier': fourier,
    'chirp': chirp, 'sine': sine, 'hand_guided': hand_guided, 'standstill': standstill,
    'pick_and_place': pick_and_place}
HELD_OUT = frozenset({'pick_and_place'})        # which only the final study makes
