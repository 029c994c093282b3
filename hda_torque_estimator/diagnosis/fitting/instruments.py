"""
Estimates without the bias of noisy regressors: instrumental variables (eq:instruments).

What a fit moves along, accelerations and torsions, is measured with noise, and noise of the torque
moves the arm as well. Least squares therefore read inertias, stiffnesses and torque constants too
small, by a few of their own deviations over a minute. A simulated twin that follows the same
motion has other noise. Its derivatives have the same directions and go with nothing that was
random in the recording (Janot, Vandanjon and Gautier 2014, for rigid robots).
"""

from dataclasses import replace

from hda_arm_sim.foundation.arrays import Array
import numpy as np

from .column_noise import projection
from .derivatives import IMPOSSIBLE
from .fit import Fit, Fitter, moved, room
from .solve import condense, solve
from ..balances.balance import Balancer
from ...significance import SCORE_BAR

# Numerics; choices unless stated otherwise.
_ALIKE = 0.85           # correlation with the twin's column from which it can stand for one


def unbiased(fitter: Fitter, fit: Fit, twin: Balancer) -> Fit:
    """
    Return a fit moved to where its rest goes with no column of the twin, and those columns.

    Fine waves, on which the twin is not at the same place, keep their own columns. No tolerated
    number is a wave. The own column of one may be mostly noise, as that of a delay is where a log
    has not kept all commands. A fit of which a cause would move too far, or that would fit much
    worse, is returned as it was.
    """
    theirs = replace(fitter, balancer=twin).derivatives(fit.terms, fit.terms)
    valid = fitter.valid(fit.balance)
    causes = slice(sum(term.size for term in fit.accepted))
    columns = _projected(fit.columns, theirs, np.where(valid, 1.0 / np.sqrt(fit.variance), 0.0),
                         causes)
    step = solve(condense(fit.balance.residual, columns, valid), fitter.noise, fitter.effective,
                 fitter.away(fit.terms), fit.deviations, room(fit.terms)).step
    spread = np.sqrt(np.diag(fitter.covariance(fit)))
    if (np.abs(step) > np.sqrt(SCORE_BAR) * spread)[causes].any():
        return fit
    try:
        there = fitter.at(moved(fit.terms, step), len(fit.accepted),
                          fit.slopes.with_columns(columns))
    except IMPOSSIBLE:
        return fit
    return there if there.score < fit.score + len(step) * SCORE_BAR else fit


def _projected(own: Array, theirs: Array, weight: Array, causes: slice) -> Array:
    """
    Return columns (m, c, p) as far as the twin's explain them, weighed by (m, c).

    Those of `causes` keep their own where the twin's are not alike.
    """
    ours, instruments = (columns * weight[:, :, None] for columns in (own, theirs))
    power = np.sqrt((ours ** 2).sum(axis=(0, 1)) * (instruments ** 2).sum(axis=(0, 1)))
    alike = power > 0.0
    alike[causes] &= ((ours * instruments).sum(axis=(0, 1)) > _ALIKE * power)[causes]
    return projection(own, np.where(alike, theirs, own), weight)
