"""
The mass at the tip of a chain that its model does not know, from the external torques.

What is wrong with torques and links lasts, so time adds nothing to how sure the mass is. Means
over a few seconds are reported, with the deviation of one moment.
"""

from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.chain import ASKED, DRIFT, PLACE, SPIN, tip_velocity
from hda_arm_sim.foundation.compiled import compiled, inlined
from hda_arm_sim.foundation.vectors import cross, dot, plus, Vector, vector
import numpy as np

from .layout import MASS, MASS_DEVIATION
from .payload import HEAVIEST

PULL, WEIGHT, HEARD = range(3)      # means, and the time that they are from [s]
_PATIENCE = 2.0         # over which the mass is averaged: choice [s]


@inlined
def _held(c: Array) -> Vector:
    """Return the force that each kg at the tip needs, weight included [N/kg]."""
    last = c.shape[0] - 2
    tip, spin = vector(c, last + 1, PLACE), vector(c, last, SPIN)
    velocity = plus(vector(c, last, DRIFT), cross(spin, tip))
    return plus(plus(vector(c, last, ASKED + 3), cross(vector(c, last, ASKED), tip)),
                cross(spin, velocity))


class Felt(NamedTuple):
    """External torques, and how sure they are."""

    torque: Array               # (n,) [N*m]
    precision: Array            # (n, n) their inverse covariance


@compiled
def weigh(c: Array, memory: Array, felt: Felt, dt: float, tip: Array) -> None:
    """
    Fill the mass at the tip and its deviation by weighted least squares, (eq:chain-payload) [kg].

    `c` is the chain whose links' motion was asked for (`chain.move`).
    """
    force, need = _held(c), np.empty(len(felt.torque))
    for row in range(1, c.shape[0] - 1):
        need[row - 1] = dot(tip_velocity(c, row), force)
    weighed = need @ felt.precision
    pull, weight = -(weighed @ felt.torque), weighed @ need
    if dt == 0.0 or not np.isfinite(memory[PULL] + memory[WEIGHT]):
        memory[PULL] = memory[WEIGHT] = memory[HEARD] = 0.0
    if dt > 0.0 and np.isfinite(pull):
        memory[HEARD] += dt
        share = 1.0 - np.exp(-dt / min(memory[HEARD], _PATIENCE))
        memory[PULL] += share * (pull - memory[PULL])
        memory[WEIGHT] += share * (weight - memory[WEIGHT])
    known = memory[WEIGHT] + 1.0 / HEAVIEST ** 2
    tip[MASS], tip[MASS_DEVIATION] = memory[PULL] / known, np.sqrt(1.0 / known)
