"""
Find the unknowns of a joint over passages: Gauss-Newton on the error of the estimator itself.

Errors are averaged to rows and rows gathered in stretches of a few seconds. Every fifth stretch
in turn is left out of the fit to tell what it is worth where it has not seen. Intervals come from
how much the stretches pull the fit to and fro, so they hold errors that follow each other.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from hda_arm_sim.model.arm import Arm
import numpy as np
from numpy.typing import NDArray

from .fit import applied
from .tangent import tangents
from .terms import Term
from ..passages.loads import DOUBTS
from ..passages.passage import Passage
from ...estimating.estimator import Estimates, Estimator, EstimatorSettings
from ...estimating.laws.estimate import KINEMATIC_TORSION, TORSION
from ...samples.readings import LINK_READING

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
# Choices unless told otherwise.
STRETCH = 3.0           # of a recording, left out of a fit or kept as a whole [s]
FOLDS = 5               # every so many-th stretch is left out in turn
PIECES = 3              # fewest recordings, or parts of them, that tell how laws fail
STEP = 0.02             # of a sigma, for the slopes
ZERO_KNOWN = 1.0        # [rad], as good as nothing
PASSES = 14             # of Gauss-Newton at most
CLOSE = 2e-3            # relative gain of a pass that ends the descent
SHARES = (1.0, 0.5, 0.2, 0.05)  # of a step that are tried, the longest first
WORTHLESS = 1e-9        # [N*m], the least noise
UNFUSED = EstimatorSettings(fusion=0.0)     # what is calibrated is the torsion alone


@dataclass(frozen=True, eq=False)
class Rows:
    """Errors over the rows of all passages, and their slopes over the unknowns."""

    error: Floats       # (m,) [N*m]
    slopes: Floats      # (m, p) per sigma of each unknown
    stretch: Ints       # (m,)
    piece: Ints         # (m,) of one recording, or of a part of it where there are few

    @property
    def fold(self) -> Ints:
        """Return which fifth of the stretches a row belongs to (m,)."""
        return self.stretch % FOLDS


@dataclass(frozen=True, eq=False)
class Found:
    """The fit: values of all unknowns, then the zero and the doubts; in sigmas from known."""

    terms: tuple[Term, ...]
    scaled: Floats      # (p,)
    rows: Rows
    noise: float        # that a row has if its neighbours told nothing new [N*m]

    @property
    def unknowns(self) -> int:
        """Return the number of unknowns of the terms; zero and doubts come behind them."""
        return sum(len(term.unknowns) for term in self.terms)

    def values(self) -> Floats:
        """Return the values of the terms' unknowns."""
        nominal, spread = known(self.terms)
        return nominal + spread * self.scaled[:len(nominal)]

    def zero(self) -> float:
        """Return by how much the link's zero is off [rad]."""
        return float(self.scaled[self.unknowns] * ZERO_KNOWN)

    def covariance(self) -> Floats:
        """
        Return the covariance of all unknowns in sigmas (p, p), by the pulls of stretches.

        What a whole recording pulls comes on top: no law is exact, and where it is not depends
        on the motion.
        """
        rows, weight = self.rows, self.noise ** -2
        inner = np.linalg.inv(weight * rows.slopes.T @ rows.slopes + _prior(len(self.scaled)))
        pulls = _pulls(rows, rows.stretch) + _pulls(rows, rows.piece)
        return inner @ (weight ** 2 * pulls + _prior(len(self.scaled))) @ inner


def _pulls(rows: Rows, part: Ints) -> Floats:
    """Return the summed squares of what each part of the rows pulls at the unknowns (p, p)."""
    pulls = np.stack([rows.slopes[part == one].T @ rows.error[part == one]
                      for one in np.unique(part)])
    return pulls.T @ pulls


def known(terms: Sequence[Term]) -> tuple[Floats, Floats]:
    """Return what is known of all unknowns before: values and sigmas."""
    unknowns = [unknown for term in terms for unknown in term.unknowns]
    return (np.array([unknown.nominal for unknown in unknowns]),
            np.array([unknown.spread for unknown in unknowns]))


def spread_of(term: Term) -> Floats:
    """Return the sigmas of a term's unknowns."""
    return np.array([unknown.spread for unknown in term.unknowns])


def _prior(size: int) -> Floats:
    return np.eye(size)


class Descent:
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
        self._reference = self.thinned([passage.reference for passage in passages])
        self._doubt = self.thinned([passage.doubt for passage in passages])

    def thinned(self, columns: Sequence[Floats]) -> Floats:
        """Return values of every passage (k, ...) as rows (m, ...)."""
        return np.concatenate([passage.thinned(column)[used] for passage, column, used
                               in zip(self.passages, columns, self._used)])

    def estimated(self, arm: Arm, zero: float) -> list[Estimates]:
        """Return what the estimator of an arm tells of every passage."""
        estimator, found = Estimator(arm, UNFUSED), []
        for passage in self.passages:
            readings = passage.readings.copy()
            readings[:, 0, LINK_READING] -= zero
            estimator.reset()
            found.append(estimator.run(passage.stamps, readings))
        return found

    def torque(self, terms: Sequence[Term], scaled: Floats) -> Floats:
        """Return the torque of the rows (m,) with unknowns in sigmas from what was known."""
        return self.thinned([found.torque[:, 0] for found in
                             self.estimated(*self._arm(terms, scaled))])

    def _arm(self, terms: Sequence[Term], scaled: Floats) -> tuple[Arm, float]:
        """Return the arm with these unknowns, and the zero of its link."""
        nominal, spread = known(terms)
        count = len(nominal)
        return (applied(self.arm, terms, nominal + spread * scaled[:count]),
                float(scaled[count] * ZERO_KNOWN))

    def error(self, terms: Sequence[Term], scaled: Floats) -> Floats:
        """Return the error of the rows (m,): torque less reference and its doubts."""
        return self.torque(terms, scaled) - self._reference - self._doubt @ scaled[-DOUBTS:]

    def rows(self, terms: Sequence[Term], scaled: Floats, error: Floats) -> Rows:
        """Return the rows with all slopes; unknowns that do more than turn take a run each."""
        arm, zero = self._arm(terms, scaled)
        base = self.estimated(arm, zero)
        torque = self.thinned([found.torque[:, 0] for found in base])
        slopes = np.empty((len(error), len(scaled)))
        slopes[:, -DOUBTS:] = -self._doubt
        turned: list[int] = []
        first = 0
        for term in terms:
            places = range(first, first := first + len(term.unknowns))
            for place in places if term.turns is None else ():
                step = np.zeros(len(scaled))
                step[place] = STEP
                slopes[:, place] = (self.torque(terms, scaled + step) - torque) / STEP
            turned += places if term.turns is not None else ()
        slopes[:, [*turned, first]] = self._turned(terms, arm, base)
        return Rows(error, slopes, self.stretch, self.piece)

    def _turned(self, terms: Sequence[Term], arm: Arm, base: Sequence[Estimates]) -> Floats:
        """Return the slopes of the rows over what adds to the torsion, the zero last (m, q)."""
        joint, columns = arm.record().joints[0], []
        for passage, found in zip(self.passages, base):
            change = np.concatenate(
                [spread_of(term) * term.turns(passage) for term in terms
                 if term.turns is not None] + [np.full((len(passage.reference), 1), ZERO_KNOWN)],
                axis=1)
            slope = np.empty_like(change)
            elastic = found.joints[:, 0, TORSION] - found.joints[:, 0, KINEMATIC_TORSION]
            tangents(joint, elastic, change, slope)
            columns.append(slope)
        return self.thinned(columns)

    def fit(self, terms: Sequence[Term], start: Floats | None = None) -> Found:
        """Return the most likely unknowns, descending from where they begin or from `start`."""
        scaled = beginning(terms) if start is None else start
        bounds, error = _bounds(terms), self.error(terms, scaled)
        rows, fresh = self.rows(terms, scaled, error), True
        for _ in range(PASSES):
            noise = noise_of(error, self.stretch)
            trial, trial_error, gain = self._step(terms, rows, noise, scaled, bounds)
            if gain > CLOSE:
                slopes = _corrected(rows.slopes, trial_error - error, trial - scaled)
                scaled, error, fresh = trial, trial_error, False
                rows = Rows(error, slopes, self.stretch, self.piece)
            elif fresh:
                break
            else:
                rows, fresh = self.rows(terms, scaled, error), True
        rows = rows if fresh else self.rows(terms, scaled, error)
        return Found(tuple(terms), scaled, rows, noise_of(error, self.stretch))

    def _step(self, terms: Sequence[Term], rows: Rows, noise: float, scaled: Floats,
              bounds: tuple[Floats, Floats]) -> tuple[Floats, Floats, float]:
        """Return unknowns after a step, their errors, and the relative gain, 0 where none is."""
        step, before = solved(rows, noise, scaled), _cost(rows.error, noise, scaled)
        for share in SHARES:
            trial = np.clip(scaled + share * step, *bounds)
            error = self.error(terms, trial)
            if (after := _cost(error, noise, trial)) < before:
                return trial, error, 1.0 - after / before
        return scaled, rows.error, 0.0


def _corrected(slopes: Floats, change: Floats, step: Floats) -> Floats:
    """Return slopes that explain the last change of the errors (Broyden), in place of new ones."""
    miss = change - slopes @ step
    return slopes + np.outer(miss, step / max(float(step @ step), WORTHLESS))


def beginning(terms: Sequence[Term]) -> Floats:
    """Return where the unknowns begin, in sigmas from what is known; zero and doubts at 0."""
    nominal, spread = known(terms)
    start = np.array([unknown.start for term in terms for unknown in term.unknowns])
    return np.concatenate([(start - nominal) / spread, np.zeros(1 + DOUBTS)])


def _bounds(terms: Sequence[Term]) -> tuple[Floats, Floats]:
    nominal, spread = known(terms)
    unknowns = [unknown for term in terms for unknown in term.unknowns]
    wide = np.full(1 + DOUBTS, np.inf)
    return (np.concatenate([([u.low for u in unknowns] - nominal) / spread, -wide]),
            np.concatenate([([u.high for u in unknowns] - nominal) / spread, wide]))


def solved(rows: Rows, noise: float, scaled: Floats) -> Floats:
    """Return the step to the most likely unknowns, if slopes stay as they are."""
    weight = noise ** -2
    normal = weight * rows.slopes.T @ rows.slopes + _prior(len(scaled))
    return -np.linalg.solve(normal, weight * rows.slopes.T @ rows.error + scaled)


def held_out(rows: Rows, noise: float, scaled: Floats) -> float:
    """Return the error on stretches that a fit has not seen, each fifth in turn [N*m rms]."""
    left = np.empty_like(rows.error)
    for fold in range(FOLDS):
        seen = rows.fold != fold
        step = solved(replace(rows, error=rows.error[seen], slopes=rows.slopes[seen]), noise,
                      scaled)
        left[~seen] = rows.error[~seen] + rows.slopes[~seen] @ step
    return rms(left)


def rms(values: Floats) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(values ** 2)))


def _cost(error: Floats, noise: float, scaled: Floats) -> float:
    return float(error @ error / noise ** 2 + scaled @ scaled)


def noise_of(error: Floats, stretch: Ints) -> float:
    """Return the noise of a row if its neighbours told nothing new: by means over few rows."""
    following = error[1:] * error[:-1]
    inside = stretch[1:] == stretch[:-1]
    power = float(np.mean(error ** 2))
    alike = float(np.clip(np.mean(following[inside]) / max(power, WORTHLESS ** 2), 0.0, 0.98))
    return max(float(np.sqrt(power * (1.0 + alike) / (1.0 - alike))), WORTHLESS)
