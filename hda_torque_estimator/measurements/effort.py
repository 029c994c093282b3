"""Which motor torque acts about a sample: its command is held, its current is measured."""

from dataclasses import replace

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.parts import Joint
import numpy as np

from .measurement import Measurement

HELD: float = Joint.declaration('effort_lag').default
"""Samples by which a command acts later that is held until the next."""
MEASURED = 0.0
"""The same of a current that was measured at its stamp."""


def acting(effort: Array, lag: float) -> Array:
    """
    Return the motor torque that acts about each sample (k,), from those recorded (k,) [N*m].

    It acts `lag` samples after its stamp, (eq:effort-lag). That is 0.5 for a command that is held
    until the next, and 0 for a measured current. Between stamps it goes along a line.
    """
    place = np.clip(np.arange(len(effort)) - lag, 0.0, len(effort) - 1.0)
    first = np.minimum(place.astype(np.intp), max(len(effort) - 2, 0))
    share = place - first
    second = np.minimum(first + 1, len(effort) - 1)
    between = (1.0 - share) * effort[first] + share * effort[second]
    return np.where(share == 0.0, effort[first], np.where(share == 1.0, effort[second], between))


def as_held(measurement: Measurement, arm: Arm) -> Measurement:
    """
    Return a measurement with the motor torques that acted from each sample to the next.

    It is the same object where the joints of the arm have commands that are held (eq:effort-lag).
    """
    lags = [joint.effort_lag for joint in arm.joints]
    if all(lag == HELD for lag in lags):
        return measurement
    command = measurement.command.copy()
    for piece in measurement.pieces():
        for joint, lag in enumerate(lags):
            command[piece, joint] = acting(measurement.command[piece, joint], lag - HELD)
    return replace(measurement, command=command, held=True)
