"""What the links of a chain ask of the gears, with a known wrench on the tip, and how surely."""

from hda_arm_sim.foundation import chain
from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.compiled import compiled
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.kernel import LINK_ANGLE, LINK_VELOCITY
from hda_arm_sim.model.link_side import loaded_inertia
import numpy as np

from ...measurements.motion import Motion


@compiled
def _needs(c: Array, moved: Array, wrench: Array, torque: Array) -> None:
    """Fill the torques (k, n) of angles, rates, accelerations (k, n, 3) under wrenches (k, 6)."""
    for k in range(moved.shape[0]):
        c[1:-1, chain.ANGLE:chain.SPEEDING + 1] = moved[k]
        c[-1, chain.WRENCH:chain.WRENCH + 6] = wrench[k]
        chain.place(c)
        chain.inverse_dynamics(c)
        torque[k] = c[1:-1, chain.TORQUE]


def chain_needs(arm: Arm, motion: Motion, wrench: Array) -> tuple[Array, list[Array]]:
    """
    Return torques (k, n) under a wrench (k, 6) on the tip, and what the mass of each link doubts.

    A doubt (k, n) is of one link: what its motion and weight need, times how well its mass is
    known [N*m].
    """
    table, usual = loaded_inertia(arm.record().body).table, arm.tolerances.link_inertia
    moved = np.ascontiguousarray(np.stack(
        [motion.state[:, :, LINK_ANGLE], motion.state[:, :, LINK_VELOCITY],
         motion.acceleration[:, :, 1]], axis=2))
    torque = np.empty(moved.shape[:2])
    _needs(table.copy(), moved, wrench, torque)
    doubts = []
    for row, known in enumerate(arm.links.known(usual), start=1):
        alone, need = table.copy(), np.empty_like(torque)
        others = [other for other in range(1, len(table) - 1) if other != row]
        alone[others, chain.MASS:chain.CONSTANTS] = 0.0
        _needs(alone, moved, np.zeros_like(wrench), need)
        doubts.append(known.mass * need)
    return torque, doubts


def principal(doubts: list[Array], count: int) -> Array:
    """
    Return as many independent doubts (k, n, count) as say most of what these (k, n) say.

    Of each joint they are the principal components: of all sums of so many columns those that are
    nearest in mean square.
    """
    whole = np.stack(doubts, axis=2)                            # (k, n, links)
    found = np.zeros((*whole.shape[:2], count))
    for joint in range(whole.shape[1]):
        own = whole[:, joint]
        _, ways = np.linalg.eigh(own.T @ own)
        best = ways[:, ::-1][:, :count]
        found[:, joint, :best.shape[1]] = own @ best
    return found
