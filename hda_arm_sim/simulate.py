"""Move the arm: from a state and inputs to a trajectory, compiled and deterministic."""

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from .model.arm import Arm, ArmError
from .model.compiled import compiled
from .model.integrate import advance
from .model.kernel import (LINK_ANGLE, LINK_VELOCITY, loaded_inertia, MOTOR_ANGLE, MOTOR_VELOCITY,
                           registers, slope, SLOPE_1, STATE, STATES, TORQUE)

Array = NDArray[np.float64]
STEP = 1e-3 / 3                   # default integration step [s]


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
    """Return the state (n, STATES) of an unloaded arm at rest at these link angles [rad]."""
    state = np.zeros((len(arm.joints), STATES))
    state[:, LINK_ANGLE] = link_angle
    state[:, MOTOR_ANGLE] = state[:, LINK_ANGLE] * [joint.ratio for joint in arm.joints]
    return state


def rollout(arm: Arm, initial: Array, motor_torque: Array, tip_force: Array, dt: float, *,
            step: float = STEP, held: bool = True) -> Trajectory:
    """
    Simulate an arm under given inputs, sampled every dt [s].

    `motor_torque` (k, n) [N*m, shaft] and `tip_force` (k, 2) [N, base frame] are held from their
    sample until the next, or joined by a cubic spline with `held=False`. Raises ArmError for an
    arm without links and for arrays that do not fit.
    """
    record = checked(arm).record()
    samples = len(motor_torque)
    if motor_torque.shape != (samples, len(arm.joints)) or tip_force.shape != (samples, 2):
        raise ArmError(f'inputs must have shapes (k, {len(arm.joints)}) and (k, 2), got '
                       f'{motor_torque.shape} and {tip_force.shape}')
    count = step_count(dt, step)
    torque = _inputs(np.asarray(motor_torque, float), count, held)
    force = _inputs(np.asarray(tip_force, float), count, held)
    states = np.empty((samples, *initial.shape))
    extra = np.empty((3, samples, len(arm.joints)))
    _run(record, registers(initial), torque, force, dt / count, states, extra)
    return Trajectory(dt * np.arange(samples), states, *extra)


def step_count(dt: float, step: float = STEP) -> int:
    """Return into how many steps of at most `step` [s] a sample of dt [s] is divided."""
    return max(1, math.ceil(dt / step - 1e-9))


def checked(arm: Arm) -> Arm:
    """Return the arm if it can move; raises ArmError for an arm without links."""
    if arm.links is None:
        raise ArmError('an arm without links ("links: none") cannot be simulated: '
                       'give its lengths and inertia under "links"')
    return arm


def _inputs(values: Array, count: int, held: bool) -> Array:
    """Return the inputs at start, middle and end of every step, ((k-1) count, 3, m)."""
    samples = len(values)
    if held or samples < 4:
        return np.repeat(values[:-1, None, :], count, axis=0).repeat(3, axis=1)
    nodes = np.arange((samples - 1) * 2 * count + 1) / (2 * count)
    fine = CubicSpline(np.arange(samples), values)(nodes)
    return np.stack([fine[0:-2:2], fine[1::2], fine[2::2]], axis=1)


@compiled
def observe(arm, inertia, w, torque, acceleration):                 # type: ignore[no-untyped-def]
    """Fill the joint torques (n,) [N*m] and the accelerations (2, n) of links and motors."""
    slope(arm, inertia, w, STATE, SLOPE_1)
    for j in range(arm.joints.shape[0]):
        torque[j] = w[j, TORQUE]
        acceleration[0, j] = w[j, SLOPE_1 + LINK_VELOCITY]
        acceleration[1, j] = w[j, SLOPE_1 + MOTOR_VELOCITY]


@compiled
def _run(arm, w, torque, force, dt, states, extra):                 # type: ignore[no-untyped-def]
    inertia = loaded_inertia(arm.body)
    joints = states.shape[1]
    count = torque.shape[0] // max(1, states.shape[0] - 1)
    for i in range(states.shape[0]):
        states[i] = w[:joints, STATE:STATE + STATES]
        observe(arm, inertia, w, extra[0, i], extra[1:, i])
        if i + 1 < states.shape[0]:
            for k in range(i * count, (i + 1) * count):
                advance(arm, inertia, w, torque[k], force[k], dt)
