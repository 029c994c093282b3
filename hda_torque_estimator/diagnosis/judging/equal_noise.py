"""
The score of a fit as if every arm made as much noise.

What is unknown of a motion, noise of readings and of torques, comes into a balance by the inertia
and the stiffness of the arm. Commands that a log did not keep come into it by the torque
constants. An arm that has less of these makes less of it, which is no reason to believe it.
All arms are asked alike: how much the whole arm leaves, and how much of that is its noise. Of some
numbers a fit takes the noise out of the columns (`column_noise`), of others it does not. The two
take out different shares of it, and do not compare.
"""

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
import numpy as np
from numpy.typing import NDArray

from ..balances.channels import sensed_channels
from ..fitting.fit import Fit, Fitter
from ..fitting.solve import score
from ...significance import HARDLY, MOSTLY


def equal_noise_score(fitter: Fitter, fit: Fit, usual: Array) -> float:
    """Return the score of a fit as if noise had its `usual` power (c,)."""
    valid = fitter.valid(fit.balance)
    count = np.maximum(valid.sum(axis=0), 1)
    arm = fitter.on(fit.terms)
    left, exact = (np.where(valid, residual ** 2, 0.0).sum(axis=0) / count for residual in
                   (fit.balance.residual, fitter.balancer(arm).residual))
    share = np.minimum(_noise_of(fitter, arm, valid) / usual, 1.0 + MOSTLY)
    fair = np.maximum(exact + fitter.noise ** 2 * (1.0 - share), HARDLY * left)
    return (fit.score + score(fair, count, fitter.noise, fitter.effective)
            - score(left, count, fitter.noise, fitter.effective))


def noise_in(fitter: Fitter, fit: Fit) -> Array:
    """Return the power (c,) that some noise of the angles has in the residual of a fit."""
    return _noise_of(fitter, fitter.as_noisy(fit), fitter.valid(fit.balance))


def _noise_of(fitter: Fitter, arm: Arm, valid: NDArray[np.bool_]) -> Array:
    """
    Return the power (c,) that some noise of the readings has in the balances of an arm.

    In balances held against sensors that of torques stands beside it. It is of commands and of
    sensors, in whose units these balances are, and so the same for all arms.
    """
    power = _power_of_more(fitter, arm, valid)
    sensed = sensed_channels(fitter.balancer.measurement)
    if sensed.any():
        of_torques = fitter.noise ** 2 * valid.sum(axis=0) - _power_of_more(
            fitter, fitter.arm, valid)
        power = power + np.where(sensed, np.maximum(of_torques, 0.0), 0.0)
    return np.maximum(power, 1e-300)


def _power_of_more(fitter: Fitter, arm: Arm, valid: NDArray[np.bool_]) -> Array:
    """Return the power (c,) that as much noise of readings and commands again has in balances."""
    balancer, plain = fitter.balancer, fitter.balancer(arm).residual
    return np.asarray(sum(((more(arm).residual - plain) ** 2).sum(axis=0, where=valid)
                          for more in balancer.noisier_each))
