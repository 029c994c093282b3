"""What the links of a chain ask of the gears, with a known wrench on the tip."""

from hda_arm_sim.foundation import chain
from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.compiled import compiled
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.kernel import LINK_ANGLE, LINK_VELOCITY
from hda_arm_sim.model.link_side import loaded_inertia
import numpy as np

from ...measurements.motion import MeasuredMotion


@compiled
def _needs(c: Array, moved: Array, wrench: Array, torque: Array) -> None:
    """Fill the torques (k, n) of angles, rates, accelerations (k, n, 3) under wrenches (k, 6)."""
    for k in range(moved.shape[0]):
        c[1:-1, chain.ANGLE:chain.SPEEDING + 1] = moved[k]
        c[-1, chain.WRENCH:chain.WRENCH + 6] = wrench[k]
        chain.place(c)
        chain.inverse_dynamics(c)
        torque[k] = c[1:-1, chain.TORQUE]


def chain_needs(arm: Arm, motion: MeasuredMotion, wrench: Array) -> Array:
    """Return the torques (k, n) of a motion under a wrench (k, 6) on the tip [N*m]."""
    moved = np.ascontiguousarray(np.stack(
        [motion.state[:, :, LINK_ANGLE], motion.state[:, :, LINK_VELOCITY],
         motion.acceleration[:, :, 1]], axis=2))
    torque = np.empty(moved.shape[:2])
    _needs(loaded_inertia(arm.record().body).table, moved, wrench, torque)
    return torque
