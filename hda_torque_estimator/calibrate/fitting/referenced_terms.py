"""
What recordings with reference torques can find about a joint, without anything known of its links.

Torsion and motor have terms that are always looked for, and terms that must earn their place where
a fit has not seen.
"""

from collections.abc import Callable
from dataclasses import replace
import math
from typing import Any

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import Effect
from hda_arm_sim.model.effects.catalogue import (known_as, orders_at, tried_orders, unmeasured_at,
                                                 usual_at)
from hda_arm_sim.model.effects.place import (BREAKAWAY, CLOCK, DRY_LEVEL, LOOP, MESH,
                                             MOTOR_INERTIA, TRANSMISSION, TURN)
import numpy as np
from numpy.typing import NDArray

from .laws import chords_of
from ...least_squares.charts import Chart, Factor, Identity, Logarithm, WaveParts
from ...least_squares.term import Term

# Choices unless stated otherwise.
# References alone leave more to a fit, so what effects declare of joints that nobody has measured
# counts in part. (measured: with all of it a real joint was off by 0.22 N*m with offset, not 0.10)
WAVES = 1.0 / 3.0               # share of the waves of a gear
SKEW = 0.6                      # share of the skew of two encoders
# One sigma of what no effect declares.
# (measured: 7e-3 rad on a joint of two real arms each, with all that bends as a disc does)
DISC = 3e-3                     # [rad], a disc of 25 mm that sits 75 um off its axis
ZERO = 0.01                     # [rad], half a degree
RIPPLE = 0.05                   # of the usual motor torque
WIDEST_LOOP = 3.0               # times the deviation of the reference torque
WIDEST_FACTOR = math.log(50.0)   # of a stiffness over its nominal value, either way
# (measured: a joint of a real arm has a quarter of its gear's stiffness, another a tenth)
YIELDS = 0.5                    # of a stiffness, for bearings and links in series
STIFFENS = 0.5                  # of the torque at which a spring is twice as stiff, the other way
LEAST_TOLERANCE = 1e-6  # relative, where the arm file states none

Floats = NDArray[np.float64]
Maker = Callable[[Arm, float], Term]


def _effect(arm: Arm, kind: type[Effect], *charts: Chart, **values: float) -> Term:
    """Return the term of an effect as the arm has it, but for some values; it owns its charts."""
    own = (*values, *(name for chart in charts for name in chart.names if name not in values))
    present: Any = arm.effect(kind.name, arm.labels[0])
    return Term(replace(present, **values), arm.labels[0], charts, own=own)


def stiffness(arm: Arm, varies: float) -> Term:
    """Return the stiffness of the flexspline, with all that yields behind it."""
    law = arm.joints[0].torsion
    spread = max(arm.tolerances.stiffness, YIELDS)
    if law.knee_1 > 0.0:
        chords = chords_of(law, spread, WIDEST_FACTOR)
        return Term(law, arm.labels[0], (chords,), 'torsion', chords.names)
    chart = Logarithm(('flexspline_stiffness',), spread, spread, -WIDEST_FACTOR, WIDEST_FACTOR,
                      about=law.flexspline_stiffness)
    return Term(law, arm.labels[0], (chart,), 'torsion', chart.names)


def hysteresis(arm: Arm, varies: float) -> Term:
    """Return the loop of torque over torsion: its level and its width."""
    kind, width = unmeasured_at(LOOP), usual_at(LOOP).usual['width']
    known: Any = arm.effect(kind.name, arm.labels[0])
    spread = WIDEST_LOOP * varies
    return _effect(arm, kind, Identity(('level',), spread, spread, 0.0, spread, 0.4 * spread),
                   Identity(('width',), width, width, 0.13 * width, 6.0 * width),
                   level=min(known.level, spread), width=width)


def waves_of_motor(arm: Arm, varies: float) -> Term:
    """Return the kinematic error once and twice per motor turn."""
    return _of_gear(arm, '1', '2')


def skew(arm: Arm, varies: float) -> Term:
    """Return the time between the readings of both encoders."""
    kind, spread = unmeasured_at(CLOCK), SKEW * usual_at(CLOCK).sigma['skew']
    known: Any = arm.effect(kind.name, arm.labels[0])
    return _effect(arm, kind, Identity(('skew',), spread, spread, known.skew - 5 * spread,
                                       known.skew + 5 * spread))


def zero(arm: Arm, varies: float) -> Term:
    """Return the zero of the link encoder that recordings have in common."""
    return Term(arm.joints[0].link_encoder, arm.labels[0], (Identity(('zero',), ZERO, ZERO),),
                'link_encoder', ('zero',))


def disc(arm: Arm, varies: float) -> Term:
    """Return the disc of the link encoder off its axis, once per turn."""
    return _effect(arm, known_as('eccentricity'), _wave('1', DISC, 10 * DISC))


def fourth_wave(arm: Arm, varies: float) -> Term:
    """Return the kinematic error four times per motor turn."""
    return _of_gear(arm, '4')


def _of_gear(arm: Arm, *orders: str) -> Term:
    """Return waves of the kinematic error, by their orders per motor turn."""
    size = WAVES * usual_at(TRANSMISSION).sigma['amplitude']
    return _effect(arm, unmeasured_at(TRANSMISSION), *(
        _wave(order, size, 40 * size) for order in orders))


def stiffening(arm: Arm, varies: float) -> Term:
    """Return how the flexspline stiffens with torque."""
    law, spread = arm.joints[0].torsion, STIFFENS / max(varies, LEAST_TOLERANCE)
    chart = Identity(('flexspline_curvature',), spread, spread, 0.0, 4.0 * spread,
                     max(law.flexspline_curvature, 0.5 * spread))
    return Term(law, arm.labels[0], (chart,), 'torsion', chart.names)


def _wave(name: str, sigma: float, reach: float) -> WaveParts:
    """Return a wave of an effect, which may go so far from nothing."""
    return WaveParts((f'amplitude_{name}', f'phase_{name}'), sigma, sigma, -reach, reach)


def constant(arm: Arm, varies: float) -> Term:
    """Return the error of the motor's torque constant."""
    kind = known_as('torque_constant')
    assert kind.unmeasured is not None
    spread = max(kind.unmeasured.sigma['error'], arm.tolerances.torque_constant)
    return _effect(arm, kind, Factor(('error',), spread, spread, -2.0, 1.0))


def dry(arm: Arm, varies: float) -> Term:
    """Return the level of dry friction."""
    return _effect(arm, known_as('dry_friction'), _friction(arm, 'level', varies))


def offset(arm: Arm, varies: float) -> Term:
    """Return the torque that the drive gives at zero command."""
    spread = varies / arm.joints[0].ratio
    return _effect(arm, known_as('drive_offset'), Identity(('offset',), spread, spread))


def _friction(arm: Arm, name: str, varies: float, per: float = 1.0) -> Identity:
    """Return a number of friction of which nothing is known but the torque of the joint."""
    spread = varies / arm.joints[0].ratio / per
    return Identity((name,), spread, spread, 0.0)


def viscous(fastest: float) -> Maker:
    """Return how viscous friction is looked for where the shaft turns so fast [rad/s]."""
    return lambda arm, varies: _effect(arm, known_as('viscous_friction'),
                                       _friction(arm, 'slope', varies, fastest))


def of_load(arm: Arm, varies: float) -> Term:
    """Return the loss of the mesh."""
    spread = usual_at(MESH).sigma['coefficient']
    return _effect(arm, unmeasured_at(MESH), Identity(('coefficient',), spread, spread, 0.0))


def near_rest(arm: Arm, varies: float) -> Term:
    """Return the friction that falls with speed."""
    spread, speed = usual_at(BREAKAWAY).sigma['speed'], usual_at(BREAKAWAY).usual['speed']
    return _effect(arm, unmeasured_at(BREAKAWAY), replace(
        _friction(arm, 'excess', varies), start=0.2 * varies / arm.joints[0].ratio),
        Logarithm(('speed',), spread, spread, -3.0, 2.0, about=speed), speed=speed)


def one_sided(arm: Arm, varies: float) -> Term:
    """Return the share by which friction is larger one way."""
    spread = usual_at(DRY_LEVEL).sigma['asymmetry']
    return _effect(arm, unmeasured_at(DRY_LEVEL), Identity(('asymmetry',), spread, spread))


def inertia(arm: Arm, varies: float) -> Term:
    """Return the error of the motor's inertia."""
    spread = usual_at(MOTOR_INERTIA).sigma['error']
    return _effect(arm, unmeasured_at(MOTOR_INERTIA),
                   Factor(('error',), spread, spread, -2.0, 1.7))


def ripple(name: str) -> Maker:
    """Return how a ripple of order 2 or 4 is looked for."""
    return lambda arm, varies: _effect(arm, known_as('torque_ripple'), _wave(
        name, _rippling(arm, varies), 40.0 * _rippling(arm, varies)))


def cogging(order: float) -> Maker:
    """Return how a cogging of an order per motor turn is looked for."""
    return lambda arm, varies: _effect(
        arm, orders_at(TURN), WaveParts(('amplitude', 'phase'), _rippling(arm, varies),
                                        _rippling(arm, varies)), order=order)


def _rippling(arm: Arm, varies: float) -> float:
    return RIPPLE * varies / arm.joints[0].ratio


TORSION: tuple[Maker, ...] = (stiffness, hysteresis, waves_of_motor, skew, zero)
TORSION_MORE: tuple[Maker, ...] = (disc, stiffening, fourth_wave)


def motor_always(fastest: float, *, slides: bool) -> tuple[Maker, ...]:
    """
    Return what is always looked for at a motor whose shaft turns so fast [rad/s].

    One that is not seen to slide tells no slope over speed: it would be used at speeds a hundred
    times as high.
    """
    slope = (viscous(fastest),) if slides else ()
    return constant, dry, offset, *slope, of_load


def motor_more() -> tuple[Maker, ...]:
    """Return what must earn its place at a motor."""
    return near_rest, one_sided, inertia, ripple('2'), ripple('4')


def likely_order(angle: Floats, rest: Floats) -> float:
    """Return the order of cogging of which a rest (m,) at shaft angles (m,) has most."""
    return max(tried_orders(TURN), key=lambda order: abs(np.exp(-1j * order * angle) @ rest))
