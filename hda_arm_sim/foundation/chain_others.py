"""
Torques that a motion needs of a chain in which one link is another, for many such links at once.

Where links are and how they move depends on no mass. So a motion is placed once, and each other
link costs what it needs alone. Every torque is, bit by bit, that of a chain with that link.
"""

import numpy as np
from numpy.typing import NDArray

from .arrays import Array
from .chain import (CONSTANTS, FORCE, here, MASS, move, needed, put_inertia, SLIDING, TURNING,
                    TWIST, withstood)
from .compiled import compiled, inlined
from .vectors import dot, plus, vector


@compiled
def torques_with_others(c: Array, stated: Array, rows: NDArray[np.intp], others: Array,
                        torque: Array) -> None:
    """
    Fill the torques (v, n) for the SPEEDING that is asked, at the frames placed.

    Each time one of the `rows` (v,) weighs something else, MASS to CONSTANTS: one of the `others`
    (v, 10). All rows weigh what is `stated` (n + 2, 10) before and after.
    """
    move(c)
    for v in range(len(rows)):
        row = rows[v]
        c[row, MASS:CONSTANTS] = others[v]
        put_inertia(c, row)
        _carry(c, row, torque[v])
        c[row, MASS:CONSTANTS] = stated[row]


@inlined
def _carry(c: Array, changed: int, torque: Array) -> None:
    """Fill torques (n,) as `inverse_dynamics` does, where one link has changed since `move`."""
    last = c.shape[0] - 1
    moment, force = withstood(c, last, last)
    for row in range(last - 1, 0, -1):
        twisted, pushed = withstood(c, row, row + 1)
        own, push = vector(c, row, TWIST), vector(c, row, FORCE)
        if row == changed:
            own, push = needed(c, row, here(c, row))
        moment, force = plus(moment, own), plus(force, push)
        moment, force = plus(moment, twisted), plus(force, pushed)
        torque[row - 1] = (dot(vector(c, row, TURNING), moment)
                           + dot(vector(c, row, SLIDING), force))
