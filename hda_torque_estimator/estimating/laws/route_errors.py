"""
What may be wrong with the two ways to a joint's torque (docs/estimation.md#equations).

The torsion determines the torque through the gear, and so does the motor: its torque less friction
and inertia. Each error is one number in units of how well it is known, and has an effect on the
torque of its way. So before anything is learnt the covariance of all errors is the identity.
"""

from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.compiled import compiled, inlined, Record
from hda_arm_sim.model.effect_loops import record_of
from hda_arm_sim.model.effects.catalogue import known_as
from hda_arm_sim.model.motor_side import drag, friction_budget, ripple, shaft_torque
import numpy as np

# Errors of the torsion: zero, waves over shaft and link (sine and cosine of an order), skew of the
# encoders, stiffness. Errors of the motor: friction, torque constant, offset of the drive, ripple.
ZERO, SHAFT_1, SHAFT_2, SHAFT_4, LINK_1, LINK_2, SKEW, STIFFNESS = 0, 1, 3, 5, 7, 9, 11, 12
TORSION_ERRORS = 13
DRY, VISCOUS, GAIN, OFFSET, RIPPLE_2, RIPPLE_4 = 13, 14, 15, 16, 17, 19
ERRORS = 21
_viscous_of = record_of(known_as('viscous_friction'))


class ShaftState(NamedTuple):
    """A shaft in motion: angle [rad], velocity [rad/s], its sign, 0 where it may stick."""

    angle: float
    velocity: float
    sense: float
    link_angle: float


@compiled
def torsion_effects(known: Record, motor_angle: float, link_angle: float, link_velocity: float,
                    effect: Array) -> None:
    """Fill what a sigma of each error adds to the torsion (ERRORS,) [rad], (eq:wrong-torsion)."""
    _wave(known.kinematic_error, motor_angle, effect, SHAFT_1)
    _wave(known.kinematic_error, 2.0 * motor_angle, effect, SHAFT_2)
    _wave(known.kinematic_error, 4.0 * motor_angle, effect, SHAFT_4)
    _wave(known.eccentricity, link_angle, effect, LINK_1)
    _wave(known.eccentricity, 2.0 * link_angle, effect, LINK_2)
    effect[ZERO] = known.torsion_zero
    effect[SKEW] = -known.clock_skew * link_velocity


@inlined
def _wave(size: float, angle: float, effect: Array, place: int) -> None:
    effect[place], effect[place + 1] = size * np.sin(angle), size * np.cos(angle)


@compiled
def torque_effects(known: Record, flexed: float, stiffness: float, effect: Array) -> None:
    """
    Turn effects on the torsion into those on its torque [N*m], (eq:two-routes).

    `flexed` is the torsion that a softer flexspline adds, for each 1 of its factor [rad].
    """
    effect[:STIFFNESS] *= stiffness
    effect[STIFFNESS] = -known.stiffness * flexed * stiffness


@compiled
def motor_effects(joint: Record, known: Record, command: float, at: ShaftState, friction: float,
                  effect: Array) -> None:
    """
    Fill what one sigma of each error takes from the motor's torque, (eq:motor-torque).

    `friction` is all that dry friction can oppose, of a load as well [N*m at the link].
    """
    ratio, wavy = joint.ratio, joint.ratio * known.torque_ripple
    effect[DRY] = -known.dry_friction * friction * at.sense
    effect[VISCOUS] = -ratio * known.viscous_friction * _viscous_of(joint).slope * at.velocity
    effect[GAIN] = ratio * known.torque_constant * command
    effect[OFFSET] = ratio * known.drive_offset
    _wave(wavy, 2.0 * at.angle, effect, RIPPLE_2)
    _wave(wavy, 4.0 * at.angle, effect, RIPPLE_4)


@inlined
def dry_friction(joint: Record, at: ShaftState, torque: float) -> float:
    """Return the most that dry friction opposes, sliding or at rest [N*m at the link]."""
    sense = at.sense if at.sense != 0.0 else 1.0
    return joint.ratio * friction_budget(joint, at.velocity, sense, torque, at.link_angle)


@compiled
def motor_torque(joint: Record, command: float, at: ShaftState, torque: float,
                 time: float) -> float:
    """Return the gear's torque that a motor without inertia has [N*m], (eq:motor-torque)."""
    dry = at.sense * friction_budget(joint, at.velocity, at.sense, torque, at.link_angle)
    driving = shaft_torque(joint, command) + ripple(joint, at.angle)
    return joint.ratio * (driving - drag(joint, at.velocity, time) - dry)
