"""
The motion behind a measurement: angles, velocities and accelerations without delay.

Angles are first freed of what the encoders add, by the model's own sensing laws. Then they are
differentiated by local polynomials (Savitzky and Golay). These are exact up to their degree and
pass what the arm does, up to about 100 Hz. Last they are taken at the stamp where an encoder is
late.
"""

from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.compiled import compiled
from hda_arm_sim.foundation.rigid import Inertia
from hda_arm_sim.model.arm import Arm, ArmRecord
from hda_arm_sim.model.encoders import link_angle_behind, motor_angle_behind, tilt_moments, tilt_of
from hda_arm_sim.model.kernel import LINK_ANGLE, LINK_VELOCITY, MOTOR_ANGLE, MOTOR_VELOCITY
from hda_arm_sim.model.link_side import loaded_inertia
import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from .measurement import Measurement

# Choices unless told otherwise.
WINDOW, _DEGREE = 0.021, 5      # of the polynomials [s]
# (measured: a window of 21 ms loses 5 % at 40 Hz, which made cogging 1 % low)
SHORT = 0.009                   # window for what passes a filter of its own later [s]
# (measured: turns at the torque limit were wrong by 60 deviations)
_JOLT = 30.0            # accelerations of two windows this far apart, in the usual distance


class Motion(NamedTuple):
    """What moved: state (k, n, 4) in the kernel's columns, acceleration (k, n, 2) motor, link."""

    state: Array
    acceleration: Array


def motion_of(measurement: Measurement, arm: Arm, window: float = WINDOW) -> Motion:
    """
    Return the motion of an arm whose sensing is that of `arm`.

    Accelerations come by polynomials over `window` [s]. Of a wave of 40 Hz the usual one passes
    95.1 %, the short one 99.9 % and much noise beyond.
    """
    record = arm.record()
    angles = np.empty_like(measurement.reading)
    _behind(record, loaded_inertia(record.body), measurement.reading, angles)
    smooth, velocity = (_derivative(angles, order, WINDOW, measurement.dt) for order in range(2))
    acceleration = _derivative(angles, 2, window, measurement.dt)
    late = np.stack([record.joints['motor_encoder']['sampling_time'],
                     record.joints['motor_encoder']['sampling_time']
                     + record.joints['clock_skew']['skew']], axis=1)
    if late.any():
        curvature, jerk = (_derivative(angles, order, WINDOW, measurement.dt) for order in (2, 3))
        smooth = smooth - late * velocity + 0.5 * late ** 2 * curvature
        velocity = velocity - late * curvature
        acceleration = acceleration - late * jerk
    state = np.empty((*angles.shape[:2], 4))
    state[:, :, MOTOR_ANGLE], state[:, :, LINK_ANGLE] = smooth[:, :, 0], smooth[:, :, 1]
    state[:, :, MOTOR_VELOCITY], state[:, :, LINK_VELOCITY] = velocity[:, :, 0], velocity[:, :, 1]
    return Motion(state, np.ascontiguousarray(acceleration))


def jolts(measurement: Measurement) -> NDArray[np.bool_]:
    """
    Return where a link is jolted faster than the samples tell (k,).

    There the accelerations by the short and the long window fall apart, far beyond noise and
    beyond all that the link usually does.
    """
    link = measurement.reading[:, :, 1]
    long = _derivative(link, 2, WINDOW, measurement.dt)
    apart = np.abs(_derivative(link, 2, SHORT, measurement.dt) - long)
    usual = np.maximum(_JOLT * np.median(apart, axis=0), np.std(long, axis=0))
    return np.asarray((apart > usual).any(axis=1))


def smoothed(values: Array, dt: float) -> Array:
    """Return values (k, ...) as smooth as the motion is: polynomials over the same window."""
    return _derivative(values, 0, WINDOW, dt)


def _derivative(angles: Array, order: int, window: float, dt: float) -> Array:
    """Return a derivative of angles by polynomials over a window [s]."""
    length = max(_DEGREE + 2, 2 * round(0.5 * window / dt) + 1)
    start = angles[0] if order == 0 else 0.0
    return np.asarray(savgol_filter(angles - angles[0], length, _DEGREE, deriv=order, delta=dt,
                                    axis=0) + start)


@compiled
def _behind(arm: ArmRecord, inertia: Inertia, reading: Array, angles: Array) -> None:
    """Fill the angles (k, n, 2) behind readings, at the times when they were read."""
    for k in range(reading.shape[0]):
        tilt = tilt_moments(arm.body, inertia, reading[k, :, 1])
        for j in range(reading.shape[1]):
            joint = arm.joints[j]
            angles[k, j, 0] = motor_angle_behind(joint, reading[k, j, 0]
                                                 - joint.motor_encoder.zero)
            angles[k, j, 1] = link_angle_behind(joint, reading[k, j, 1]
                                                - joint.link_encoder.zero, tilt_of(tilt, j))
