"""
What ordinary recordings can find about a joint, as terms: torsion law, loop, skew and waves.

A calibration looks for these because the arm file is not trusted. What is known before is the
scatter of such gears, or the arm's tolerance where that is larger.
"""

from collections.abc import Callable, Sequence
import math
from typing import cast

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import (ClockSkew, KinematicError, LinkEncoderEccentricity,
                                       StructuralDamping, TorsionalHysteresis)
import numpy as np
from numpy.typing import NDArray

from .bounds import APART
from .terms import Term, Unknown
from ..passages.passage import Passage

Floats = NDArray[np.float64]
# Choices unless told otherwise.
STIFFNESS = 0.25        # scatter of a stiffness, on its logarithm
CURVATURE = 0.5         # scatter of the stiffening, of its nominal value
KNEE, CHORD = 0.3, 0.3  # scatter of knees and of the stiffness beyond, on their logarithms
SOFTNESS = 0.5          # scatter of the soft wind-up, on its logarithm
LEVEL = 1.5             # scatter of a loop's torque on a joint of the usual torque [N*m]
# (source: valid torque of the shipped arm, docs/model.md)
USUAL_TORQUE = 37.0     # valid torque of the law for which that is stated [N*m]
WIDTH = 0.7             # scatter of a loop's width, on its logarithm
USUAL_WIDTH = 1.5e-4    # width of a loop, about half an arcmin [rad]
SKEW = 5e-4             # scatter of the time between both encoders [s]
DAMPING = 0.5           # scatter of the damping, of its nominal value
LEAST_DAMPING = 4.0     # scatter of the damping at least [N*m*s/rad]
WAVE = 3e-4             # [rad], half a micrometre of disc and a quarter of the worst gear error
NAMED = (1.0, 2.0, 4.0)         # orders per motor turn that have a name of their own
FURTHER = ('a', 'b', 'c', 'd')
WIDEST = 4.0            # of any scatter, either way
SAME = 1e-6             # of an order


def stiffness(arm: Arm) -> Term:
    """Return the stiffness of the flexspline at zero torque."""
    law = arm.joints[0].torsion
    spread = max(STIFFNESS, arm.tolerances.stiffness)
    return _of_law('flexspline_stiffness', _logarithm(spread),
                   lambda value: law.flexspline_stiffness * math.exp(value))


def curvature(arm: Arm) -> Term:
    """Return how the flexspline stiffens with torque; zero stays zero."""
    nominal = arm.joints[0].torsion.flexspline_curvature
    unknown = Unknown(1.0, CURVATURE, 0.0, 1.0 + WIDEST * CURVATURE, 1.0)
    return _of_law('flexspline_curvature', unknown, lambda value: nominal * value)


def segments(arm: Arm, largest: float) -> Term:
    """
    Return three straight segments in the place of the tangent law, for torques up to `largest`.

    They begin as chords of the tangent law between a quarter and half of the largest torque.
    """
    law = arm.joints[0].torsion
    knees = np.array([0.25, 0.5]) * largest
    middles = np.array([0.375, 0.75]) * largest
    chords = law.flexspline_stiffness * (1.0 + (law.flexspline_curvature * middles) ** 2)
    names = ('knee_1', 'second_stiffness', 'knee_2', 'third_stiffness')
    first = np.array([knees[0], chords[0], knees[1], chords[1]])

    def numbers(values: Floats) -> dict[str, float]:
        found = first * np.exp(values)
        found[2] = max(found[2], APART * found[0])
        return {f'torsion.{name}': float(value) for name, value in zip(names, found)}

    return Term(tuple(_logarithm(spread) for spread in (KNEE, CHORD, KNEE, CHORD)), numbers)


def soft_wind_up(arm: Arm) -> Term:
    """Return the stiffness of the wave generator near zero torque."""
    law = arm.joints[0].torsion
    return _of_law('wave_generator_stiffness', _logarithm(SOFTNESS),
                   lambda value: law.wave_generator_stiffness * math.exp(value))


def _logarithm(spread: float) -> Unknown:
    return Unknown(0.0, spread, -WIDEST * spread, WIDEST * spread, 0.0)


def _of_law(name: str, unknown: Unknown, number: Callable[[float], float]) -> Term:
    """Return a number of the torsion law as a term."""
    return Term((unknown,), lambda values: {f'torsion.{name}': number(float(values[0]))})


def damping(arm: Arm) -> Term:
    """Return the damping of the torsion."""
    known = cast(StructuralDamping, arm.effect(StructuralDamping.name, arm.labels[0])).coefficient
    spread = DAMPING * max(known, LEAST_DAMPING)
    return Term((Unknown(known, spread, 0.0, known + WIDEST * spread, known),),
                lambda values: {'structural_damping.coefficient': float(values[0])})


def loop(arm: Arm) -> Term:
    """Return the hysteresis: torque of the saturated loop, and its width in torsion."""
    known = cast(TorsionalHysteresis, arm.effect(TorsionalHysteresis.name, arm.labels[0]))
    width = known.width if known.level > 0.0 else USUAL_WIDTH
    spread = LEVEL * max(arm.joints[0].torsion.valid_torque / USUAL_TORQUE, 1.0)

    def numbers(values: Floats) -> dict[str, float]:
        return {'torsional_hysteresis.level': float(values[0]),
                'torsional_hysteresis.width': width * math.exp(values[1])}

    return Term((Unknown(known.level, spread, 0.0, known.level + WIDEST * spread,
                         max(known.level, 0.2 * spread)),
                 Unknown(0.0, WIDTH, -2.0 * WIDTH, 3.0 * WIDTH, 0.0)), numbers)


def skew(arm: Arm) -> Term:
    """Return the time between the readings of both encoders."""
    known = cast(ClockSkew, arm.effect(ClockSkew.name, arm.labels[0])).skew
    return Term((Unknown(known, SKEW, known - 20 * SKEW, known + 20 * SKEW, known),),
                lambda values: {'clock_skew.skew': float(values[0])},
                lambda passage: passage.link_rate[:, None])


def waves(arm: Arm, orders: Sequence[float]) -> Term:
    """
    Return the errors that repeat with these orders, per motor turn, as sine and cosine parts.

    Once and twice per link turn are laid to the disc of the link encoder, all others to the gear.
    For the torque it is one. Orders without a name of their own take the free places.
    """
    places = _places(orders, arm.joints[0].ratio)

    def numbers(values: Floats) -> dict[str, float]:
        found: dict[str, float] = {}
        for place, order, (sine, cosine) in zip(places, orders, values.reshape(-1, 2)):
            owner, name = place.split('.')
            if name in FURTHER:
                found[f'{owner}.order_{name}'] = order
            found[f'{owner}.amplitude_{name}'] = math.hypot(sine, cosine)
            found[f'{owner}.phase_{name}'] = math.atan2(cosine, sine)
        return found

    return Term(tuple(Unknown(0.0, WAVE, -40 * WAVE, 40 * WAVE, 0.0)
                      for _ in range(2 * len(orders))), numbers,
                lambda passage: wave_columns(passage, orders))


def wave_columns(passage: Passage, orders: Sequence[float]) -> Floats:
    """Return the sine and the cosine of every order along a passage (k, 2 m)."""
    angle = passage.readings[:, 0, 0]
    return np.stack([part(order * angle) for order in orders for part in (np.sin, np.cos)]
                    or [angle], axis=1)[:, :2 * len(orders)]


def _places(orders: Sequence[float], ratio: float) -> list[str]:
    """Return where the amplitude and phase of each order stand: effect.suffix."""
    free = iter(FURTHER)
    return [f'{LinkEncoderEccentricity.name}.{round(order * ratio)}'
            if is_of_disc(order, ratio) else
            f'{KinematicError.name}.{round(order) if is_named(order) else next(free)}'
            for order in orders]


def is_named(order: float) -> bool:
    """Tell whether an order per motor turn has a place of its own in the transmission error."""
    return any(abs(order - named) < SAME for named in NAMED)


def is_of_disc(order: float, ratio: float) -> bool:
    """Tell whether an order per motor turn is once or twice per turn of the link."""
    return any(abs(order * ratio - turns) < SAME * ratio for turns in (1.0, 2.0))
