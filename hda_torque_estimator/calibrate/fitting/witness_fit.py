"""Fit torsion or motor to reference torques: which terms earn their place, and what is left."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
import math

from hda_arm_sim.model.arm import Arm
import numpy as np
from numpy.typing import NDArray

from .arm_numbers import doubtful, Number, number, numbers
from .motor_witness import MotorWitness
from .referenced_problem import error_left_out, fitted, LAG, likeliest, Referenced
from .referenced_terms import (cogging, likely_poles, Maker, MOTOR, motor_more, stiffening,
                               TORSION, TORSION_MORE)
from .torsion_witness import TorsionWitness
from ..passages.joint_recording import Measured
from ...least_squares.descent import beginning, Found
from ...least_squares.rows import rms, solved

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
TINY = np.finfo(float).tiny
# Choices unless told otherwise.
SOFTER = 0.2            # of the stiffness known, where a search begins as well
BENDS = 1.0             # deviation of a torque, from which a law can be seen to bend [N*m]
# (measured: for a joint of a real arm a true term made 0.52 N*m to 0.29, false ones 0.60 to 0.52)
FARTHEST = 6.0          # of what references lag before anything is known, longest first guess
CLEARLY = 0.8           # of the error on recordings left out, below which a term has its place


@dataclass(frozen=True)
class Heard:
    """What one witness of a joint tells."""

    numbers: tuple[Number, ...]
    known: tuple[Number, ...]   # the same, as well known as if they were independent
    spread: float           # of its zero over recordings [unit of the witness]
    lag: float              # of the references [s]
    error: float            # where the fit has not seen, zeros free to move as they do [N*m rms]
    offset: float           # deviation of the torque by its zero, of a recording not seen [N*m]
    before: float           # as the arm was given, every recording with a zero of its own [N*m]
    given: float            # as the arm was given, its zero as well [N*m rms]
    varies: float           # the reference as the witness's rows see it, about its means [N*m rms]
    doubtful: tuple[str, ...]
    arm: Arm                # of one joint, with these numbers

    @property
    def is_odd(self) -> bool:
        """Tell whether the motor would have to give another torque than any such motor does."""
        return 'torque_constant_error.error' in self.doubtful

    @property
    def whole_error(self) -> float:
        """Return the error of a recording not seen, its zero as unknown as it is [N*m rms]."""
        return math.hypot(self.error, self.offset)


def torsion_of(arm: Arm, recordings: Sequence[Measured]) -> Heard:
    """Return what the torsion of recordings that have both encoders tells of a joint."""
    witness, varies = TorsionWitness(recordings), _varies(recordings)
    problem = Referenced(arm, witness, tuple(make(arm, varies) for make in TORSION),
                         witness.usual_zero)
    start = beginning(problem.terms, problem.beside)
    softer = start.copy()
    softer[0] = math.log(SOFTER) / float(problem.terms[0].deviations()[0])
    problem, found = fitted(problem, [0.0 * start, start, softer])
    more = [make for make in TORSION_MORE if make is not stiffening or varies > BENDS]
    problem, found = _worthwhile(problem, found, more, varies)
    return _told(problem, found, 'link_encoder.zero', problem.witness.torque(arm, np.zeros(0)))


def motor_of(arm: Arm, recordings: Sequence[Measured]) -> Heard:
    """Return what the motor of recordings that have its torque tells of a joint."""
    witness, varies = MotorWitness(recordings), _varies(recordings)
    problem = Referenced(arm, witness, tuple(make(arm, varies) for make in MOTOR),
                         witness.usual_zero)
    problem, found = fitted(problem)
    problem, found = _worthwhile(problem, found, motor_more(witness.fastest), varies)
    order = likely_poles(witness.angle, found.rows.error)
    problem, found = _worthwhile(problem, found, [cogging(order)], varies)
    return _told(problem, found, 'drive_offset.offset', witness.torque(arm, np.zeros(0)))


def _varies(recordings: Sequence[Measured]) -> float:
    return rms(np.concatenate([one.reference - one.reference.mean() for one in recordings]))


def _worthwhile(problem: Referenced, found: Found, more: Sequence[Maker],
                varies: float) -> tuple[Referenced, Found]:
    """Return the fit with all that lowers its error where it has not seen, the best first."""
    best, rest = error_left_out(problem, found), [*more, None]
    while rest:
        trials = [_with(problem, found, make, varies) for make in rest]
        errors = [error_left_out(*trial) if _may_be(*trial) else math.inf for trial in trials]
        place = int(np.argmin(errors))
        if not earns_its_place(errors[place], best):
            break
        problem, found = fitted(trials[place][0], [trials[place][1].scaled])
        best = error_left_out(problem, found)
        rest.pop(place)
    return problem, found


def earns_its_place(error: float, before: float) -> bool:
    """Tell whether an error on recordings left out is clearly less than without [N*m]."""
    return error < CLEARLY * before


def _may_be(problem: Referenced, found: Found) -> bool:
    """Tell whether a lag is none, or longer than a sample: below that, nobody can tell it."""
    return not problem.lags or problem.lag(found.scaled) > problem.witness.dt


def _with(problem: Referenced, found: Found, make: Maker | None,
          varies: float) -> tuple[Referenced, Found]:
    """Return the fit with one more term, or with a lag of the references."""
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
    return wider, likeliest(wider, [start, 0.0 * start])


def _likely_lag(problem: Referenced, found: Found) -> float:
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


def _told(problem: Referenced, found: Found, zero: str, given: Floats) -> Heard:
    """
    Return what a fit tells; `zero` is the number that moves between recordings.

    `given` (m,) is the torque of the rows as the arm was given [N*m].
    """
    scaled, reference = found.scaled, problem.witness.reference(0.0)
    ratio = problem.arm.joints[0].ratio if zero == 'drive_offset.offset' else 1.0
    spread = problem.spread / ratio if problem.moving else 0.0
    fitted_numbers = numbers(found, found.covariance())
    told, known = ([number(one.name, one.value, math.hypot(
        share * one.sigma, spread if one.name == zero else 0.0)) for one in fitted_numbers]
        for share in (1.0, independent_share(problem, found)))
    before, varies = (_about_means(values, problem.witness.blocks.recording)
                      for values in (given - reference, reference))
    return Heard(tuple(told), tuple(known), spread, problem.lag(scaled),
                 error_left_out(problem, found),
                 _moved(problem, found), before, rms(given - reference), varies, doubtful(found),
                 problem.on(scaled))


def independent_share(problem: Referenced, found: Found) -> float:
    """
    Return by which share numbers are better known where each is taken for independent.

    A fit may know numbers only together: a stiffness and a zero, where the torque hardly varies.
    The estimator takes their errors for independent. So it would find the torque far less sure
    than the fit is. The square of the share is E[s^T C s] / E[s^T diag(C) s].
    Here s (p,) are the slopes of a row, and C (p, p) is the covariance.
    """
    last = len(found.scaled) - problem.moving
    slopes, covariance = found.rows.slopes[:, :last], found.covariance()[:last, :last]
    together = float(np.sum((slopes @ covariance) * slopes))
    alone = float(np.sum(slopes ** 2 @ np.diag(covariance)))
    return math.sqrt(min(max(together, 0.0) / max(alone, TINY), 1.0))


def _about_means(values: Floats, recording: Ints) -> float:
    """Return the rms of rows (m,) about the mean of each recording."""
    means = np.bincount(recording, values) / np.bincount(recording)
    return rms(values - means[recording])


def _moved(problem: Referenced, found: Found) -> float:
    """Return what a zero that is one spread off makes of the torque [N*m rms]."""
    if not problem.moving:
        return 0.0
    first = len(found.scaled) - problem.moving
    return rms(found.rows.slopes[:, first:].sum(axis=1))
