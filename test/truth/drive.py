"""The motor and its amplifier: from the torque commanded to the torque at the shaft."""

import math
from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from .layout import Record

Array = NDArray[np.float64]


class Sent(NamedTuple):
    """Commands on their way to the amplifiers, once settled."""

    torque: Array               # (k, 2) of each sample [N*m]
    arrival: Array              # (k + 1, 2) when they get there, without delay [s]
    active: NDArray[np.int64]   # (2,) which one is in force


# Forms of laws, by effect (`forms.py`); 0 is the one of README.md.
SOFT, FALLING, KNEE = 1, 2, 3           # torque_saturation
IRON, WARM_MAGNET = 1, 2                # torque_constant_error
WARMING, WANDERING = 1, 2               # drive_offset
SECOND_ORDER, TWO_LAGS = 1, 2           # current_loop_lag
JITTER, SLOWING = 1, 2                  # command_delay
WITH_TORQUE, MORE_ORDERS = 1, 2         # torque_ripple
TWO_ORDERS, PEAKED = 1, 2               # motor_cogging


@numba.njit(cache=True, error_model='numpy')
def issued(joint: Record, command: float, noise: float, rate: float, time: float) -> float:
    """Return the torque that the amplifier makes of a command, once it has settled [N*m]."""
    return (clipped(joint, command, rate) * joint.gain
            * (1.0 + torque_constant(joint, command, time)) + offset(joint, time) + noise)


@numba.njit(cache=True, error_model='numpy')
def clipped(joint: Record, command: float, rate: float) -> float:
    """Return what the amplifier lets through of a command at a motor rate [N*m]."""
    limit = joint.torque_saturation_limit
    if joint.torque_saturation_form == SOFT:
        return limit * math.tanh(command / limit)
    if joint.torque_saturation_form == FALLING:
        limit *= max(1.0 - joint.torque_saturation_first * abs(rate) / joint.pace, 0.3)
    if joint.torque_saturation_form == KNEE:
        sharp = joint.torque_saturation_first
        return command / (1.0 + abs(command / limit) ** sharp) ** (1.0 / sharp)
    return min(max(command, -limit), limit)


@numba.njit(cache=True, error_model='numpy')
def torque_constant(joint: Record, command: float, time: float) -> float:
    """Return the relative error of torque per command."""
    error, first = joint.torque_constant_error_relative_error, joint.torque_constant_error_first
    if joint.torque_constant_error_form == IRON:
        error *= 1.0 + first * (2.0 * abs(command) / joint.limit - 0.5)
    elif joint.torque_constant_error_form == WARM_MAGNET:
        error *= 1.0 - 0.5 * math.exp(-max(time, 0.0) / first)
    return error


@numba.njit(cache=True, error_model='numpy')
def offset(joint: Record, time: float) -> float:
    """Return the torque that an amplifier makes of no command [N*m]."""
    size, first = joint.drive_offset_offset, joint.drive_offset_first
    if joint.drive_offset_form == WARMING:
        size *= 1.0 - 0.6 * math.exp(-max(time, 0.0) / first)
    elif joint.drive_offset_form == WANDERING:
        size *= 1.0 + first * math.sin(2.0 * math.pi * time / joint.drive_offset_second)
    return size


@numba.njit(cache=True, error_model='numpy')
def delayed(sent: Sent, newest: int, j: int, delay: float, begin: float, h: float) -> float:
    """
    Return the mean of the delayed torque of a joint over [begin, begin + h].

    The command in force moves on; a change within the step counts by the time that is left, so
    the delay need not be a whole number of steps.
    """
    torque, instant, active = sent.torque, sent.arrival[:, j], sent.active
    total, now, end = 0.0, begin, begin + h
    while active[j] < newest and instant[active[j] + 1] + delay < end:
        change = max(instant[active[j] + 1] + delay, now)
        total += torque[active[j], j] * (change - now)
        now = change
        active[j] += 1
    return (total + torque[active[j], j] * (end - now)) / h


@numba.njit(cache=True, error_model='numpy')
def looped(joint: Record, torque: float, j: int, lag: Array, memory: Array, h: float) -> float:
    """Return the mean torque over h behind the current loop, whatever its form."""
    form, first = joint.current_loop_lag_form, joint.current_loop_lag_first
    if form == 0.0:
        return lagged(joint, torque, j, lag, h)
    if form == TWO_LAGS:
        after = follow(torque, memory, h, (1.0 - first) * joint.current_loop_lag_time_constant, 0)
        lag[j] = follow(after, memory, h, first * joint.current_loop_lag_time_constant, 1)
        return lag[j]
    swing = 2.0 * first / joint.current_loop_lag_time_constant
    memory[1] += h * swing * (swing * (torque - memory[0]) - 2.0 * first * memory[1])
    memory[0] += h * memory[1]
    lag[j] = memory[0]
    return lag[j]


@numba.njit(cache=True, error_model='numpy')
def follow(torque: float, memory: Array, h: float, time_constant: float, place: int) -> float:
    """Move a first-order lag at its place of a memory for h; return where it is then [N*m]."""
    memory[place] += (torque - memory[place]) * -math.expm1(-h / time_constant)
    return memory[place]


@numba.njit(cache=True, error_model='numpy')
def lagged(joint: Record, torque: float, j: int, lag: Array, h: float) -> float:
    """Return the mean torque over h behind a first-order lag, and move its state `lag[j]`."""
    time_constant = joint.current_loop_lag_time_constant
    if time_constant <= 0.0:
        lag[j] = torque
        return torque
    left = -math.expm1(-h / time_constant)
    away = lag[j] - torque
    lag[j] -= away * left
    return torque + away * left * time_constant / h


@numba.njit(cache=True, error_model='numpy')
def angle_torque(joint: Record, motor: float, applied: float, time: float) -> float:
    """Return what the motor adds by itself: ripple, cogging, a line in time [N*m]."""
    torque = ripple(joint, motor, applied)
    if joint.motor_cogging_amplitude != 0.0:
        torque += cogging(joint, motor)
    if joint.motor_torque_line_amplitude != 0.0:
        torque += joint.motor_torque_line_amplitude * math.sin(
            2.0 * math.pi * joint.motor_torque_line_frequency * time
            + joint.motor_torque_line_phase)
    return torque


@numba.njit(cache=True, error_model='numpy')
def ripple(joint: Record, motor: float, applied: float) -> float:
    """Return the waves of the torque over a motor turn [N*m]."""
    size_2, size_4 = joint.torque_ripple_amplitude_2, joint.torque_ripple_amplitude_4
    if size_2 == 0.0 and size_4 == 0.0:
        return 0.0
    torque = 0.0
    for order, size, phase in ((2.0, size_2, joint.torque_ripple_phase_2),
                               (4.0, size_4, joint.torque_ripple_phase_4)):
        if size != 0.0:
            torque += size * math.sin(order * motor + phase)
    first, second = joint.torque_ripple_first, joint.torque_ripple_second
    if joint.torque_ripple_form == WITH_TORQUE:
        torque *= first + (1.0 - first) * 4.0 * abs(applied) / joint.limit
    elif joint.torque_ripple_form == MORE_ORDERS:
        torque += first * size_2 * (
            math.sin(motor + second) + 0.5 * math.sin(6.0 * motor - second))
    return torque


@numba.njit(cache=True, error_model='numpy')
def cogging(joint: Record, motor: float) -> float:
    """Return the torque at which the magnets hold on to the slots [N*m]."""
    size, first = joint.motor_cogging_amplitude, joint.motor_cogging_first
    angle = joint.motor_cogging_order * motor + joint.motor_cogging_phase
    torque = size * math.sin(angle)
    if joint.motor_cogging_form == TWO_ORDERS:
        torque += first * size * math.sin(
            2.0 * joint.motor_cogging_order * motor + joint.motor_cogging_second)
    elif joint.motor_cogging_form == PEAKED:
        torque += first * size * math.sin(3.0 * angle)
    return torque
