"""
What link bearings do along a measured motion, beside what gears do (eq:balance-bearing).

One that moves opposes its link, by a torque of its own joint alone. One at rest holds its link.
That link is predicted to stay where it is, and the others to move as if it were a wall.
"""

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.compiled import compiled, Record
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effect_loops import any_acts, where_acts
from hda_arm_sim.model.effects.place import BEARING
from hda_arm_sim.model.link_side import bearing_level
import numpy as np
from numpy.typing import NDArray

from .kernel_along import REST
from ...measurements.motion import DifferentiatedAngle


def bearings_act(arm: Arm) -> bool:
    """Return whether the bearing of a link may oppose or hold it."""
    return any_acts(arm.record().joints, BEARING)


def borne_by(arm: Arm) -> tuple[int, ...]:
    """Return the places of the joints whose links bearings may oppose or hold."""
    return where_acts(arm.record().joints, BEARING)


def opposed(arm: Arm, links: DifferentiatedAngle) -> tuple[Array, NDArray[np.bool_]]:
    """Return what bearings oppose links that move (k, n) [N*m], and which they hold (k, n)."""
    level = np.empty_like(links.angle)
    for joint in range(len(arm.joints)):
        _fill_level(arm.record().joints, joint, links.angle, level)
    resting = np.abs(links.velocity) <= REST
    return np.where(resting, 0.0, np.sign(links.velocity) * level), resting & (level > 0.0)


def held(holding: NDArray[np.bool_], balance: Array, acceleration: Array,
         inertia: Array) -> Array:
    """
    Return the link balances (h, n) where bearings hold some links, from those of free ones.

    The mass matrices are `inertia` (h, n, n).
    """
    found, which = balance.copy(), holding @ (1 << np.arange(holding.shape[1]))
    for alike in np.unique(which):
        rows = np.flatnonzero(which == alike)
        still, free = np.flatnonzero(holding[rows[0]]), np.flatnonzero(~holding[rows[0]])
        matrix, moved = inertia[rows], acceleration[rows]
        away = balance[rows][:, free] - _times(matrix[:, free][:, :, still], moved[:, still])
        misses = np.asarray(np.linalg.solve(
            matrix[:, free][:, :, free], away[:, :, None])[:, :, 0], np.float64)
        of_held = matrix[:, still]
        found[rows[:, None], still] = np.add(_times(of_held[:, :, still], moved[:, still]),
                                             _times(of_held[:, :, free], misses))
    return found


def _times(matrices: Array, vectors: Array) -> Array:
    """Return the product of each matrix (h, a, b) with its vector (h, b)."""
    return np.asarray(np.einsum('hab,hb->ha', matrices, vectors))


@compiled
def _fill_level(joints: Record, j: int, angle: Array, level: Array) -> None:
    """Fill the most torque that the bearing of a joint opposes at its link's angles (k, n)."""
    joint = joints[j]
    for k in range(angle.shape[0]):
        level[k, j] = bearing_level(joint, angle[k, j])
