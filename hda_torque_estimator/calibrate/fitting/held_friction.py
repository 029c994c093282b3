"""
How much of its dry friction holds a shaft at rest, by what its motor misses there.

Friction at rest may hold anything up to its level, either way, and nobody knows what. But the
drives of some joints always come to rest alike: under one load, by one controller. Then recordings
left out show that the motor is off by less.
"""

from dataclasses import replace
import math

from hda_arm_sim.model.arm import Arm
import numpy as np
from numpy.typing import NDArray

from .arm_numbers import ArmNumber, number
from .motor_witness import MotorWitness

Floats = NDArray[np.float64]
HELD_SHARE = 'held_share'
TINY = np.finfo(float).tiny
# Choices unless stated otherwise.
FEWEST = 2              # recordings with rests, fewer do not show how others differ


def held_friction(witness: MotorWitness, arm: Arm, left: Floats) -> tuple[ArmNumber, ...]:
    """
    Return the share of the dry friction that may hold either way, (eq:held); none if all of it.

    `left` (m,) is what recordings left out are missed by [N*m]. What is missed of a sliding shaft
    as well is not held.
    """
    rests, recording = witness.rests, witness.blocks.recording
    count = len(np.unique(recording[rests]))
    if count < FEWEST:
        return ()
    level = float(np.sqrt(np.mean(witness.dry_friction(arm)[rests] ** 2)))
    missed, usual = (float(np.sum(left[rows] ** 2)) / max(int(rows.sum()), 1)
                     for rows in (rests, ~rests))       # [N^2*m^2]
    share, most = (math.sqrt(3.0 * max(size - usual, 0.0)) / max(level, TINY)
                   for size in (missed, missed * (1.0 + math.sqrt(2.0 / count))))
    if share >= 1.0:
        return ()
    return (replace(number(HELD_SHARE, share, min(most, 1.0) - share), at_bound=False),)
