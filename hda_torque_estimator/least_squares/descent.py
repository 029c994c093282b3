"""
The descent of every fit: damped Gauss-Newton, with Broyden's slopes between new ones.

`descend` fits a `Problem`: it gives errors and slopes for unknowns in sigmas from what was
known before. Unknowns stay within the bounds of the problem. A fit whose score is no sum of
squares takes its own steps, and descends by `improved`. Both shorten steps by `damped`.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from .rows import bounded, noise_of, Rows, WORTHLESS
from .sandwich import covariance
from .term import Term

Floats = NDArray[np.float64]
Step = TypeVar('Step')
Size = TypeVar('Size')
# Choices unless stated otherwise.
PASSES = 14             # of Gauss-Newton at most
CLOSE = 2e-3            # relative gain of a pass that ends the descent
SHARES = (1.0, 0.5, 0.2, 0.05)  # of a step that are tried, the longest first


class Scored(Protocol):
    """What a descent can stand at: smaller scores are better."""

    @property
    def score(self) -> float:
        """Return twice the negative log posterior."""


State = TypeVar('State', bound=Scored)


class Problem(Protocol):
    """
    What is fitted: terms of a joint, then unknowns that are no numbers of it.

    Unknowns (p,) are in sigmas from what was known. `prior` (p,) is 0 where that was nothing.
    """

    @property
    def terms(self) -> tuple[Term, ...]:
        """Return the terms."""

    @property
    def prior(self) -> Floats:
        """Return 1 for every unknown of which something was known, else 0 (p,)."""

    @property
    def bounds(self) -> tuple[Floats, Floats]:
        """Return where the search ends (p,)."""

    def error(self, scaled: Floats) -> Floats:
        """Return the errors of all rows (m,) [N*m]."""

    def rows(self, scaled: Floats, error: Floats) -> Rows:
        """Return the rows with all slopes about unknowns of which the errors are known."""


@dataclass(frozen=True, eq=False)
class Minimum:
    """A fit: all unknowns in sigmas from what was known, and what they leave."""

    terms: tuple[Term, ...]     # as they were known before
    scaled: Floats              # (p,)
    prior: Floats               # (p,)
    rows: Rows
    noise: float                # that a row has if its neighbours held nothing new [N*m]

    @property
    def unknowns(self) -> int:
        """Return the number of unknowns of the terms; others come behind them."""
        return sum(term.size for term in self.terms)

    def moved(self) -> list[Term]:
        """Return the terms as they were found."""
        return placed(self.terms, self.scaled)

    def covariance(self) -> Floats:
        """Return the covariance of all unknowns in sigmas (p, p)."""
        return covariance(self.rows, self.noise, self.prior)

    def without(self, term: Term) -> 'Minimum':
        """Return the fit without one of its terms, as far as slopes stay as they are."""
        place = next(place for place, one in zip(places(self.terms), self.terms) if one is term)
        gone = np.arange(place.start, place.stop)
        error = self.rows.error - self.rows.slopes[:, gone] @ self.scaled[gone]
        rows = replace(self.rows, error=error, slopes=np.delete(self.rows.slopes, gone, axis=1))
        return replace(self, terms=tuple(one for one in self.terms if one is not term), rows=rows,
                       scaled=np.delete(self.scaled, gone), prior=np.delete(self.prior, gone))


def places(terms: Sequence[Term]) -> list[slice]:
    """Return where the unknowns of each term stand among all."""
    ends = np.cumsum([term.size for term in terms])
    return [slice(int(end) - term.size, int(end)) for term, end in zip(terms, ends)]


def placed(terms: Sequence[Term], scaled: Floats) -> list[Term]:
    """Return terms moved to unknowns in sigmas from what was known."""
    return [term.at(term.vector() + term.deviations() * scaled[place])
            for term, place in zip(terms, places(terms))]


def beginning(terms: Sequence[Term], more: int) -> Floats:
    """Return where a search begins, in sigmas; `more` unknowns behind the terms begin at 0."""
    return np.concatenate([*((term.start() - term.vector()) / term.deviations()
                             for term in terms), np.zeros(more)])


def limits(terms: Sequence[Term], more: int) -> tuple[Floats, Floats]:
    """Return the bounds of a search, in sigmas; `more` unknowns behind the terms have none."""
    low, high = ([(term.bounds()[side] - term.vector()) / term.deviations() for term in terms]
                 for side in (0, 1))
    wide = np.full(more, np.inf)
    return np.concatenate([*low, -wide]), np.concatenate([*high, wide])


def descend(problem: Problem, start: Floats, noise: float | None = None,
            known: Rows | None = None) -> Minimum:
    """
    Return the most likely unknowns, descending from `start` (p,), about which rows may be known.

    The noise of a row is what each pass leaves, or `noise` [N*m] where that is given. A fit that
    is far off takes all of its error for noise, and priors then hold it where it is.
    """
    rows = problem.rows(start, problem.error(start)) if known is None else known
    scaled, error, fresh = start, rows.error, True
    for _ in range(PASSES):
        weighed = noise_of(error, rows.stretch) if noise is None else noise
        trial = _step(problem, rows, weighed, scaled)
        if trial is not None and trial.gain > CLOSE:
            slopes = _corrected(rows.slopes, trial.error - error, trial.scaled - scaled)
            scaled, error, fresh = trial.scaled, trial.error, False
            rows = replace(rows, error=error, slopes=slopes)
        elif fresh:
            break
        else:
            rows, fresh = problem.rows(scaled, error), True
    rows = rows if fresh else problem.rows(scaled, error)
    return Minimum(tuple(problem.terms), scaled, problem.prior, rows,
                   noise_of(error, rows.stretch))


class _Trial(NamedTuple):
    """Unknowns after a step, their errors, and the relative gain."""

    scaled: Floats
    error: Floats
    gain: float


def _step(problem: Problem, rows: Rows, noise: float, scaled: Floats) -> _Trial | None:
    """Return the longest share of a step that gains, None where none does."""
    step = bounded(rows, noise, scaled, problem.prior, problem.bounds)
    before = _cost(problem, rows.error, noise, scaled)

    def trial(share: float) -> _Trial:
        there = np.clip(scaled + share * step, *problem.bounds)
        error = problem.error(there)
        return _Trial(there, error, 1.0 - _cost(problem, error, noise, there) / before)

    return damped(trial, SHARES, lambda found: found.gain > 0.0)


def damped(trial: Callable[[Size], Step | None], sizes: Sequence[Size],
           gains: Callable[[Step], bool]) -> Step | None:
    """Return the first of a step's sizes, tried in this order, that gains; None if none does."""
    for size in sizes:
        found = trial(size)
        if found is not None and gains(found):
            return found
    return None


def improved(start: State, step: Callable[[State], State],
             renewed: Callable[[State, float], State], passes: int, enough: float) -> State:
    """
    Return a state after steps that lower its score, until one gains less than `enough`.

    `step` returns a better state or the same. `renewed(state, gained)` makes the slopes anew from
    which the next step is taken.
    """
    best = start
    for _ in range(passes):
        better = step(best)
        gained, best = best.score - better.score, better
        if gained < enough:
            break
        best = renewed(best, gained)
    return best


def _corrected(slopes: Floats, change: Floats, step: Floats) -> Floats:
    """Return slopes that explain the last change of the errors (Broyden), in place of new ones."""
    miss = change - slopes @ step
    return slopes + np.outer(miss, step / max(float(step @ step), WORTHLESS))


def _cost(problem: Problem, error: Floats, noise: float, scaled: Floats) -> float:
    return float(error @ error / noise ** 2 + (problem.prior * scaled) @ scaled)
