"""
What acts on the shaft of one joint: every effect of the motor at its place, by its law.

See docs/model.md#motion.
"""

from .effect_loops import acting_at, added, grown, passed, record_at
from .effects.catalogue import sole_at
from .effects.place import (BREAKAWAY, Commanded, CURRENT_LOOP, Delivered, DRAG, Dragged,
                            DRY_LEVEL, LIMIT, MESH, Rubbed, SHAFT, TURN, Turned)
from ..foundation.compiled import inlined, Record


limit_of, loop_of = record_at(LIMIT), record_at(CURRENT_LOOP)
lags = acting_at(CURRENT_LOOP)          # whether the current loop of a joint does
_clipped, _lagging = sole_at(LIMIT).law, sole_at(CURRENT_LOOP).law


@inlined
def _delivered(at: Delivered, torque: float) -> Delivered:
    return Delivered(torque)


@inlined
def _rubbed(at: Rubbed, budget: float) -> Rubbed:
    return Rubbed(budget, at.sense, at.motor_velocity, at.joint_torque, at.ratio, at.link_angle)


_driven = passed(SHAFT, _delivered)
_turned, _dragged = added(TURN), added(DRAG)
_dry, _breaking, _meshing = (grown(place, _rubbed) for place in (DRY_LEVEL, BREAKAWAY, MESH))


@inlined
def clipped(joint: Record, command: float) -> float:
    """Return what the drive's limit leaves of a command [N*m motor]."""
    return _clipped(limit_of(joint), Commanded(command, 0.0, 0.0, 0.0))


@inlined
def lagging(joint: Record, at: Commanded) -> float:
    """Return what the current loop delivers, if it lags [N*m motor]."""
    return _lagging(loop_of(joint), at)


@inlined
def shaft_torque(joint: Record, current: float) -> float:
    """Return the torque at the shaft of what the current loop delivers [N*m motor]."""
    return _driven(joint, Delivered(current), current)


@inlined
def ripple(joint: Record, motor_angle: float) -> float:
    """Return the torques that vary along the turn of the motor [N*m motor]."""
    return _turned(joint, Turned(motor_angle), 0.0)


@inlined
def drag(joint: Record, motor_velocity: float, time: float) -> float:
    """Return the torque of viscous friction, against the motion [N*m motor]."""
    return _dragged(joint, Dragged(motor_velocity, time), 0.0)


@inlined
def friction_budget(joint: Record, motor_velocity: float, sense: float, joint_torque: float,
                    link_angle: float) -> float:
    """
    Return the most torque that dry friction can oppose, (eq:friction-budget) [N*m motor].

    `sense` is the sign of sliding, or of the torque that would start it. The dry level and its
    variation come first, then what adds to them.
    """
    at = Rubbed(0.0, sense, motor_velocity, joint_torque, joint.ratio, link_angle)
    return _meshing(joint, at, _breaking(joint, at, _dry(joint, at, 0.0)))
