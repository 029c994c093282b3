"""
The balances of an arm along a measured motion: the kernel read backwards (docs/model.md, 42-44).

The kernel says how the arm would accelerate in the measured state under the recorded command;
what the measurement did instead, as a torque, is the residual. Because it is the simulator's own
equation of motion, every effect of the catalogue acts here as it acts there.

    A, motor:    N J (ddtheta_m - predicted) + B,  the motor balance closed over the link
    B, torsion:  M (ddq - predicted),              the torsion against the link

Torques at the output side. A wrong friction shows in A alone, a wrong torsion in B alone, a wrong
load in both alike.
"""

from dataclasses import dataclass

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.compiled import compiled
from hda_arm_sim.model.kernel import (COMMAND, LINK_ANGLE, LINK_VELOCITY, loaded_inertia, MODE,
                                      MOTOR_VELOCITY, REGISTERS, slope, SLOPE_1, STATE, STATES)
from hda_arm_sim.model.rigid import mass_matrix
import numpy as np
from numpy.typing import NDArray
from scipy.signal import firwin, upfirdn

from .measurement import Measurement
from .motion import Motion, motion_of

Array = NDArray[np.float64]
BANDWIDTH = 40.0        # of the balances [Hz]
RATE = 125.0            # at which balances are kept [Hz]
_SLOW = 0.3             # shaft speed below which dry friction is not known [rad/s]
_MEASURED = 4           # states that a motion gives; the kernel's others are its memory


@dataclass(frozen=True, eq=False)
class Balance:
    """Residuals over time, columns A1, A2, B1, B2 (m, 2 n) [N*m at the output]."""

    residual: Array
    valid: NDArray[np.bool_]        # (m, 2 n): away from ends, and for A away from standstill


class Balancer:
    """The balances of one measurement, for one arm after another."""

    def __init__(self, measurement: Measurement) -> None:
        """Prepare filters; the motion is found anew only when an arm's sensing differs."""
        self.measurement = measurement
        self.every = max(1, round(1.0 / (RATE * measurement.dt)))
        self.time = measurement.time[::self.every]
        half = 4 * max(1, round(0.25 / (BANDWIDTH * measurement.dt) / 4.0) * 4)
        self._low_pass = firwin(2 * half + 1, BANDWIDTH, window=('kaiser', 6.0),
                                fs=1.0 / measurement.dt)
        self._motions: dict[bytes, Motion] = {}

    def motion(self, arm: Arm) -> Motion:
        """Return the motion behind the measurement if the arm senses as `arm` does."""
        key = _sensing(arm)
        if key not in self._motions:
            if len(self._motions) > 8:
                self._motions.pop(next(iter(self._motions)))
            self._motions[key] = motion_of(self.measurement, arm)
        return self._motions[key]

    def __call__(self, arm: Arm) -> Balance:
        """Return the balances of an arm."""
        motion, record = self.motion(arm), arm.record()
        samples, joints = self.measurement.command.shape
        raw = np.empty((samples, 2 * joints))
        _along(record, loaded_inertia(record.body), motion.state, motion.acceleration,
               _centred(self.measurement.command), self.measurement.dt, raw)
        return Balance(self.filtered(raw), self._valid(motion))

    def filtered(self, raw: Array) -> Array:
        """Return columns (k, m) low-passed without delay and thinned to the balances' rate."""
        half = len(self._low_pass) // 2
        padded = np.concatenate([raw, np.zeros((half, raw.shape[1]))])
        thin = upfirdn(self._low_pass, padded, down=1, axis=0)[half:half + len(raw):self.every]
        return np.ascontiguousarray(thin)

    def _valid(self, motion: Motion) -> NDArray[np.bool_]:
        """Return where a balance can be trusted: its filter has seen neither end nor standstill."""
        reach = len(self._low_pass) // 2 + 12
        ends = np.zeros(len(motion.state), bool)
        ends[reach:-reach] = True
        slow = np.abs(motion.state[:, :, MOTOR_VELOCITY]) < _SLOW
        spread = np.ones(2 * reach + 1)
        near = np.stack([np.convolve(column, spread, 'same') > 0.5 for column in slow.T], axis=1)
        valid = np.concatenate([ends[:, None] & ~near, np.repeat(ends[:, None], slow.shape[1], 1)],
                               axis=1)
        return valid[::self.every]


def _sensing(arm: Arm) -> bytes:
    """Return what the motion depends on: all that stands between an angle and its reading."""
    joints = arm.record().joints
    return b''.join(np.ascontiguousarray(joints[name]).tobytes() for name in joints.dtype.names
                    if 'encoder' in name or 'skew' in name or name == 'ratio')


def _centred(command: Array) -> Array:
    """Return the command around every sample: the mean of the one before and the one after."""
    return 0.5 * (command + np.concatenate([command[:1], command[:-1]]))


@compiled
def _along(arm, inertia, state, acceleration, command, dt, residual):
    # type: ignore[no-untyped-def]
    """Fill the residuals (k, 2 n): A of every joint, then B of every joint."""
    joints = state.shape[1]
    w = np.zeros((2, REGISTERS))
    for k in range(state.shape[0]):
        for j in range(joints):
            for i in range(_MEASURED):
                w[j, STATE + i] = state[k, j, i]
            w[j, COMMAND] = command[k, j]
            w[j, MODE] = np.sign(state[k, j, MOTOR_VELOCITY])
        slope(arm, inertia, w, STATE, SLOPE_1)
        for j in range(joints):
            for i in range(_MEASURED, STATES):
                w[j, STATE + i] += dt * w[j, SLOPE_1 + i]
        miss1 = acceleration[k, 0, 1] - w[0, SLOPE_1 + LINK_VELOCITY]
        if joints == 1:
            residual[k, 1] = inertia.p1 * miss1
        else:
            miss2 = acceleration[k, 1, 1] - w[1, SLOPE_1 + LINK_VELOCITY]
            m11, m12, m22 = mass_matrix(inertia, w[1, STATE + LINK_ANGLE])
            residual[k, 2] = m11 * miss1 + m12 * miss2
            residual[k, 3] = m12 * miss1 + m22 * miss2
        for j in range(joints):
            joint = arm.joints[j]
            miss = acceleration[k, j, 0] - w[j, SLOPE_1 + MOTOR_VELOCITY]
            residual[k, j] = (joint.ratio * joint.motor_inertia * miss
                              + residual[k, joints + j])
