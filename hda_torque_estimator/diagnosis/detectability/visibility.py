"""
How large an effect must be for the search to accept it in one recording.

It is imagined on top of what the last fit leaves. All that may differ, and all that was accepted,
explains as much of it as it can. What is left must be material and pass the score threshold.
"""

from collections.abc import Callable
from functools import cached_property
import math
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
import numpy as np

from .curve_visibility import CurveVisibility, Followed
from ..balances.balance import RATE
from ..fitting.fit import Fit, Fitter
from ..fitting.hypotheses import HYPOTHESES
from ..fitting.solve import Columns, condense, condense_more, score, solve
from ..judging.search import SearchResult
from ..judging.selection_criteria import (floor, LOOKED_AT, material, quiet_joints, SLOW,
                                          threshold)
from ...least_squares.term import Term
from ...significance import surely_above

# Numerics; choices unless stated otherwise.
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
        self._curves = CurveVisibility(fitter, fit, self._known, quiet_joints(fitter, fit))

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
        others = self._others(term)
        weighed = condense_more(others.known, self.fit.balance.residual, others.columns,
                                seen.shift, self._valid)
        along = _faintest(weighed, seen.shift.shape[2], self.fitter.effective / self._variance,
                          others.tolerances, self._needed)
        values = np.where(self._valid, seen.shift @ along, 0.0)
        imagined = _Shift(others, weighed, along, values)
        curves = (self._curves.along(values, imagined.across(), term.joint)
                  if others.columns is self.fit.columns else None)
        bar = surely_above(threshold(self.fitter, term) + seen.chance)
        return lambda share: self._of(imagined, curves, share, bar)

    def _of(self, shift: '_Shift', curves: list[Followed] | None,
            share: float, bar: float) -> float:
        """
        Return the strength of a share of a shift: 1 where a search would just accept it.

        It must be worth a cause, make the search look, and pass the `bar` of the score. Where it
        was accepted the search did look, and there are no `curves`.
        """
        fitter, kept = self.fitter, shift.others.tolerances
        left = solve(shift.imagined(share, self._background), fitter.noise, fitter.effective,
                     np.zeros(len(kept)), kept)
        gained = left.score - score(self._background, shift.weighed.samples, fitter.noise,
                                    fitter.effective)
        rise = left.variance - self._variance
        loud = strength = float((rise / np.maximum(floor(fitter), self._needed)).max())
        shift.weigh(share, left.step)
        if loud < gained / bar:             # else what is slow changes nothing
            strength = max(loud, float((shift.slow * rise / self._needed).max()))
        strength = min(strength, gained / bar)
        if curves is None:
            return strength
        curve = self._curves.improvement(curves, share, left.step) / surely_above(LOOKED_AT)
        return min(strength, max(loud, curve))

    def _others(self, term: Term) -> '_Others':
        """Return what is known but for the term where it is accepted, or its twin is."""
        fit = self.fit
        own = {term.place, (HYPOTHESES[term.name].twin, term.joint)}
        if not own & {other.place for other in fit.accepted}:
            return _Others(self._known, fit.columns, fit.deviations)
        keep = np.concatenate([np.full(other.size, other not in fit.accepted
                                       or other.place not in own) for other in fit.terms])
        known = self._known._replace(products=self._known.products[:, keep][:, :, keep],
                                     against=self._known.against[:, keep])
        return _Others(known, fit.columns[:, :, keep], fit.deviations[keep])


class _Others(NamedTuple):
    """What is known beside an effect that is imagined."""

    known: Columns
    columns: Array          # (m, c, p) of the residuals
    tolerances: Array       # (p,)


class _Shift:
    """A shift (m, c) of the residuals, and what the terms beside it explain of it."""

    def __init__(self, others: _Others, weighed: Columns, along: Array, values: Array) -> None:
        """Keep the direction (q,) `along` the first columns of what is `weighed`."""
        self.others, self.weighed, self.along = others, weighed, along
        self._values = values
        self._weighed: tuple[float, Array] | None = None

    def imagined(self, share: float, background: Array) -> Columns:
        """Return residuals that are a share of the shift and a background, by the rest."""
        extra, along = len(self.along), share * self.along
        own, across = self.weighed.products[:, :extra, :extra], self.across()
        return Columns(self.weighed.products[:, extra:, extra:], share * across,
                       along @ own @ along + background * self.weighed.samples,
                       self.weighed.samples)

    def across(self) -> Array:
        """Return the shift times the terms beside it (c, p)."""
        extra = len(self.along)
        return np.asarray(self.along @ self.weighed.products[:, :extra, extra:])

    def weigh(self, share: float, step: Array) -> None:
        """Keep the share of the shift that is weighed first, and the step (p,) of the terms."""
        self._weighed = self._weighed or (share, step)

    @cached_property
    def slow(self) -> Array:
        """Return which part (c,) of its power is slow where it was weighed first, 1 before."""
        slow = np.ones_like(self.weighed.power)
        if self._weighed is None:
            return slow
        share, step = self._weighed
        shown = np.flatnonzero(self._values.any(axis=0))
        moved = self._values[:, shown]
        rest = share * moved + np.where(moved, self.others.columns[:, shown] @ step, 0.0)
        power = np.abs(np.fft.rfft(rest, axis=0)) ** 2
        below = np.fft.rfftfreq(len(rest), 1.0 / RATE) < SLOW
        slow[shown] = power[below].sum(axis=0) / np.maximum(power.sum(axis=0), 1e-300)
        return slow


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
