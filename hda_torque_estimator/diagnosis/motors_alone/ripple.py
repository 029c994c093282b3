"""
Find what repeats with every turn of a motor, in a torque that depends on much else besides.

A line must stand out of the spectrum about it, over the angle and not over time. So neither slow
loads nor the noise of a controller can pass for one.
"""

from collections.abc import Sequence
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
import numpy as np
from scipy.ndimage import median_filter
from scipy.optimize import minimize_scalar

from ...significance import IMMATERIAL, MOSTLY, STANDS_OUT

# Numerics; choices unless stated otherwise.
_LOWEST = 0.5           # order: slower waves are loads [1/turn]
_ABOUT = 201            # frequencies about a line that show its surroundings
_PER_SAMPLE = 0.4       # waves in a sample: faster ones are not seen
_ROUNDING = 1e-9        # of the travel, up to which a step is one of rounding
_APART = 3.0            # widths of a line within which there is no other
# (source: one turn in rad)
_TURN = 2.0 * np.pi     # one turn [rad]


class RippleLine(NamedTuple):
    """A wave over the motor angle: its order [1/turn], and its power over that about it."""

    order: float
    stands_out: float


def strongest_line(angle: Array, rest: Array, known: Sequence[float] = ()) -> RippleLine | None:
    """
    Return the line that stands out most in a rest (k,) over an angle (k,), if one does.

    Orders that are `known` already are left out.
    """
    orders, size = spectrum(angle, rest)
    power = size ** 2
    ratio = np.where(orders > _LOWEST, power / np.maximum(median_filter(power, _ABOUT), 1e-300),
                     0.0)
    for order in known:
        ratio[np.abs(orders - order) < _APART * _TURN / float(np.ptp(angle))] = 0.0
    best = int(np.argmax(ratio))
    if ratio[best] <= STANDS_OUT:
        return None
    step = float(orders[1])
    found = minimize_scalar(lambda order: -explained_power(angle, rest, float(order)),
                            method='bounded',
                            bounds=(orders[best] - 2.0 * step, orders[best] + 2.0 * step))
    order = _whole(float(found.x), _TURN / float(np.ptp(angle)))
    least = MOSTLY * IMMATERIAL     # a line is half of what is worth a name: some make one law
    if order < 1.0 or explained_power(angle, rest, order) < least * float(rest @ rest):
        return None
    return RippleLine(order, float(ratio[best]))


def _whole(order: float, width: float) -> float:
    """Return the whole order within the width of a line: what turns with a motor has no other."""
    return float(round(order)) if abs(order - round(order)) < width else order


def spectrum(angle: Array, rest: Array) -> tuple[Array, Array]:
    """Return orders (f,) [1/turn] and the amplitudes of a rest (k,) over an angle (k,) there."""
    highest = _PER_SAMPLE * _TURN / _step(angle)
    width = _TURN / (4.0 * highest)
    place = ((angle - angle.min()) / width).astype(np.int64)
    count = 4 * (int(place.max()) + 1)
    size = 2.0 * np.abs(np.fft.rfft(np.bincount(place, rest, count))) / len(rest)
    orders = np.arange(len(size), dtype=np.float64) * (_TURN / (count * width))
    return orders[orders < highest], size[orders < highest]


def _step(angle: Array) -> float:
    """
    Return how far a motor usually turns from row to row [rad].

    Of rows that repeat the one before, as a host reads them that asks faster than a drive answers,
    it is the share of a step over several.
    """
    travel, apart = float(np.ptp(angle)), 1
    while 2 * apart < len(angle):
        step = float(np.median(np.abs(angle[apart:] - angle[:-apart])))
        if step > _ROUNDING * travel:
            return step / apart
        apart *= 2
    return max(travel, 1e-9)


def explained_power(angle: Array, rest: Array, order: float) -> float:
    """Return how much of the power of a rest (k,) a wave of this order explains."""
    columns = waves(angle, order)
    against = columns.T @ rest
    return float(against @ np.linalg.solve(columns.T @ columns, against))


def waves(angle: Array, order: float) -> Array:
    """Return sine and cosine of an order over an angle (k, 2)."""
    return np.stack([np.sin(order * angle), np.cos(order * angle)], axis=1)
