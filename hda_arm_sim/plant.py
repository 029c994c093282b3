"""A simulated arm that is advanced sample by sample, as a real one would be asked."""

import numpy as np
from numpy.typing import NDArray

from .model.arm import Arm
from .model.compiled import compiled
from .model.integrate import advance
from .model.kernel import loaded_inertia, registers, slope, SLOPE_1, STATE, STATES, TORQUE
from .sensors import read_encoders, SIDES
from .simulate import checked, step_count

Array = NDArray[np.float64]


@compiled
def observe(arm, inertia, w, noise, dt, first, reading, torque):    # type: ignore[no-untyped-def]
    """
    Fill a reading (n, 4) and the true joint torques (n,) [N*m] at the state in the registers.

    Velocities are what a drive reports: the angle's change since the last reading over dt [s].
    """
    joints = arm.joints.shape[0]
    slope(arm, inertia, w, STATE, SLOPE_1)
    angles = np.empty((joints, SIDES))
    read_encoders(arm, w, noise, angles)
    for j in range(joints):
        torque[j] = w[j, TORQUE]
        for side in range(SIDES):
            change = (angles[j, side] - reading[j, side]) / dt
            reading[j, SIDES + side] = np.nan if first else change
            reading[j, side] = angles[j, side]


@compiled
def act(arm, inertia, w, torque, force, dt, count):                 # type: ignore[no-untyped-def]
    """Advance the registers by one sample of dt [s] in `count` steps under held inputs."""
    held_torque, held_force = np.empty((3, torque.shape[0])), np.empty((3, 2))
    for k in range(3):
        held_torque[k] = torque
        held_force[k] = force
    for _ in range(count):
        advance(arm, inertia, w, held_torque, held_force, dt / count)


class Plant:
    """The arm with its encoders, started from a state, seeded and deterministic."""

    def __init__(self, arm: Arm, initial: Array, dt: float, seed: int) -> None:
        """Start from a state (n, STATES) with samples every dt [s]; raises ArmError."""
        self._record = checked(arm).record()
        self._inertia = loaded_inertia(self._record.body)
        self._registers = registers(initial)
        self._random = np.random.default_rng(seed)
        self._dt, self._count = dt, step_count(dt)
        self._first = True
        joints = len(arm.joints)
        self.reading = np.zeros((joints, 2 * SIDES))
        self.joint_torque = np.zeros(joints)

    def sample(self) -> Array:
        """Return the reading (n, 4) now: angles [rad] and velocities [rad/s], shaft and link."""
        noise = self._random.standard_normal((len(self.reading), SIDES))
        observe(self._record, self._inertia, self._registers, noise, self._dt, self._first,
                self.reading, self.joint_torque)
        self._first = False
        return self.reading

    def advance(self, motor_torque: Array, tip_force: Array) -> None:
        """Move on by one sample under motor torques (n,) [N*m] and a tip force (2,) [N, base]."""
        act(self._record, self._inertia, self._registers, motor_torque, tip_force, self._dt,
            self._count)

    @property
    def state(self) -> Array:
        """Return the true state (n, STATES)."""
        return self._registers[:len(self.reading), STATE:STATE + STATES].copy()
