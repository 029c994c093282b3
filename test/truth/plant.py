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
from .friction import bent, drag, level, resistance
from .gear import hold, SLIDERS
from .layout import Record, sources
from .nominal import RATIO
from .torsion import table

Array = NDArray[np.float64]
BEARING_GIVES = 1.5e-5          # bending of the link bearing before it slides [rad]
IDLE = 0.7                      # share of the heat that motor and amplifier give anyway
HEAT_LAG = 1.2                  # heat over viscosity: a cold drive's larger loss warms it faster

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
                 np.zeros(2), np.zeros(2, HELD), np.zeros(links.POSE))


@numba.njit(cache=True, error_model='numpy')
def relative(values: Array, j: int) -> float:
    """Return angle or rate of joint j out of the links' absolute ones."""
    return values[2] if j == 0 else values[3] - values[2]


@numba.njit(cache=True, error_model='numpy')
def locate(plant: Plant, state: State, fx: float, fy: float, time: float) -> None:
    """Evaluate everything that depends on the angles and not on the rates."""
    arm = plant.arm[0]
    push_x, push_y = links.contact(arm, time)
    links.write_pose(arm, plant.body, state.position[2], state.position[3], fx + push_x,
                     fy + push_y, state.pose)
    for j in range(2):
        joint, held = plant.joints[j], state.held[j]
        motor, q, other = state.position[j], relative(state.position, j), relative(
            state.position, 1 - j)
        hold(joint, plant.law[j], motor, q, state.sliders[j], held)
        held.own = angle_torque(joint, motor, time)
        held.load = links.link_torque(joint, q, time)
        held.dry = (joint.dry + joint.coulomb_friction_level) * waviness(joint, q, other)
        held.mesh = joint.load_dependent_friction_coefficient * abs(held.torque) / RATIO


@numba.njit(cache=True, error_model='numpy')
def waviness(joint: Record, q: float, other: float) -> float:
    """Return the factor on dry friction at the angles of this and of the other link."""
    factor = 1.0
    if joint.position_dependent_friction_amplitude != 0.0:
        factor += joint.position_dependent_friction_amplitude * math.sin(
            joint.position_dependent_friction_order * q + joint.position_dependent_friction_phase)
    if joint.crossed_friction_amplitude != 0.0:
        factor += joint.crossed_friction_amplitude * math.sin(
            joint.crossed_friction_order * other + joint.crossed_friction_phase)
    return factor


@numba.njit(cache=True, error_model='numpy')
def drift(plant: Plant, state: State, h: float) -> None:
    """Move all angles, and bend all bristles, for h seconds at the present rates."""
    for j in range(2):
        joint, held, rate = plant.joints[j], state.held[j], state.rate[j]
        state.bristle[j, 0] = bent(
            state.bristle[j, 0], rate, joint.presliding_friction_stiffness,
            level(joint, held.dry, held.mesh, rate), h)
        bearing = joint.link_bearing_friction_level
        if bearing > 0.0:
            state.bristle[j, 1] = bent(state.bristle[j, 1], relative(state.rate, j),
                                       bearing / BEARING_GIVES, bearing, h)
    for i in range(5):
        state.position[i] += h * state.rate[i]


@numba.njit(cache=True, error_model='numpy')
def joint_side(joint: Record, held: Record, bristle: float, motor_rate: float,
               rate: float) -> float:
    """Return the torque on a joint's link from gear, bearing and load; keep the gear's [N*m]."""
    held.torque = held.elastic + held.damping * (held.lever * motor_rate - rate)
    torque = held.torque + held.load
    bearing = joint.link_bearing_friction_level
    if bearing > 0.0:
        stiffness = bearing / BEARING_GIVES
        torque -= resistance(bristle, rate, stiffness, 0.3 * math.sqrt(stiffness), bearing)
    return torque


@numba.njit(cache=True, error_model='numpy')
def accelerate(plant: Plant, state: State, rate: Array, out: Array) -> None:
    """Write all accelerations (5,) at the held angles and these rates."""
    arm = plant.arm[0]
    t1 = joint_side(plant.joints[0], state.held[0], state.bristle[0, 1], rate[0],
                    relative(rate, 0))
    t2 = joint_side(plant.joints[1], state.held[1], state.bristle[1, 1], rate[1],
                    relative(rate, 1))
    links.accelerate(arm, plant.body, state.pose, t1, t2, state.position[4], rate, out)
    for j in range(2):
        joint, held = plant.joints[j], state.held[j]
        against = drag(joint, state.heat[j], rate[j]) + resistance(
            state.bristle[j, 0], rate[j], joint.presliding_friction_stiffness,
            joint.presliding_friction_damping, level(joint, held.dry, held.mesh, rate[j]))
        held.loss = against * rate[j]
        inertia = joint.inertia * (1.0 + joint.motor_inertia_error_relative_error)
        out[j] = (held.applied + held.own - against - held.torque * held.lever) / inertia


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
        fed = IDLE + (1.0 - IDLE) * state.held[j].loss / joint.reference_power
        state.heat[j] += h * (fed - state.heat[j]) / (
            HEAT_LAG * joint.thermal_viscosity_time_constant)
