"""
Rows of a fit: errors, their slopes, and which of them belong together.

Errors follow each other in time. So rows are gathered in stretches of a few seconds and in pieces
of a recording. What is left out of a fit, and what pulls a fit to and fro, are whole ones.
"""

from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from .normal import within

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
# Choices unless stated otherwise.
FOLDS = 5               # every so many-th stretch is left out in turn
WORTHLESS = 1e-9        # [N*m], the least noise


@dataclass(frozen=True, eq=False)
class Rows:
    """Errors over the rows of all recordings, and their slopes over the unknowns."""

    error: Floats       # (m,) [N*m]
    slopes: Floats      # (m, p) per sigma of each unknown
    stretch: Ints       # (m,)
    piece: Ints         # (m,) of one recording, or of a part of it where there are few
    fold: Ints          # (m,) what is left out together

    def some(self, chosen: NDArray[np.bool_]) -> 'Rows':
        """Return some of the rows."""
        return Rows(*(getattr(self, field.name)[chosen] for field in fields(self)))

    def along(self, unknowns: list[int]) -> 'Rows':
        """Return the rows with the slopes of some unknowns alone."""
        return replace(self, slopes=self.slopes[:, unknowns])

    def after(self, step: Floats) -> 'Rows':
        """Return the rows after a step of the unknowns (p,), if slopes stay as they are."""
        return replace(self, error=self.error + self.slopes @ step)


def normal_of(rows: Rows, noise: float, scaled: Floats, prior: Floats) -> tuple[Floats, Floats]:
    """
    Return the normal equations of a step to the most likely unknowns: matrix (p, p), right (p,).

    `scaled` (p,) are the unknowns in sigmas from what was known; `prior` (p,) is 1 where something
    was known, else 0. `noise` is that of a row [N*m].
    """
    weight = noise ** -2
    return (weight * rows.slopes.T @ rows.slopes + np.diag(prior),
            -(weight * rows.slopes.T @ rows.error + prior * scaled))


def solved(rows: Rows, noise: float, scaled: Floats, prior: Floats) -> Floats:
    """Return the step (p,) to the most likely unknowns, if slopes stay as they are."""
    return np.asarray(np.linalg.solve(*normal_of(rows, noise, scaled, prior)))


def bounded(rows: Rows, noise: float, scaled: Floats, prior: Floats,
            bounds: tuple[Floats, Floats]) -> Floats:
    """Return the same step (p,), or the best of those that stay within bounds (p,)."""
    return within(*normal_of(rows, noise, scaled, prior), scaled, bounds)


def held_out(rows: Rows, noise: float, scaled: Floats, prior: Floats) -> float:
    """Return the error where a fit has not seen, each fold left out in turn [N*m rms]."""
    left = np.empty_like(rows.error)
    for fold in np.unique(rows.fold):
        seen = rows.fold != fold
        step = solved(rows.some(seen), noise, scaled, prior)
        left[~seen] = rows.error[~seen] + rows.slopes[~seen] @ step
    return rms(left)


def rms(values: Floats) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(values ** 2)))


def noise_of(error: Floats, stretch: Ints) -> float:
    """Return the noise of a row if its neighbours held nothing new: by means over few rows."""
    following = error[1:] * error[:-1]
    inside = stretch[1:] == stretch[:-1]
    power = float(np.mean(error ** 2))
    alike = float(np.clip(np.mean(following[inside]) / max(power, WORTHLESS ** 2), 0.0, 0.98))
    return max(float(np.sqrt(power * (1.0 + alike) / (1.0 - alike))), WORTHLESS)
