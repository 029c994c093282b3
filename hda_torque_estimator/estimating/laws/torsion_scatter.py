"""
How much a torsion scatters from sample to sample, learnt from its second differences.

A torque that changes steadily leaves none, and neither does a gear's slow error. So what the motor
shows is not asked: beside a motor that scatters more, a product of both would be mostly chance.
"""

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.compiled import compiled
import numpy as np

from .fusion_memory import LAST_TWIST, LONG, PRIOR, share, TWIST_CHANGE, TWIST_SCATTER, TWIST_TIME

# What independent samples of variance 1 make of a second difference, 1 + 2^2 + 1.
_SECOND = 6.0


@compiled
def forget_twist(memory: Array) -> None:
    """Forget the last torsions, as after a gap; what was learnt of them stays."""
    memory[LAST_TWIST] = memory[TWIST_CHANGE] = np.nan
    memory[TWIST_TIME] = 0.0


@compiled
def follow_twist(memory: Array, torsion: float, moving: bool, dt: float) -> float:
    """Follow a torsion [rad] and return the variance of its samples [rad^2], (eq:twisting)."""
    change = torsion - memory[LAST_TWIST]
    second = (change - memory[TWIST_CHANGE]) ** 2 / _SECOND
    memory[LAST_TWIST], memory[TWIST_CHANGE] = torsion, change
    if moving and np.isfinite(second):
        part = max(share(dt, LONG), dt / (memory[TWIST_TIME] + PRIOR + dt))
        memory[TWIST_TIME] += dt
        memory[TWIST_SCATTER] += part * (second - memory[TWIST_SCATTER])
    return memory[TWIST_SCATTER]
