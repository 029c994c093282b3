"""
The score of a fit as if every arm made as much noise.

What is unknown of a motion, noise of readings and of torques, comes into a balance by the inertia
and the stiffness of the arm. Commands that a log did not keep come into it by the torque
constants. An arm that has less of these makes less of it, which is no reason to believe it.
All arms are asked alike: how much the whole arm leaves, and how much of that is its noise. Of some
numbers a fit takes the noise out of the columns (`column_noise`), of others it does not. The two
take out different shares of it, and do not compare.
"""

from collections.abc import Sequence
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
import numpy as np
from numpy.typing import NDArray

from ..balances.balance import Balancer
from ..balances.channels import noisy_by_torques
from ..fitting.fit import Fit, Fitter
from ..fitting.solve import score
from ...least_squares.normal import TINY
from ...significance import HARDLY, MOSTLY


class NoisePower(NamedTuple):
    """The power (c,) that noise has in the balances of an arm [N^2*m^2]."""

    readings: Array         # of these, and of commands that a log has not kept
    torques: Array          # of drives and sensors, as loud as it may be

    @property
    def whole(self) -> Array:
        """Return that of all noise (c,)."""
        return np.maximum(self.readings + self.torques, TINY)


def equal_noise_score(fitter: Fitter, fit: Fit, usual: NoisePower) -> float:
    """Return the score of a fit as if noise had its `usual` power."""
    valid = fitter.valid(fit.balance)
    count = np.maximum(valid.sum(axis=0), 1)
    arm = fitter.on(fit.terms)
    left, exact = (np.where(valid, residual ** 2, 0.0).sum(axis=0) / count for residual in
                   (fit.balance.residual, fitter.balancer(arm).residual))
    own = _noise_of(fitter, arm, valid)
    share = np.minimum(own.whole / usual.whole, 1.0 + MOSTLY)
    fair = np.where(noisy_by_torques(fitter.balancer.measurement) & (usual.torques > 0.0),
                    exact + _less_noise(own, usual, exact),
                    exact + fitter.noise ** 2 * (1.0 - share))
    fair = np.maximum(fair, HARDLY * left)
    return (fit.score + score(fair, count, fitter.noise, fitter.effective)
            - score(left, count, fitter.noise, fitter.effective))


def _less_noise(own: NoisePower, usual: NoisePower, exact: Array) -> Array:
    """
    Return what an arm makes less noise than usual (c,) where torques are noisy.

    Noise of readings is known by them. How loud torques are was only told by what was left before
    any cause was known. So of neither more counts than the arm leaves.
    """
    readings = np.minimum(own.readings, (1.0 + MOSTLY) * usual.readings)
    torques = np.minimum(own.torques, (1.0 + MOSTLY) * usual.torques)
    shown = np.minimum(exact / np.maximum(readings, TINY), 1.0)
    louder = np.clip((exact - readings) / np.maximum(torques, TINY), 0.0, 1.0)
    return shown * (usual.readings - readings) + louder * (usual.torques - torques)


def noise_in(fitter: Fitter, fit: Fit) -> NoisePower:
    """Return the power that as much noise again has in the residual of a fit."""
    return _noise_of(fitter, fitter.as_noisy(fit), fitter.valid(fit.balance))


def _noise_of(fitter: Fitter, arm: Arm, valid: NDArray[np.bool_]) -> NoisePower:
    """
    Return the power that as much noise again has in the balances of an arm.

    That of torques was simulated as loud as it seemed before any cause was known. It is no louder
    than what noise of the fitter has beyond that of readings.
    """
    balancer, given = fitter.balancer, fitter.arm
    readings = _power_of_more(fitter, arm, balancer.noisier_each, valid)
    shaken = balancer.beside_torque_noise
    if shaken is None:
        return NoisePower(readings, np.zeros_like(readings))
    of_readings, of_torques = (_power_of_more(fitter, given, more, valid)
                               for more in (balancer.noisier_each, (shaken,)))
    beyond = np.maximum(fitter.noise ** 2 - of_readings, 0.0)
    loud = np.minimum(beyond / np.maximum(of_torques, TINY), 1.0)
    return NoisePower(readings, loud * _power_of_more(fitter, arm, (shaken,), valid))


def _power_of_more(fitter: Fitter, arm: Arm, noisier: Sequence[Balancer],
                   valid: NDArray[np.bool_]) -> Array:
    """Return the power (c,) that balances of an arm have more where a recording is noisier."""
    plain = fitter.balancer(arm).residual
    power = sum(((more(arm).residual - plain) ** 2).sum(axis=0, where=valid) for more in noisier)
    return np.asarray(power / np.maximum(valid.sum(axis=0), 1))
