"""
What the rig of the experiments may have had: causes by name, with sizes from the literature.

Nothing here was fitted to the paper's errors: each size lies within what `docs/model.md` gives
for gears, encoders and electronics of this class.
"""

from collections.abc import Iterable
from typing import NamedTuple

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import (Backlash, ClockSkew, Effect, EncoderInterpolationError,
                                       KinematicError, LinkEncoderEccentricity,
                                       MotorEncoderEccentricity, StiffeningError, StiffnessError,
                                       TorsionalHysteresis, WaveGeneratorCompliance)

from .printed import CATALOGUE, PRINTED


class Imperfection(NamedTuple):
    """One named cause: its size in words, and the effects of the product that make it."""

    name: str
    size: str
    effects: tuple[Effect, ...]


CAUSES = (
    Imperfection('kinematic error', '0.9 arcmin from peak to peak', (KinematicError(
        amplitude_1=2.0e-5, amplitude_2=1.1e-4, amplitude_4=1.5e-5, phase_2=0.7),)),
    Imperfection('eccentric scale', '2 um on a disc of 50 mm, 0.5 um oval', (
        LinkEncoderEccentricity(amplitude_1=8.0e-5, amplitude_2=2.0e-5, phase_1=0.9),)),
    Imperfection('eccentric motor encoder', '4 mrad at the shaft', (MotorEncoderEccentricity(
        amplitude=4.0e-3, phase=2.0),)),
    Imperfection('skew of the clocks', '0.1 ms', (ClockSkew(skew=1.0e-4),)),
    Imperfection('torsion law', 'the gear as in the catalogue', (
        StiffnessError(error=CATALOGUE.first_stiffness / PRINTED.tangent_stiffness - 1.0),
        StiffeningError(knee_1=CATALOGUE.knee_1, second_stiffness=CATALOGUE.second_stiffness,
                        knee_2=CATALOGUE.knee_2, third_stiffness=CATALOGUE.third_stiffness),
        WaveGeneratorCompliance(compliance=-1.0 / PRINTED.wave_generator_stiffness))),
    Imperfection('hysteresis', '0.8 N*m, half an arcmin', (TorsionalHysteresis(
        level=0.8, width=1.5e-4),)),
    Imperfection('backlash', '1 um at 25 mm, either way', (Backlash(half_width=4.0e-5),)),
    Imperfection('interpolation of the scale', '120 nm', (EncoderInterpolationError(
        amplitude=5.0e-6, lines=3927.0),)),
)


SUSPECTED = 'backlash'               # by the paper; not needed to explain its errors
TOGETHER = tuple(cause for cause in CAUSES if cause.name != SUSPECTED)


def imperfect(arm: Arm, causes: Iterable[Imperfection]) -> Arm:
    """Return a single axis with some causes."""
    for cause in causes:
        for effect in cause.effects:
            arm = arm.with_effect(effect, arm.labels[0])
    return arm
