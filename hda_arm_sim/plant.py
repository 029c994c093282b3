"""A simulated arm that is advanced sample by sample, as a real one would be asked."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .drive import act
from .foundation.compiled import borrowed, compiled
from .foundation.rigid import Inertia
from .model.arm import Arm, ArmRecord
from .model.kernel import registers, slope, SLOPE_1, STATE, STATES, TORQUE
from .model.plain import inertia_of, plain
from .sensors import DRAWS, read_encoders, sample_lost, SIDES
from .simulate import checked, step_count

Array = NDArray[np.float64]


@compiled
def observe(arm: ArmRecord, inertia: Inertia, w: Array, noise: Array, dt: float, first: bool,
            reading: Array, torque: Array) -> None:
    """
    Fill a reading (n, 4) and the true joint torques (n,) [N*m] at the state in the registers.

    Velocities are what a drive reports, (eq:velocity): the angle's change since the last reading
    over dt [s]. A lost sample leaves the reading as it was.
    """
    arm, w = ArmRecord(borrowed(arm.joints), arm.body), borrowed(w)
    joints = arm.joints.shape[0]
    slope(arm, inertia, w, STATE, SLOPE_1)
    for j in range(joints):
        torque[j] = w[j, TORQUE]
    if not first and sample_lost(arm, noise):
        return
    angles = np.empty((joints, SIDES))
    read_encoders(arm, inertia, w, noise, angles)
    for j in range(joints):
        for side in range(SIDES):
            change = (angles[j, side] - reading[j, side]) / dt
            reading[j, SIDES + side] = np.nan if first else change
            reading[j, side] = angles[j, side]


@compiled
def _observe(joints: NDArray[Any], body: NDArray[Any], inertia: Array, w: Array, noise: Array,
             dt: float, first: bool, reading: Array, torque: Array) -> None:
    observe(ArmRecord(joints, body[0]), inertia_of(inertia), w, noise, dt, first, reading, torque)


@compiled
def _act(joints: NDArray[Any], body: NDArray[Any], inertia: Array, w: Array, torque: Array,
         force: Array, dt: float, count: int) -> None:
    act(ArmRecord(joints, body[0]), inertia_of(inertia), w, torque, force, dt, count)


class Plant:
    """The arm with its encoders, started from a state, seeded and deterministic."""

    def __init__(self, arm: Arm, initial: Array, dt: float, seed: int) -> None:
        """Start from a state (n, STATES) with samples every dt [s]; raises ArmError."""
        self._plain = plain(checked(arm, dt).record())
        self._registers = registers(initial)
        self._random = np.random.default_rng(seed)
        self._dt, self._count = dt, step_count(dt)
        self._first = True
        joints = len(arm.joints)
        self.reading = np.zeros((joints, 2 * SIDES))
        self.joint_torque = np.zeros(joints)

    def sample(self) -> Array:
        """Return the reading (n, 4) now: angles [rad] and velocities [rad/s], shaft and link."""
        noise = self._random.standard_normal((len(self.reading), DRAWS))
        _observe(*self._plain, self._registers, noise, self._dt, self._first, self.reading,
                 self.joint_torque)
        self._first = False
        return self.reading

    def advance(self, motor_torque: Array, tip_force: Array) -> None:
        """Move on by one sample under motor torques (n,) [N*m] and a tip force (2,) [N, base]."""
        _act(*self._plain, self._registers, motor_torque, tip_force, self._dt, self._count)

    @property
    def state(self) -> Array:
        """Return what is true now, (n, STATES)."""
        return self._registers[:len(self.reading), STATE:STATE + STATES].copy()
