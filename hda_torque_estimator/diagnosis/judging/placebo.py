"""
What the freedom of a cause buys by itself: placebos, fitted and judged like the cause.

They are the cause's own columns, moved along the recording to where they are least like what they
were. They are as free, as large and as rough, with no reason to explain anything. What the best of
them gains on held-out stretches is chance.
"""

from collections.abc import Iterator
import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..balances.balance import RATE
from ..fitting.fit import deviations, Fit, Fitter
from ..fitting.solve import condense, solve
from ...least_squares.term import Term
from ...significance import IMMATERIAL, NORMAL_90

Array = NDArray[np.float64]
# Numerics; choices unless stated otherwise.
_NEAREST = 0.25         # of the recording, that a placebo is away from the cause at least
_PLACEBOS = 4           # of each cause


class RemovedShares(NamedTuple):
    """
    Shares of what held-out balances have beyond noise that a cause and a placebo remove.

    Each whole second counts over what all causes leave of it (eq:held-out).
    """

    cause: float
    placebo: float
    low: float = -math.inf      # 90 % interval of the cause's, by what is left beside it
    high: float = math.inf
    before: float = math.nan    # power without the cause and with it, over that of noise
    after: float = math.nan


def placebo_shares(fitter: Fitter, fit: Fit, term: Term) -> RemovedShares:
    """
    Return what an accepted cause removes from held-out balances, and what its best placebo does.

    Everything else that is free is fitted anew beside either, on the rows of the fitter.
    """
    keep = fit.own(term)
    others = fitter.terms_without(fit, term)
    known, away, free = fit.columns[:, :, ~keep], fitter.away(others), deviations(others)
    lacking = fitter.residual(others, fit.slopes.noise)
    rows = fit.balance.valid & ~fitter.rows[:, None]

    def left(more: Array) -> Array:
        columns, extra = np.concatenate([more, known], axis=2), more.shape[2]
        condensed = condense(lacking, columns, fitter.valid(fit.balance))
        step = solve(condensed, fitter.noise, fitter.effective,
                     np.concatenate([np.zeros(extra), away]),
                     np.concatenate([np.full(extra, np.inf), free])).step
        return _over_noise(fitter, lacking + columns @ step, rows)

    own, of_all = fit.columns[:, :, keep], _over_noise(fitter, fit.balance.residual, rows)
    levels = _levels(of_all, rows)
    without, beside, noise = left(own[:, :, :0]) / levels, of_all / levels, rows / levels ** 2
    before, after = float((without ** 2).sum()), float((beside ** 2).sum())
    count = max(float(noise.sum()), 1.0)
    # A channel that is quieter than its noise takes nothing from the others.
    excess = max(float(np.maximum((without ** 2 - noise).sum(axis=0), 0.0).sum()),
                 IMMATERIAL * count)
    best = max(before - float(((left(moved) / levels) ** 2).sum()) for moved in moved_away(own))
    cause, reach = (before - after) / excess, _reach(without, beside) / excess
    return RemovedShares(cause, best / excess, cause - reach, cause + reach,
                         before / count, after / count)


def moved_away(columns: Array) -> Iterator[Array]:
    """
    Yield columns (m, c, p) without their means, rolled to where they are least like themselves.

    One for each part of the recording that is not near. A mean would stay wherever it is moved.
    """
    varied = columns - columns.mean(axis=0)
    flat = varied.reshape(len(varied), -1)
    scaled = flat / np.maximum(np.sqrt((flat ** 2).sum(axis=0)), 1e-300)
    alike = np.abs(np.fft.irfft(np.abs(np.fft.rfft(scaled, axis=0)) ** 2, len(flat), axis=0))
    ends = np.linspace(_NEAREST, 1.0 - _NEAREST, _PLACEBOS + 1) * len(flat)
    for first, last in zip(ends[:-1].astype(int), ends[1:].astype(int)):
        away = first + int(np.argmin(alike[first:last].max(axis=1)))
        yield np.roll(varied, away, axis=0)


def _reach(without: Array, beside: Array) -> float:
    """
    Return how far what a cause removes reaches either way, within 90 % (eq:held-out).

    By chance what is left beside it goes with what it does, in whole seconds as such errors last.
    """
    together = 2.0 * (beside * (without - beside)).sum(axis=1)
    return NORMAL_90 * float(np.sqrt((_by_second(together) ** 2).sum()))


def _levels(beside: Array, rows: NDArray[np.bool_]) -> Array:
    """
    Return the rms (m, c) over noise of what all causes leave of each whole second, 1 at least.

    A push that is not quite known leaves much while it lasts. That is no rest of the others.
    """
    powers = _by_second(beside ** 2) / np.maximum(_by_second(rows), 1.0)
    return np.repeat(np.sqrt(np.maximum(powers, 1.0)), round(RATE), axis=0)[:len(beside)]


def _by_second(values: NDArray[Any]) -> Array:
    """Return sums of values (m,) or (m, c) over whole seconds, the last as long as it is."""
    return np.asarray(np.add.reduceat(values, np.arange(0, len(values), round(RATE)),
                                      dtype=np.float64))


def _over_noise(fitter: Fitter, residual: Array, rows: NDArray[np.bool_]) -> Array:
    """Return a residual (m, c) over the noise, zero but in these rows."""
    return np.where(rows, residual / fitter.noise, 0.0)
