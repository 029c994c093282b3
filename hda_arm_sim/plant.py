"""A simulated arm that is advanced sample by sample, as a real one would be asked."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .drive import act
from .foundation.arrays import Array
from .foundation.chain import lent
from .foundation.compiled import borrowed, compiled
from .foundation.rigid import Inertia
from .model.arm import Arm, ArmRecord
from .model.arm_arrays import inertia_of, plain
from .model.kernel import registers, slope, SLOPE_1, STATE, STATES, TORQUE
from .sensors import DRAWS, read_encoders, sample_lost, SIDES
from .simulate import checked, longest_step, STEP, step_count


@compiled
def observe(arm: ArmRecord, inertia: Inertia, w: Array, noise: Array, dt: float,
            reading: Array, torque: Array) -> None:
    """
    Fill a reading (n, 4) and the true joint torques (n,) [N*m] at the state in the registers.

    Velocities are what a drive reports, (eq:velocity): the angle's change since the last reading
    over dt [s], which is 0 for the first one. A lost sample leaves the reading as it was.
    """
    arm, w, inertia = ArmRecord(borrowed(arm.joints), arm.body), borrowed(w), lent(inertia)
    joints = arm.joints.shape[0]
    slope(arm, inertia, w, STATE, SLOPE_1)
    for j in range(joints):
        torque[j] = w[j, TORQUE]
    first = dt == 0.0
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
             dt: float, shown: Array) -> None:
    observe(ArmRecord(joints, body[0]), inertia_of(inertia), w, noise, dt,
            shown[:, :2 * SIDES], shown[:, 2 * SIDES])


@compiled
def _act(joints: NDArray[Any], body: NDArray[Any], inertia: Array, w: Array, torque: Array,
         force: Array, pace: Array) -> None:
    act(ArmRecord(joints, body[0]), inertia_of(inertia), w, torque, force, pace[0], int(pace[1]))


class Plant:
    """The arm with its encoders, started from a state, seeded and deterministic."""

    def __init__(self, arm: Arm, initial: Array, dt: float, seed: int) -> None:
        """Start from a state (n, STATES) with samples every dt [s]; raises ArmError."""
        self._plain = plain(checked(arm, dt).record())
        self._registers = registers(initial)
        self._random = np.random.default_rng(seed)
        self._pace = np.array([dt, step_count(dt, min(STEP, longest_step(arm)))])
        self._since = 0.0
        self._shown = np.zeros((len(arm.joints), 2 * SIDES + 1))
        self.reading, self.joint_torque = self._shown[:, :2 * SIDES], self._shown[:, 2 * SIDES]

    def sample(self) -> Array:
        """Return the reading (n, 4) now: angles [rad] and velocities [rad/s], shaft and link."""
        noise = self._random.standard_normal((len(self.reading), DRAWS))
        _observe(*self._plain, self._registers, noise, self._since, self._shown)
        self._since = self._pace[0]
        return self.reading

    def advance(self, motor_torque: Array, tip_force: Array) -> None:
        """
        Move on by one sample under motor torques (n,) [N*m] and what acts on the tip.

        That is a force (2,) [N], or a wrench (6,) on a chain [N, N*m], in the base frame.
        """
        _act(*self._plain, self._registers, motor_torque, tip_force, self._pace)

    @property
    def state(self) -> Array:
        """Return what is true now, (n, STATES)."""
        return self._registers[:len(self.reading), STATE:STATE + STATES].copy()
