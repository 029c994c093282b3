"""
Find the unknowns of a joint over passages: the error of the estimator itself, run over them.

Errors are averaged to rows and rows gathered in stretches of a few seconds. Behind the terms come
the zero of the link encoder and the doubts of the loads.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from hda_arm_sim.model.arm import Arm
import numpy as np
from numpy.typing import NDArray

from .laws import turning, turns
from .tangent import tangents
from ..passages.loads import DOUBTS
from ..passages.passage import Passage
from ...estimating.estimates import Estimates
from ...estimating.estimator import Estimator, EstimatorSettings
from ...estimating.laws.layout import KINEMATIC_TORSION, TORSION
from ...least_squares.descent import beginning, descend, limits, Minimum, placed, places
from ...least_squares.rows import FOLDS, Rows
from ...least_squares.term import Term
from ...samples.readings import LINK_READING

Floats = NDArray[np.float64]
# Choices unless stated otherwise.
STRETCH = 3.0           # of a recording, left out of a fit or kept as a whole [s]
PIECES = 3              # fewest recordings, or parts of them, that show how laws fail
STEP = 0.02             # of a sigma, for the slopes
ZERO_KNOWN = 1.0        # [rad], as good as nothing
BESIDE = 1 + DOUBTS     # unknowns that are no terms: the zero, then the doubts
UNFUSED = EstimatorSettings(fusion=0.0)     # what is calibrated is the torsion alone


class TorsionFits:
    """The rows of passages of one joint, for one arm after another."""

    def __init__(self, arm: Arm, passages: Sequence[Passage]) -> None:
        """`arm` is one joint as it was given."""
        self.arm, self.passages = arm, passages
        self._used = [passage.rows_used() for passage in passages]
        stretches, pieces, first = [], [], 0
        parts = -(-PIECES // len(passages))             # of each recording
        for place, (passage, used) in enumerate(zip(passages, self._used)):
            length = max(1, round(STRETCH / (passage.dt * passage.every)))
            numbers = first + np.arange(len(used)) // length
            stretches.append(numbers[used])
            first = int(numbers[-1]) + 1
            pieces.append(place * parts + np.arange(used.sum()) * parts // max(used.sum(), 1))
        self.stretch, self.piece = np.concatenate(stretches), np.concatenate(pieces)
        self.reference = self.thinned([passage.reference for passage in passages])
        self.doubt = self.thinned([passage.doubt for passage in passages])

    def thinned(self, columns: Sequence[Floats]) -> Floats:
        """Return values of every passage (k, ...) as rows (m, ...)."""
        return np.concatenate([passage.thinned(column)[used] for passage, column, used
                               in zip(self.passages, columns, self._used)])

    def estimated(self, arm: Arm, zero: float) -> list[Estimates]:
        """Return the estimates of an arm over every passage."""
        estimator, found = Estimator(arm, UNFUSED), []
        for passage in self.passages:
            readings = passage.readings.copy()
            readings[:, 0, LINK_READING] -= zero
            estimator.reset()
            found.append(estimator.run(passage.stamps, readings))
        return found

    def fit(self, terms: Sequence[Term], start: Floats | None = None) -> Minimum:
        """Return the most likely unknowns, descending from where they begin or from `start`."""
        problem = TorsionProblem(self, tuple(terms))
        return descend(problem, beginning(terms, BESIDE) if start is None else start)


@dataclass(frozen=True)
class TorsionProblem:
    """Terms of a joint against the torques of its passages."""

    fits: TorsionFits
    terms: tuple[Term, ...]

    @property
    def prior(self) -> Floats:
        """Return the priors, all of which are in their own sigmas (p,)."""
        return np.ones(sum(term.size for term in self.terms) + BESIDE)

    @property
    def bounds(self) -> tuple[Floats, Floats]:
        """Return where the search ends (p,)."""
        return limits(self.terms, BESIDE)

    def error(self, scaled: Floats) -> Floats:
        """Return the error of the rows (m,): torque less reference and its doubts [N*m]."""
        return self._torque(scaled) - self.fits.reference - self.fits.doubt @ scaled[-DOUBTS:]

    def _torque(self, scaled: Floats) -> Floats:
        """Return the torque of the rows (m,) with unknowns in sigmas from what was known."""
        return self.fits.thinned([found.torque[:, 0] for found in
                                  self.fits.estimated(*self._arm(scaled))])

    def _arm(self, scaled: Floats) -> tuple[Arm, float]:
        """Return the arm with these unknowns, and the zero of its link [rad]."""
        arm = self.fits.arm
        for term in placed(self.terms, scaled):
            arm = term.on(arm)
        return arm, float(scaled[-BESIDE] * ZERO_KNOWN)

    def rows(self, scaled: Floats, error: Floats) -> Rows:
        """Return the rows with all slopes; unknowns that do more than turn take a run each."""
        arm, zero = self._arm(scaled)
        base = self.fits.estimated(arm, zero)
        torque = self.fits.thinned([found.torque[:, 0] for found in base])
        slopes = np.empty((len(error), len(scaled)))
        slopes[:, -DOUBTS:] = -self.fits.doubt
        turned: list[int] = []
        for term, place in zip(self.terms, places(self.terms)):
            if turns(term):
                turned += range(place.start, place.stop)
                continue
            for one in range(place.start, place.stop):
                step = np.zeros(len(scaled))
                step[one] = STEP
                slopes[:, one] = (self._torque(scaled + step) - torque) / STEP
        slopes[:, [*turned, len(scaled) - BESIDE]] = self._turned(arm, base)
        stretch = self.fits.stretch
        return Rows(error, slopes, stretch, self.fits.piece, stretch % FOLDS)

    def _turned(self, arm: Arm, base: Sequence[Estimates]) -> Floats:
        """Return the slopes of the rows over what adds to the torsion, the zero last (m, q)."""
        joint, columns = arm.record().joints[0], []
        for passage, found in zip(self.fits.passages, base):
            change = np.concatenate(
                [term.deviations() * turning(term, passage, self.fits.arm.joints[0].ratio)
                 for term in self.terms if turns(term)]
                + [np.full((len(passage.reference), 1), ZERO_KNOWN)], axis=1)
            slope = np.empty_like(change)
            elastic = found.joints[:, 0, TORSION] - found.joints[:, 0, KINEMATIC_TORSION]
            tangents(joint, elastic, change, slope)
            columns.append(slope)
        return self.fits.thinned(columns)
