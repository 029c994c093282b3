"""
Integrate the equation of motion: Runge-Kutta 4, with sticking and breaking away as events.

A joint has two contacts: the motor's dry friction, side 0, and that of its link bearing, side 1.
Within a step every contact slides one way or sticks. Where a sliding one comes to rest or a
sticking one breaks away, the step is cut there. So the order survives dry friction
(docs/model.md, eq:contact-event).
"""

from typing import NamedTuple

import numpy as np

from .arm import ArmRecord
from .effects.place import Commanded
from .kernel import (AXES, BUDGET, COMMAND, COMMANDS, CURRENT, DRIVE, FORCE, FORCES, MODE,
                     MOTOR_VELOCITY, NOW, settle, slope, SLOPE_1, SLOPE_2, SLOPE_3, SLOPE_4, STAGE,
                     STATE, STATES, TIME, TRIAL)
from .motor_side import clipped, lagging, lags, shaft_torque
from ..foundation.arrays import Array
from ..foundation.chain import of_links
from ..foundation.compiled import compiled, inlined, Record
from ..foundation.rigid import Inertia

SIDES = 2               # contacts of a joint; their speeds are SIDES columns of the state apart
MAX_EVENTS = 16         # in one step; a real arm has one or two
_NONE, _STOP, _BREAK = 0, 1, 2


class Event(NamedTuple):
    """A contact that comes to rest or breaks away: which way, of which joint, on which side."""

    kind: int
    joint: int
    side: int


@inlined
def _between(w: Array, row: int, column: int, s: float) -> float:
    """Return an input at the fraction s of a step: a parabola through start, middle, end."""
    return ((1.0 - s) * (1.0 - 2.0 * s) * w[row, column] + 4.0 * s * (1.0 - s) * w[row, column + 1]
            + s * (2.0 * s - 1.0) * w[row, column + 2])


@inlined
def _two(arm: ArmRecord) -> int:
    return 2


@inlined
def _six(arm: ArmRecord) -> int:
    return AXES


axes = of_links(_two, _six)         # components of what acts on the tip


@inlined
def _current(joint: Record, w: Array, j: int, dt: float, begin: float, s: float) -> float:
    """Return what the current loop delivers at a fraction of a step, from its state at `begin`."""
    command = clipped(joint, _between(w, j, COMMANDS, s))
    if not lags(joint):
        return command
    if s == begin:
        return w[j, STATE + CURRENT]
    last = clipped(joint, _between(w, j, COMMANDS, begin))
    return lagging(joint, Commanded(command, last, w[j, STATE + CURRENT], (s - begin) * dt))


@inlined
def set_input(arm: ArmRecord, w: Array, dt: float, begin: float, s: float) -> None:
    """Set time, motor torques and tip force at the fraction s of a step cut at `begin`."""
    w[0, NOW] = w[0, TIME] + s * dt
    for j in range(arm.joints.shape[0]):
        joint = arm.joints[j]
        w[j, TRIAL + CURRENT] = _current(joint, w, j, dt, begin, s)
        w[j, COMMAND] = shaft_torque(joint, w[j, TRIAL + CURRENT])
    for axis in range(axes(arm)):
        w[axis, FORCE] = _between(w, axis, FORCES, s)


@inlined
def _stage(arm: ArmRecord, w: Array, block: int, span: float) -> None:
    """Set the stage: the state moved along one block of slopes."""
    for j in range(arm.joints.shape[0]):
        for i in range(STATES):
            w[j, STAGE + i] = w[j, STATE + i] + span * w[j, block + i]


@compiled
def _runge_kutta(arm: ArmRecord, inertia: Inertia, w: Array, dt: float, begin: float,
                 end: float) -> None:
    """Set the trial state: the state after the part [begin, end] of a step of length dt."""
    span = (end - begin) * dt
    set_input(arm, w, dt, begin, begin)
    slope(arm, inertia, w, STATE, SLOPE_1)
    set_input(arm, w, dt, begin, 0.5 * (begin + end))
    _stage(arm, w, SLOPE_1, 0.5 * span)
    slope(arm, inertia, w, STAGE, SLOPE_2)
    _stage(arm, w, SLOPE_2, 0.5 * span)
    slope(arm, inertia, w, STAGE, SLOPE_3)
    set_input(arm, w, dt, begin, end)
    _stage(arm, w, SLOPE_3, span)
    slope(arm, inertia, w, STAGE, SLOPE_4)
    for j in range(arm.joints.shape[0]):
        current = w[j, TRIAL + CURRENT]
        for i in range(STATES):
            w[j, TRIAL + i] = w[j, STATE + i] + span / 6.0 * (
                w[j, SLOPE_1 + i] + 2.0 * (w[j, SLOPE_2 + i] + w[j, SLOPE_3 + i])
                + w[j, SLOPE_4 + i])
        w[j, TRIAL + CURRENT] = current


@inlined
def _accept(arm: ArmRecord, w: Array) -> None:
    for j in range(arm.joints.shape[0]):
        for i in range(STATES):
            w[j, STATE + i] = w[j, TRIAL + i]
    settle(arm, w)


@inlined
def _sticks(arm: ArmRecord, w: Array) -> bool:
    """Return whether any contact sticks."""
    for j in range(arm.joints.shape[0]):
        for side in range(SIDES):
            if w[j, MODE + side] == 0.0 and w[j, BUDGET + side] > 0.0:
                return True
    return False


@inlined
def _overload(w: Array, j: int, side: int) -> float:
    """Return by how much a contact is overloaded at the last slope [N*m at its side]."""
    return abs(w[j, DRIVE + side]) - w[j, BUDGET + side]


@compiled
def _first_event(arm: ArmRecord, inertia: Inertia, w: Array) -> Event:
    """Return the trial step's first event."""
    kind, who, where, first = _NONE, -1, 0, 2.0
    sticks = _sticks(arm, w)
    if sticks:
        slope(arm, inertia, w, TRIAL, SLOPE_1)
    for j in range(arm.joints.shape[0]):
        for side in range(SIDES):
            mode, column = w[j, MODE + side], MOTOR_VELOCITY + SIDES * side
            if w[j, BUDGET + side] <= 0.0:
                continue
            before, after = w[j, STATE + column], w[j, TRIAL + column]
            if mode != 0.0 and after * mode < 0.0 and before / (before - after) < first:
                kind, who, where, first = _STOP, j, side, before / (before - after)
            elif mode == 0.0 and first > 1.0 and _overload(w, j, side) > 0.0:
                kind, who, where, first = _BREAK, j, side, 1.0
    return Event(kind, who, where)


@compiled
def _distance(arm: ArmRecord, inertia: Inertia, w: Array, event: Event) -> float:
    """Return what falls through zero at an event, at the trial state."""
    kind, joint, side = event
    if kind == _STOP:
        return w[joint, TRIAL + MOTOR_VELOCITY + SIDES * side] * w[joint, MODE + side]
    slope(arm, inertia, w, TRIAL, SLOPE_1)
    return -_overload(w, joint, side)


@compiled
def _locate(arm: ArmRecord, inertia: Inertia, w: Array, dt: float, begin: float,
            event: Event) -> float:
    """Return the fraction of the step at which an event happens; its state is the trial's."""
    low, high, middle = begin, 1.0, begin
    at_high = _distance(arm, inertia, w, event)
    _runge_kutta(arm, inertia, w, dt, begin, begin)
    at_low = _distance(arm, inertia, w, event)
    if not at_low > 0.0:
        return begin
    for _ in range(40):                                             # Illinois: regula falsi
        middle = high - at_high * (high - low) / (at_high - at_low)
        _runge_kutta(arm, inertia, w, dt, begin, middle)
        distance = _distance(arm, inertia, w, event)
        if abs(distance) < 1e-13 or high - low < 1e-12:
            break
        if distance < 0.0:
            high, at_high, at_low = middle, distance, 0.5 * at_low
        else:
            low, at_low, at_high = middle, distance, 0.5 * at_high
    return middle


@compiled
def _release(arm: ArmRecord, inertia: Inertia, w: Array) -> None:
    """Let go the contacts that cannot hold now; one link may pull the other loose."""
    for _ in range(SIDES * arm.joints.shape[0]):
        if not _sticks(arm, w):
            return
        slope(arm, inertia, w, STATE, SLOPE_1)
        who, where, most = -1, 0, 0.0
        for j in range(arm.joints.shape[0]):
            for side in range(SIDES):
                excess = _overload(w, j, side)
                if w[j, MODE + side] == 0.0 and w[j, BUDGET + side] > 0.0 and excess > most:
                    who, where, most = j, side, excess
        if who < 0:
            return
        w[who, MODE + where] = np.sign(w[who, DRIVE + where])


@compiled
def _meet(arm: ArmRecord, inertia: Inertia, w: Array, event: Event) -> None:
    """Bring a contact to rest, or let it break away the way it is driven."""
    kind, joint, side = event
    w[joint, STATE + MOTOR_VELOCITY + SIDES * side] = 0.0
    w[joint, MODE + side] = 0.0
    _release(arm, inertia, w)
    if kind == _BREAK and w[joint, MODE + side] == 0.0:
        w[joint, MODE + side] = np.sign(w[joint, DRIVE + side])


@compiled
def advance(arm: ArmRecord, inertia: Inertia, w: Array, dt: float) -> int:
    """
    Advance the state in the registers by dt [s] under the inputs in the registers.

    The inputs are given at the start, the middle and the end of the step, see `COMMANDS` and
    `FORCES` of the kernel. Returns the number of events met.
    """
    begin = 0.0
    events = 0
    set_input(arm, w, dt, begin, begin)
    _release(arm, inertia, w)
    while True:
        _runge_kutta(arm, inertia, w, dt, begin, 1.0)
        event = _first_event(arm, inertia, w)
        kind, joint, side = event
        if kind == _NONE or events == MAX_EVENTS:
            break
        events += 1
        if kind == _STOP and w[joint, STATE + MOTOR_VELOCITY + SIDES * side] == 0.0:
            w[joint, MODE + side] = 0.0                             # set off the wrong way
            continue
        begin = _locate(arm, inertia, w, dt, begin, event)
        _accept(arm, w)
        set_input(arm, w, dt, begin, begin)
        _meet(arm, inertia, w, event)
    _accept(arm, w)
    w[0, TIME] += dt
    return events
