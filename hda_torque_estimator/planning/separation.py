"""
How well a motion separates two effects: what is left when the wrong one explains it.

An arm with one effect is simulated along the motion and diagnosed twice: with the effect that it
has, and with the other one. Each is fitted with all that may differ within tolerances. The
difference of the scores is twice the logarithm of the odds. Either arm is asked; the weaker answer
counts. To be seen, an effect must be better than none by what a diagnosis asks.
"""

from dataclasses import replace
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.kernel import LINK_ANGLE, MOTOR_VELOCITY
from hda_arm_sim.motions import Motion
import numpy as np
from numpy.typing import NDArray

from .question import Question, Suspect
from ..diagnosis.assumptions import EFFECTIVE
from ..diagnosis.balances.balance import Balancer
from ..diagnosis.fitting.derivatives import IMPOSSIBLE
from ..diagnosis.fitting.fit import Fit, Fitter
from ..diagnosis.fitting.hypotheses import terms_of
from ..diagnosis.judging.screening import screen
from ..measurements.measurement import Measurement
from ..measurements.running_clock import inside, stretches
from ..simulating.closed_loop import ClosedLoopRun, run

# Choices unless stated otherwise.
SEED = 7                # of the encoders' noise in simulations
USED = 0.95             # of each limit, at most: an arm with an effect may need more


class Load(NamedTuple):
    """The largest share (n,) of each limit that a motion takes from a healthy arm."""

    angle: Array
    velocity: Array
    torque: Array

    @property
    def largest(self) -> float:
        """Return the largest share of all."""
        return float(np.max(self))


class Strength(NamedTuple):
    """
    Scores by which the wrong effect, or none, is worse, on the arms with one suspect each.

    It may lack some: one that is weak already decides.
    """

    scores: tuple[float, ...]

    @property
    def least(self) -> float:
        """Return the one that counts."""
        return min(self.scores)


def load_of(arm: Arm, made: ClosedLoopRun) -> Load:
    """Return what a run takes of an arm's limits."""
    low, high = arm.ranges().T
    velocity, torque = np.array([[joint.velocity_limit, joint.torque_limit]
                                 for joint in arm.joints]).T
    used = ((made.state[:, :, LINK_ANGLE] - 0.5 * (low + high), 0.5 * (high - low)),
            (made.state[:, :, MOTOR_VELOCITY], velocity), (made.command, torque))
    return Load(*(np.abs(part).max(axis=0) / limit for part, limit in used))


def separation(asked: Question, motion: Motion, healthy: ClosedLoopRun,
               least: float = -1.0) -> Strength:
    """
    Return how strongly a motion separates or shows suspects; `healthy` is a run without any.

    Those after one that it separates by no more than `least` are not tried.
    """
    plain = Balancer(_measured(asked.arm, healthy))(asked.arm)
    noise = np.array([column[valid].std() if valid.any() else 1.0
                      for column, valid in zip(plain.residual.T, plain.valid.T)])
    scores: list[float] = []
    for has in asked.suspects:
        blamed = next(other for other in asked.suspects if other is not has) \
            if asked.between else None
        scores.append(_gap(asked.arm, motion, noise, has, blamed))
        if scores[-1] <= least:
            break
    return Strength(tuple(scores))


def _gap(arm: Arm, motion: Motion, noise: Array, has: Suspect, blamed: Suspect | None) -> float:
    """Return by how much blaming another suspect, or none, is worse; 0 where it is no worse."""
    measurement = _measured(arm, run(has.on(arm), arm, motion, SEED, estimator=None))
    balancer = Balancer(measurement)
    fitter = Fitter(balancer, arm, noise, EFFECTIVE,
                    _training(balancer.time, measurement.duration))
    neither = fitter.fit(())
    wrong = neither.score if blamed is None else _wrong(fitter, neither, blamed)
    return max(wrong - _right(fitter, neither, has), 0.0)


def _right(fitter: Fitter, neither: Fit, has: Suspect) -> float:
    """Return the score of the effect that the arm has, fitted from the truth."""
    start = next(term for term in terms_of(fitter.arm, has.effect.name)
                 if term.joint == has.joint)
    return fitter.refined(fitter.refit(neither, replace(start, effect=has.effect))).score


def _wrong(fitter: Fitter, neither: Fit, blamed: Suspect) -> float:
    """Return the best score of the effect that the arm does not have, of any size."""
    scores = [neither.score]
    for prospect in screen(fitter, neither, [blamed.effect.name]):
        if prospect.term.joint == blamed.joint:
            try:
                scores.append(fitter.refined(fitter.refit(neither, prospect.term)).score)
            except IMPOSSIBLE:
                continue
    return min(scores)


def _measured(arm: Arm, made: ClosedLoopRun) -> Measurement:
    return Measurement(arm.labels, float(made.time[1] - made.time[0]),
                       np.ascontiguousarray(made.reading[:, :, :2]), made.command)


def _training(time: Array, duration: float) -> NDArray[np.bool_]:
    """Return the rows that the fits of a diagnosis would see (m,)."""
    return inside(time, stretches(duration)[0])
