"""What a healthy arm would have recorded on the same motion: the noise of the diagnosis."""

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.kernel import LINK_ANGLE, LINK_VELOCITY
from hda_arm_sim.motions import Motion
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from .balance import Balancer, BANDWIDTH, RATE
from .measurement import Measurement
from ..closed_loop import run

Array = NDArray[np.float64]
_SEGMENT = 0.5          # of the estimate of noise [s]
_QUIET = 0.25           # share of segments that an effect surely leaves quiet


def healthy_twin(balancer: Balancer, arm: Arm, seed: int, torque_noise: float = 0.0,
                 ) -> Measurement:
    """
    Return a simulated recording of `arm` along the links' measured motion.

    `torque_noise` is the standard deviation of what the drive adds to every command [N*m shaft].
    """
    measured = balancer.measurement
    state = balancer.motion(arm).state
    angle, rate = state[:, :, LINK_ANGLE].copy(), state[:, :, LINK_VELOCITY].copy()
    made = run(arm, arm, Motion(measured.time, angle, rate, np.zeros((len(angle), 2))), seed)
    random = np.random.default_rng(seed)
    command = made.command + torque_noise * random.standard_normal(made.command.shape)
    return Measurement(measured.labels, measured.dt, np.ascontiguousarray(made.reading[:, :, :2]),
                       command)


def torque_noise_of(noise: Array, plain: Array, balancer: Balancer, arm: Arm) -> float:
    """Return the noise of the motor torque that lifts the motor balances so far [N*m shaft]."""
    joints = len(arm.joints)
    passed = np.sqrt(2.0 * BANDWIDTH * balancer.measurement.dt)     # of white noise, by the filter
    excess = np.maximum(noise[:joints] ** 2 - plain[:joints] ** 2, 0.0)
    return float(np.sqrt(np.median(excess)) / passed / arm.joints[0].ratio)


def noise_of(balancer: Balancer, arm: Arm, seed: int = 0) -> tuple[Array, Array]:
    """
    Return the standard deviation (c,) of each balance that noise leaves, and resolution alone.

    The second is that of a healthy twin [N*m]; the first is scaled by how much noisier the
    quieter stretches of the measurement are at high frequency, where effects seldom show. Torsion
    balances have no noise but that of the readings, which are sharper than anything that moves.
    """
    made = healthy_twin(balancer, arm, seed)
    theirs, ours = Balancer(made)(arm), balancer(arm)
    plain = np.array([column[valid].std() for column, valid in
                      zip(theirs.residual.T, theirs.valid.T)])
    rough = _roughness(ours.residual, ours.valid) / _roughness(theirs.residual, theirs.valid)
    sharp = _sharpness(balancer.measurement) / _sharpness(made)
    joints = len(arm.joints)
    rough[joints:] = np.fmin(rough[joints:], np.maximum(sharp[:, 0], sharp[:, 1].max()))
    return plain * np.clip(np.nan_to_num(rough, nan=1.0), 1.0, 30.0), plain


def _sharpness(measurement: Measurement) -> Array:
    """Return the level of fourth differences of readings (n, 2) in the quieter segments [rad]."""
    sharp = np.diff(measurement.reading, 4, axis=0)
    length = max(1, round(_SEGMENT / measurement.dt))
    parts = sharp[:len(sharp) // length * length].reshape(-1, length, *sharp.shape[1:])
    return np.maximum(np.quantile(parts.std(axis=1), _QUIET, axis=0), 1e-12)


def _roughness(residual: Array, valid: NDArray[np.bool_]) -> Array:
    """Return the high-frequency level of the quieter segments (c,) [N*m]."""
    fast = residual - gaussian_filter1d(residual, 1.0, axis=0)
    length = round(_SEGMENT * RATE)
    levels = []
    for column, good in zip(fast.T, valid.T):
        parts = [column[k:k + length].std() for k in range(0, len(column) - length, length)
                 if good[k:k + length].all()]
        levels.append(np.quantile(parts, _QUIET) if parts else np.nan)
    return np.array(levels)
