"""What a healthy arm would have recorded on the same motion: the noise of the diagnosis."""

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.kernel import LINK_ANGLE, LINK_VELOCITY
from hda_arm_sim.motions import Motion
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from .balance import Balancer, BANDWIDTH, RATE
from ...measurements.finer import between
from ...measurements.measurement import Measurement, QUIET, SEGMENT
from ...measurements.running_clock import arm_during
from ...simulating.closed_loop import run

# Choices unless told otherwise.
_MOST = 30.0            # times as noisy as resolution alone that is still believed
_UNSEEN = 1.0           # noise of a balance that never holds, for which any will do [N*m]


def healthy_twin(balancer: Balancer, arm: Arm, seed: int, torque_noise: float = 0.0,
                 ) -> Measurement:
    """
    Return a simulated recording of `arm` along the links' measured motion.

    `torque_noise` is the standard deviation of what the drive adds to every command [N*m shaft].
    """
    measured = balancer.measurement
    reading = np.empty(measured.reading.shape)          # rows in a row, as compiled code has them
    command = np.empty(measured.command.shape)
    for place, piece in enumerate(measured.pieces()):
        state = balancer.motion(arm).state[piece]
        angle, rate = state[:, :, LINK_ANGLE].copy(), state[:, :, LINK_VELOCITY].copy()
        time = measured.dt * np.arange(len(angle), dtype=np.float64)
        asked = Motion(time, angle, rate, np.zeros((len(angle), 2)))
        own = arm_during(arm, piece, measured.dt)
        made = run(own, own, asked, seed + place, estimator=None)
        read = made.reading[::measured.parts, :, :2]
        reading[piece], command[piece] = between(read, measured.parts), made.command
    random = np.random.default_rng(seed)
    command += torque_noise * random.standard_normal(command.shape)
    return Measurement(measured.labels, measured.dt, reading, command, begins=measured.begins,
                       parts=measured.parts)


def torque_noise_of(noise: Array, plain: Array, balancer: Balancer, arm: Arm) -> float:
    """Return the noise of the motor torque that lifts the motor balances so far [N*m shaft]."""
    joints = len(arm.joints)
    passed = np.sqrt(2.0 * BANDWIDTH * balancer.measurement.dt)     # of white noise, by the filter
    excess = np.maximum(noise[:joints] ** 2 - plain[:joints] ** 2, 0.0)
    return float(np.sqrt(np.median(excess)) / passed / arm.joints[0].ratio)


def noise_of(balancer: Balancer, arm: Arm, seed: int = 0) -> tuple[Array, Array]:
    """
    Return the standard deviation (c,) of each balance that noise leaves, and resolution alone.

    The second is that of a healthy twin [N*m]. Readings that are sharper than the twin's raise
    it in proportion. What motor balances then have more at high frequency, where effects seldom
    show, is white noise of the torque, which is added.
    """
    made = healthy_twin(balancer, arm, seed)
    theirs, ours = Balancer(made)(arm), balancer(arm)
    plain = np.array([column[valid].std() if valid.any() else _UNSEEN for column, valid in
                      zip(theirs.residual.T, theirs.valid.T)])
    sharp = np.clip(balancer.measurement.reading_noise() / made.reading_noise(), 1.0, _MOST)
    joints = len(arm.joints)
    motor, torsion = plain[:joints] * sharp[:, 0], plain[joints:] * np.maximum(
        sharp[:, 0], sharp[:, 1].max())
    rough = _roughness(ours.residual, ours.valid), _roughness(theirs.residual, theirs.valid)
    white = (rough[0][:joints] ** 2 - (sharp[:, 0] * rough[1][:joints]) ** 2) / _white_roughness(
        balancer, seed) ** 2
    ratio = np.clip(np.nan_to_num(np.divide(
        rough[0], rough[1], where=rough[1] > 0.0, out=np.ones_like(rough[0])), nan=1.0),
        1.0, _MOST)[joints:]
    return np.concatenate([
        np.sqrt(motor ** 2 + np.maximum(np.nan_to_num(white), 0.0)),
        np.fmin(torsion, plain[joints:] * ratio)]), plain


def _white_roughness(balancer: Balancer, seed: int) -> float:
    """Return the roughness that white noise has when a balance of it has the deviation 1."""
    noise = np.random.default_rng(seed).standard_normal((len(balancer.measurement.command), 1))
    balance = balancer.filtered(noise)
    return float(_roughness(balance / balance.std(), np.ones(balance.shape, bool))[0])


def _roughness(residual: Array, valid: NDArray[np.bool_]) -> Array:
    """Return the high-frequency level of the quieter segments (c,) [N*m]."""
    fast = residual - gaussian_filter1d(residual, 1.0, axis=0)
    length = round(SEGMENT * RATE)
    levels = []
    for column, good in zip(fast.T, valid.T):
        parts = [column[k:k + length].std() for k in range(0, len(column) - length, length)
                 if good[k:k + length].all()]
        levels.append(np.quantile(parts, QUIET) if parts else np.nan)
    return np.array(levels)
