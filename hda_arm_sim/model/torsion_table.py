"""
Torques of many torsions under one law: a table of its inverse (docs/model.md, eq:torsion).

One torsion is inverted by iteration. Along a recording the law stays the same, so its torques are
found at evenly spaced torsions, with their stiffnesses. Between two of them a cubic has both ends
and both stiffnesses. Where that is not as good as asked, as at a knee, the iteration is run.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .torsion import stiffness_at, torque_of_torsion, torsion_of_torque
from ..foundation.arrays import Array
from ..foundation.compiled import compiled, inlined, Record

_CELLS = 1024           # of a table
_ERROR = 1e-11          # of the largest torque, at the middle of a cell


class TorqueTable(NamedTuple):
    """The inverse of a law from zero to a largest torsion."""

    step: float                 # between nodes [rad]
    torque: Array               # (_CELLS + 1,) at the nodes [N*m]
    rise: Array                 # (_CELLS + 1,) stiffness there, times the step [N*m]
    good: NDArray[np.bool_]     # (_CELLS,) whether the cubic is as good as asked


@compiled
def torque_table(law: Record, ratio: float, largest: float) -> TorqueTable:
    """Return the table of a law up to a torsion within its valid range [rad]."""
    step = largest / _CELLS
    torque, rise = np.zeros(_CELLS + 1), np.zeros(_CELLS + 1)
    rise[0] = stiffness_at(law, ratio, 0.0) * step
    for node in range(1, _CELLS + 1):
        torque[node] = torque_of_torsion(law, ratio, node * step)
        rise[node] = stiffness_at(law, ratio, torque[node]) * step
    good = np.zeros(_CELLS, np.bool_)
    for cell in range(_CELLS):
        middle = _cubic(torque, rise, cell, 0.5)
        missed = torsion_of_torque(law, ratio, middle) - (cell + 0.5) * step
        steepest = max(rise[cell], rise[cell + 1])
        good[cell] = abs(missed) * steepest <= _ERROR * step * torque[_CELLS]
    return TorqueTable(step, torque, rise, good)


@inlined
def _cubic(torque: Array, rise: Array, cell: int, along: float) -> float:
    """Return the torque a share of the way along a cell."""
    gained = torque[cell + 1] - torque[cell]
    bent, twisted = 3.0 * gained - 2.0 * rise[cell] - rise[cell + 1], (
        rise[cell] + rise[cell + 1] - 2.0 * gained)
    return torque[cell] + along * (rise[cell] + along * (bent + along * twisted))


@inlined
def tabled_torque(law: Record, ratio: float, table: TorqueTable, torsion: float) -> float:
    """Return the torque under a torsion within reach of the table, or beyond all [N*m]."""
    size = abs(torsion)
    if size < law.valid_torsion:
        place = size / table.step
        cell = min(int(place), _CELLS - 1)
        if table.good[cell]:
            torque = _cubic(table.torque, table.rise, cell, place - cell)
            return torque if torsion > 0.0 else -torque
    return torque_of_torsion(law, ratio, torsion)
