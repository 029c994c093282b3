"""
Examine an arm on what no fit has seen: the estimator itself, with one weight of its ways or other.

A witness is worth what it predicts of recordings left out. Its error there is its deviation, and
the estimator weighs both ways by their deviations. Whether that is right shows in what both
predict together. So other weights are tried as well, up to those that leave the torque to one way.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from hda_arm_sim.model.arm import Arm
import numpy as np
from numpy.typing import NDArray
from scipy.stats import t

from .arm_numbers import ArmNumber, number, rest
from .witness_fit import WitnessFit
from ..passages.joint_recording import Measured
from ...estimating.estimator import Estimator, EstimatorSettings
from ...least_squares.bounds import entered
from ...least_squares.rows import FOLDS, rms
from ...samples.readings import by_motor
from ...significance import NORMAL_90

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
# Choices unless stated otherwise.
# Factors of the deviations of torsion and motor that are tried.
WEIGHTS = ((1.0, 1.0), (3.0, 1.0), (1.0, 3.0), (30.0, 1.0), (1.0, 30.0))
BETTER = 0.97           # of the error with the deviations as they are, below which others count
# (asked: both ways together err by 1.05 times the better one at most)
ALONE = 1.0 / 1.05      # the same where one way alone would give the torque
LEADS = 10.0            # factor from which one way alone gives the torque
FARTHEST = 1e3          # deviation that an arm file takes, and no torque needs more [N*m]
LEAST = 1e-9            # deviation that anything may be over [N*m]
NAMES, FACTOR = ('torsion.deviation', 'motor_deviation'), 'deviation_factor'
FEWEST = 2.0            # degrees of freedom of a size, of which a piece has stretches
ROUNDS = 2              # in which a factor is found


class Witnesses(NamedTuple):
    """What the fits of both ways of a joint gave, None of one that gives nothing."""

    torsion: WitnessFit | None
    motor: WitnessFit | None

    @property
    def lag(self) -> float:
        """Return by how much the references lag [s], as the witness has it that errs less."""
        return min((one for one in self if one is not None), key=lambda one: one.error).lag

    def without(self, recording: Measured, fifth: int) -> dict[str, float]:
        """Return numbers by their names that have not seen a recording, or a fifth of it."""
        return {name: value for one in self if one is not None
                for name, value in one.without(recording, fifth).items()}

    def pieces(self, recording: Measured) -> Iterator[tuple[slice, dict[str, float]]]:
        """Yield samples of a recording, with the numbers of fits that have not seen them."""
        alone = any(one is not None and len(one.recordings) == 1
                    and one.recordings[0] is recording for one in self)
        ends = np.linspace(0, len(recording.stamps), (FOLDS if alone else 1) + 1).astype(int)
        for fifth, (begin, end) in enumerate(zip(ends, ends[1:])):
            yield slice(int(begin), int(end)), self.without(recording, fifth)


class Examined(NamedTuple):
    """What the estimator reaches with the best weights."""

    error: float                    # [N*m rms]
    about: float                    # the same about the mean of each recording [N*m rms]
    deviations: tuple[ArmNumber, ...]  # of torsion and motor
    leader: str                     # 'torsion' or 'motor' where that alone gives the torque


class EstimatorErrors(NamedTuple):
    """Errors of the estimator over samples (m,) that are believed."""

    error: Floats                   # [N*m]
    deviation: Floats               # [N*m]
    about: Floats                   # the error about the mean of its recording [N*m]
    piece: Ints                     # which samples no fit has seen together


def examined(arm: Arm, witnesses: Witnesses, recordings: Sequence[Measured],
             deviations: Mapping[str, float]) -> Examined:
    """
    Return the weights with which the estimator errs least on what no fit has seen.

    `arm` is one joint with the numbers of all recordings. `deviations` [N*m] are those of
    `torsion.deviation` and `motor_deviation`, as far as there are such witnesses. In the end all
    deviations of the torque have the factor that nine in ten torques ask for.
    """
    def judged(weights: tuple[float, float], factor: float = 1.0) -> EstimatorErrors:
        there = entered(arm, arm.labels[0], {FACTOR: factor})
        return left_out(_weighed(there, deviations, weights), witnesses, recordings)

    tried = WEIGHTS if len(deviations) > 1 else WEIGHTS[:1]
    found = {weights: judged(weights) for weights in tried}
    best = min(found, key=lambda weights: rms(found[weights].error) / _asked(*weights))
    factor, last = 1.0, found[best]
    for _ in range(ROUNDS):             # what the witnesses contradict has no share in it
        factor = number(FACTOR, factor * too_sure(last, len(recordings)), 0.0).value
        last = judged(best, factor)
    numbers = tuple(rest(min(each * deviations[name], FARTHEST), len(recordings), name)
                    for name, each in zip(NAMES, best) if name in deviations)
    return Examined(rms(last.error), rms(last.about),
                    (*numbers, rest(factor, len(recordings), FACTOR)), _leader(*best))


def too_sure(errors: EstimatorErrors, recordings: int) -> float:
    """
    Return by which factor deviations are too small for nine in ten to hold.

    Pieces err by sizes of their own. The more these differ, the less do few of them say of
    others. Satterthwaite gives their squares degrees of freedom, and these Student's t. Fifths of
    one recording do not show how others differ.
    """
    size = np.abs(errors.error) / np.maximum(errors.deviation, LEAST)
    usual = float(np.quantile(size, 0.9)) / NORMAL_90
    if recordings == 1:
        return usual
    squares = np.array([np.mean(size[errors.piece == one] ** 2)
                        for one in np.unique(errors.piece)])
    varies = np.var(squares, ddof=1) / max(float(np.mean(squares)) ** 2, LEAST)
    freedom = max(2.0 * len(squares) / max(varies, LEAST), FEWEST)
    return usual * float(t.ppf(0.95, freedom)) / NORMAL_90


def _weighed(arm: Arm, deviations: Mapping[str, float], weights: tuple[float, float]) -> Arm:
    """Return the arm with weights times the deviations that there are."""
    return entered(arm, arm.labels[0], {
        name: min(factor * deviations[name], FARTHEST)
        for name, factor in zip(NAMES, weights) if name in deviations})


def _asked(torsion: float, motor: float) -> float:
    """Return the share of the error below which such factors of their deviations are taken."""
    most = max(torsion, motor)
    return 1.0 if most == 1.0 else BETTER if most < LEADS else ALONE


def _leader(torsion: float, motor: float) -> str:
    """Return which way alone gives the torque with such factors of their deviations."""
    if max(torsion, motor) < LEADS:
        return ''
    return 'motor' if torsion > motor else 'torsion'


def left_out(arm: Arm, witnesses: Witnesses, recordings: Sequence[Measured]) -> EstimatorErrors:
    """Return the estimator's errors over recordings, by numbers that have not seen them."""
    return _joined([
        _errors_of(entered(arm, arm.labels[0], numbers), recording, rows, witnesses.lag)
        for recording in recordings for rows, numbers in witnesses.pieces(recording)])


def as_given(arm: Arm, recordings: Sequence[Measured], lag: float, *,
             fused: bool = True) -> EstimatorErrors:
    """Return the estimator's errors over recordings with the arm as it was given."""
    settings = EstimatorSettings(fusion=float(fused))
    return _joined([_errors_of(arm, recording, slice(None), lag, settings)
                    for recording in recordings])


def _joined(parts: Sequence[EstimatorErrors]) -> EstimatorErrors:
    whole = EstimatorErrors(*map(np.concatenate, zip(*parts)))
    return whole._replace(piece=np.repeat(np.arange(len(parts)),
                                          [len(part.error) for part in parts]))


def _errors_of(arm: Arm, recording: Measured, rows: slice, lag: float,
               settings: EstimatorSettings = EstimatorSettings()) -> EstimatorErrors:
    """Return the errors over some samples; the estimator runs from the begin of the recording."""
    if not recording.has_link:
        arm, recording = by_motor(arm, arm.labels), recording.with_link(arm.joints[0].ratio)
    seen = slice(0, rows.stop)          # it has its zero from what came before
    estimated = Estimator(arm, settings).run(recording.stamps[seen], recording.readings[seen],
                                             recording.command[seen, np.newaxis])
    error = estimated.torque[rows, 0] - recording.later(lag)[rows]
    known = np.isfinite(error)
    if recording.has_command:           # where it is missing no weight counts
        known &= np.isfinite(recording.command[rows])
        known[:1] &= (rows.start or 0) > 0          # nor where no time has passed
    error = error[known]
    mean = float(error.mean()) if len(error) else 0.0
    return EstimatorErrors(error, estimated.torque_deviation[rows, 0][known], error - mean,
                           np.zeros(len(error), np.int64))
