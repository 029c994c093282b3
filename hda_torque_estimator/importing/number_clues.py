"""What the numbers in columns say where their names say nothing: units, sides, rates, splits."""

from collections.abc import Mapping
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .units import ANGLE, SPEED, TIME

Floats = NDArray[np.float64]
Columns = Mapping[str, NDArray[Any]]

FEWEST = 8                      # rows that say anything
WIDEST_LINK = 4.0 * math.pi     # [rad], more than a link turns
MANY_COUNTS = 1000
LIKELY_RATE = 200.0             # [Hz], so that 7 Hz to 6 kHz are read right: factors of 30
RETURNS = 0.5                   # of its way that a joint is away from its start at the end
DRIVES = 0.2                    # cosine of torque and speed from which work is no accident
UNEVEN = 0.5                    # of the usual step, by which steps of a time differ
MOST = 0.9                      # of the steps of a time
SAME = 0.1                      # relative difference of two slopes that mean the same


def numbers(columns: Columns, name: str) -> Floats:
    """Return what a column holds as floats (n,), NaN where it holds something else."""
    values = columns[name]
    if values.dtype.kind not in 'iufb':
        return np.full(len(values), np.nan)
    return values.astype(np.float64)


def angle_unit(values: Floats) -> str:
    """Return the unit in which angles of a joint most likely are, by their size."""
    known = values[np.isfinite(values)]
    if known.size < FEWEST:
        return 'rad'
    if np.ptp(known) > MANY_COUNTS and is_whole(known):
        return 'count'
    return 'deg' if np.abs(known).max() > WIDEST_LINK else 'rad'


def is_whole(values: Floats) -> bool:
    """Return whether a column holds whole numbers alone."""
    known = values[np.isfinite(values)]
    return bool(known.size and (known == np.rint(known)).all())


def is_dead(values: NDArray[Any]) -> bool:
    """Return whether a column of numbers says nothing: zero, or not known, in every row."""
    return values.dtype.kind in 'iufb' and not np.nan_to_num(values.astype(np.float64)).any()


def speed_unit(speed: Floats, angle: Floats, seconds: Floats) -> str | None:
    """Return the unit in which a speed is the rate of an angle [rad], or None if it is not."""
    if (slope := rate_over(speed, angle, seconds)) is None:
        return None
    for name, unit in SPEED.units.items():
        if unit.over is None and abs(slope * unit.factor - 1.0) < SAME:
            return name
    return None


def rate_over(speed: Floats, angle: Floats, seconds: Floats) -> float | None:
    """Return how large a speed is for one of the rate of an angle, or None if it is not."""
    if len(seconds) < FEWEST:
        return None
    with np.errstate(all='ignore'):
        rate = (angle[2:] - angle[:-2]) / (seconds[2:] - seconds[:-2])
    return through_zero(rate, speed[1:-1])


def through_zero(x: Floats, y: Floats) -> float | None:
    """Return the slope of y over x without offset, or None where y does not follow x."""
    both = np.isfinite(x) & np.isfinite(y)
    x, y = x[both], y[both]
    if len(x) < FEWEST or not x.any() or not y.any():
        return None
    slope = float(x @ y / (x @ x))
    left = y - slope * x
    return slope if left @ left < 0.1 * (y @ y) else None


def motor_over_link(motor: Floats, link: Floats) -> float | None:
    """Return how far the motor's angle moves for one of the link, or None if it does not."""
    if not (np.isfinite(motor).any() and np.isfinite(link).any()):
        return None
    return through_zero(link - np.nanmean(link), motor - np.nanmean(motor))


def way_of_work(torque: Floats, angle: Floats) -> int | None:
    """
    Return 1 where a torque drives the motion of an angle, -1 where it brakes, else None.

    Friction takes work from whatever drives a joint. A load gives back what it took where the
    joint comes back. So in sum the work of the drive is positive.
    """
    step, mean = np.diff(angle), 0.5 * (torque[1:] + torque[:-1])
    known = np.isfinite(step) & np.isfinite(mean)
    step, mean = step[known], mean[known]
    if len(step) < FEWEST or abs(step.sum()) > RETURNS * np.abs(step).sum():
        return None
    size = math.sqrt(float(step @ step) * float(mean @ mean))
    cosine = float(step @ mean) / size if size else 0.0
    return None if abs(cosine) < DRIVES else (1 if cosine > 0.0 else -1)


def time_step(values: Floats) -> float | None:
    """Return the usual step of a column that grows like a time, or None if it does not."""
    steps = np.diff(values)
    if len(steps) < 1 or not np.isfinite(values).all():
        return None
    step = float(np.median(steps))
    # It may start again a few times, where several recordings share a table.
    return step if step > 0.0 and np.mean(steps <= 0.0) < 0.1 else None


def is_even(values: Floats) -> bool:
    """Return whether a column grows in even steps, as a time does, and does not count rows."""
    steps = np.diff(values)
    if len(steps) < FEWEST or not (steps > 0.0).all() or (steps == 1.0).all():
        return False
    step = float(np.median(steps))
    return bool((np.abs(steps - step) < UNEVEN * step).mean() > MOST)


def time_unit(step: float) -> str:
    """Return the unit that makes such a step the likeliest rate."""
    def unlikely(name: str) -> float:
        return abs(math.log(step * TIME.units[name].factor * LIKELY_RATE))

    return min(TIME.units, key=unlikely)


def splits(times: Floats, values: NDArray[Any]) -> bool:
    """Return if times grow within each run of equal values, and every value has one run."""
    changes = values[1:] != values[:-1]
    backwards = np.diff(times) <= 0.0
    runs = 1 + int(changes.sum())
    return bool(changes[backwards].all()) and len(np.unique(values)) == runs


def radians(values: Floats, unit: str) -> Floats:
    """Return angles [rad]; counts, and what has no known unit, stay as they are."""
    known = ANGLE.units.get(unit)
    return values * (known.factor if known and known.over is None else 1.0)
