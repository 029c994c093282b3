"""
One step of the arm: leapfrog, angles drifting between kicks of the rates.

While the angles drift the rates stand still, so bristles bend and friction elements slide
exactly; while the rates are kicked the angles stand still, so springs and masses are evaluated
once and only what depends on the rates takes part in the kick's explicit midpoint rule. The whole
is of second order.
"""

import math
from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from . import links
from .drive import angle_torque
from .friction import (
    bearing, bearing_gives, bent, drag, level, LOSSES, meshing, moved, resistance, sticking,
    waviness)
from .gear import dampened, hold, SLIDERS
from .layout import Record, sources
from .torsion import table

Array = NDArray[np.float64]
BEARING_GIVES = 1.5e-5          # bending of the link bearing before it slides [rad]
IDLE = 0.7                      # share of the heat that motor and amplifier give anyway
LOSSES_IDLE = 0.2               # the same where losses feed the heat, nearly alone
SLOWER = 4.0                    # how much later the housing is warm than the grease
HEAT_LAG = 1.2                  # heat over viscosity: a cold drive's larger loss warms it faster

# Forms of laws (`forms.py`); 0 is the one of README.md.
OLDHAM, DRAGGED_DISC = 1, 2     # motor_inertia_error
# Places of a joint's memory.
FIRST_LAG, SECOND_LAG, DISC, HOUSING, MEMORIES = 0, 1, 2, 3, 4

# What a joint holds between two steps. `torque` is the gear's, `applied` the motor's.
HELD = np.dtype([(name, float) for name in (
    'elastic', 'torsion', 'lever', 'damping', 'own', 'dry', 'mesh', 'load', 'applied', 'torque',
    'loss', f'of_{sources()}')], align=True)


class Plant(NamedTuple):
    """An arm ready to move: its numbers (1,), (2,), torsion tables and inertia."""

    arm: NDArray[np.void]
    joints: NDArray[np.void]
    law: Array                  # (2, CELLS + 2, 2)
    body: Array                 # (6,)


class State(NamedTuple):
    """Where an arm is: motors, absolute link angles, base, and everything with a memory."""

    position: Array             # (5,) motors, links, base [rad, m]
    rate: Array                 # (5,)
    bristle: Array              # (2, 2) of motor and link bearing [rad]
    sliders: Array              # (2, SLIDERS) stretch of the friction elements [rad]
    heat: Array                 # (2,) 1 at the temperature that the duty leads to
    lag: Array                  # (2,) [N*m]
    memory: Array               # (2, MEMORIES) of lags [N*m], loose disc [rad/s], housing's heat
    held: NDArray[np.void]      # (2,)
    pose: Array                 # (POSE,)


def plant(arm: NDArray[np.void], joints: NDArray[np.void]) -> Plant:
    """Return the arm of these numbers."""
    return Plant(arm, joints, np.stack([table(joint) for joint in joints]),
                 links.body(arm, joints))


def at_rest(motor: Array, link: Array) -> State:
    """Return the state at rest at motor angles (2,) and relative link angles (2,)."""
    position = np.array([motor[0], motor[1], link[0], link[0] + link[1], 0.0])
    return State(position, np.zeros(5), np.zeros((2, 2)), np.zeros((2, SLIDERS)), np.zeros(2),
                 np.zeros(2), np.zeros((2, MEMORIES)), np.zeros(2, HELD),
                 np.zeros(links.POSE))


@numba.njit(cache=True, error_model='numpy')
def relative(values: Array, j: int) -> float:
    """Return angle or rate of joint j out of the links' absolute ones."""
    return values[2] if j == 0 else values[3] - values[2]


@numba.njit(cache=True, error_model='numpy')
def locate(plant: Plant, state: State, fx: float, fy: float, time: float) -> None:
    """Evaluate everything that depends on the angles and not on the rates."""
    arm = plant.arm[0]
    push_x, push_y = links.contact(arm, time)
    links.write_pose(arm, plant.body, state.position[2], state.position[3],
                     (fx + push_x, fy + push_y), state.pose, time)
    for j in range(2):
        joint, held = plant.joints[j], state.held[j]
        motor, q, other = state.position[j], relative(state.position, j), relative(
            state.position, 1 - j)
        hold(joint, plant.law[j], motor, q, state.sliders[j], held)
        held.own = angle_torque(joint, motor, held.applied, time)
        held.load = links.link_torque(joint, q, time)
        held.dry = (joint.dry + joint.coulomb_friction_level) * waviness(joint, q, other)
        held.mesh = meshing(joint, held.torque)


@numba.njit(cache=True, error_model='numpy')
def drift(plant: Plant, state: State, h: float) -> None:
    """Move all angles, and bend all bristles, for h seconds at the present rates."""
    for j in range(2):
        joint, held, rate = plant.joints[j], state.held[j], state.rate[j]
        state.bristle[j, 0] = moved(joint, state.bristle[j, 0], rate, level(joint, held, rate), h)
        if joint.link_bearing_friction_level > 0.0:
            link_rate = relative(state.rate, j)
            sliding = bearing(joint, link_rate)
            state.bristle[j, 1] = bent(
                state.bristle[j, 1], link_rate,
                joint.link_bearing_friction_level / bearing_gives(joint, BEARING_GIVES), sliding,
                h)
    for i in range(5):
        state.position[i] += h * state.rate[i]


@numba.njit(cache=True, error_model='numpy')
def joint_side(joint: Record, held: Record, bristle: float, motor_rate: float,
               rate: float) -> float:
    """Return the torque on a joint's link from gear, bearing and load; keep the gear's [N*m]."""
    held.torque = held.elastic + dampened(joint, held, held.lever * motor_rate - rate)
    torque = held.torque + held.load
    if joint.link_bearing_friction_level > 0.0:
        stiffness = joint.link_bearing_friction_level / bearing_gives(joint, BEARING_GIVES)
        torque -= resistance(bristle, rate, stiffness, 0.3 * math.sqrt(stiffness * joint.size),
                             bearing(joint, rate))
    return torque


@numba.njit(cache=True, error_model='numpy')
def accelerate(plant: Plant, state: State, rate: Array, out: Array) -> None:
    """Write all accelerations (5,) at the held angles and these rates."""
    arm = plant.arm[0]
    t1 = joint_side(plant.joints[0], state.held[0], state.bristle[0, 1], rate[0],
                    relative(rate, 0))
    t2 = joint_side(plant.joints[1], state.held[1], state.bristle[1, 1], rate[1],
                    relative(rate, 1))
    links.accelerate(arm, plant.body, state.pose, (t1, t2), state.position[4], rate, out)
    for j in range(2):
        joint, held = plant.joints[j], state.held[j]
        against = drag(joint, state.heat[j], state.memory[j, HOUSING], rate[j]) + sticking(
            joint, held, state.bristle[j, 0], rate[j])
        held.loss = against * rate[j]
        torque = held.applied + held.own - against - held.torque * held.lever
        out[j] = turned(joint, state.position[j], rate[j], torque, state.memory[j, DISC])


@numba.njit(cache=True, error_model='numpy')
def turned(joint: Record, angle: float, rate: float, torque: float, disc: float) -> float:
    """Return a motor's acceleration under a torque [rad/s^2]; `disc` is a loose one's rate."""
    error, form = joint.motor_inertia_error_relative_error, joint.motor_inertia_error_form
    if form == OLDHAM:      # an inertia that swings twice a turn, with the torque of its change
        share = joint.motor_inertia_error_first
        slope = 2.0 * share * error * math.cos(2.0 * angle)
        error *= 1.0 + share * math.sin(2.0 * angle)
        torque -= 0.5 * joint.inertia * slope * rate * rate
    elif form == DRAGGED_DISC:
        torque -= abs(error) * joint.inertia * (rate - disc) / joint.motor_inertia_error_first
        error = 0.0
    return torque / (joint.inertia * (1.0 + error))


@numba.njit(cache=True, error_model='numpy')
def kick(plant: Plant, state: State, h: float, middle: Array, acceleration: Array) -> None:
    """Change all rates over h seconds at the present angles; warm the drives by their losses."""
    accelerate(plant, state, state.rate, acceleration)
    for i in range(5):
        middle[i] = state.rate[i] + 0.5 * h * acceleration[i]
    accelerate(plant, state, middle, acceleration)
    for i in range(5):
        state.rate[i] += h * acceleration[i]
    for j in range(2):
        joint = plant.joints[j]
        idle = LOSSES_IDLE if joint.thermal_viscosity_form == LOSSES else IDLE
        fed = idle + (1.0 - idle) * state.held[j].loss / joint.reference_power
        slow = HEAT_LAG * joint.thermal_viscosity_time_constant
        state.heat[j] += h * (fed - state.heat[j]) / slow
        state.memory[j, HOUSING] += h * (fed - state.memory[j, HOUSING]) / (SLOWER * slow)
        if joint.motor_inertia_error_form == DRAGGED_DISC:
            state.memory[j, DISC] += (state.rate[j] - state.memory[j, DISC]) * -math.expm1(
                -h / joint.motor_inertia_error_first)
