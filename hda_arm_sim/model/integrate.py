"""
Integrate the equation of motion: Runge-Kutta 4, with sticking and breaking away as events.

Within a step every motor slides one way or sticks; where a sliding motor comes to rest or a
sticking one breaks away, the step is cut there, so that the order survives dry friction.
"""

import numpy as np

from .compiled import compiled, inlined
from .kernel import (BUDGET, COMMAND, DRIVE, FORCE, MODE, MOTOR_VELOCITY, slope, SLOPE_1, SLOPE_2,
                     SLOPE_3, SLOPE_4, STAGE, STATE, STATES, TRIAL)

MAX_EVENTS = 12         # in one step; a real arm has one or two
_NONE, _STOP, _BREAK = 0, 1, 2


@inlined
def _set_input(arm, w, torque, force, s):                           # type: ignore[no-untyped-def]
    """Set the input at the fraction s of a step, a parabola through start, middle and end."""
    a, b, c = (1.0 - s) * (1.0 - 2.0 * s), 4.0 * s * (1.0 - s), s * (2.0 * s - 1.0)
    for j in range(arm.joints.shape[0]):
        w[j, COMMAND] = a * torque[0, j] + b * torque[1, j] + c * torque[2, j]
    for k in range(2):
        w[k, FORCE] = a * force[0, k] + b * force[1, k] + c * force[2, k]


@inlined
def _stage(arm, w, block, span):                                    # type: ignore[no-untyped-def]
    """Set the stage: the state moved along one block of slopes."""
    for j in range(arm.joints.shape[0]):
        for i in range(STATES):
            w[j, STAGE + i] = w[j, STATE + i] + span * w[j, block + i]


@compiled
def _runge_kutta(arm, inertia, w, torque, force, dt, begin, end):   # type: ignore[no-untyped-def]
    """Set the trial state: the state after the part [begin, end] of a step of length dt."""
    span = (end - begin) * dt
    _set_input(arm, w, torque, force, begin)
    slope(arm, inertia, w, STATE, SLOPE_1)
    _set_input(arm, w, torque, force, 0.5 * (begin + end))
    _stage(arm, w, SLOPE_1, 0.5 * span)
    slope(arm, inertia, w, STAGE, SLOPE_2)
    _stage(arm, w, SLOPE_2, 0.5 * span)
    slope(arm, inertia, w, STAGE, SLOPE_3)
    _set_input(arm, w, torque, force, end)
    _stage(arm, w, SLOPE_3, span)
    slope(arm, inertia, w, STAGE, SLOPE_4)
    for j in range(arm.joints.shape[0]):
        for i in range(STATES):
            w[j, TRIAL + i] = w[j, STATE + i] + span / 6.0 * (
                w[j, SLOPE_1 + i] + 2.0 * (w[j, SLOPE_2 + i] + w[j, SLOPE_3 + i])
                + w[j, SLOPE_4 + i])


@inlined
def _accept(arm, w):                                                # type: ignore[no-untyped-def]
    for j in range(arm.joints.shape[0]):
        for i in range(STATES):
            w[j, STATE + i] = w[j, TRIAL + i]


@compiled
def _overload(arm, inertia, w, joint):                              # type: ignore[no-untyped-def]
    """Return by how much the trial state overloads a sticking motor [N*m motor]."""
    slope(arm, inertia, w, TRIAL, SLOPE_1)
    return abs(w[joint, DRIVE]) - w[joint, BUDGET]


@compiled
def _first_event(arm, inertia, w):                                  # type: ignore[no-untyped-def]
    """Return the kind of the trial step's first event and its joint."""
    kind, who, first = _NONE, -1, 2.0
    for j in range(arm.joints.shape[0]):
        before, after = w[j, STATE + MOTOR_VELOCITY], w[j, TRIAL + MOTOR_VELOCITY]
        mode = w[j, MODE]
        if w[j, BUDGET] <= 0.0:
            continue
        if mode != 0.0 and after * mode < 0.0 and before / (before - after) < first:
            kind, who, first = _STOP, j, before / (before - after)
        elif mode == 0.0 and first > 1.0 and _overload(arm, inertia, w, j) > 0.0:
            kind, who, first = _BREAK, j, 1.0
    return kind, who


@compiled
def _distance(arm, inertia, w, kind, joint):                        # type: ignore[no-untyped-def]
    """Return what falls through zero at an event, at the trial state."""
    if kind == _STOP:
        return w[joint, TRIAL + MOTOR_VELOCITY] * w[joint, MODE]
    return -_overload(arm, inertia, w, joint)


@compiled
def _locate(arm, inertia, w, torque, force, dt, begin, kind, joint):
    # type: ignore[no-untyped-def]
    """Return the fraction of the step at which an event happens; its state is the trial's."""
    low, high, middle = begin, 1.0, begin
    at_high = _distance(arm, inertia, w, kind, joint)
    _runge_kutta(arm, inertia, w, torque, force, dt, begin, begin)
    at_low = _distance(arm, inertia, w, kind, joint)
    if not at_low > 0.0:
        return begin
    for _ in range(40):                                             # Illinois: regula falsi
        middle = high - at_high * (high - low) / (at_high - at_low)
        _runge_kutta(arm, inertia, w, torque, force, dt, begin, middle)
        distance = _distance(arm, inertia, w, kind, joint)
        if abs(distance) < 1e-13 or high - low < 1e-12:
            break
        if distance < 0.0:
            high, at_high, at_low = middle, distance, 0.5 * at_low
        else:
            low, at_low, at_high = middle, distance, 0.5 * at_high
    return middle


@compiled
def _release(arm, inertia, w):                                      # type: ignore[no-untyped-def]
    """Let go the sticking motors that the present input overloads."""
    sticks = False
    for j in range(arm.joints.shape[0]):
        sticks = sticks or w[j, MODE] == 0.0
    if sticks:
        slope(arm, inertia, w, STATE, SLOPE_1)
        for j in range(arm.joints.shape[0]):
            if w[j, MODE] == 0.0 and abs(w[j, DRIVE]) > w[j, BUDGET]:
                w[j, MODE] = np.sign(w[j, DRIVE])


@compiled
def _meet(arm, inertia, w, kind, joint):                            # type: ignore[no-untyped-def]
    """Bring a motor to rest, or let it break away the way it is driven."""
    _accept(arm, w)
    w[joint, STATE + MOTOR_VELOCITY] = 0.0
    w[joint, MODE] = 0.0
    _release(arm, inertia, w)
    if kind == _BREAK:
        w[joint, MODE] = np.sign(w[joint, DRIVE])


@compiled
def advance(arm, inertia, w, torque, force, dt):                    # type: ignore[no-untyped-def]
    """
    Advance the state in the registers by dt [s].

    `torque` (3, n) [N*m motor] and `force` (3, 2) [N, base frame] are the inputs at the start,
    the middle and the end of the step. Returns the number of events met.
    """
    begin = 0.0
    _set_input(arm, w, torque, force, begin)
    _release(arm, inertia, w)
    for events in range(MAX_EVENTS):
        _runge_kutta(arm, inertia, w, torque, force, dt, begin, 1.0)
        kind, joint = _first_event(arm, inertia, w)
        if kind == _NONE:
            _accept(arm, w)
            return events
        if kind == _STOP and w[joint, STATE + MOTOR_VELOCITY] == 0.0:
            w[joint, MODE] = 0.0                                    # set off the wrong way
            continue
        begin = _locate(arm, inertia, w, torque, force, dt, begin, kind, joint)
        _set_input(arm, w, torque, force, begin)
        _meet(arm, inertia, w, kind, joint)
    _runge_kutta(arm, inertia, w, torque, force, dt, begin, 1.0)
    _accept(arm, w)
    return MAX_EVENTS
