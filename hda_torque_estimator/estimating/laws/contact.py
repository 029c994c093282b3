"""
Distinguish contacts from free motion by the external torques and how sure they are (eq:chi).

Two levels: a contact ends by itself when the arm is let go, a collision stays until the reset.
"""

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.compiled import compiled
import numpy as np
from scipy.special import gammaincc, gammainccinv

# Memory: contact now, time since it was last felt [s], collisions felt, contacts so far.
TOUCHING, CALM, COLLIDED, CONTACTS = range(4)
MEMORY = 4  # (layout)

FREE, CONTACT, COLLISION = 0.0, 1.0, 2.0  # (layout)
_NAMES = {CONTACT: 'contact', COLLISION: 'collision'}

FEW = 2                 # joints to which `contact_deviations` refer (choice)
# Choices unless stated otherwise.
_RELEASE = 0.5          # of the level, below which a contact is over
_HOLD = 0.1             # time for which it must be [s]


def contact_name(level: float) -> str:
    """Return the name of a level, that of no contact where links are unknown."""
    return _NAMES.get(level, 'free')


def contact_level(deviations: float, joints: int) -> float:
    """
    Return the deviations of all joints together from which on they mean a contact.

    `deviations` are those of one or two joints. More exceed them by chance more often. So their
    level is the one with the same chance, by the chi-square distribution.
    """
    if joints <= FEW:
        return deviations
    chance = float(gammaincc(0.5 * FEW, 0.5 * deviations ** 2))
    return float(np.sqrt(2.0 * gammainccinv(0.5 * joints, chance)))


@compiled
def deviations(torque: Array, deviation: Array) -> float:
    """Return external torques (n,) over their deviations, all joints together, (eq:chi)."""
    return np.sqrt(((torque / deviation) ** 2).sum())


@compiled
def feel(memory: Array, felt: float, torque: Array, contact_deviations: float,
         collision_torque: float, dt: float) -> float:
    """
    Renew the memory from `felt` deviations of external torques (n,); returns the level.

    A collision is a contact whose torques, all joints together, exceed `collision_torque` [N*m].
    """
    if felt > contact_deviations:
        memory[CONTACTS] += 1.0 - memory[TOUCHING]
        memory[TOUCHING] = 1.0
        if np.sqrt((torque ** 2).sum()) > collision_torque:
            memory[COLLIDED] = 1.0
    memory[CALM] = 0.0 if felt > _RELEASE * contact_deviations else memory[CALM] + dt
    if memory[CALM] >= _HOLD:
        memory[TOUCHING] = 0.0
    return level(memory)


@compiled
def level(memory: Array) -> float:
    """Return the level by what was felt so far."""
    if memory[COLLIDED] > 0.0:
        return COLLISION
    return CONTACT if memory[TOUCHING] > 0.0 else FREE
