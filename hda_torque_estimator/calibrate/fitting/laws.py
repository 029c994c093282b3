"""
What ordinary recordings can find about a joint, as terms: torsion law, loop, skew and waves.

A calibration looks for these because the arm file is not trusted. What is known before is what
each effect declares of joints that nobody has measured, or the arm's tolerance where that is
larger.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects.catalogue import known_as, unmeasured_at, usual_at
from hda_arm_sim.model.effects.place import (CLOCK, GEAR, LOOP, Place, STIFFENING, STIFFNESS,
                                             TRANSMISSION, WIND_UP)
from hda_arm_sim.model.torsion import TorsionLaw
import numpy as np
from numpy.typing import NDArray

from ..passages.passage import Passage
from ...least_squares.bounds import bounded
from ...least_squares.charts import Chart, Chords, Identity, Logarithm, WaveParts
from ...least_squares.term import Term

Floats = NDArray[np.float64]
# Choices unless stated otherwise.
# (source: valid torque of the shipped arm, docs/model.md)
USUAL_TORQUE = 37.0     # valid torque of the law for which a loop's level is stated [N*m]
NAMED = (1.0, 2.0, 4.0)         # orders per motor turn that have a name of their own
FURTHER = ('a', 'b', 'c', 'd')
WIDEST = 4.0            # of any scatter, either way
SAME = 1e-6             # of an order
SEGMENTS = ('flexspline_stiffness', 'second_stiffness', 'third_stiffness')
BENT = ('knee_1', 'second_stiffness', 'knee_2', 'third_stiffness')

WAVE = usual_at(TRANSMISSION).sigma['amplitude']
_GEAR, _DISC, _SKEW = unmeasured_at(TRANSMISSION), known_as('eccentricity'), unmeasured_at(CLOCK)


def stiffness(arm: Arm) -> Term:
    """Return the stiffness of the flexspline at zero torque, of segments all stiffnesses."""
    law = arm.joints[0].torsion
    spread = max(usual_at(STIFFNESS).sigma['error'], arm.tolerances.stiffness)
    if law.knee_1 > 0.0:
        return _of_law(arm, chords_of(law, spread, WIDEST * spread))
    return _of_law(arm, _size(law, 'flexspline_stiffness', spread))


def chords_of(law: TorsionLaw, spread: float, reach: float) -> Chords:
    """Return the stiffnesses of straight segments, about those that a law has."""
    names = SEGMENTS if law.knee_2 > 0.0 else SEGMENTS[:2]
    return Chords(names, spread, spread, -reach, reach,
                  about=tuple(getattr(law, name) for name in names))


def curvature(arm: Arm) -> Term:
    """Return how the flexspline stiffens with torque; zero stays zero."""
    nominal = arm.joints[0].torsion.flexspline_curvature
    spread = usual_at(STIFFENING).sigma['error'] * nominal
    return _of_law(arm, Identity(('flexspline_curvature',), spread, spread, 0.0,
                                 nominal + WIDEST * spread))


def segments(arm: Arm, largest: float) -> Term:
    """
    Return three straight segments in the place of the tangent law, for torques up to `largest`.

    They begin as chords of the tangent law between a quarter and half of the largest torque.
    """
    law = arm.joints[0].torsion
    knees = np.array([0.25, 0.5]) * largest
    middles = np.array([0.375, 0.75]) * largest
    chords = law.flexspline_stiffness * (1.0 + (law.flexspline_curvature * middles) ** 2)
    start = replace(law, **bounded(TorsionLaw, {
        'knee_1': knees[0], 'second_stiffness': chords[0],
        'knee_2': knees[1], 'third_stiffness': chords[1]}))
    usual = usual_at(STIFFENING).sigma
    return _of_law(replace(arm, joints=(replace(arm.joints[0], torsion=start),)),
                   *(_size(start, name, usual[name]) for name in BENT))


def soft_wind_up(arm: Arm) -> Term:
    """Return the stiffness of the wave generator near zero torque."""
    return _of_law(arm, _size(arm.joints[0].torsion, 'wave_generator_stiffness',
                              usual_at(WIND_UP).sigma['compliance']))


def _size(owner: Any, name: str, spread: float, low: float = WIDEST,
          high: float = WIDEST) -> Logarithm:
    """Return a size by its logarithm, about the value that it has."""
    return Logarithm((name,), spread, spread, -low * spread, high * spread,
                     about=getattr(owner, name))


def _of_law(arm: Arm, *charts: Chart) -> Term:
    """Return numbers of the torsion law as a term."""
    return Term(arm.joints[0].torsion, arm.labels[0], charts, 'torsion',
                tuple(name for chart in charts for name in chart.names))


def damping(arm: Arm) -> Term:
    """Return the damping of the torsion."""
    known, usual = _present(arm, GEAR), usual_at(GEAR)
    spread = usual.sigma['coefficient'] * max(known.coefficient, usual.usual['coefficient'])
    return Term(known, arm.labels[0], (Identity(('coefficient',), spread, spread, 0.0,
                                                known.coefficient + WIDEST * spread),))


def loop(arm: Arm) -> Term:
    """Return the hysteresis: torque of the saturated loop, and its width in torsion."""
    known, usual = _present(arm, LOOP), usual_at(LOOP)
    if known.level == 0.0:
        known = replace(known, width=usual.usual['width'])
    spread = usual.sigma['level'] * max(arm.joints[0].torsion.valid_torque / USUAL_TORQUE, 1.0)
    level = Identity(('level',), spread, spread, 0.0, known.level + WIDEST * spread,
                     max(known.level, 0.2 * spread))
    width = _size(known, 'width', usual.sigma['width'], 2.0, 3.0)
    return Term(known, arm.labels[0], (level, width))


def skew(arm: Arm) -> Term:
    """Return the time between the readings of both encoders."""
    known, spread = _present(arm, CLOCK), usual_at(CLOCK).sigma['skew']
    return Term(known, arm.labels[0],
                (Identity(('skew',), spread, spread, known.skew - 20 * spread,
                          known.skew + 20 * spread),))


def _present(arm: Arm, place: Place) -> Any:
    """Return what the only joint of an arm has of the effect that is looked for at a place."""
    return arm.effect(unmeasured_at(place).name, arm.labels[0])


def waves(arm: Arm, orders: Sequence[float]) -> list[Term]:
    """
    Return the errors that repeat with these orders, per motor turn, each as a term.

    Once and twice per link turn are laid to the disc of the link encoder, all others to the gear.
    For the torque it is one. Orders without a name of their own take the free places.
    """
    return [_wave(arm, place, order)
            for place, order in zip(_places(orders, arm.joints[0].ratio), orders)]


def _wave(arm: Arm, place: str, order: float) -> Term:
    owner, name = place.split('.')
    names, effect = (f'amplitude_{name}', f'phase_{name}'), arm.effect(owner, arm.labels[0])
    own: tuple[str, ...] = names
    if name in FURTHER:
        effect, own = replace(effect, **{f'order_{name}': order}), (f'order_{name}', *names)
    chart = WaveParts(names, WAVE, WAVE, -40 * WAVE, 40 * WAVE)
    return Term(effect, arm.labels[0], (chart,), own=own)


def without_waves(arm: Arm) -> Arm:
    """Return the arm without the waves that are looked for from nothing on."""
    return arm.without(_GEAR.name, arm.labels[0]).without(_DISC.name, arm.labels[0])


def turns(term: Term) -> bool:
    """Return whether a term only adds to the torsion, which saves a fit most of its work."""
    return term.name in (_SKEW.name, _GEAR.name, _DISC.name)


def turning(term: Term, passage: Passage, ratio: float) -> Floats:
    """Return the torsion (k, p) for one of each unknown of a term that adds to it."""
    if term.name == _SKEW.name:
        return passage.link_rate[:, None]
    return wave_columns(passage, [_order(term, names[0].removeprefix('amplitude_'), ratio)
                                  for names in term.waves])


def _order(term: Term, name: str, ratio: float) -> float:
    """Return the order of a wave, per motor turn."""
    if term.name == _DISC.name:
        return float(name) / ratio
    return float(getattr(term.effect, f'order_{name}')) if name in FURTHER else float(name)


def wave_columns(passage: Passage, orders: Sequence[float]) -> Floats:
    """Return the sine and the cosine of every order along a passage (k, 2 m)."""
    angle = passage.readings[:, 0, 0]
    return np.stack([part(order * angle) for order in orders for part in (np.sin, np.cos)]
                    or [angle], axis=1)[:, :2 * len(orders)]


def _places(orders: Sequence[float], ratio: float) -> list[str]:
    """Return where the amplitude and phase of each order stand: effect.suffix."""
    free = iter(FURTHER)
    return [f'{_DISC.name}.{round(order * ratio)}'
            if is_of_disc(order, ratio) else
            f'{_GEAR.name}.{round(order) if is_named(order) else next(free)}'
            for order in orders]


def is_named(order: float) -> bool:
    """Return whether an order per motor turn has a place of its own in the transmission error."""
    return any(abs(order - named) < SAME for named in NAMED)


def is_of_disc(order: float, ratio: float) -> bool:
    """Return whether an order per motor turn is once or twice per turn of the link."""
    return any(abs(order * ratio - turns) < SAME * ratio for turns in (1.0, 2.0))
