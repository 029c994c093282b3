"""
How uncertain a fit is where its errors follow each other: Huber's sandwich, by blocks of rows.

A block that pulls the fit by more than noise would is a block of errors that go together.
"""

import numpy as np
from numpy.typing import NDArray

from .rows import normal_of, Rows

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def sandwich(inner: Floats, pulls: Floats, prior: Floats) -> Floats:
    """
    Return the covariance (p, p) of unknowns.

    `inner` (p, p) is the inverse of the normal matrix, and `pulls` (p, p) the summed squares of
    what blocks pull. `prior` (p,) is the inverse variance of what was known before.
    """
    return np.asarray(inner @ (pulls + np.diag(prior)) @ inner)


def pulls_of(slopes: Floats, error: Floats, block: Ints) -> Floats:
    """Return the summed squares of what blocks (m,) of rows pull at the unknowns (p, p)."""
    pulls = np.stack([slopes[block == one].T @ error[block == one] for one in np.unique(block)])
    return pulls.T @ pulls


def covariance(rows: Rows, noise: float, prior: Floats) -> Floats:
    """
    Return the covariance of all unknowns in sigmas (p, p), by the pulls of stretches.

    What a whole recording pulls comes on top: no law is exact, and where it is not depends
    on the motion.
    """
    weight = noise ** -2
    normal, _ = normal_of(rows, noise, np.zeros_like(prior), prior)
    inner = np.asarray(np.linalg.inv(normal), np.float64)
    pulls = (pulls_of(rows.slopes, rows.error, rows.stretch)
             + pulls_of(rows.slopes, rows.error, rows.piece))
    return sandwich(inner, weight ** 2 * pulls, prior)
