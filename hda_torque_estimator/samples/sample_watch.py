"""
Say what the next sample of an arm can be, from its limits, the last one believed, and the time.

`judge` is compiled and keeps all that it knows in an array, so that it runs inside a loop as well
as behind a node. A sample with a fault changes nothing that is believed. Bounds are wide: they
tell what no arm can do, not what this arm should do.
"""

import math

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.compiled import compiled, inlined
from hda_arm_sim.foundation.rigid import mass_matrix
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.chain_links import ChainLinks
from hda_arm_sim.model.link_side import loaded_inertia
from hda_arm_sim.model.stiffness_rate import masses
from hda_arm_sim.sensors import LINK, MOTOR
import numpy as np

from .sample_faults import Fault, sentence, Told

# Limits, per joint (n, LIMITS); angles and steps of both sides at their own shafts.
(LARGEST, SPEED, ACCELERATION,          # link [rad]; shaft [rad/s, rad/s^2]
 RATIO, ZERO, STEP, WOUND, ALLOWED_APART, LATE,
 EASE,                                  # of a link, infinite without links [rad/s^2/(N*m)]
 ) = 0, 1, 2, 3, 4, 6, 8, 9, 10, 11
LIMITS = 12  # (layout)

# Memory, per joint (n, WATCH_MEMORY); pairs are shaft and link.
LAST, ANCHOR, FIRST, DOUBTED, CHANGE, EARLIER, STILL, REPEATS, FROM, SUM = range(0, 20, 2)
# In row 0, of all joints.
STARTED, SINCE_ANCHOR, PERIOD, IN_TURN, WAS_LATE, DOUBTS, BELIEVED_SINCE = range(20, 27)
WATCH_MEMORY = 27  # (layout)

# Choices unless told otherwise.
FASTER = 1.5            # than the declared limit: choice; supply and overhauling loads add 10-20 %
WIDER = 0.05            # than the angle limit: a step of the reference that is let through [rad]
STRONGER = 2.0          # than limits and declared inertia tell: inertia of an unnamed rotor
LATENESS = 2e-3         # between two stamps of a host: each is up to 1 ms late (choice) [s]
POSTURES = 64           # of a chain, drawn at random: choice, a tenth of a second
POSED = 2.0             # than in the lightest of them: choice; in others links are lighter still
WINDOW = 0.02           # over which rates are judged: the time in which to stop [s]
SOFTER = 2.0            # than the declared torsion: stiffness of a gear known by its class
WIDEST = 0.05           # torsion where the law is valid without end: 30 times a usual gear [rad]
ENCODERS = 5e-3         # waves of both encoders and the gear, ten times what is usual [rad]
# (measured: a link encoder of a real arm was bent by 0.003)
SCALE = 0.01            # of the way travelled, that a link encoder may err
# (source: normal distribution, six deviations for each of two readings)
NOISE = 12.0            # deviations of noise between two readings: six each, never in a lifetime
STRIDE = 8.0            # counts per sample from which on an encoder does not repeat by chance
# (source: 0.14 to the fifth power)
FEWEST = 5              # repeats: at 14 % lost samples, 5e-5 by chance, and 10 ms of them less
LONGEST = 0.010         # repeats that happen: half of the time in which to stop [s]
BACK = 1.0              # a clock that went back, not a message that came late [s]
NEAR_TURN = 0.3         # choice: a jump of any size looks like turns in one case of ten [rad]
IN_TURNS = 3               # in which stamps alternate: a swapped pair of messages alternates once


def watch_limits(arm: Arm, *, apart: float = math.inf) -> Array:
    """
    Return what the samples of an arm can be (n, LIMITS).

    `apart` is how far motor angle / ratio and link angle may differ at the first sample, beyond
    torsion [rad]. It is infinite where the zeros of the encoders are not known.
    """
    made = np.zeros((len(arm.joints), LIMITS))
    for row, joint, numbers in zip(made, arm.joints, arm.record().joints):
        strongest = (joint.torque_limit + joint.dry_friction
                     + joint.torsion.valid_torque / joint.ratio)
        noise = NOISE * np.array([joint.motor_encoder.noise, joint.link_encoder.noise])
        counts = [numbers['coarse_quantisation'][f'{side}_step'] for side in ('motor', 'link')]
        row[LARGEST] = joint.angle_limit + WIDER
        row[SPEED] = FASTER * joint.velocity_limit
        row[ACCELERATION] = STRONGER * strongest / numbers['motor_inertia']
        row[RATIO] = joint.ratio
        row[ZERO:ZERO + 2] = joint.motor_encoder.zero, joint.link_encoder.zero
        row[STEP:STEP + 2] = counts + noise
        wound = SOFTER * numbers['torsion']['valid_torsion']
        row[WOUND] = 2.0 * (min(wound, WIDEST) + numbers['backlash']['half_width'])
        row[ALLOWED_APART] = apart
        row[LATE] = LATENESS + abs(numbers['clock_skew']['skew'])
    made[:, EASE] = _ease(arm)
    return made


def _ease(arm: Arm) -> Array:
    """Return the most that a torque at any joint speeds each link up, at any elbow (n,)."""
    joints = len(arm.joints)
    if arm.links is None:
        return np.full(joints, math.inf)
    if isinstance(arm.links, ChainLinks):
        return np.max([POSED * np.abs(np.linalg.inv(mass)).max(axis=1)
                       for mass in masses(arm, POSTURES)], axis=0)
    first, both, second = mass_matrix(loaded_inertia(arm.record().body),
                                      np.linspace(0.0, math.pi, 181))
    if joints == 1:
        return 1.0 / np.min(first, keepdims=True)
    whole, across = first * second - both ** 2, abs(both)
    return np.array([np.max(np.maximum(own, across) / whole) for own in (second, first)])


@inlined
def _say(told: Array, joint: int, side: int, got: float, right: float, seconds: float) -> None:
    told[0], told[1], told[2], told[3], told[4] = joint, side, got, right, seconds


@inlined
def _twist(limits: Array, j: int, motor: float, link: float) -> float:
    """Return how far a joint is twisted at its output [rad]."""
    return ((motor - limits[j, ZERO + MOTOR]) / limits[j, RATIO]
            - (link - limits[j, ZERO + LINK]))


@inlined
def _angles(limits: Array, reading: Array, told: Array) -> Fault:
    """Judge the angles alone."""
    for j in range(reading.shape[0]):
        for side in range(2):
            angle = reading[j, side]
            if not np.isfinite(angle):
                _say(told, j, side, angle, 0.0, 0.0)
                return Fault.NOT_FINITE
            scale = limits[j, RATIO] if side == MOTOR else 1.0
            if abs(angle - limits[j, ZERO + side]) > limits[j, LARGEST] * scale:
                _say(told, j, side, angle, limits[j, LARGEST] * scale, 0.0)
                return Fault.BEYOND_ANGLE
    return Fault.NONE


@inlined
def _turned(limits: Array, memory: Array, reading: Array, way: float, j: int, side: int,
            seconds: float) -> bool:
    """Tell whether a way that cannot be is one that can and whole turns, of one side only."""
    usual = memory[j, CHANGE + side] * seconds / max(memory[0, PERIOD], 1e-9)
    turns = np.round((way - usual) / (2.0 * np.pi))
    twist = (_twist(limits, j, reading[j, MOTOR], reading[j, LINK])
             - _twist(limits, j, memory[j, LAST + MOTOR], memory[j, LAST + LINK]))
    return (turns != 0.0 and abs(way - usual - 2.0 * np.pi * turns) <= NEAR_TURN
            and abs(twist) > limits[j, WOUND])


@inlined
def _way(limits: Array, memory: Array, reading: Array, place: int, seconds: float,
         told: Array) -> Fault:
    """Judge how far all sides have turned since the angles at a place of the memory."""
    for j in range(reading.shape[0]):
        for side in range(2):
            scale = 1.0 if side == MOTOR else 1.0 / limits[j, RATIO]
            way = reading[j, side] - memory[j, place + side]
            right = limits[j, SPEED] * scale * (seconds + LATENESS) + limits[j, STEP + side]
            if side == LINK:
                right += limits[j, WOUND]
            if abs(way) > right:
                _say(told, j, side, way, right, seconds)
                whole = _turned(limits, memory, reading, way, j, side, seconds)
                return Fault.TURN if whole else Fault.JUMP
    return Fault.NONE


@inlined
def _together(limits: Array, memory: Array, reading: Array, dt: float, seconds: float,
              told: Array) -> Fault:
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
                _say(told, j, MOTOR, shift, right * limits[j, RATIO], dt)
                return Fault.TURN
            _say(told, j, LINK, away, right if sudden else ever, seconds)
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
def _frozen(limits: Array, memory: Array, reading: Array, dt: float, told: Array) -> Fault:
    """Judge angles that repeat exactly right after steps that no torque could stop in one."""
    span = max(dt, memory[0, PERIOD])
    for j in range(reading.shape[0]):
        for side in range(2):
            if reading[j, side] != memory[j, LAST + side]:
                continue
            scale = 1.0 if side == MOTOR else 1.0 / limits[j, RATIO]
            before = _stride(memory, j, side)
            stoppable = limits[j, ACCELERATION] * scale * span ** 2     # twice what it takes
            still = memory[j, STILL + side] + dt
            if (abs(before) > STRIDE * limits[j, STEP + side] + stoppable and still >= LONGEST
                    and memory[j, REPEATS + side] + 1.0 >= FEWEST):
                _say(told, j, side, before, LONGEST, still)
                return Fault.FROZEN
    return Fault.NONE


@inlined
def _velocities(limits: Array, memory: Array, reading: Array, seconds: float,
                told: Array) -> Fault:
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
                _say(told, j, side, summed, right, seconds)
                return Fault.SPEED
    return Fault.NONE


@inlined
def _believe(memory: Array, reading: Array, dt: float) -> None:
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
def _stamps(memory: Array, dt: float, told: Array) -> Fault:
    """Judge a stamp that is not later than the last one."""
    _say(told, 0, MOTOR, dt, 0.0, 0.0)
    if dt <= -BACK:
        return Fault.CLOCK_BACK
    if dt < 0.0 and memory[0, WAS_LATE] == 0.0:
        memory[0, IN_TURN] += 1.0
        memory[0, WAS_LATE] = 1.0
        if memory[0, IN_TURN] >= IN_TURNS:
            _say(told, 0, MOTOR, dt, 0.0, -1.0)
            return Fault.TWO_PUBLISHERS
    return Fault.NOT_LATER


@inlined
def _doubt(limits: Array, memory: Array, reading: Array, fault: Fault, told: Array) -> Fault:
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
        j, side = int(told[0]), int(told[1])
        _say(told, j, side, reading[j, side], memory[j, LAST + side], 0.0)
        return Fault.TWO_PUBLISHERS
    return fault


@compiled
def judge(limits: Array, memory: Array, reading: Array, dt: float, told: Array) -> Fault:
    """
    Return the number of the fault of a sample, 0 if it can be believed, which it then is.

    `limits` is (n, LIMITS), `memory` (n, WATCH_MEMORY) of zeros before the first sample. `reading`
    has angles of shaft and link (n, 2) [rad], or (n, 4) with velocities, NaN where none is given.
    `dt` [s] is since the last sample that was believed, 0 for the first. `told` (5,) is filled as
    `Told` says.
    """
    fault = _angles(limits, reading, told)
    if fault != Fault.NONE:
        return fault
    if memory[0, STARTED] == 0.0:
        for j in range(reading.shape[0]):
            away = _twist(limits, j, reading[j, MOTOR], reading[j, LINK])
            if abs(away) > limits[j, WOUND] + limits[j, ALLOWED_APART]:
                _say(told, j, LINK, away, limits[j, WOUND] + limits[j, ALLOWED_APART], 0.0)
                return Fault.APART
        _believe(memory, reading, 0.0)
        return Fault.NONE
    if not dt > 0.0:
        return _stamps(memory, dt, told)
    seconds = memory[0, SINCE_ANCHOR] + dt
    fault = _way(limits, memory, reading, LAST, dt, told)
    if fault == Fault.NONE:
        fault = _way(limits, memory, reading, ANCHOR, seconds, told)
    if fault == Fault.NONE:
        fault = _together(limits, memory, reading, dt, seconds, told)
    if fault != Fault.NONE:
        return _doubt(limits, memory, reading, fault, told)
    fault = _frozen(limits, memory, reading, dt, told)
    if fault == Fault.NONE:
        fault = _velocities(limits, memory, reading, seconds, told)
    if memory[0, WAS_LATE] == 0.0:
        memory[0, IN_TURN] = 0.0                # two good ones in a row: nobody else speaks
    _believe(memory, reading, dt)
    return fault


class SampleWatch:
    """Judge one sample after another; `sentence` says what was wrong with the last one."""

    def __init__(self, arm: Arm, *, apart: float = math.inf) -> None:
        """Prepare for an arm; `apart` as `watch_limits` says [rad]."""
        self.limits = watch_limits(arm, apart=apart)
        self.memory = np.zeros((len(arm.joints), WATCH_MEMORY))
        self._labels, self._told = arm.labels, np.zeros(5)
        self._fault, self._last = Fault.NONE, 0

    def begin(self) -> None:
        """Forget every sample: the next one is the first."""
        self.memory[:] = 0.0

    def look(self, stamp: int, reading: Array) -> Fault:
        """Return what is wrong with a sample (n, 2) or (n, 4) and its stamp [ns]."""
        dt = (stamp - self._last) * 1e-9 if self.memory[0, STARTED] else 0.0
        self._fault = Fault(judge(self.limits, self.memory, reading, dt, self._told))
        if self._fault.believed:
            self._last = stamp
        return self._fault

    @property
    def period(self) -> float:
        """Return the usual time from stamp to stamp, 0 before two of them [s]."""
        return float(self.memory[0, PERIOD])

    @property
    def stamp(self) -> int:
        """Return the stamp of the last sample that was believed [ns]."""
        return self._last

    @property
    def sentence(self) -> str:
        """Return what was wrong with the last sample, empty if nothing was."""
        if self._fault is Fault.NONE:
            return ''
        joint, side, got, right, seconds = self._told.tolist()
        return sentence(self._fault, Told(int(joint), int(side), got, right, seconds),
                        self._labels)
