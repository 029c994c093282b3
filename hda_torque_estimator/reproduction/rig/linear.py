"""The arm near a state: the kernel differentiated, its resonances and frequency responses."""

from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm, ArmRecord
from hda_arm_sim.model.effects import CoulombFriction
from hda_arm_sim.model.kernel import (COMMAND, LINK_ANGLE, LINK_VELOCITY, MOTOR_ANGLE,
                                      MOTOR_VELOCITY, registers, slope, SLOPE_1, STATE, TORQUE)
from hda_arm_sim.model.link_side import loaded_inertia
from hda_arm_sim.model.torsion import torsion_of_torque
from hda_arm_sim.simulate import rest
import numpy as np

_STEPS = (1e-4, 1e-3, 1e-6, 1e-5)   # of the four states of a joint, for differences
_STILL = 1.0                        # below it an eigenvalue is that of the free turning [rad/s]


class Linear(NamedTuple):
    """
    A linear arm, states by joint: shaft angle and speed, link angle and speed.

    dx/dt = matrix x + motor u, torque = gear x, with u the motor torques [N*m, shaft].
    """

    matrix: Array                   # (4n, 4n)
    motor: Array                    # (4n, n)
    gear: Array                     # (n, 4n)

    @property
    def joints(self) -> int:
        """Return the number of joints."""
        return self.gear.shape[0]

    def response(self, output: Array, joint: int, frequency: Array) -> Array:
        """Return the response of an output (4n,) to a joint's motor torque at frequencies [Hz]."""
        points = 2j * np.pi * frequency[:, None, None]
        inner = points * np.eye(len(self.matrix)) - self.matrix
        return np.asarray(np.linalg.solve(inner, self.motor[:, joint, None])[:, :, 0] @ output)


def linearised(arm: Arm, angles: tuple[float, ...], torque: float = 0.0) -> Linear:
    """Return an arm near rest at link angles [rad] with a torque in its gears [N*m], sliding."""
    for label in arm.labels:
        arm = arm.with_effect(CoulombFriction(level=0.0), label)
    record = arm.record()
    state = rest(arm, angles)
    for row, joint in zip(state, record.joints):
        row[MOTOR_ANGLE] += joint['ratio'] * torsion_of_torque(joint['torsion'],
                                                               joint['ratio'], torque)
    places = [(j, kind) for j in range(len(angles))
              for kind in (MOTOR_ANGLE, MOTOR_VELOCITY, LINK_ANGLE, LINK_VELOCITY)]
    columns = [_difference(record, state, (j, STATE + kind), _STEPS[kind]) for j, kind in places]
    inputs = [_difference(record, state, (j, COMMAND), 1e-3) for j in range(len(angles))]
    whole = np.array([*columns, *inputs]).T
    size = len(places)
    return Linear(whole[:size, :size], whole[:size, size:], whole[size:, :size])


def _difference(record: ArmRecord, state: Array, place: tuple[int, int], step: float) -> Array:
    """Return how slopes and gear torques change with one register, slopes first."""
    inertia = loaded_inertia(record.body)
    found = []
    for sign in (1.0, -1.0):
        w = registers(state)
        w[place] += sign * step
        slope(record, inertia, w, STATE, SLOPE_1)
        joints = len(state)
        found.append(np.append(w[:joints, SLOPE_1:SLOPE_1 + 4].ravel(), w[:joints, TORQUE]))
    return (found[0] - found[1]) / (2.0 * step)


def free_resonances(linear: Linear) -> Array:
    """Return the resonances with motors that turn freely, lowest first [Hz]."""
    return _frequencies(linear.matrix)


def locked_resonances(linear: Linear) -> Array:
    """Return the resonances with motors that are held, lowest first [Hz]."""
    link = np.array([4 * j + kind for j in range(linear.joints) for kind in (2, 3)])
    return _frequencies(linear.matrix[np.ix_(link, link)])


def _frequencies(matrix: Array) -> Array:
    values = np.linalg.eigvals(matrix)
    swinging = np.abs(values[values.imag > _STILL])
    return np.asarray(np.sort(swinging) / (2.0 * np.pi))
