"""
A witness held against references: terms of the joint, the references' lag, moving zeros.

The zero may be another one in every recording. By how much it moves between recordings is found
beside everything else. So a zero that moves explains nothing. That it stays is tried as well.
(With few recordings a zero of each may pass for a law of the gear.)
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from hda_arm_sim.model.arm import Arm
import numpy as np
from numpy.typing import NDArray

from .witness import Witness
from ...least_squares.descent import beginning, descend, limits, Minimum, placed
from ...least_squares.rows import bounded, normal_of, rms, Rows, solved
from ...least_squares.term import Term, with_terms

Floats = NDArray[np.float64]
# Choices unless stated otherwise.
STEP = 0.02             # of a sigma, for the slopes
LAG = 0.02              # of a reference, before anything is known [s]
FIRST_NOISE = 0.15      # of the references' deviation, until a fit has shown the noise
ROUNDS = 6              # of a fit with the spread of zeros that the last one has left
SETTLED = 0.05          # relative change of spread and noise that ends them
STAYS = 1e-3            # of the usual zero, a spread that is none
ABSURD = 1e6            # error beyond which a torque is none, as of a law far out of range [N*m]


@dataclass(frozen=True)
class Referenced:
    """
    One witness of one joint with the terms that are looked for.

    `spread` is one sigma of the zeros over recordings, 0 where there is only one. `lags` says
    whether a lag of the references is looked for. Behind the terms come the lag, then zeros.
    """

    arm: Arm                        # one joint
    witness: Witness
    terms: tuple[Term, ...]
    spread: float
    lags: bool = False
    stays: bool = False             # whether all recordings have one zero

    @property
    def recordings(self) -> int:
        """Return the number of recordings."""
        return int(self.witness.blocks.recording.max()) + 1

    @property
    def moving(self) -> int:
        """Return the number of zeros that move."""
        return self.recordings if self.recordings > 1 and not self.stays else 0

    @property
    def beside(self) -> int:
        """Return the number of unknowns behind the terms."""
        return int(self.lags) + self.moving

    @property
    def prior(self) -> Floats:
        """Return the priors, all of which are in their own sigmas (p,)."""
        return np.ones(sum(term.size for term in self.terms) + self.beside)

    @cached_property
    def bounds(self) -> tuple[Floats, Floats]:
        """Return where the search ends (p,)."""
        low, high = limits(self.terms, self.beside)
        if self.lags:
            low[-self.beside] = 0.0         # no reference knows a torque before it is there
        return low, high

    def zeros(self, scaled: Floats) -> Floats:
        """Return by how much every recording's zero is off the common one (r,), none of one."""
        return self.spread * scaled[len(scaled) - self.moving:]

    def lag(self, scaled: Floats) -> float:
        """Return by how much the references lag [s]."""
        return LAG * float(scaled[-self.beside]) if self.lags else 0.0

    def on(self, scaled: Floats) -> Arm:
        """Return the arm with these unknowns."""
        return with_terms(self.arm, placed(self.terms, scaled))

    def error(self, scaled: Floats) -> Floats:
        """Return the error of the rows (m,) [N*m]."""
        torque = self.witness.torque(self.on(scaled), self.zeros(scaled))
        return np.clip(np.nan_to_num(torque, nan=ABSURD), -ABSURD, ABSURD) - (
            self.witness.reference(self.lag(scaled)))

    def rows(self, scaled: Floats, error: Floats) -> Rows:
        """Return the rows with all slopes, by a run for each unknown and one for all zeros."""
        slopes, blocks = np.zeros((len(error), len(scaled))), self.witness.blocks
        first = len(scaled) - self.moving
        for place in range(first):
            slopes[:, place] = self._slope(scaled, error, np.eye(len(scaled))[place])
        if self.moving:
            own = self._slope(scaled, error, (np.arange(len(scaled)) >= first).astype(float))
            rows = np.arange(len(error))
            slopes[rows, first + blocks.recording] = own
        return Rows(error, slopes, blocks.stretch, blocks.recording, blocks.fold)

    def _slope(self, scaled: Floats, error: Floats, way: Floats) -> Floats:
        """Return the slope of the errors (m,) along a way of the unknowns, into the bounds."""
        step = STEP if (scaled + STEP * way <= self.bounds[1]).all() else -STEP
        return np.asarray((self.error(scaled + step * way) - error) / step)


def fitted(problem: Referenced, starts: Sequence[Floats] = (),
           known: Rows | None = None) -> tuple[Referenced, Minimum]:
    """
    Return the most likely unknowns, and the problem with the spread that its zeros have.

    `known` are the rows about the first of the starts.
    """
    found = likeliest(problem, starts or [beginning(problem.terms, problem.beside)], known)
    for _ in range(ROUNDS):
        before = found.noise
        spread = _spread(problem, found) if problem.moving else problem.spread
        scaled, rows = _with_zeros(problem, found, problem.spread / spread)
        settled = abs(spread - problem.spread) <= SETTLED * problem.spread
        problem = replace(problem, spread=spread)
        found = descend(problem, scaled, known=rows)
        if settled and abs(found.noise - before) <= SETTLED * before:
            break
    return problem, found


def _with_zeros(problem: Referenced, found: Minimum, factor: float) -> tuple[Floats, Rows]:
    """Return unknowns and rows of a fit with zeros so many times as many sigmas."""
    scaled, slopes = found.scaled.copy(), found.rows.slopes.copy()
    first = len(scaled) - problem.moving
    scaled[first:] *= factor
    slopes[:, first:] /= factor
    return scaled, replace(found.rows, slopes=slopes)


def likeliest(problem: Referenced, starts: Sequence[Floats], known: Rows | None = None) -> Minimum:
    """Return the fit that leaves least, from one of several starts; `known` as in `fitted`."""
    fits = [_hopeful(problem, start, None if place else known)
            for place, start in enumerate(starts)]
    return min(fits, key=lambda found: found.noise)


def _hopeful(problem: Referenced, start: Floats, known: Rows | None) -> Minimum:
    """Return a fit that is first taken for nearly right, then for as right as it is."""
    noise = FIRST_NOISE * float(problem.witness.reference(0.0).std())
    first = descend(problem, start, noise, known)
    return descend(problem, first.scaled, known=first.rows)


def _spread(problem: Referenced, found: Minimum) -> float:
    """Return one sigma of the zeros over recordings, less what they are unsure by (MacKay)."""
    first = len(found.scaled) - problem.moving
    normal, _ = normal_of(found.rows, found.noise, found.scaled, found.prior)
    unsure = np.diag(np.linalg.inv(normal))[first:]
    determined = max(float((1.0 - unsure).sum()), 0.5)
    ratio = np.sqrt(float((found.scaled[first:] ** 2).sum()) / determined)
    return max(problem.spread * float(np.clip(ratio, 0.05, 20.0)),
               STAYS * problem.witness.usual_zero)


def error_left_out(problem: Referenced, found: Minimum, *, follows: bool = True) -> float:
    """
    Return the error on recordings that a fit has not seen, each in turn [N*m rms].

    It `follows` as in `left_out`.
    """
    return rms(left_out(problem, found, follows=follows))


def left_out(problem: Referenced, found: Minimum, *, follows: bool = True) -> Floats:
    """
    Return the errors (m,) on recordings that a fit has not seen, each in turn [N*m].

    If it `follows`, the zero of a recording left out may move as far as the others' have. Else it
    is what they have in common. With one recording it is every fifth of it.
    """
    rows = found.rows
    left = np.empty_like(rows.error)
    for fold in np.unique(rows.fold):
        seen, step = rows.fold != fold, step_without(problem, found, int(fold))
        if problem.moving and follows:
            own = _own(problem, found, int(fold))
            rest = rows.some(~seen).after(step)
            step[own] += solved(rest.along(own), found.noise, found.scaled[own] + step[own],
                                found.prior[own])
        left[~seen] = rows.some(~seen).after(step).error
    return left


def step_without(problem: Referenced, found: Minimum, fold: int) -> Floats:
    """Return the step (p,) to a fit that has not seen a fold, which has the common zero then."""
    step = bounded(found.rows.some(found.rows.fold != fold), found.noise, found.scaled,
                   found.prior, problem.bounds)
    if problem.moving:
        own = _own(problem, found, fold)
        step[own] = -found.scaled[own]
    return step


def _own(problem: Referenced, found: Minimum, fold: int) -> list[int]:
    """Return the place of a recording's own zero."""
    return [len(found.scaled) - problem.moving + fold]
