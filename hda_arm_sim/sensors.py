"""Read the arm as its encoders do: at their time, from their zero, with noise, in whole counts."""

from .model.compiled import compiled
from .model.effects.sensing import quantised, sampled_late
from .model.kernel import (LINK_ANGLE, LINK_VELOCITY, MOTOR_ANGLE, MOTOR_VELOCITY, SLOPE_1, STATE)

SIDES = 2
MOTOR, LINK = 0, 1      # columns of a reading


@compiled
def read_encoders(arm, w, noise, reading):                          # type: ignore[no-untyped-def]
    """
    Fill the angles (n, 2) that the encoders show, shaft and link [rad], (20)-(21).

    The registers must hold the slopes of their state (see `slope`); `noise` (n, 2) is of unit
    variance. The link encoder is late by its skew on top of the motor encoder's sampling time.
    """
    for j in range(arm.joints.shape[0]):
        joint = arm.joints[j]
        late = joint.motor_encoder.sampling_time
        angle = sampled_late(w[j, STATE + MOTOR_ANGLE], w[j, STATE + MOTOR_VELOCITY],
                             w[j, SLOPE_1 + MOTOR_VELOCITY], late)
        angle += joint.motor_encoder.zero + noise[j, MOTOR] * joint.motor_encoder.noise
        reading[j, MOTOR] = quantised(angle, joint.coarse_quantisation.motor_step)
        late += joint.clock_skew.skew
        angle = sampled_late(w[j, STATE + LINK_ANGLE], w[j, STATE + LINK_VELOCITY],
                             w[j, SLOPE_1 + LINK_VELOCITY], late)
        angle += joint.link_encoder.zero + noise[j, LINK] * joint.link_encoder.noise
        reading[j, LINK] = quantised(angle, joint.coarse_quantisation.link_step)
