"""Read the arm as its encoders do: at their time, from their zero, with noise, in whole counts."""

import math

from .foundation.arrays import Array
from .foundation.compiled import compiled, inlined
from .foundation.rigid import Inertia
from .model.arm import ArmRecord
from .model.effect_loops import acting_at, record_at
from .model.effects.catalogue import sole_at
from .model.effects.place import SAMPLE, Sent
from .model.encoders import (counted, link_error, link_lateness, motor_error, shown_after,
                             tilt_moments, tilt_of)
from .model.kernel import (LINK_ANGLE, LINK_VELOCITY, MOTOR_ANGLE, MOTOR_VELOCITY, SLOPE_1, STATE)

SIDES = 2
MOTOR, LINK = 0, 1      # columns of a reading, and of the noise
CHANCE = 2              # of the noise: decides in row 0 whether a sample is lost
DRAWS = 3               # columns of the noise
_may_be_lost, _losses = acting_at(SAMPLE), record_at(SAMPLE)
_is_lost = sole_at(SAMPLE).law


@inlined
def _turned(w: Array, j: int, velocity: int, angle: int, late: float) -> float:
    """Return one side's true angle some time after the stamp [rad]."""
    return shown_after(late, w[j, STATE + angle], w[j, STATE + velocity],
                       w[j, SLOPE_1 + velocity])


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
        link = _turned(w, j, LINK_VELOCITY, LINK_ANGLE, link_lateness(joint))
        motor += motor_error(joint, motor) + joint.motor_encoder.zero
        link += link_error(joint, link, tilt_of(moments, j)) + joint.link_encoder.zero
        reading[j, MOTOR], reading[j, LINK] = counted(
            joint, motor + noise[j, MOTOR] * joint.motor_encoder.noise,
            link + noise[j, LINK] * joint.link_encoder.noise)


@compiled
def sample_lost(arm: ArmRecord, noise: Array) -> bool:
    """Return whether a sample with this noise (n, DRAWS) is lost on its way."""
    if not _may_be_lost(arm.body):
        return False
    chance = 0.5 * math.erfc(-noise[0, CHANCE] / math.sqrt(2.0))
    return _is_lost(_losses(arm.body), Sent(chance))
