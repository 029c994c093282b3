"""
The score of a fit as if every arm made as much noise.

What is unknown of a motion, noise of readings and of torques, comes into a balance by the inertia
and the stiffness of the arm. One that has less of them makes less of it, which is no reason to
believe it.
"""

from hda_arm_sim.foundation.arrays import Array
import numpy as np

from ..fitting.fit import Fit, Fitter
from ..fitting.solve import score

# Choices unless told otherwise.
_LEAST = 0.1            # share of a rest that stays at least, without what noise makes,
_SHARES = (0.5, 1.5)    # and how much less or more noise one arm may make than another


def fair_score(fitter: Fitter, fit: Fit, usual: Array) -> float:
    """Return the score of a fit as if noise had its `usual` power (c,)."""
    valid = fitter.valid(fit.balance)
    count = np.maximum(valid.sum(axis=0), 1)
    left = np.where(valid, fit.balance.residual ** 2, 0.0).sum(axis=0) / count
    share = np.clip(noise_in(fitter, fit) / usual, *_SHARES)
    fair = np.maximum(left + fitter.noise ** 2 * (1.0 - share), _LEAST * left)
    return (fit.score + score(fair, count, fitter.noise, fitter.effective)
            - score(left, count, fitter.noise, fitter.effective))


def noise_in(fitter: Fitter, fit: Fit) -> Array:
    """Return the power (c,) that some noise of the angles has in the residual of a fit."""
    valid = fitter.valid(fit.balance)
    arm = fitter.as_noisy(fit)
    more = fitter.balancer.noisier(arm).residual - fitter.balancer(arm).residual
    return np.asarray(np.maximum((more ** 2).sum(axis=0, where=valid), 1e-300))
