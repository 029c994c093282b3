"""Read the arm as its encoders do: at their time, from their zero, with noise, in whole counts."""

import math

from .foundation.arrays import Array
from .foundation.compiled import compiled, inlined
from .foundation.rigid import Inertia
from .model.arm import ArmRecord
from .model.effects.place import Counted, Sampled, Sent
from .model.effects.sensing import quantised_sides
from .model.effects.timing import lost, sampled_late
from .model.encoders import link_error, motor_error, tilt_moments, tilt_of
from .model.kernel import (LINK_ANGLE, LINK_VELOCITY, MOTOR_ANGLE, MOTOR_VELOCITY, SLOPE_1, STATE)

SIDES = 2
MOTOR, LINK = 0, 1      # columns of a reading, and of the noise
CHANCE = 2              # of the noise: decides in row 0 whether a sample is lost
DRAWS = 3               # columns of the noise


@inlined
def _turned(w: Array, j: int, velocity: int, angle: int, late: float) -> float:
    """Return one side's true angle some time after the stamp [rad]."""
    return sampled_late(late, Sampled(w[j, STATE + angle], w[j, STATE + velocity],
                                      w[j, SLOPE_1 + velocity]))


@compiled
def read_encoders(arm: ArmRecord, inertia: Inertia, w: Array, noise: Array,
                  reading: Array) -> None:
    """
    Fill the angles (n, 2) that encoders show [rad], (eq:motor-reading, link-reading).

    The registers must hold the slopes of their state (see `slope`); `noise` (n, DRAWS) is of unit
    variance. The link encoder is late by its skew on top of the motor encoder's sampling time.
    """
    joints = arm.joints.shape[0]
    moments = tilt_moments(arm.body, inertia, w[:joints, STATE + LINK_ANGLE])
    for j in range(joints):
        joint = arm.joints[j]
        late = joint.motor_encoder.sampling_time
        motor = _turned(w, j, MOTOR_VELOCITY, MOTOR_ANGLE, late)
        link = _turned(w, j, LINK_VELOCITY, LINK_ANGLE, late + joint.clock_skew.skew)
        motor += motor_error(joint, motor) + joint.motor_encoder.zero
        link += link_error(joint, link, tilt_of(moments, j)) + joint.link_encoder.zero
        reading[j, MOTOR], reading[j, LINK] = quantised_sides(
            joint.coarse_quantisation, Counted(motor + noise[j, MOTOR] * joint.motor_encoder.noise,
                                               link + noise[j, LINK] * joint.link_encoder.noise))


@compiled
def sample_lost(arm: ArmRecord, noise: Array) -> bool:
    """Tell whether a sample with this noise (n, DRAWS) is lost on its way."""
    if arm.body.dropped_samples.rate == 0.0:
        return False
    chance = 0.5 * math.erfc(-noise[0, CHANCE] / math.sqrt(2.0))
    return lost(arm.body.dropped_samples, Sent(chance))
