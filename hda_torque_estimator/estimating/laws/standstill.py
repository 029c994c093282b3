"""
Detect a joint whose readings froze while it stood: compiled, one joint and one sample.

Where neither angle changes, the torque through the gear does not either, nor does what pulls at
the link but for the environment. Then what pushes on the joint cannot change without an angle
that shows it. A joint may seem to be held by a new force from one sample to the next, and not
yield to it by a count. Then not the joint is held, but its readings are.
"""

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.compiled import compiled, Record
from hda_arm_sim.model.torsion import stiffness_at
import numpy as np

from ...samples.sample_judge import LONGEST
from ...samples.sample_limits import RATIO, STEP

# Memory, per joint.
(MOTOR, LINK,                           # last angles [rad]
 STILL, MOVING,                         # time since one changed; from a start until then [s]
 BEFORE, DEVIATION,                     # external torque when one changed, how sure it was [N*m]
 USUAL,                                 # external torque while it moved, the most of late [N*m]
 ) = range(7)
MEMORY = 7  # (layout)

# Choices unless stated otherwise.
# (source: step response of the low-pass)
_SETTLED = 0.1          # of the observer: at 20 Hz a force of before has faded to e^-12 [s]
_FADES = 10.0           # of what was usual (choice) [s]
_FRICTION = 2.0         # times what was usual: friction of a bearing turns over at most
CERTAIN = 4.0           # deviations, as where a motor gives a torque that it cannot


@compiled
def frozen(joint: Record, limits: Array, memory: Array, reading: Array, held: Array,
           dt: float) -> bool:
    """
    Return whether a joint stands as none can; dt [s] since the last sample, 0 begins anew.

    `limits` is its row of the watch. `held` (3,) is the external torque, its deviation, both NaN
    without links, and the torque of the gear [N*m].
    """
    external, deviation, torque = held
    same = reading[0] == memory[MOTOR] and reading[1] == memory[LINK]
    memory[MOTOR], memory[LINK] = reading[0], reading[1]
    if dt == 0.0:
        memory[STILL:] = 0.0
        return False
    if not same:
        memory[MOVING] += memory[STILL] + dt
        memory[STILL] = 0.0
        memory[BEFORE], memory[DEVIATION] = external, deviation
        memory[USUAL] = max(memory[USUAL] / (1.0 + dt / _FADES), abs(external))
        return False
    memory[STILL] += dt
    if memory[STILL] < LONGEST or memory[MOVING] < _SETTLED:
        return False
    stiffness = stiffness_at(joint.torsion, joint.ratio, torque)
    unseen = stiffness * (limits[STEP] / limits[RATIO] + limits[STEP + 1])
    right = (_FRICTION * memory[USUAL] + unseen
             + CERTAIN * np.sqrt(deviation ** 2 + memory[DEVIATION] ** 2))
    return abs(external - memory[BEFORE]) > right               # NaN compares false
