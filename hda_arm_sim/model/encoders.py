"""
What both encoders of a joint show of an angle, and which angle is behind what they show.

See docs/model.md#encoders.
"""

from typing import Any

from numba.core import types

from .effect_loops import acting_at, added, record_at
from .effects.catalogue import sole_at
from .effects.place import (CLOCK, Counted, COUNTS, LINK_READING, MOTOR_READING, Read,
                            TILTED_READING, Triggered)
from ..foundation.arrays import Array
from ..foundation.chain import ANGLE, Chain, of_links, place, TORQUE
from ..foundation.chain import tilting_moment as chain_tilt
from ..foundation.compiled import compiled, either, inlined, Record
from ..foundation.rigid import Inertia, tilting_moment

_ROUNDS = 40            # of the inverse; an error's slope below 0.1 needs 15
_SAME = 1e-15           # change of an angle that ends the inverse [rad]


_at_motor, _at_link, _tilted = added(MOTOR_READING), added(LINK_READING), added(TILTED_READING)
_motor_slope, _link_slope = added(MOTOR_READING, 'law_slope'), added(LINK_READING, 'law_slope')
_later, _counted, counts_of = added(CLOCK), sole_at(COUNTS).law, record_at(COUNTS)
# Whether what tilts the bearing of a joint's link shows in its link encoder.
feels_tilt = acting_at(TILTED_READING)


@inlined
def shown_after(late: float, angle: float, velocity: float, acceleration: float) -> float:
    """Return the angle that an encoder shows `late` [s] after the stamp, (eq:skew) [rad]."""
    return angle + late * (velocity + 0.5 * late * acceleration)


@inlined
def link_lateness(joint: Record) -> float:
    """Return how long after the stamp the link encoder is read, (eq:skew) [s]."""
    late = joint.motor_encoder.sampling_time
    return _later(joint, Triggered(late), late)


@inlined
def counted(joint: Record, motor: float, link: float) -> tuple[float, float]:
    """Return both angles in the steps of their encoders, (eq:count) [rad]."""
    return _counted(counts_of(joint), Counted(motor, link))


@inlined
def motor_error(joint: Record, angle: float) -> float:
    """Return what the motor encoder adds to the shaft's angle [rad]."""
    return _at_motor(joint, Read(angle, 0.0), 0.0)


@inlined
def link_error(joint: Record, angle: float, tilt_moment: float) -> float:
    """Return what the link encoder adds to the link's angle [rad]."""
    at = Read(angle, tilt_moment)
    return _tilted(joint, at, _at_link(joint, at, 0.0))


@compiled
def motor_angle_behind(joint: Record, shown: float) -> float:
    """Return the angle of the shaft that its encoder shows as `shown`, (eq:angle-behind) [rad]."""
    angle = shown
    for _ in range(_ROUNDS):
        last, angle = angle, shown - motor_error(joint, angle)
        if abs(angle - last) <= _SAME * abs(angle):
            break
    return angle


@compiled
def link_angle_behind(joint: Record, shown: float, tilt_moment: float) -> float:
    """Return the link's angle that the link encoder shows as `shown`, (eq:angle-behind) [rad]."""
    angle = shown
    for _ in range(_ROUNDS):
        last, angle = angle, shown - link_error(joint, angle, tilt_moment)
        if abs(angle - last) <= _SAME * abs(angle):
            break
    return angle


@inlined
def motor_gain(joint: Record, angle: float) -> float:
    """Return how much faster the motor encoder turns than its shaft, at an angle."""
    return _motor_slope(joint, Read(angle, 0.0), 1.0)


@inlined
def link_gain(joint: Record, angle: float) -> float:
    """Return how much faster the link encoder turns than its link; fine waves average out."""
    return _link_slope(joint, Read(angle, 0.0), 1.0)


@inlined
def _pair_tilted(body: Record, inertia: Inertia, angles: Array) -> tuple[float, float]:
    elbow = angles[angles.shape[0] - 1]
    return tilting_moment(inertia.first, inertia.second, body.weight, elbow)


@compiled
def _chain_tilted(body: Record, inertia: Chain, angles: Array) -> Array:
    c = inertia.table
    c[1:-1, ANGLE] = angles
    place(c)
    for row in range(1, c.shape[0] - 1):
        c[row, TORQUE] = chain_tilt(c, row)
    return c[1:-1, TORQUE]


@inlined
def _one_of_pair(moments: tuple[float, float], j: int) -> float:
    return moments[min(j, 1)]


@inlined
def _one_of_many(moments: Array, j: int) -> float:
    return moments[j]


def _is_array(kind: Any) -> bool:
    return isinstance(kind, types.Array)


# Moments that tilt the bearings at some link angles (n,) [N*m], and that of one joint.
tilt_moments = of_links(_pair_tilted, _chain_tilted)
tilt_of = either(_one_of_pair, _one_of_many, _is_array)
