"""
What else looks like a wave over the lines of an encoder, and how it is distinguished from one.

Between two samples a wave must not pass more than half a cycle: a faster one is the alias of any
other. At rest none passes, and noise alone is proportional to a wave of any number of lines.
Counting makes waves of its own, at any number of lines once they are sampled. Codes that are
skipped make one of whole steps. Jitter of the stamps, and what really moves, show in the motor as
well as in the link. And a wave that belongs to the angle has one phase, in whatever direction and
however often a place is passed.
"""

import math

from hda_arm_sim.foundation.arrays import Array, Mask
import numpy as np

from ...significance import DEVIATIONS, MOSTLY, NEARLY_ALL

# Numerics; choices unless stated otherwise.
STRETCHES = 6           # in time, and in each of both directions, that must agree
_CYCLES = 0.45          # of a wave between two samples that are distinguished; at 0.5 none is


def resolved(travel: Array, fewest: float, most: float, window: int) -> Mask:
    """
    Return where samples show waves of all numbers of lines per turn from fewest to most.

    `travel` (k,) is that from sample to sample [rad]. A wave must be slow enough for them. And it
    must pass whole in a window of so many samples: a polynomial follows what passes in part.
    """
    return np.asarray(np.abs(travel) / (2.0 * math.pi) * most < _CYCLES) & passes(
        travel, fewest, window)


def passes(travel: Array, lines: float, window: int) -> Mask:
    """Return where a wave of so many lines passes whole in a window, by the travel (k,) [rad]."""
    return np.asarray(np.abs(travel) / (2.0 * math.pi) * lines * window >= 1.0)


def counting(step: float) -> float:
    """Return the largest wave that counting in steps [rad] makes: of a sawtooth, the first."""
    return step / math.pi


def of_codes(amplitude: float, lines: float, reach: float, step: float) -> bool:
    """
    Return whether a wave belongs to the codes of an encoder that counts in steps [rad].

    One that is off at every so many codes is off by less than a step, and repeats with a whole
    number of them. The `lines` per turn of the wave have `reach` as their deviation.
    """
    codes = 2.0 * math.pi / (step * lines)
    return amplitude <= step and abs(codes - round(codes)) <= DEVIATIONS * codes * reach / lines


def agrees(speed: Array, columns: Array, rest: Array) -> bool:
    """
    Return whether stretches of a recording, each alone, show the wave that they show together.

    `columns` (2, k) are its sine and cosine, `rest` (k,) what they are to explain.
    """
    numbers, left = _explained(columns, rest)
    usual = left / max(len(rest) - 2, 1)        # power that noise alone gives each number
    together, alone = float(rest @ rest) - left, 0.0
    for rows in np.array_split(np.arange(len(rest)), STRETCHES):
        for way in (speed[rows] > 0.0, speed[rows] < 0.0):
            part = rows[way]
            if len(part) > 2:
                gained = float(rest[part] @ rest[part]) - _explained(columns[:, part],
                                                                     rest[part])[1]
                alone += max(gained - 2.0 * usual, 0.0)
    return together >= NEARLY_ALL * alone


def moves(columns: Array, link: Array, motor: Array) -> bool:
    """
    Return whether a wave in the link's rest (k,) is in the motor's (k,), over the ratio, as well.

    Then it is a movement, or a sample that was taken at another time: no error of one encoder.
    """
    (at_link, _), (at_motor, left) = _explained(columns, link), _explained(columns, motor)
    spread = math.sqrt(left / len(motor) * float(np.linalg.pinv(columns @ columns.T).trace()))
    size = math.hypot(*at_motor)
    return size > MOSTLY * math.hypot(*at_link) and size > DEVIATIONS * spread


def _explained(columns: Array, rest: Array) -> tuple[Array, float]:
    """Return the numbers (2,) of columns that fit a rest (k,) best, and the power left."""
    numbers = np.linalg.pinv(columns @ columns.T) @ (columns @ rest)
    left = rest - numbers @ columns
    return numbers, float(left @ left)
