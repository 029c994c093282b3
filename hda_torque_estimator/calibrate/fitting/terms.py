"""
What can be found about a joint's torsion: each term a few unknowns, and how they enter the arm.

A term adds its unknowns to an arm of one joint. The unknowns are what a fit likes (the sine and
cosine parts of a wave). The numbers are what an arm file holds (its amplitude and phase).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
import math
from typing import cast, NamedTuple

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import (ClockSkew, Effect, KinematicError,
                                       LinkEncoderEccentricity, TorsionalHysteresis)
import numpy as np
from numpy.typing import NDArray

from .bounds import bounded, entered
from ..passages.passage import Passage

Floats = NDArray[np.float64]

# Choices unless told otherwise.
# One sigma of what is known of a strain-wave gear before it is measured.
# (source: Tuttle and Seering 1996, Ghorbel, Gandhi and Alpeter 2001)
WAVE = 1e-4                   # [rad], 0.3 to 1.5 arcmin from peak to peak
SKEW = 3e-4                     # [s], a bus cycle between the readings of two encoders
WIDTH = 1.5e-4                  # [rad], a loop of half an arcmin
DISC = 1e-3                     # [rad], a disc of 25 mm that sits 25 um off its axis
WIDEST_LOOP = 3.0               # times the deviation of the reference torque
WIDEST_FACTOR = math.log(50.0)   # of a stiffness over its nominal value, either way
LEAST_TOLERANCE = 1e-6  # relative, where the arm file states none
ORDERS = (1, 2)                 # per motor turn


class Unknown(NamedTuple):
    """One unknown: its value before, one sigma of that, where the search may begin and end."""

    nominal: float
    spread: float
    low: float
    high: float
    start: float


@dataclass(frozen=True)
class Term:
    """
    Some unknowns, and the numbers of the arm file that they make.

    Unknowns that only add to the torsion say by how much, which saves a fit most of its work.
    """

    unknowns: tuple[Unknown, ...]
    meant: Callable[[Floats], dict[str, float]]         # what values stand for, in bounds or not
    turns: Callable[[Passage], Floats] | None = None    # torsion (k, unknowns) for one of each

    def numbers(self, values: Floats) -> dict[str, float]:
        """Return the numbers that values of the unknowns make, all of which an arm can have."""
        return bounded(self.meant(values))

    def applied(self, arm: Arm, values: Floats) -> Arm:
        """Return an arm of one joint with values of the unknowns."""
        return entered(arm, arm.labels[0], self.numbers(values))


def stiffness(arm: Arm, reference_deviation: float) -> Term:
    """Return the stiffness of the flexspline; its logarithm is known to the arm's tolerance."""
    nominal = arm.joints[0].torsion.flexspline_stiffness
    spread = max(arm.tolerances.stiffness, LEAST_TOLERANCE)
    unknown = Unknown(0.0, spread, -WIDEST_FACTOR, WIDEST_FACTOR, 0.0)
    return Term((unknown,), lambda values: {
        'torsion.flexspline_stiffness': nominal * math.exp(values[0])})


def hysteresis(arm: Arm, reference_deviation: float) -> Term:
    """Return the loop of torque over torsion: its level and its width."""
    label = arm.labels[0]
    known = cast(TorsionalHysteresis, arm.effect('torsional_hysteresis', label))
    spread = WIDEST_LOOP * reference_deviation
    return Term(
        (Unknown(min(known.level, spread), spread, 0.0, spread, 0.4 * spread),
         Unknown(WIDTH, WIDTH, 0.13 * WIDTH, 6.0 * WIDTH, WIDTH)),
        lambda values: {'torsional_hysteresis.level': float(values[0]),
                        'torsional_hysteresis.width': float(values[1])})


def transmission(arm: Arm, reference_deviation: float) -> Term:
    """Return the kinematic error once and twice per motor turn, as sine and cosine parts."""
    return _waves(arm, KinematicError.name, ORDERS, WAVE, 40 * WAVE)


def skew(arm: Arm, reference_deviation: float) -> Term:
    """Return the time between the readings of both encoders."""
    label = arm.labels[0]
    known = cast(ClockSkew, arm.effect('clock_skew', label)).skew
    return Term((Unknown(known, SKEW, known - 5 * SKEW, known + 5 * SKEW, known),),
                lambda values: {'clock_skew.skew': float(values[0])})


def eccentricity(arm: Arm, reference_deviation: float) -> Term:
    """Return the disc of the link encoder off its axis, once per turn, as sine and cosine."""
    return _waves(arm, LinkEncoderEccentricity.name, (1,), DISC, 10 * DISC)


TERMS = (stiffness, hysteresis, transmission, skew)
OPTIONAL = (eccentricity,)      # where recordings left out of the fit get clearly better by it


def _waves(arm: Arm, name: str, orders: Sequence[int], sigma: float, reach: float) -> Term:
    """Return waves of an effect, each as the sine and cosine parts of its amplitude and phase."""
    known = arm.effect(name, arm.labels[0])

    def numbers(values: Floats) -> dict[str, float]:
        found = {}
        for order, (sine, cosine) in zip(orders, values.reshape(-1, 2)):
            found[f'{name}.amplitude_{order}'] = math.hypot(sine, cosine)
            found[f'{name}.phase_{order}'] = math.atan2(cosine, sine)
        return found

    parts = [part for order in orders for part in _parts(known, order)]
    return Term(tuple(Unknown(part, sigma, part - reach, part + reach, part) for part in parts),
                numbers)


def _parts(known: Effect, order: int) -> tuple[float, float]:
    amplitude, phase = getattr(known, f'amplitude_{order}'), getattr(known, f'phase_{order}')
    return amplitude * math.cos(phase), amplitude * math.sin(phase)
