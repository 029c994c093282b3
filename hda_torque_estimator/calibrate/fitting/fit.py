"""Find the unknowns of a joint: the estimator itself, with trial values, against references."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.torsion import stiffness_at
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from .terms import Term
from ..passages.measured import Measured
from ...estimating.estimator import Estimator
from ...samples.readings import LINK_READING

Floats = NDArray[np.float64]

# Choices unless told otherwise.
ROUNDS = 2                  # of fitting with the noise that the last round has left
FIRST_NOISE = 0.15          # of the reference's deviation, until a round has shown the noise
ZERO_ITERATIONS = 8     # to the zero of a recording, at most
ZERO_ACCURACY = 1e-6    # of that zero, at which they end


class Balanced(NamedTuple):
    """A recording with a zero of its own: error of the torque (k,) [N*m], link zero [rad]."""

    error: Floats
    zero: float


@dataclass(frozen=True)
class Fit:
    """Values of all unknowns (m,), their covariance (m, m), and how each recording is met."""

    values: Floats
    covariance: Floats
    moved: Floats                       # from the nominal values, in sigmas of what was known
    balanced: tuple[Balanced, ...]


def balanced(estimator: Estimator, recording: Measured, zero: float = 0.0) -> Balanced:
    """
    Return the error of the estimate with the zero at which its mean vanishes, searched from one.

    Every recording has its own zero: encoders lose it between recordings, and a reference sensor
    has one too.
    """
    joint = estimator.arm.joints[0]
    law = joint.torsion.record(joint.ratio)
    slope = stiffness_at(law, joint.ratio, float(recording.reference.mean()))
    for _ in range(ZERO_ITERATIONS):
        error = error_with(estimator, recording, zero)
        offset = float(error.mean())
        if abs(offset) <= ZERO_ACCURACY * recording.varies():
            break
        zero -= offset / slope
    return Balanced(error, zero)


def error_with(estimator: Estimator, recording: Measured, zero: float) -> Floats:
    """Return the error of the estimate with a zero of the link encoder (k,) [N*m]."""
    readings = recording.readings.copy()
    readings[:, 0, LINK_READING] -= zero
    estimator.reset()
    return estimator.run(recording.stamps, readings).torque[:, 0] - recording.reference


def rms(parts: Sequence[Balanced]) -> float:
    """Return the root mean square of the error over all recordings [N*m]."""
    return float(np.sqrt(np.mean(np.concatenate([part.error for part in parts]) ** 2)))


def applied(arm: Arm, terms: Sequence[Term], values: Floats) -> Arm:
    """Return the arm of one joint with the values of all terms."""
    first = 0
    for term in terms:
        last = first + len(term.unknowns)
        arm, first = term.applied(arm, values[first:last]), last
    return arm


def fit(arm: Arm, terms: Sequence[Term], recordings: Sequence[Measured]) -> Fit:
    """
    Return the most likely values: least squares against the references and the prior of each.

    The noise is what the fit itself leaves, counted once per correlation time: errors of torque
    follow each other. So neighbouring samples are not independent witnesses.
    """
    unknowns = [unknown for term in terms for unknown in term.unknowns]
    nominal, spread, low, high, start = np.array(unknowns).T
    noise = FIRST_NOISE * float(np.mean([recording.varies() for recording in recordings]))
    parts = tuple(balanced(Estimator(arm), recording) for recording in recordings)
    candidates: Sequence[Floats] = (nominal, start)

    def residuals(scaled: Floats) -> Floats:
        trial = Estimator(applied(arm, terms, nominal + spread * scaled))
        errors = [error_with(trial, recording, part.zero)
                  for recording, part in zip(recordings, parts)]
        return np.concatenate([*((error - error.mean()) / noise for error in errors), scaled])

    bounds = (low - nominal) / spread, (high - nominal) / spread
    for _ in range(ROUNDS):
        inside = [np.clip((candidate - nominal) / spread, bounds[0] + 1e-6, bounds[1] - 1e-6)
                  for candidate in candidates]
        best = min((least_squares(residuals, scaled, bounds=bounds, x_scale='jac')
                    for scaled in inside), key=lambda solution: solution.cost)
        values = nominal + spread * best.x
        found = Estimator(applied(arm, terms, values))
        parts = tuple(balanced(found, recording, part.zero)
                      for recording, part in zip(recordings, parts))
        noise, candidates = _noise(parts), (values,)
    slopes = np.asarray(best.jac)
    covariance = np.linalg.pinv(slopes.T @ slopes, hermitian=True) * np.outer(spread, spread)
    return Fit(values, covariance, best.x, parts)


def _noise(parts: Sequence[Balanced]) -> float:
    """Return the deviation that a sample has if its neighbours told nothing new [N*m]."""
    times = [_correlation_time(part.error) for part in parts]
    return rms(parts) * float(np.sqrt(np.mean(times)))


def _correlation_time(error: Floats) -> float:
    """Return the integrated correlation time in samples, summed until correlation is lost."""
    size = 1 << (2 * len(error) - 1).bit_length()
    power = np.abs(np.fft.rfft(error - error.mean(), size)) ** 2
    correlation = np.fft.irfft(power, size)[:len(error)]
    correlation = correlation / max(correlation[0], np.finfo(float).tiny)
    lost = np.flatnonzero(correlation <= 0.0)
    return float(1.0 + 2.0 * correlation[1:lost[0] if lost.size else None].sum())
