"""Move the arm: from a state and inputs to a trajectory, compiled and deterministic."""

from dataclasses import dataclass
import math
from typing import Any, NamedTuple

import numpy as np

from .drive import NODES, pass_sample, send
from .foundation.arrays import Array
from .foundation.compiled import borrowed, compiled
from .foundation.rigid import Inertia
from .model.arm import Arm, ArmError, ArmRecord
from .model.chain_links import ChainLinks
from .model.effect_loops import numbers_at
from .model.effects.catalogue import sole_at
from .model.effects.place import WIRE
from .model.integrate import advance, set_input
from .model.kernel import (AXES, COMMANDS, FORCES, HISTORY, LINK_ANGLE, LINK_VELOCITY, MOTOR_ANGLE,
                           MOTOR_VELOCITY, registers, slope, SLOPE_1, STATE, STATES, TIME, TORQUE)
from .model.link_side import loaded_inertia
from .model.stiffness_rate import fastest_rate

STEP = 1e-3 / 3         # default integration step [s]
STABLE = 2.0            # step times fastest rate; beyond 2.78 Runge-Kutta 4 grows without end


class InputHistory(NamedTuple):
    """Inputs over time: torques of the motors, and what acts on the tip."""

    torque: Array               # (k, n) at the shafts [N*m]
    force: Array                # (k, 2) [N, base frame]; on a chain also (k, 6) [N, N*m]


@dataclass(frozen=True)
class Trajectory:
    """True states of a simulated arm; arrays over time, one column per joint."""

    time: Array                 # (k,) s
    state: Array                # (k, n, STATES), columns of model.kernel
    joint_torque: Array         # (k, n) through the gear, output side [N*m]
    link_acceleration: Array    # (k, n) [rad/s^2]
    motor_acceleration: Array   # (k, n) [rad/s^2]

    @property
    def motor_angle(self) -> Array:
        """Return the shaft angles (k, n) [rad]."""
        return self.state[:, :, MOTOR_ANGLE]

    @property
    def motor_velocity(self) -> Array:
        """Return the shaft velocities (k, n) [rad/s]."""
        return self.state[:, :, MOTOR_VELOCITY]

    @property
    def link_angle(self) -> Array:
        """Return the link angles (k, n) [rad]."""
        return self.state[:, :, LINK_ANGLE]

    @property
    def link_velocity(self) -> Array:
        """Return the link velocities (k, n) [rad/s]."""
        return self.state[:, :, LINK_VELOCITY]


def rest(arm: Arm, link_angle: Array | tuple[float, ...]) -> Array:
    """Return the state (n, STATES) of an arm at rest at these link angles, (eq:start) [rad]."""
    state = np.zeros((len(arm.joints), STATES))
    state[:, LINK_ANGLE] = link_angle
    state[:, MOTOR_ANGLE] = state[:, LINK_ANGLE] * [joint.ratio for joint in arm.joints]
    return state


def rollout(arm: Arm, initial: Array, inputs: InputHistory, dt: float, *, step: float = STEP,
            held: bool = True, start: float = 0.0) -> Trajectory:
    """
    Simulate an arm under given inputs, sampled every dt [s].

    Inputs are held from their sample until the next, or joined by a cubic spline with
    `held=False`. `start` is the time of the first sample [s], for what changes with time.
    Accelerations are those under the inputs from their sample on. Raises ArmError for an arm
    without links and for arrays that do not fit.
    """
    motor_torque, tip_force = inputs
    record = checked(arm, dt).record()
    samples = len(motor_torque)
    if motor_torque.shape != (samples, len(arm.joints)) or len(tip_force) != samples:
        raise ArmError(f'inputs must have shapes (k, {len(arm.joints)}) and (k, 2), got '
                       f'{motor_torque.shape} and {tip_force.shape}')
    count = step_count(dt, min(step, longest_step(arm)))
    torque = np.ascontiguousarray(motor_torque, float)
    force = on_tip(arm, tip_force)
    states: Array = np.empty((samples, len(arm.joints), STATES))
    extra: Array = np.empty((3, samples, len(arm.joints)))
    w = registers(np.asarray(initial, float))
    w[0, TIME] = start
    if held or samples < 4:
        _run_held(record, w, InputHistory(torque, force), dt, count, states, extra)
    else:
        late = [delay / dt for delay in numbers_at(record.joints, WIRE)['delay']]
        nodes = InputHistory(_nodes(torque, count, late),
                             _nodes(force, count, [0.0] * force.shape[1]))
        _run_smooth(record, w, nodes, dt / count, count, states, extra)
    return Trajectory(start + dt * np.arange(float(samples)), states, *extra)


def step_count(dt: float, step: float) -> int:
    """Return into how many steps of at most `step` [s] a sample of dt [s] is divided."""
    return max(1, math.ceil(dt / step - 1e-9))


def checked(arm: Arm, dt: float = 1e-3) -> Arm:
    """Return the arm if it can move in samples of dt [s]; raises ArmError if not."""
    if arm.links is None:
        how = ('its lengths and inertia' if len(arm.joints) <= 2 else
               '{urdf: FILE, tip: FRAME, joints: [...]}')
        raise ArmError('an arm without links ("links: none") cannot be simulated: '
                       f'give {how} under "links"')
    longest = (HISTORY - 2) * dt
    for label in arm.labels:
        wire: Any = arm.effect(sole_at(WIRE).name, label)
        if wire.delay > longest:
            raise ArmError(f'{wire.name} of {label} must be at most {HISTORY - 2} samples, '
                           f'{longest:g} s, got {wire.delay:g} s')
    return arm


def on_tip(arm: Arm, force: Array) -> Array:
    """Return what acts on the tip: (k, 2) in a plane, (k, 6) on a chain; raises ArmError."""
    count = AXES if isinstance(arm.links, ChainLinks) else 2
    given = np.ascontiguousarray(force, float)
    if given.ndim != 2 or given.shape[1] not in (2, 3, count) or given.shape[1] > count:
        raise ArmError(f'what acts on the tip must have shape (k, {count}), got {given.shape}')
    return np.ascontiguousarray(np.pad(given, ((0, 0), (0, count - given.shape[1]))))


def longest_step(arm: Arm) -> float:
    """
    Return the longest step of integration that an arm bears [s].

    Two links bear any that is short enough to be accurate. Light links of a chain behind stiff
    gears may not. Runge-Kutta 4 is stable while a step times its fastest rate is below 2.78.
    """
    return STABLE / fastest_rate(arm) if isinstance(arm.links, ChainLinks) else math.inf


def _nodes(values: Array, count: int, late: list[float]) -> Array:
    """Return a spline at start, middle and end of every step, its columns some samples late."""
    from scipy.interpolate import CubicSpline       # a third of a second that few need to wait
    nodes = np.arange((len(values) - 1) * 2 * count + 1) / (2 * count)
    fine = np.stack([CubicSpline(np.arange(len(values)), column)(np.maximum(nodes - samples, 0.0))
                     for column, samples in zip(values.T, late)], axis=1)
    return np.stack([fine[0:-2:2], fine[1::2], fine[2::2]], axis=1)


@compiled
def observe(arm: ArmRecord, inertia: Inertia, w: Array, torque: Array,
            acceleration: Array) -> None:
    """Fill the joint torques (n,) [N*m] and the accelerations (2, n) of links and motors."""
    slope(arm, inertia, w, STATE, SLOPE_1)
    for j in range(arm.joints.shape[0]):
        torque[j] = w[j, TORQUE]
        acceleration[0, j] = w[j, SLOPE_1 + LINK_VELOCITY]
        acceleration[1, j] = w[j, SLOPE_1 + MOTOR_VELOCITY]


@compiled
def _run_held(arm: ArmRecord, w: Array, course: InputHistory, dt: float, count: int,
              states: Array, extra: Array) -> None:
    """Fill the states (k, n, STATES) and torques and accelerations under held inputs."""
    inertia, (torque, force) = loaded_inertia(arm.body), course
    arm, w = ArmRecord(borrowed(arm.joints), arm.body), borrowed(w)
    joints, samples = states.shape[1], states.shape[0]
    for i in range(samples):
        states[i] = w[:joints, STATE:STATE + STATES]
        send(arm, w, torque[i], force[i], dt)
        observe(arm, inertia, w, extra[0, i], extra[1:, i])
        if i + 1 < samples:
            pass_sample(arm, inertia, w, force[i], dt, count)


@compiled
def _run_smooth(arm: ArmRecord, w: Array, course: InputHistory, dt: float, count: int,
                states: Array, extra: Array) -> None:
    """Fill the same under inputs at the start, middle and end of every step of dt [s]."""
    inertia, (torque, force) = loaded_inertia(arm.body), course
    arm, w = ArmRecord(borrowed(arm.joints), arm.body), borrowed(w)
    joints, samples = states.shape[1], states.shape[0]
    for i in range(samples):
        states[i] = w[:joints, STATE:STATE + STATES]
        _load(w, torque[min(i * count, len(torque) - 1)], force[min(i * count, len(force) - 1)])
        set_input(arm, w, dt, 0.0, 0.0 if i + 1 < samples else 1.0)
        observe(arm, inertia, w, extra[0, i], extra[1:, i])
        if i + 1 < samples:
            for k in range(i * count, (i + 1) * count):
                _load(w, torque[k], force[k])
                advance(arm, inertia, w, dt)


@compiled
def _load(w: Array, torque: Array, force: Array) -> None:
    """Load the inputs of a step, torques (NODES, n) and forces (NODES, 2 or 6)."""
    for k in range(NODES):
        for j in range(torque.shape[1]):
            w[j, COMMANDS + k] = torque[k, j]
        for axis in range(force.shape[1]):
            w[axis, FORCES + k] = force[k, axis]
