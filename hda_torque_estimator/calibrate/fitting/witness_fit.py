"""Fit torsion or motor to reference torques: which terms earn their place, and what is left."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
import math
from typing import NamedTuple

from hda_arm_sim.model.arm import Arm
import numpy as np
from numpy.typing import NDArray

from .arm_numbers import ArmNumber, doubtful, number, numbers, OFFSET
from .held_friction import held_friction
from .motor_witness import MotorWitness, sliding, SLOWEST, STANDS
from .referenced_problem import (error_left_out, fitted, LAG, left_out, Referenced,
                                 step_without)
from .referenced_terms import (cogging, likely_order, Maker, motor_always, motor_more, stiffening,
                               TORSION, TORSION_MORE)
from .ripple_left import ripple_left
from .torsion_witness import TorsionWitness
from .witness import Witness
from ..passages.joint_recording import Measured
from ...least_squares.descent import beginning, Minimum, placed
from ...least_squares.rows import rms, solved

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Fit = tuple[Referenced, Minimum]
TINY = np.finfo(float).tiny
# Choices unless stated otherwise.
SOFTER = 0.2            # of the stiffness known, where a search begins as well
BENDS = 1.0             # deviation of a torque, from which a law can be seen to bend [N*m]
FARTHEST = 6.0          # of what references lag before anything is known, longest first guess
# (measured: for a joint of a real arm a true term made 0.52 N*m to 0.29, false ones 0.60 to 0.52)
CLEARLY = 0.8           # of the error left out, below which a term of the torsion has its place
PATIENT = 2000          # rows of a torsion up to which all terms are fitted, not looked at alone
SLIGHTLY = 0.97         # the same of the motor, whose friction no term can stand in for
SHARES = (0.5, 0.2, 0.0)         # of a step that are tried as well
BELIEVED = 0.9          # of the error left out if zeros move, below which all are one zero
FOLLOWED = 1.0          # times that of zeros that are followed, above which they are


@dataclass(frozen=True)
class WitnessFit:
    """What the fit of one witness of a joint gave."""

    numbers: tuple[ArmNumber, ...]
    known: tuple[ArmNumber, ...]   # the same, as well known as if they were independent
    spread: float           # of its zero over recordings [unit of the witness]
    lag: float              # of the references [s]
    error: float            # where the fit has not seen, zeros free to move as they do [N*m rms]
    deviation: float        # of that, what no number is unsure by [N*m rms]
    offset: float           # deviation of the torque by its zero, of a recording not seen [N*m]
    before: float           # as the arm was given, every recording with a zero of its own [N*m]
    varies: float           # the reference as the witness's rows see it, about its means [N*m rms]
    doubtful: tuple[str, ...]
    recordings: tuple[Measured, ...]
    left_out: tuple[dict[str, float], ...]      # numbers by their names, of each fold left out
    ripple: float = math.inf        # what waves of the motor may have at most [N*m motor]

    def without(self, recording: Measured, fifth: int) -> dict[str, float]:
        """Return numbers by their names that have not seen a recording, or a fifth of the only."""
        places = [place for place, one in enumerate(self.recordings) if one is recording]
        if not places:
            return {number.name: number.value for number in self.numbers}
        return self.left_out[fifth if len(self.recordings) == 1 else places[0]]


class Search(NamedTuple):
    """What a witness is asked: terms that are always there, others, and what must be gained."""

    always: tuple[Maker, ...]
    more: tuple[Maker, ...]
    worth: float            # share of the error left out, below which others have a place


def torsion_of(arm: Arm, recordings: Sequence[Measured]) -> WitnessFit | None:
    """Return the fit of a joint's torsion to recordings; None where none is believed."""
    recordings = [one for one in recordings if one.has_link]
    if not recordings:
        return None
    witness, varies = TorsionWitness(arm, recordings), _varies(recordings)
    if not witness.is_observed:
        return None
    bends = varies > BENDS and arm.joints[0].torsion.knee_1 == 0.0
    more = tuple(make for make in TORSION_MORE if make is not stiffening or bends)
    search = Search(TORSION, more, CLEARLY)

    def starts(problem: Referenced) -> list[Floats]:
        start = beginning(problem.terms, problem.beside)
        softer = start.copy()
        softer[0] = math.log(SOFTER) / float(problem.terms[0].deviations()[0])
        return [0.0 * start, start, softer]

    problem, found = _zeroed([_searched(_asked(arm, witness, search, varies, stays=stays), search,
                                        starts, varies) for stays in _may_stay(recordings)])
    return _fit_of(problem, found, 'link_encoder.zero', witness)


def motor_of(arm: Arm, recordings: Sequence[Measured], *,
             resting: bool = False) -> WitnessFit | None:
    """
    Return the fit of the motor to recordings; None where it has no torque, or stands.

    Where it is `resting`, friction that may hold either way counts as none, and by how much less
    it holds is found. Else only rows count in which the shaft slides; None where these are few.
    """
    recordings = [one for one in recordings if one.has_command]
    recordings = recordings if resting else sliding(recordings)
    if not recordings:
        return None
    witness, varies = MotorWitness(recordings, resting=resting), _varies(recordings)
    if witness.fastest <= STANDS:
        return None
    always = motor_always(witness.fastest, slides=witness.fastest > SLOWEST)
    search = Search(always, motor_more(), SLIGHTLY)

    def starts(problem: Referenced) -> list[Floats]:
        return [beginning(problem.terms, problem.beside)]

    def found_with(stays: bool) -> Fit:
        problem, found = _searched(_asked(arm, witness, search, varies, stays=stays), search,
                                   starts, varies)
        order = likely_order(witness.angle, found.rows.error)
        return _worthwhile(problem, found, search._replace(more=(cogging(order),)), varies)

    problem, found = _zeroed([found_with(stays) for stays in _may_stay(recordings)])
    fit = _fit_of(problem, found, OFFSET, witness)
    ripple = ripple_left(witness, arm, found.rows.error, fit.error)
    beside = math.sqrt(max(fit.deviation ** 2 - ripple.seen ** 2, 0.0))
    held = () if not resting else held_friction(
        witness, problem.on(found.scaled), left_out(problem, found))
    return replace(fit, numbers=(*fit.numbers, *held), ripple=ripple.size, deviation=beside)


def _may_stay(recordings: Sequence[Measured]) -> tuple[bool, ...]:
    """Return whether zeros stay, both where there are several recordings."""
    return (False, True) if len(recordings) > 1 else (False,)


def _asked(arm: Arm, witness: Witness, search: Search, varies: float, *,
           stays: bool) -> Referenced:
    return Referenced(arm, witness, tuple(make(arm, varies) for make in search.always),
                      witness.usual_zero, stays=stays)


def _searched(problem: Referenced, search: Search,
              starts: Callable[[Referenced], list[Floats]],
              varies: float) -> Fit:
    """Return the fit of all terms that are always there, and of those that earn their place."""
    problem, found = fitted(problem, starts(problem))
    return _worthwhile(problem, found, search, varies)


def _zeroed(fits: Sequence[Fit]) -> Fit:
    """
    Return the fit whose zeros move, or that with one zero if it predicts others better.

    Both are judged on recordings left out, with the zero that the others have in common. One zero
    must do hardly worse than zeros that follow, for another witness can show how they move. The
    terms of one are tried with the other as well: a search may find a disc with one alone.
    """
    if len(fits) == 1:
        return fits[0]
    moves, stays = (min((fit, _crossed(*other)), key=lambda each: error_left_out(*each))
                    for fit, other in (fits, fits[::-1]))
    one_zero = error_left_out(*stays)
    believed = (one_zero < BELIEVED * error_left_out(*moves, follows=False)
                and one_zero < FOLLOWED * error_left_out(*moves))
    return stays if believed else moves


def _crossed(problem: Referenced, found: Minimum) -> Fit:
    """Return the fit of the same terms whose zeros stay where they moved, or the other way."""
    other = replace(problem, stays=not problem.stays, spread=problem.witness.usual_zero)
    start = np.concatenate([found.scaled[:len(found.scaled) - problem.moving],
                            np.zeros(other.moving)])
    return fitted(other, [start])


def _varies(recordings: Sequence[Measured]) -> float:
    return rms(np.concatenate([one.reference - one.reference.mean() for one in recordings]))


def _worthwhile(problem: Referenced, found: Minimum, search: Search,
                varies: float) -> Fit:
    """
    Return the fit with all that lowers its error where it has not seen, the best first.

    What each would gain is seen by its slopes. Those that would are fitted, the best first. Of few
    rows all are: slopes do not see a torsion far from its best fit.
    """
    rest: list[Maker | None] = [*search.more, None]
    while True:
        best = error_left_out(problem, found)
        trials = [(make, _with(problem, found, make, varies)) for make in rest]
        hopeful = sorted(((error_left_out(*trial) / _worth(search, make), place)
                          for place, (make, trial) in enumerate(trials)))
        for promised, place in hopeful:
            make, (wider, start) = trials[place]
            few = len(found.rows.error) < PATIENT and search.worth == CLEARLY
            if promised * _worth(search, make) >= best and not few:
                continue
            fit = fitted(wider, [start.scaled, 0.0 * start.scaled], start.rows)
            if error_left_out(*fit) < _worth(search, make) * best and _may_be(*fit):
                problem, found = fit
                rest.remove(make)
                break
        else:
            return problem, found


def _worth(search: Search, make: Maker | None) -> float:
    """Return the share of an error below which a term has its place, or a lag: None."""
    return CLEARLY if make is None else search.worth


def _may_be(problem: Referenced, found: Minimum) -> bool:
    """Return whether a lag is none, or longer than a sample: below that, it is not observable."""
    return not problem.lags or problem.lag(found.scaled) > problem.witness.dt


def _with(problem: Referenced, found: Minimum, make: Maker | None,
          varies: float) -> Fit:
    """Return where a fit with one more term begins, or with a lag of the references: None."""
    if make is None:
        wider = replace(problem, lags=True)
    else:
        wider = replace(problem, terms=(*problem.terms, make(problem.arm, varies)))
    start = beginning(wider.terms, wider.beside)
    start[:found.unknowns] = found.scaled[:found.unknowns]
    if problem.moving:
        start[len(start) - problem.moving:] = found.scaled[len(found.scaled) - problem.moving:]
    if problem.lags:
        start[len(start) - wider.beside] = found.scaled[len(found.scaled) - problem.beside]
    elif wider.lags:
        start[len(start) - wider.beside] = _likely_lag(problem, found) / LAG
    rows = wider.rows(start, wider.error(start))
    return wider, Minimum(tuple(wider.terms), start, wider.prior, rows, found.noise)


def _likely_lag(problem: Referenced, found: Minimum) -> float:
    """
    Return the lag from which a search for it begins [s].

    The error of a shorter or longer lag has hills in between, where references swing faster than
    the lag is long. So lags are compared first, each with all else refitted at the slopes known.
    """
    on_time, lags = problem.witness.reference(0.0), LAG * np.linspace(0.0, FARTHEST, 31)

    def left(lag: float) -> float:
        error = found.rows.error + on_time - problem.witness.reference(lag)
        rows = replace(found.rows, error=error)
        return rms(rows.after(solved(rows, found.noise, found.scaled, found.prior)).error)
    return float(min(lags, key=left))


def _fit_of(problem: Referenced, found: Minimum, zero: str,
            witness: TorsionWitness | MotorWitness) -> WitnessFit:
    """Return what a fit gave; `zero` is the number that moves between recordings."""
    scaled, reference = found.scaled, witness.reference(0.0)
    given = witness.torque(problem.arm, np.zeros(0))    # as the arm was given
    ratio = problem.arm.joints[0].ratio if zero == OFFSET else 1.0
    spread = problem.spread / ratio if problem.moving else 0.0
    unsure = spread if len(witness.recordings) > 1 else _zero_known(problem.arm, zero)
    fitted_numbers = numbers(found, found.covariance())
    fitted, known = ([number(one.name, one.value, math.hypot(
        share * one.sigma, unsure if one.name == zero else 0.0)) for one in fitted_numbers]
        for share in (1.0, independent_share(problem, found)))
    before, varies = (_about_means(values, witness.blocks.recording)
                      for values in (given - reference, reference))
    error = error_left_out(problem, found)
    return WitnessFit(tuple(fitted), tuple(known), spread, problem.lag(scaled),
                      error, lawless(problem, found, error), _moved(problem, found), before,
                      varies,
                      doubtful(found), tuple(witness.recordings),
                      tuple(_numbers_without(problem, found, int(fold))
                            for fold in np.unique(found.rows.fold)))


def _zero_known(arm: Arm, zero: str) -> float:
    """Return how well a zero is known before: one recording does not show how far it moves."""
    known = arm.tolerances
    return known.drive_offset if zero == OFFSET else known.torsion_zero


def _numbers_without(problem: Referenced, found: Minimum, fold: int) -> dict[str, float]:
    """
    Return the numbers, by their names, of a fit that has not seen a fold.

    Of the step by slopes that share counts which fits best what was seen.
    """
    step, seen = step_without(problem, found, fold), found.rows.fold != fold
    places = np.clip(found.scaled + np.outer((1.0, *SHARES), step), *problem.bounds)
    best = min(places, key=lambda scaled: float(
        np.sum(problem.error(scaled)[seen] ** 2) / found.noise ** 2
        + found.prior @ scaled ** 2))
    return {name: value for term in placed(problem.terms, best)
            for name, value in term.numbers().items()}


def lawless(problem: Referenced, found: Minimum, error: float) -> float:
    """
    Return what is left of an error [N*m rms] by no number that the fit is unsure of.

    It is never less than what the fit leaves of what it has seen.
    """
    together, rows = _unsure(problem, found)[0], found.rows.error
    return math.sqrt(max(error ** 2 - together / len(rows), float(np.mean(rows ** 2))))


def independent_share(problem: Referenced, found: Minimum) -> float:
    """
    Return by which share numbers are better known where each is taken for independent.

    A fit may know numbers only together: a stiffness and a zero, where the torque hardly varies.
    The estimator takes their errors for independent. So it would find the torque far less sure
    than the fit is. The square of the share is E[s^T C s] / E[s^T diag(C) s].
    Here s (p,) are the slopes of a row, and C (p, p) is the covariance.
    """
    together, alone = _unsure(problem, found)
    return math.sqrt(min(together / max(alone, TINY), 1.0))


def _unsure(problem: Referenced, found: Minimum) -> tuple[float, float]:
    """Return the variances of all rows by unsure numbers, together and each for itself."""
    last = len(found.scaled) - problem.moving
    slopes, covariance = found.rows.slopes[:, :last], found.covariance()[:last, :last]
    together = float(np.sum((slopes @ covariance) * slopes))
    return max(together, 0.0), float(np.sum(slopes ** 2 @ np.diag(covariance)))


def _about_means(values: Floats, recording: Ints) -> float:
    """Return the rms of rows (m,) about the mean of each recording."""
    means = np.bincount(recording, values) / np.bincount(recording)
    return rms(values - means[recording])


def _moved(problem: Referenced, found: Minimum) -> float:
    """Return what a zero that is one spread off makes of the torque [N*m rms]."""
    if not problem.moving:
        return 0.0
    first = len(found.scaled) - problem.moving
    return rms(found.rows.slopes[:, first:].sum(axis=1))
