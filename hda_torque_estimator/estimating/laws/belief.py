"""
Why an estimate is not believed: compiled, before and after each sample's step of the estimator.

What no arm can do (`sample_watch.py`) is never estimated from: such a sample has no torque, and
leaves no trace in the memory. Everything that makes `valid` false, or is flagged beside it, is one
number in `layout.DOUBT`; `belief_words.py` has its sentence.
"""

from typing import Any

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.compiled import compiled, inlined
from hda_arm_sim.model.arm import ArmRecord
from hda_arm_sim.model.motor_side import limit_of
import numpy as np
from numpy.typing import NDArray

from . import fusion_memory as fusion, slips, standstill
from ...samples import coupling
from ...samples.sample_faults import Fault
from ...samples.sample_judge import judge, STARTED
from ...samples.sample_limits import RATIO, SPEED, STEP, STRONGER

# Doubts: faults of samples have the numbers of `Fault`; then come other reasons, worst last.
BELIEVED, APART, CHANGED, IMPOSSIBLE, LOST = 0.0, 20.0, 21.0, 22.0, 23.0  # (layout)
SLIPPED = 24.0          # and the side: the shaft or the link (layout)
MOTOR_ALONE = 27.0      # as APART, where the motor is the better witness (layout)
CLOCK_BACK, TWO_PUBLISHERS, FROZEN = (
    float(fault) for fault in (Fault.CLOCK_BACK, Fault.TWO_PUBLISHERS, Fault.FROZEN))
COUPLED = 40.0          # and the kind of coupling, which may be negative (layout)

# Memory, per joint: that of the coupling. In row 0 also what concerns all joints.
(FAULT, AGE,            # the last fault of a sample, and time since [s]
 HELD,                  # since the last sample that was believed [s]
 LOSING, LOSSES,        # time of unbelieved samples in a row [s]; 1 once the watch began anew
 UNBELIEVED,            # samples so far
 ) = range(coupling.MEMORY, coupling.MEMORY + 6)
ANGLE, RATE, STILL = range(coupling.MEMORY + 6, coupling.MEMORY + 12, 2)    # of shaft and link
LEAST, GAINED = range(coupling.MEMORY + 12, coupling.MEMORY + 16, 2)
SLIPS = coupling.MEMORY + 16            # from here on the memory of slips
STANDING = SLIPS + slips.MEMORY         # and of joints that stand
PULL = STANDING + standstill.MEMORY     # at the link at the last sample [N*m]
PULLED = PULL + 1                       # at the one before, which a slip has not spoilt
MEMORY = PULLED + 1

# Choices unless stated otherwise.
SHOWN = 0.1             # time for which a fault is reported: 5 states at 50 Hz (choice) [s]
LONGEST = 0.1           # of unbelieved samples in a row, then the watch begins anew (choice) [s]
LEAST_STILL = 0.01      # of angle and velocity that repeat, half of the time to detect it [s]
GROWN = 32.0            # counts by a velocity that grows while its angle repeats (choice)
PASSED = 2.0            # counts that a shaft would have passed: coarse encoders repeat one
ABSURD = 3.0            # times what the watch allows, from which a velocity is no velocity
OVERLOAD = 10.0         # times the torque limit, from which a motor torque is no torque


@inlined
def of_fusion(learning: Array) -> float:
    """Return the doubt that motor and torsion cast on a joint's torque."""
    if learning[fusion.SLIPPED] > 0.0:
        return SLIPPED + learning[fusion.SIDE]
    if learning[fusion.IMPOSSIBLE] > 0.0:
        return IMPOSSIBLE
    if learning[fusion.CHANGED] > 0.0:
        return CHANGED
    if learning[fusion.APART] > 0.0:
        return MOTOR_ALONE if learning[fusion.MOTOR_ALONE] > 0.0 else APART
    return BELIEVED


@compiled
def begin(memory: Array, watch: Array) -> None:
    """Expect nothing of the next sample: after a gap anything may have happened."""
    memory[:, FAULT:] = 0.0
    for j in range(memory.shape[0]):
        coupling.restart(memory[j])
    watch[:] = 0.0


@compiled
def look(record: ArmRecord, limits: Array, watch: Array, memory: Array, reading: Array,
         seconds: float, details: Array) -> float:
    """
    Judge a sample; returns the time since the last one that was believed, negative if this is not.

    `seconds` is the time since the last sample, 0 for one that begins afresh.
    """
    if seconds == 0.0:
        begin(memory, watch)
    since = memory[0, HELD] + seconds
    anew = watch[0, STARTED] == 0.0
    fault = judge(limits, watch, reading, since, details)
    memory[0, AGE] += seconds
    if _stuck(limits, memory, reading, seconds):
        memory[0, FAULT], memory[0, AGE] = FROZEN, 0.0
    if fault != Fault.NONE:
        memory[0, FAULT], memory[0, AGE] = fault.value, 0.0
    if fault == Fault.NONE or fault == Fault.FROZEN or fault == Fault.SPEED:
        memory[0, HELD] = memory[0, LOSING] = 0.0
        _couple(record, memory, reading)
        return 0.0 if anew else since
    memory[0, HELD] = since
    memory[0, LOSING] += seconds
    memory[0, UNBELIEVED] += 1.0
    if fault == Fault.APART:
        _couple(record, memory, reading)
    else:
        for j in range(memory.shape[0]):
            coupling.restart(memory[j])
    if memory[0, LOSING] > LONGEST:
        memory[0, LOSING], memory[0, LOSSES] = 0.0, 1.0
        memory[0, HELD] = 0.0
        watch[:] = 0.0
    return -1.0


@inlined
def _stuck(limits: Array, memory: Array, reading: Array, seconds: float) -> bool:
    """
    Return whether an angle and its velocity, which is not zero, repeat to the last bit.

    A velocity may be filtered and late, but then it decays where a shaft stands. So it must not
    gain a way either, above its least since the angle repeats.
    """
    found = False
    for j in range(reading.shape[0]):
        for side in range(2):
            angle, rate = reading[j, side], reading[j, 2 + side]
            same = angle == memory[j, ANGLE + side] and rate == memory[j, RATE + side]
            still = memory[j, STILL + side] + seconds if same else 0.0
            if _gains(limits, memory, angle, rate, j, side, seconds):
                found = True
            memory[j, ANGLE + side], memory[j, RATE + side] = angle, rate
            memory[j, STILL + side] = still
            if still >= LEAST_STILL and abs(rate) * still > PASSED * limits[j, STEP + side]:
                found = True
    return found


@inlined
def _gains(limits: Array, memory: Array, angle: float, rate: float, j: int, side: int,
           seconds: float) -> bool:
    """Return whether a velocity grows and means many counts while its angle repeats."""
    if angle != memory[j, ANGLE + side] or not np.isfinite(rate):
        memory[j, LEAST + side], memory[j, GAINED + side] = abs(rate), 0.0
        return False
    least = min(memory[j, LEAST + side], abs(rate))
    grown = np.sign(rate) * (abs(rate) - least)
    gained = memory[j, GAINED + side] / (1.0 + seconds / SHOWN) + grown * seconds
    memory[j, LEAST + side], memory[j, GAINED + side] = least, gained
    return abs(gained) > GROWN * limits[j, STEP + side]


@inlined
def _couple(record: ArmRecord, memory: Array, reading: Array) -> None:
    for j in range(reading.shape[0]):
        joint = record.joints[j]
        coupling.add(memory[j], reading[j, 0], reading[j, 1], joint.ratio,
                     coupling.twist_of(joint.torsion.valid_torsion), coupling.disc_of(joint))


@compiled
def sane(limits: Array, joints: NDArray[Any], reading: Array, command: Array, clean: Array,
         given: Array) -> None:
    """Copy a sample with no velocity and no motor torque where there is an absurd one."""
    for j in range(reading.shape[0]):
        clean[j, :] = reading[j]
        for side in range(2):
            scale = 1.0 if side == 0 else 1.0 / limits[j, RATIO]
            if not abs(reading[j, 2 + side]) <= ABSURD * limits[j, SPEED] * scale:
                clean[j, 2 + side] = np.nan
        most = OVERLOAD * limit_of(joints[j]).limit
        given[j] = command[j] if abs(command[j]) <= most else np.nan


@compiled
def feel_slips(record: ArmRecord, limits: Array, memory: Array, learning: Array, reading: Array,
               dt: float) -> None:
    """
    Let the fusion of each joint (n, ...) doubt its zero after a slip.

    What pulled at the links before that are gears and environment; twice, for what they did since.
    """
    torque = 0.0
    for j in range(memory.shape[0]):
        torque += STRONGER * memory[j, PULLED]
    for j in range(memory.shape[0]):
        side = slips.look(limits[j], memory[j, SLIPS:STANDING], reading[j], torque, dt)
        if side != slips.NOTHING:
            size = slips.size(memory[j, SLIPS:STANDING], side, limits[j, RATIO])
            zero = record.joints[j].tolerances.torsion_zero
            fusion.slipped(learning[j], side, size / max(zero, 1e-12))


@compiled
def feel_standstill(record: ArmRecord, limits: Array, memory: Array, reading: Array, held: Array,
                    dt: float) -> None:
    """
    Blame readings that froze while their joint stood.

    `held` (n, 3) is the external torque of each joint, its deviation, the torque of the gear.
    """
    for j in range(memory.shape[0]):
        memory[j, PULLED] = memory[j, PULL]
        memory[j, PULL] = abs(held[j, 2]) + abs(held[j, 0]) + standstill.CERTAIN * held[j, 1]
        if standstill.frozen(record.joints[j], limits[j], memory[j, STANDING:PULL], reading[j],
                             held[j], dt):
            blame(memory, FROZEN)


@compiled
def blame(memory: Array, fault: float) -> None:
    """Report a fault that the stamps show."""
    memory[0, FAULT], memory[0, AGE] = fault, 0.0


@compiled
def doubt(memory: Array, j: int, of_joint: float) -> float:
    """Return the worst doubt of joint j, with what motor and torsion say of each other."""
    kind = memory[j, coupling.KIND]
    if kind != coupling.RIGHT:
        return COUPLED + kind
    fault = memory[0, FAULT]
    if fault != BELIEVED and memory[0, AGE] < SHOWN:
        return fault
    return LOST if memory[0, LOSSES] > 0.0 else of_joint
