"""The motor and its amplifier: from the torque commanded to the torque at the shaft."""

import math

import numba
import numpy as np
from numpy.typing import NDArray

from .layout import Record

Array = NDArray[np.float64]


@numba.njit(cache=True, error_model='numpy')
def issued(joint: Record, command: float, noise: float) -> float:
    """Return the torque that the amplifier makes of a command, once it has settled [N*m]."""
    limit = joint.torque_saturation_limit
    return (min(max(command, -limit), limit) * joint.gain
            * (1.0 + joint.torque_constant_error_relative_error)
            + joint.drive_offset_offset + noise)


@numba.njit(cache=True, error_model='numpy')
def delayed(torque: Array, instant: Array, newest: int, j: int, delay: float, begin: float,
            h: float, active: NDArray[np.int64]) -> float:
    """
    Return the mean of the delayed torque over [begin, begin + h].

    `active[j]` is the command in force and moves on; a change within the step counts by the time
    that is left, so the delay need not be a whole number of steps.
    """
    total, now, end = 0.0, begin, begin + h
    while active[j] < newest and instant[active[j] + 1] + delay < end:
        change = max(instant[active[j] + 1] + delay, now)
        total += torque[active[j], j] * (change - now)
        now = change
        active[j] += 1
    return (total + torque[active[j], j] * (end - now)) / h


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
def angle_torque(joint: Record, motor: float, time: float) -> float:
    """Return what the motor adds by itself: ripple, cogging, a line in time [N*m]."""
    torque = 0.0
    for order, size, phase in (
            (2.0, joint.torque_ripple_amplitude_2, joint.torque_ripple_phase_2),
            (4.0, joint.torque_ripple_amplitude_4, joint.torque_ripple_phase_4),
            (joint.motor_cogging_order, joint.motor_cogging_amplitude,
             joint.motor_cogging_phase)):
        if size != 0.0:
            torque += size * math.sin(order * motor + phase)
    if joint.motor_torque_line_amplitude != 0.0:
        torque += joint.motor_torque_line_amplitude * math.sin(
            2.0 * math.pi * joint.motor_torque_line_frequency * time
            + joint.motor_torque_line_phase)
    return torque
