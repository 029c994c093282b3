"""
Predict a recording by simulation from measured states, and measure how far off it ends.

From the measured state at the start of each window the arm is simulated open loop under the
recorded command. The reference motion and the controller need not be known. The error is that of
the predicted encoder readings, at the output side, over the window. Links that are led by
something unknown are moved as they were measured, and the motors are predicted beside them.
"""

from typing import NamedTuple

from hda_arm_sim.drive import act
from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.compiled import compiled
from hda_arm_sim.foundation.rigid import Inertia
from hda_arm_sim.model.arm import Arm, ArmRecord
from hda_arm_sim.model.kernel import (AXES, CURRENT, HISTORY, LINK_ANGLE, LINK_VELOCITY,
                                      registers, SENT, slope, SLOPE_1, STATE, STATES, TIME)
from hda_arm_sim.model.link_side import loaded_inertia
from hda_arm_sim.sensors import DRAWS, read_encoders
from hda_arm_sim.simulate import longest_step, STEP, step_count
import numpy as np

from .balance import Balancer
from .kernel_along import MEASURED
from ...measurements.running_clock import arm_during, Spans, within

# Numerics; choices unless stated otherwise.
HORIZON = 0.2           # length of a window [s]
EVERY = 0.1             # from window to window [s]
_LINK = [LINK_ANGLE, LINK_VELOCITY]
_EDGE = 0.05            # of the recording, where its motion is not known well [s]


class PredictionWindow(NamedTuple):
    """What was recorded of a window; the first reading is where it starts."""

    command: Array              # (k, n) motor torques [N*m]
    reading: Array              # (k + 1, n, 2) motor, link [rad]
    led: Array                  # (k + 1, n, 2) angles and speeds of led links, (0, n, 2) of others


def prediction_errors(balancer: Balancer, arm: Arm, spans: Spans,
                      horizon: float = HORIZON) -> Array:
    """
    Return the mean squared errors (w, 3 n) of windows within spans of time.

    Columns are motors (over their ratio), links and torsions [rad^2 at the output].
    """
    record = arm.record()
    key = record.joints.tobytes(), record.body.tobytes(), spans, horizon
    return balancer.predictions.of(key, lambda: np.concatenate([
        _errors(balancer, arm, spans, piece, horizon)
        for piece in balancer.measurement.pieces()]))


def _errors(balancer: Balancer, arm: Arm, spans: Spans, piece: slice, horizon: float) -> Array:
    """Return the mean squared errors of the windows within one recording."""
    measurement, dt = balancer.measurement, balancer.measurement.dt
    motion, memory = balancer.motion(arm), balancer.memory(arm)
    steps, record = round(horizon / dt), arm_during(arm, piece, dt).record()
    count = step_count(dt, min(STEP, longest_step(arm)))
    inertia = loaded_inertia(record.body)
    starts = _starts(within(spans, piece, dt), (piece.stop - 1 - piece.start) * dt, dt)
    squared = np.zeros((len(starts), 3 * len(arm.joints)))
    for errors, start in zip(squared, starts):
        begin = piece.start + start
        state = np.zeros((motion.state.shape[1], STATES))
        state[:, :MEASURED], state[:, MEASURED:] = motion.state[begin], memory[begin]
        w = registers(state)
        w[0, TIME] = start * dt
        _remember(w, measurement.command[piece.start:begin])
        end = begin + steps + 1
        moved = motion.state[begin:end if measurement.led else begin, :, _LINK]
        window = PredictionWindow(measurement.command[begin:end - 1],
                                  measurement.reading[begin:end],
                                  np.ascontiguousarray(moved))
        _predict(record, inertia, w, window, dt, count, errors)
    return squared


def _remember(w: Array, command: Array) -> None:
    """Set what the drive remembers at the start of a window: the last commands [N*m]."""
    joints = command.shape[1]
    last = command[::-1][:HISTORY]
    w[:joints, SENT:SENT + len(last)] = last.T
    w[:joints, STATE + CURRENT] = last[0]


def _starts(spans: Spans, duration: float, dt: float) -> list[int]:
    """Return the first samples of all windows that lie within spans."""
    starts: list[int] = []
    for begin, end in spans:
        last = min(end, duration - _EDGE) - HORIZON
        starts += [round(time / dt) for time in np.arange(max(begin, _EDGE), last, EVERY)]
    return starts


@compiled
def _predict(arm: ArmRecord, inertia: Inertia, w: Array, window: PredictionWindow, dt: float,
             count: int,
             errors: Array) -> None:
    """Fill the mean squared errors (3 n,) of one window."""
    command, reading, led = window
    joints = reading.shape[1]
    shown, noise, force = np.empty((joints, 2)), np.zeros((joints, DRAWS)), np.zeros(AXES)
    for k in range(command.shape[0]):
        act(arm, inertia, w, command[k], force, dt, count)
        if led.shape[0] > 0:
            for j in range(joints):
                w[j, STATE + LINK_ANGLE], w[j, STATE + LINK_VELOCITY] = led[k + 1, j]
        slope(arm, inertia, w, STATE, SLOPE_1)
        read_encoders(arm, inertia, w, noise, shown)
        for j in range(joints):
            motor = (shown[j, 0] - reading[k + 1, j, 0]) / arm.joints[j].ratio
            link = shown[j, 1] - reading[k + 1, j, 1]
            errors[j] += motor ** 2 / command.shape[0]
            errors[joints + j] += link ** 2 / command.shape[0]
            errors[2 * joints + j] += (motor - link) ** 2 / command.shape[0]
