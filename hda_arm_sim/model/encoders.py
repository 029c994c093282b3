"""
What both encoders of a joint show of an angle, and which angle is behind what they show.

See docs/model.md#encoders.
"""

from .acting import added
from .effects.place import LINK_READING, MOTOR_READING, Read
from .effects.sensing import tilting_moment
from ..foundation.compiled import compiled, inlined, Record
from ..foundation.rigid import Inertia

_ROUNDS = 40            # of the inverse; an error's slope below 0.1 needs 15
_SAME = 1e-15           # change of an angle that ends the inverse [rad]


_at_motor, _at_link = added(MOTOR_READING), added(LINK_READING)
_motor_slope, _link_slope = added(MOTOR_READING, 'law_slope'), added(LINK_READING, 'law_slope')


@inlined
def motor_error(joint: Record, angle: float) -> float:
    """Return what the motor encoder adds to the shaft's angle [rad]."""
    return _at_motor(joint, Read(angle, 0.0), 0.0)


@inlined
def link_error(joint: Record, angle: float, tilt_moment: float) -> float:
    """Return what the link encoder adds to the link's angle [rad]."""
    return _at_link(joint, Read(angle, tilt_moment), 0.0)


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


@compiled
def tilt_moments(body: Record, inertia: Inertia, elbow: float) -> tuple[float, float]:
    """Return the tilting moments on the bearings of joints 1 and 2 [N*m]."""
    return tilting_moment(inertia.first, inertia.second, body.weight, elbow)
