"""
How large an effect must be for the search to accept it in one recording.

It is imagined on top of what the last fit leaves. All that may differ, and all that was accepted,
explains as much of it as it can. What is left must be material and pass the score threshold.
"""

from collections.abc import Callable
import math
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
import numpy as np

from ..fitting.fit import Fit, Fitter
from ..fitting.solve import Columns, condense, condense_more, score, solve
from ..judging.search import SearchResult
from ..judging.selection_criteria import material, threshold
from ...least_squares.term import Term

# Choices unless stated otherwise.
_PHASES = np.linspace(0.0, math.pi, 12, endpoint=False)     # of a wave, one of which shows least
_CLOSE = 0.03           # of what is needed: near enough
_ROUNDS = 12            # of a bisection, at most
_FURTHEST = 1e4         # least strength that shows how far to go on


class Imagined(NamedTuple):
    """What an effect would do, and what chance buys of it."""

    shift: Array        # (m, c, d) of the residuals, for a size or for the two parts of a wave
    chance: float       # improvement of the score


class Visibility:
    """What the residuals of one recording show beyond what is known already."""

    def __init__(self, fitter: Fitter, found: SearchResult, fit: Fit) -> None:
        """`fit` is what is known, `found.first` what was wrong at first."""
        self.fitter, self.fit = fitter, fit
        self._valid = fitter.valid(fit.balance)
        self._known = condense(fit.balance.residual, fit.columns, self._valid)
        self._background = self._known.power / np.maximum(self._known.samples, 1.0)
        self._variance = np.maximum(self._background, fitter.noise ** 2)
        self._needed = material(fitter, found.first, fit)

    def least(self, term: Term, seen: Imagined, most: float) -> float:
        """
        Return how many of a shift (m, c, 1) of the residuals are just enough.

        Of a wave's two shifts (m, c, 2), the phase counts that shows least. Infinite if `most`
        are not enough.
        """
        strength = self._strength(term, seen)
        low, high, share = 0.0, np.inf, min(1.0, most)
        for _ in range(_ROUNDS):
            now = strength(share)
            if abs(now - 1.0) < _CLOSE:
                return share
            low, high = (share, high) if now < 1.0 else (low, share)
            if low >= most:
                return np.inf
            guess = min(share / math.sqrt(max(now, 1.0 / _FURTHEST)), most)
            share = guess if low < guess < high else math.sqrt(max(low, 1e-3 * high) * high)
        return share

    def strength(self, term: Term, seen: Imagined) -> float:
        """Return how far one shift (m, c, 1) is above what is needed, 1 for just enough."""
        return self._strength(term, seen)(1.0)

    def _strength(self, term: Term, seen: Imagined) -> Callable[[float], float]:
        """Return what determines the strength of any share of a shift."""
        shift = seen.shift
        known, columns, kept = self._others(term)
        weighed = condense_more(known, self.fit.balance.residual, columns, shift, self._valid)
        along = _faintest(weighed, shift.shape[2], self.fitter.effective / self._variance,
                          kept, self._needed)
        return lambda share: self._of(_imagined(weighed, share * along, self._background), kept,
                                      threshold(self.fitter, term) + seen.chance)

    def _of(self, seen: Columns, kept: Array, threshold: float) -> float:
        """Return the strength of imagined residuals beside terms of these tolerances."""
        fitter = self.fitter
        left = solve(seen, fitter.noise, fitter.effective, np.zeros(len(kept)), kept)
        gained = left.score - score(self._background, seen.samples, fitter.noise,
                                    fitter.effective)
        return min(float(((left.variance - self._variance) / self._needed).max()),
                   gained / threshold)

    def _others(self, term: Term) -> tuple[Columns, Array, Array]:
        """Return what is known but for the term where it is accepted: columns, tolerances."""
        if term.place not in {own.place for own in self.fit.accepted}:
            return self._known, self.fit.columns, self.fit.deviations
        keep = np.concatenate([np.full(other.size, other not in self.fit.accepted
                                       or other.place != term.place)
                               for other in self.fit.terms])
        known = self._known._replace(products=self._known.products[:, keep][:, :, keep],
                                     against=self._known.against[:, keep])
        return known, self.fit.columns[:, :, keep], self.fit.deviations[keep]


def _imagined(weighed: Columns, along: Array, background: Array) -> Columns:
    """Return residuals that are `along` (q,) the first columns, and a background, by the rest."""
    extra = len(along)
    own, across = weighed.products[:, :extra, :extra], weighed.products[:, :extra, extra:]
    return Columns(weighed.products[:, extra:, extra:], along @ across,
                   along @ own @ along + background * weighed.samples, weighed.samples)


def _faintest(weighed: Columns, extra: int, weight: Array, tolerances: Array,
              needed: Array) -> Array:
    """Return the direction (q,) among the first columns that the others hide best."""
    if extra == 1:
        return np.ones(1)
    across, others = weighed.products[:, :extra, extra:], weighed.products[:, extra:, extra:]
    normal = np.einsum('c,cpq->pq', weight, others) + np.diag(1.0 / tolerances ** 2)
    taken = -np.linalg.lstsq(normal, np.einsum('c,cqp->pq', weight, across), rcond=None)[0]
    left = (weighed.products[:, :extra, :extra] + across @ taken + (across @ taken).swapaxes(1, 2)
            + taken.T @ others @ taken)
    directions = np.stack([np.cos(_PHASES), np.sin(_PHASES)], axis=1)
    power = np.einsum('dp,cpq,dq->dc', directions, left, directions)
    information = power / np.maximum(needed * weighed.samples, 1e-300)  # at least one sample
    return directions[np.argmin(information.max(axis=1))]
