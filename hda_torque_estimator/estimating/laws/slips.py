"""
Detect an encoder that slipped, its angle a step. Compiled, one joint and one sample.

A slip is one step of one side; the other side and the samples around it are as still as before.
A shaft or link that does so in truth must speed up and stop within one period, which its inertia
forbids. While the joint moves the motor's torque contradicts a slip too; at rest only this does.
"""

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.compiled import compiled, inlined

from ...samples.sample_limits import ACCELERATION, EASE, LATE, RATIO, STEP

NOTHING, OF_MOTOR, OF_LINK = 0, 1, 2

# Memory, per joint; pairs are shaft and link.
(ANGLE, WAY,                            # last angle, and the way to it [rad]
 BEFORE, EARLIER,                       # rates of the two ways before that [rad/s]
 ) = range(0, 8, 2)
TIME, LAST_TIME, COUNT = range(8, 11)   # of the last way and the one before [s]; samples so far
MEMORY = 11  # (layout)

# Choices unless stated otherwise.
_FEWEST = 4.0           # samples that distinguish a step from a change of speed
_LATE = 3.0             # periods by which one side may be late: a reading held for two of them
# A body speeds up and stops by a constant acceleration A around one period T. In it, the body goes
# at most 5/12 A T^2 farther than 3 times what it goes in the period before or after.
# (source: constant acceleration, as derived here)
_STOPPABLE = 5.0 / 12.0
_APART = 0.5            # of a step: what the other side does where only one slipped (choice)


@compiled
def look(limits: Array, memory: Array, reading: Array, torque: float, dt: float) -> int:
    """
    Return which side slipped one sample ago; dt [s] since the last sample, 0 begins anew.

    `limits` is the joint's row of the watch, `torque` what may pull at its link [N*m]. Where
    samples come so seldom that a body has the time, nothing is detected.
    """
    if dt == 0.0:
        memory[:] = 0.0
    ratio = limits[RATIO]
    span, fastest, found = max(dt, memory[TIME], memory[LAST_TIME]), 0.0, NOTHING
    for side in range(2):
        rate = (reading[side] - memory[ANGLE + side]) / dt if dt > 0.0 else 0.0
        quick = max(abs(rate), abs(memory[BEFORE + side]), abs(memory[EARLIER + side]))
        fastest = max(fastest, quick / ratio if side == 0 else quick)
    shaft, link = abs(memory[WAY]) / ratio, abs(memory[WAY + 1])
    moved = fastest * (_LATE * span + limits[LATE])
    if memory[COUNT] >= _FEWEST - 1.0:
        if shaft > moved + _still(limits[STEP], limits[ACCELERATION], span) / ratio:
            found = OF_MOTOR if link < _APART * shaft else NOTHING
        elif link > moved + _still(limits[STEP + 1], torque * limits[EASE], span):
            found = OF_LINK if shaft < _APART * link else NOTHING
    _remember(memory, reading, dt)
    return found


@inlined
def size(memory: Array, side: int, ratio: float) -> float:
    """Return the size of the slip that was just detected, at the output [rad]."""
    way = memory[BEFORE + side - OF_MOTOR] * memory[LAST_TIME]
    return way / ratio if side == OF_MOTOR else way


@inlined
def _still(step: float, acceleration: float, span: float) -> float:
    """Return how far a side goes in one sample between two in which it stands [rad]."""
    return step + _STOPPABLE * acceleration * span ** 2


@inlined
def _remember(memory: Array, reading: Array, dt: float) -> None:
    for side in range(2):
        memory[EARLIER + side] = memory[BEFORE + side]
        last = memory[TIME]
        memory[BEFORE + side] = memory[WAY + side] / last if last > 0.0 else 0.0
        memory[WAY + side] = reading[side] - memory[ANGLE + side] if dt > 0.0 else 0.0
        memory[ANGLE + side] = reading[side]
    memory[LAST_TIME], memory[TIME] = memory[TIME], dt
    memory[COUNT] += 1.0
