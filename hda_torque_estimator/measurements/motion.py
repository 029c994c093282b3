"""
The motion behind a measurement: angles, velocities and accelerations without delay.

Angles are first freed of what the encoders add, by the model's own sensing laws. Then they are
differentiated by local polynomials (Savitzky and Golay). These are exact up to their degree and
pass what the arm does, up to about 100 Hz. Last they are taken at the stamp where an encoder is
late.
"""

from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.compiled import compiled, Record
from hda_arm_sim.foundation.rigid import Inertia
from hda_arm_sim.model.arm import Arm, ArmRecord
from hda_arm_sim.model.effect_loops import numbers_at
from hda_arm_sim.model.effects.place import CLOCK
from hda_arm_sim.model.encoders import (feels_tilt, link_angle_behind, motor_angle_behind,
                                        tilt_moments, tilt_of)
from hda_arm_sim.model.kernel import LINK_ANGLE, LINK_VELOCITY, MOTOR_ANGLE, MOTOR_VELOCITY
from hda_arm_sim.model.link_side import loaded_inertia
import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from .measurement import Measurement

MOTOR, LINK = range(2)  # sides of a reading (layout)
# Choices unless stated otherwise.
WINDOW, _DEGREE = 0.021, 5      # of the polynomials [s]
# (measured: a window of 21 ms loses 5 % at 40 Hz, which made cogging 1 % low)
SHORT = 0.009                   # window for what passes a filter of its own later [s]
# (measured: turns at the torque limit were wrong by 60 deviations)
_JOLT = 30.0            # accelerations of two windows this far apart, in the usual distance
_LONGER = 4             # samples by which the long window has more than the short one, at least


class MeasuredMotion(NamedTuple):
    """What moved: state (k, n, 4) in the kernel's columns, acceleration (k, n, 2) motor, link."""

    state: Array
    acceleration: Array

    def during(self, piece: slice) -> 'MeasuredMotion':
        """Return the motion in some of its samples."""
        return MeasuredMotion(self.state[piece], self.acceleration[piece])

    @property
    def links(self) -> 'DifferentiatedAngle':
        """Return what the links did, (k, n) each."""
        return DifferentiatedAngle(self.state[:, :, LINK_ANGLE], self.state[:, :, LINK_VELOCITY],
                                   self.acceleration[:, :, LINK])


class DifferentiatedAngle(NamedTuple):
    """Angles behind encoders and their derivatives, at the stamps: (k,) each, or (k, c)."""

    angle: Array                # [rad]
    velocity: Array             # [rad/s]
    acceleration: Array         # [rad/s^2]

    def during(self, piece: slice) -> 'DifferentiatedAngle':
        """Return the course in some of its samples."""
        return DifferentiatedAngle(self.angle[piece], self.velocity[piece],
                                   self.acceleration[piece])

    def shifted(self, away: float) -> 'DifferentiatedAngle':
        """Return the course of angles that are all so far away: polynomials are linear [rad]."""
        return self._replace(angle=self.angle + away)


def motion_of(measurement: Measurement, arm: Arm, window: float = WINDOW) -> MeasuredMotion:
    """
    Return the motion of an arm whose sensing is that of `arm`.

    Accelerations come by polynomials over `window` [s]. Of a wave of 40 Hz the usual one passes
    95.1 %, the short one 99.9 % and much noise beyond.
    """
    sides = [(joint, side) for joint in range(len(arm.joints)) for side in (MOTOR, LINK)]
    angles = np.stack([angle_behind(measurement.reading, arm, *place) for place in sides], axis=1)
    late = np.array([lateness(arm, *place) for place in sides])
    angle, velocity, acceleration = (
        part.reshape(len(part), -1, 2) for part in course_of(angles, late, window, measurement.dt))
    state = np.empty((*angle.shape[:2], 4))
    state[:, :, MOTOR_ANGLE], state[:, :, LINK_ANGLE] = angle[:, :, 0], angle[:, :, 1]
    state[:, :, MOTOR_VELOCITY], state[:, :, LINK_VELOCITY] = velocity[:, :, 0], velocity[:, :, 1]
    return MeasuredMotion(state, np.ascontiguousarray(acceleration))


def course_of(angles: Array, late: Array, window: float, dt: float) -> DifferentiatedAngle:
    """Return the course of angles (k, c) that were read so late (c,) after their stamps [s]."""
    usual = _length(WINDOW, dt)
    smooth, velocity = (_derivative(angles, order, usual, dt) for order in range(2))
    acceleration = _derivative(angles, 2, _length(window, dt), dt)
    if late.any():
        curvature, jerk = (_derivative(angles, order, usual, dt) for order in (2, 3))
        smooth = smooth - late * velocity + 0.5 * late ** 2 * curvature
        velocity = velocity - late * curvature
        acceleration = acceleration - late * jerk
    return DifferentiatedAngle(smooth, velocity, acceleration)


def lateness(arm: Arm, joint: int, side: int) -> float:
    """Return how long after its stamp an encoder is read [s]."""
    record = arm.record().joints[joint]
    late = record['motor_encoder']['sampling_time']
    return float(late + numbers_at(record, CLOCK)['skew'] if side == LINK else late)


def angle_behind(reading: Array, arm: Arm, joint: int, side: int) -> Array:
    """Return the angle (k,) behind the readings (k, n, 2) of an encoder, when it was read."""
    record, angle = arm.record(), np.empty(len(reading))
    if side == MOTOR:
        _fill_motor(record.joints, joint, reading, angle)
    else:
        _fill_link(record, loaded_inertia(record.body), joint, reading, angle)
    return angle


def jolts(measurement: Measurement) -> NDArray[np.bool_]:
    """
    Return where a link is jolted faster than the samples resolve (k,).

    There the accelerations by the short and the long window fall apart, far beyond noise and
    beyond all that the link usually does. Both are windows of the samples that were recorded, so
    the shortest of a slow recording has as many as its polynomial needs.
    """
    parts = measurement.parts
    link, dt = measurement.reading[::parts, :, LINK], parts * measurement.dt
    few = _length(SHORT, dt)
    long = _derivative(link, 2, max(_length(WINDOW, dt), few + _LONGER), dt)
    apart = np.abs(_derivative(link, 2, few, dt) - long)
    usual = np.maximum(_JOLT * np.median(apart, axis=0), np.std(long, axis=0))
    jolted = np.asarray((apart > usual).any(axis=1))
    return np.repeat(jolted, parts)[:len(measurement.reading)]


def smoothed(values: Array, dt: float) -> Array:
    """Return values (k, ...) as smooth as the motion is: polynomials over the same window."""
    return _derivative(values, 0, _length(WINDOW, dt), dt)


def _derivative(angles: Array, order: int, length: int, dt: float) -> Array:
    """Return a derivative of angles by polynomials over so many samples."""
    start = angles[0] if order == 0 else 0.0
    return np.asarray(savgol_filter(angles - angles[0], length, _DEGREE, deriv=order, delta=dt,
                                    axis=0) + start)


def _length(window: float, dt: float) -> int:
    """Return how many samples a window [s] has, as many as its polynomial needs at least."""
    return max(_DEGREE + 2, 2 * round(0.5 * window / dt) + 1)


@compiled
def _fill_motor(joints: Record, j: int, reading: Array, angle: Array) -> None:
    """Fill the angle (k,) of a shaft behind readings, at the times when they were read."""
    joint = joints[j]
    for k in range(reading.shape[0]):
        angle[k] = motor_angle_behind(joint, reading[k, j, 0] - joint.motor_encoder.zero)


@compiled
def _fill_link(arm: ArmRecord, inertia: Inertia, j: int, reading: Array, angle: Array) -> None:
    """Fill the angle (k,) of a link behind readings, at the times when they were read."""
    joint, moment = arm.joints[j], 0.0
    for k in range(reading.shape[0]):
        if feels_tilt(joint):
            moment = tilt_of(tilt_moments(arm.body, inertia, reading[k, :, 1]), j)
        angle[k] = link_angle_behind(joint, reading[k, j, 1] - joint.link_encoder.zero, moment)
