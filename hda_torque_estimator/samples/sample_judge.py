"""
Judge whether a sample can be, from an arm's limits, the last sample believed, and the time.

`judge` is compiled and keeps all that it knows in an array, so that it runs inside a loop as well
as behind a node. A sample with a fault changes nothing that is believed.
"""

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.compiled import compiled, inlined
from hda_arm_sim.sensors import LINK, MOTOR
import numpy as np

from .sample_faults import Fault
from .sample_limits import (
    ACCELERATION, ALLOWED_APART, LARGEST, LATE, LATENESS, RATIO, SPEED, STEP, WOUND, ZERO)

# Memory, per joint (n, WATCH_MEMORY); pairs are shaft and link.
(LAST, ANCHOR, FIRST, DOUBTED, CHANGE, EARLIER, STILL, REPEATS, FROM, SUM,
 MOVED, LOST) = range(0, 24, 2)
# In row 0, of all joints.
STARTED, SINCE_ANCHOR, PERIOD, IN_TURN, WAS_LATE, DOUBTS, BELIEVED_SINCE = range(24, 31)
WATCH_MEMORY = 31  # (layout)

# Choices unless stated otherwise.
WINDOW = 0.02           # over which rates are judged: the time in which to stop [s]
ENCODERS = 5e-3         # waves of both encoders and the gear, ten times what is usual [rad]
# (measured: a link encoder of a real arm was bent by 0.003)
SCALE = 0.01            # of the way travelled, that a link encoder may err
STRIDE = 8.0            # counts per sample from which on an encoder does not repeat by chance
BY_CHANCE = 1e-8        # of a streak of lost samples: one in a day at 1 kHz
USUAL = 0.14            # of samples that a bad link loses, before a log has shown its own share,
KNOWN = 50.0            # samples on the way that weigh as much as that
FEWEST = 5              # repeats: at a share of 2.5 % so many are one in 1e8
LONGEST = 0.010         # repeats that happen: half of the time in which to stop [s]
BACK = 1.0              # a clock that went back, not a message that came late [s]
NEAR_TURN = 0.3         # choice: a jump of any size looks like turns in one case of ten [rad]
IN_TURNS = 3               # in which stamps alternate: a swapped pair of messages alternates once


@inlined
def _say(details: Array, joint: int, side: int, got: float, right: float, seconds: float) -> None:
    details[0], details[1], details[2], details[3], details[4] = joint, side, got, right, seconds


@inlined
def _twist(limits: Array, j: int, motor: float, link: float) -> float:
    """Return how far a joint is twisted at its output [rad]."""
    return ((motor - limits[j, ZERO + MOTOR]) / limits[j, RATIO]
            - (link - limits[j, ZERO + LINK]))


@inlined
def _angles(limits: Array, reading: Array, details: Array) -> Fault:
    """Judge the angles alone."""
    for j in range(reading.shape[0]):
        for side in range(2):
            angle = reading[j, side]
            if not np.isfinite(angle):
                _say(details, j, side, angle, 0.0, 0.0)
                return Fault.NOT_FINITE
            scale = limits[j, RATIO] if side == MOTOR else 1.0
            if abs(angle - limits[j, ZERO + side]) > limits[j, LARGEST] * scale:
                _say(details, j, side, angle, limits[j, LARGEST] * scale, 0.0)
                return Fault.BEYOND_ANGLE
    return Fault.NONE


@inlined
def _turned(limits: Array, memory: Array, reading: Array, way: float, j: int, side: int,
            seconds: float) -> bool:
    """Return whether a way that cannot be is one that can and whole turns, of one side only."""
    usual = memory[j, CHANGE + side] * seconds / max(memory[0, PERIOD], 1e-9)
    turns = np.round((way - usual) / (2.0 * np.pi))
    twist = (_twist(limits, j, reading[j, MOTOR], reading[j, LINK])
             - _twist(limits, j, memory[j, LAST + MOTOR], memory[j, LAST + LINK]))
    return (turns != 0.0 and abs(way - usual - 2.0 * np.pi * turns) <= NEAR_TURN
            and abs(twist) > limits[j, WOUND])


@inlined
def _fewest(memory: Array, j: int, side: int) -> float:
    """Return how many repeats are no streak of lost samples, by the share that a log has lost."""
    share = (memory[j, LOST + side] + USUAL * KNOWN) / (memory[j, MOVED + side] + KNOWN)
    return max(FEWEST, np.log(BY_CHANCE) / np.log(share))


@inlined
def _since(memory: Array, j: int, side: int, seconds: float, dt: float) -> float:
    """Return in which time a side may have turned: a streak of lost samples hides its way [s]."""
    hides = 0.0 < memory[j, REPEATS + side] < _fewest(memory, j, side)
    return max(seconds, memory[j, STILL + side] + dt) if hides else seconds


@inlined
def _way(limits: Array, memory: Array, reading: Array, place: int, seconds: float, dt: float,
         details: Array) -> Fault:
    """Judge how far all sides have turned since the angles at a place of the memory."""
    for j in range(reading.shape[0]):
        for side in range(2):
            scale = 1.0 if side == MOTOR else 1.0 / limits[j, RATIO]
            way = reading[j, side] - memory[j, place + side]
            passed = _since(memory, j, side, seconds, dt)
            right = limits[j, SPEED] * scale * (passed + LATENESS) + limits[j, STEP + side]
            if side == LINK:
                right += limits[j, WOUND]
            if abs(way) > right:
                _say(details, j, side, way, right, passed)
                whole = _turned(limits, memory, reading, way, j, side, seconds)
                return Fault.TURN if whole else Fault.JUMP
    return Fault.NONE


@inlined
def _together(limits: Array, memory: Array, reading: Array, dt: float, seconds: float,
              details: Array) -> Fault:
    """Judge whether shaft and link of every joint went the same way."""
    for j in range(reading.shape[0]):
        motor, link = reading[j, MOTOR], reading[j, LINK]
        now = _twist(limits, j, motor, link)
        steps = limits[j, STEP + MOTOR] / limits[j, RATIO] + limits[j, STEP + LINK]
        shaft_way = abs(motor - memory[j, ANCHOR + MOTOR]) / limits[j, RATIO]
        link_way = abs(link - memory[j, ANCHOR + LINK])
        late = limits[j, LATE] * min(shaft_way, link_way) / (seconds + limits[j, LATE])
        quick = now - _twist(limits, j, memory[j, ANCHOR + MOTOR], memory[j, ANCHOR + LINK])
        right = limits[j, WOUND] + steps + late + SCALE * min(shaft_way, link_way)
        slow = now - _twist(limits, j, memory[j, FIRST + MOTOR], memory[j, FIRST + LINK])
        ever = right + ENCODERS + SCALE * abs(link - memory[j, FIRST + LINK])
        if abs(quick) > right or abs(slow) > ever:
            sudden = abs(quick) > right
            away = quick if sudden else slow
            shift = motor - memory[j, LAST + MOTOR]
            if sudden and _turned(limits, memory, reading, shift, j, MOTOR, dt):
                _say(details, j, MOTOR, shift, right * limits[j, RATIO], dt)
                return Fault.TURN
            _say(details, j, LINK, away, right if sudden else ever, seconds)
            return Fault.APART
    return Fault.NONE


@inlined
def _stride(memory: Array, j: int, side: int) -> float:
    """Return how far a side went per sample before it repeated: the lesser of two steps [rad]."""
    if memory[j, REPEATS + side] > 0.0:
        return memory[j, FROM + side]
    last, earlier = memory[j, CHANGE + side], memory[j, EARLIER + side]
    if last * earlier <= 0.0:
        return 0.0                              # coarse counts, which now and then repeat
    return last if abs(last) < abs(earlier) else earlier


@inlined
def _cannot_stop(limits: Array, memory: Array, j: int, side: int, dt: float) -> bool:
    """Return whether a side goes by steps that no torque could stop in one sample."""
    scale = 1.0 if side == MOTOR else 1.0 / limits[j, RATIO]
    span = max(dt, memory[0, PERIOD])
    stoppable = limits[j, ACCELERATION] * scale * span ** 2     # twice what it takes
    return abs(_stride(memory, j, side)) > STRIDE * limits[j, STEP + side] + stoppable


@inlined
def _frozen(limits: Array, memory: Array, reading: Array, dt: float, details: Array) -> Fault:
    """Judge angles that repeat exactly right after steps that no torque could stop in one."""
    for j in range(reading.shape[0]):
        for side in range(2):
            still = memory[j, STILL + side] + dt
            if (reading[j, side] == memory[j, LAST + side] and still >= LONGEST
                    and memory[j, REPEATS + side] + 1.0 >= _fewest(memory, j, side)
                    and _cannot_stop(limits, memory, j, side, dt)):
                _say(details, j, side, _stride(memory, j, side), LONGEST, still)
                return Fault.FROZEN
    return Fault.NONE


@inlined
def _count_lost(limits: Array, memory: Array, j: int, side: int, dt: float) -> None:
    """Count a sample on the way, with the repeats before it; an outage is a few of them."""
    if _cannot_stop(limits, memory, j, side, dt):
        lost = min(memory[j, REPEATS + side], FEWEST)
        memory[j, LOST + side] += lost
        memory[j, MOVED + side] += 1.0 + lost


@inlined
def _velocities(limits: Array, memory: Array, reading: Array, seconds: float,
                details: Array) -> Fault:
    """Judge given velocities: what they add up to must be the way that was turned."""
    if reading.shape[1] < 4:
        return Fault.NONE
    for j in range(reading.shape[0]):
        for side in range(2):
            scale = 1.0 if side == MOTOR else 1.0 / limits[j, RATIO]
            way = abs(reading[j, side] - memory[j, ANCHOR + side])
            right = (3.0 * way + 4.0 * limits[j, STEP + side]
                     + 0.2 * limits[j, SPEED] * scale * (seconds + LATENESS))
            summed = abs(memory[j, SUM + side])
            if seconds >= WINDOW and summed > right:            # NaN compares false
                _say(details, j, side, summed, right, seconds)
                return Fault.SPEED
    return Fault.NONE


@inlined
def _believe(limits: Array, memory: Array, reading: Array, dt: float) -> None:
    """Take a sample for what is so."""
    first = memory[0, STARTED] == 0.0
    seconds = memory[0, SINCE_ANCHOR] + dt
    anew = first or seconds >= WINDOW
    for j in range(reading.shape[0]):
        for side in range(2):
            angle = reading[j, side]
            change = 0.0 if first else angle - memory[j, LAST + side]
            if change == 0.0 and not first:
                memory[j, FROM + side] = _stride(memory, j, side)
                memory[j, REPEATS + side] += 1.0
                memory[j, STILL + side] += dt
            else:
                _count_lost(limits, memory, j, side, dt)
                memory[j, REPEATS + side] = memory[j, STILL + side] = 0.0
            memory[j, EARLIER + side] = memory[j, CHANGE + side]
            memory[j, CHANGE + side] = change / max(1.0, dt / max(memory[0, PERIOD], 1e-9))
            memory[j, LAST + side] = angle
            if first:
                memory[j, FIRST + side] = angle
            if reading.shape[1] >= 4:
                memory[j, SUM + side] += reading[j, side + 2] * dt
            if anew:
                memory[j, ANCHOR + side], memory[j, SUM + side] = angle, 0.0
    memory[0, SINCE_ANCHOR] = 0.0 if anew else seconds
    if not first:
        usual = memory[0, PERIOD]
        memory[0, PERIOD] = dt if usual == 0.0 else usual + 0.05 * (min(dt, 4.0 * usual) - usual)
    memory[0, STARTED], memory[0, WAS_LATE] = 1.0, 0.0
    memory[0, BELIEVED_SINCE] = 1.0


@inlined
def _stamps(memory: Array, dt: float, details: Array) -> Fault:
    """Judge a stamp that is not later than the last one."""
    _say(details, 0, MOTOR, dt, 0.0, 0.0)
    if dt <= -BACK:
        return Fault.CLOCK_BACK
    if dt < 0.0 and memory[0, WAS_LATE] == 0.0:
        memory[0, IN_TURN] += 1.0
        memory[0, WAS_LATE] = 1.0
        if memory[0, IN_TURN] >= IN_TURNS:
            _say(details, 0, MOTOR, dt, 0.0, -1.0)
            return Fault.TWO_PUBLISHERS
    return Fault.NOT_LATER


@inlined
def _doubt(limits: Array, memory: Array, reading: Array, fault: Fault, details: Array) -> Fault:
    """Keep a sample that is not believed; one like the last such, with good ones between: two."""
    again = memory[0, DOUBTS] > 0.0 and memory[0, BELIEVED_SINCE] > 0.0
    for j in range(reading.shape[0]):
        for side in range(2):
            scale = 1.0 if side == MOTOR else 1.0 / limits[j, RATIO]
            near = limits[j, SPEED] * scale * WINDOW + limits[j, STEP + side]
            if not abs(reading[j, side] - memory[j, DOUBTED + side]) <= near:
                again = False
            memory[j, DOUBTED + side] = reading[j, side]
    memory[0, DOUBTS] += 1.0
    memory[0, BELIEVED_SINCE] = 0.0
    if again:
        j, side = int(details[0]), int(details[1])
        _say(details, j, side, reading[j, side], memory[j, LAST + side], 0.0)
        return Fault.TWO_PUBLISHERS
    return fault


@compiled
def judge(limits: Array, memory: Array, reading: Array, dt: float, details: Array) -> Fault:
    """
    Return the number of the fault of a sample, 0 if it can be believed, which it then is.

    `limits` is (n, LIMITS), `memory` (n, WATCH_MEMORY) of zeros before the first sample. `reading`
    has angles of shaft and link (n, 2) [rad], or (n, 4) with velocities, NaN where none is given.
    `dt` [s] is since the last sample that was believed, 0 for the first. `details` (5,) is filled
    as `FaultDetails` says.
    """
    fault = _angles(limits, reading, details)
    if fault != Fault.NONE:
        return fault
    if memory[0, STARTED] == 0.0:
        for j in range(reading.shape[0]):
            away = _twist(limits, j, reading[j, MOTOR], reading[j, LINK])
            if abs(away) > limits[j, WOUND] + limits[j, ALLOWED_APART]:
                _say(details, j, LINK, away, limits[j, WOUND] + limits[j, ALLOWED_APART], 0.0)
                return Fault.APART
        _believe(limits, memory, reading, 0.0)
        return Fault.NONE
    if not dt > 0.0:
        return _stamps(memory, dt, details)
    seconds = memory[0, SINCE_ANCHOR] + dt
    fault = _way(limits, memory, reading, LAST, dt, dt, details)
    if fault == Fault.NONE:
        fault = _way(limits, memory, reading, ANCHOR, seconds, dt, details)
    if fault == Fault.NONE:
        fault = _together(limits, memory, reading, dt, seconds, details)
    if fault != Fault.NONE:
        return _doubt(limits, memory, reading, fault, details)
    fault = _frozen(limits, memory, reading, dt, details)
    if fault == Fault.NONE:
        fault = _velocities(limits, memory, reading, seconds, details)
    if memory[0, WAS_LATE] == 0.0:
        memory[0, IN_TURN] = 0.0                # two good ones in a row: nobody else speaks
    _believe(limits, memory, reading, dt)
    return fault
