"""
How far a residual follows a coordinate, alone or as the size of something that it multiplies.

A residual follows a coordinate x if r = w f(x) for some curve f, found by least squares in bins of
x. The carrier w is 1, the direction of the shaft (friction along x) or the torque (stiffness or
mesh loss along x). What the carrier alone explains is not the coordinate's:
it is what x explains when it is shifted in time against the residual. Over time a residual follows
a slow curve, or one line. The text of a report and all of its figures ask here.
"""

from collections.abc import Iterator, Mapping
import math
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
import numpy as np
from numpy.typing import NDArray

from ..balances.strongest_wave import strongest_wave, TURN, wave_share
from ...significance import IMMATERIAL, UNLIKE

Bins = NDArray[np.int64]
WRAPPED = 'motor_angle'             # the coordinate that counts modulo one turn
# Numerics; choices unless stated otherwise.
TRAVEL = 2.0                        # least motor turns in which a period of one turn shows
BINS = 24               # of a coordinate
TURN_BINS = 120                    # of a motor turn: cogging has up to 42 periods in it
_FASTEST = 0.98                     # share of the speeds within the bins of a velocity
_PER_BIN = 15                       # least samples in a bin, on average
_SHIFTS = 16            # of a coordinate along the recording, to see what chance explains
_ORDERS = np.arange(0.5, 13.0, 0.25)        # of a link turn: higher ones move too fast to separate
_ANGLES = ('link_angle', 'other_link_angle')
VELOCITIES = ('motor_velocity', 'link_velocity')
# Carriers that a coordinate is, or goes with: a curve along it holds what they would explain.
_HELD = {**dict.fromkeys(VELOCITIES, ('direction', 'torque')), 'joint_torque': ('torque',),
         'motor_torque': ('direction', 'torque')}


class Following(NamedTuple):
    """How far a residual follows a coordinate."""

    coordinate: str
    carrier: str                    # '', 'direction' or 'torque': what the curve multiplies
    share: float                    # of the power beyond chance, in [0, 1]
    line: float | None = None       # of a wave: over time [Hz], over an angle [1/turn]


def follow(time: Array, values: Array, valid: NDArray[np.bool_],
           coordinates: Mapping[str, Array], velocity: str = '') -> list[Following]:
    """
    Return how far values (m,) follow time [s] and each coordinate (m,), the most first.

    `coordinates` holds `motor_velocity` and `joint_torque` for the carriers. `velocity` names the
    one of the values' own side: shaft and link have nearly the same.
    """
    if not valid.any():
        return [Following('time', '', 0.0)]
    rest = np.where(valid, values - values[valid].mean(), 0.0)
    carriers = {'': valid.astype(float),
                'direction': np.where(valid, np.sign(coordinates['motor_velocity']), 0.0),
                'torque': np.where(valid, coordinates['joint_torque'], 0.0)}
    found = [over_time(time, rest, valid)]
    for name, along in coordinates.items():
        if _varies(name, along[valid]):
            found.append(max((_carried(name, along, carrier, weight, rest, valid)
                              for carrier, weight in carriers.items()
                              if carrier not in _HELD.get(name, ())), key=_rank))
    other = velocity and VELOCITIES[VELOCITIES.index(velocity) - 1]
    return sorted(found, reverse=True, key=lambda one: _rank(one) - IMMATERIAL * (
        one.coordinate == other))


def _varies(name: str, along: Array) -> bool:
    """Return whether a coordinate varies enough; a part of a turn looks like the link angle."""
    travel = float(np.ptp(along))
    return travel >= TRAVEL * TURN if name == WRAPPED else travel > 0.0


def _rank(following: Following) -> float:
    """Return what dependences are ordered by: the simpler one wins where two explain the same."""
    return (following.share - IMMATERIAL * bool(following.carrier)
            - IMMATERIAL * (following.coordinate == 'time'))


def over_time(time: Array, rest: Array, valid: NDArray[np.bool_]) -> Following:
    """Return how far a residual (m,), 0 where invalid, follows time: a slow curve or a line."""
    bins, count = _bins('time', time, valid)
    slow = _explained_share(bins, count, valid.astype(float), rest)
    line = strongest_wave(time, rest, valid)
    if line.share > slow:
        return Following('time', '', line.share, line.frequency)
    return Following('time', '', slow)


def _carried(name: str, along: Array, carrier: str, weight: Array, rest: Array,
             valid: NDArray[np.bool_]) -> Following:
    """Return how far a residual (m,), 0 where invalid, follows a coordinate with a carrier."""
    bins, count = _bins(name, along, valid)
    explained = _explained_share(bins, count, weight, rest)
    chance = float(np.median([_explained_share(shifted, count, weight,
                                               rest) for shifted in _shifted(bins)]))
    share = (explained - chance) / max(1.0 - chance, 1e-12)
    return Following(name, carrier, max(share, 0.0),
                     _line(name, along[valid], weight[valid], rest[valid], explained, count))


def _line(name: str, along: Array, weight: Array, rest: Array, explained: float,
          count: int) -> float | None:
    """Return the order [1/turn] of the wave that a dependence on an angle is, if it is one."""
    if name == WRAPPED:
        orders = np.arange(1.0, count // 2)
    elif name in _ANGLES:
        orders = _ORDERS
    else:
        return None
    shares = [wave_share(order * along, rest, weight) for order in orders]
    best = float(orders[int(np.argmax(shares))])
    whole = best * float(np.ptp(along)) >= TURN     # a part of a wave could be any curve
    return best if whole and max(shares) > (1.0 - UNLIKE) * explained else None


def _bins(name: str, along: Array, valid: NDArray[np.bool_]) -> tuple[Bins, int]:
    """Return the bin (m,) of each sample, and how many bins there are."""
    most = TURN_BINS if name == WRAPPED else BINS
    count = int(np.clip(valid.sum() // _PER_BIN, 2, most))
    if name == WRAPPED:
        place = (np.mod(along, TURN) / TURN * count).astype(np.int64)
        return np.minimum(place, count - 1), count
    if name in VELOCITIES:          # finer where friction turns, at low speed
        reach = np.linspace(-1.0, 1.0, count + 1)[1:-1]
        edges = np.quantile(np.abs(along[valid]), _FASTEST) * reach ** 3
    else:
        edges = np.quantile(along[valid], np.arange(1, count) / count)
    return np.searchsorted(edges, along, side='right').astype(np.int64), count


def _explained_share(bins: Bins, count: int, weight: Array, rest: Array) -> float:
    """Return the share of a residual (m,) that a curve over bins (m,) times a weight explains."""
    against = np.bincount(bins, weight * rest, count)
    own = np.bincount(bins, weight * weight, count)
    return float(np.sum(against ** 2 / np.maximum(own, 1e-12)) / max(float(rest @ rest), 1e-300))


def _shifted(bins: Bins) -> Iterator[Bins]:
    """Yield bins (m,) shifted around in time, by steps that no periodic motion repeats."""
    golden = 0.5 * (math.sqrt(5.0) - 1.0)
    for place in range(1, _SHIFTS + 1):
        yield np.roll(bins, round((0.05 + 0.9 * (place * golden % 1.0)) * len(bins)))
