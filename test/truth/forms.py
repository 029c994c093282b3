"""
The forms of law that an effect can have besides the one of README.md, and which are held out.

A form is a code for the compiled law of its effect and two numbers of its own. Forms that are
held out are drawn in the final study only: nothing is developed or tuned against them.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from . import drive, encoders, friction, gear, links, plant, recording, torsion
from .effect import angle, between, Draw, Hidden, one_of, TruthError

NONE = one_of(0.0)              # a number that a form does not have


class Form(NamedTuple):
    """One form of law: its name, code, numbers, and whether only the final study draws it."""

    name: str
    code: int
    first: Draw = NONE
    second: Draw = NONE
    held_out: bool = False
    also: tuple[str, ...] = ()  # effects that name such a law as well


def held(name: str, code: int, first: Draw = NONE, second: Draw = NONE,
         also: tuple[str, ...] = ()) -> Form:
    """Return a form that only the final study draws."""
    return Form(name, code, first, second, True, also)


def share(low: float, high: float) -> Draw:
    """Return a draw of a share, uniform between two."""
    return between((low, high))


_F, _D, _G, _L, _E = friction, drive, gear, links, encoders
FORMS: Mapping[str, tuple[Form, ...]] = {
    'coulomb_friction': (
        Form('smooth', _F.SMOOTH, share(0.005, 0.03)), held('dahl', _F.DAHL)),
    'viscous_friction': (
        Form('thinning', _F.THINNING, share(6.0, 12.0)),
        held('thickening', _F.THICKENING, share(0.02, 0.06))),
    'nonlinear_viscous_friction': (
        Form('saturating', _F.SATURATING, share(0.1, 0.5)),
        Form('cubic', _F.CUBIC, share(0.15, 0.4)),
        held('arctan', _F.ARCTAN, share(0.1, 0.4)),
        held('table', _F.TABLE, share(0.45, 0.7), share(1.2, 1.6))),
    'stribeck_friction': (
        Form('tustin', _F.TUSTIN), Form('power', _F.POWER, share(0.6, 1.5)),
        Form('with_load', _F.WITH_LOAD, share(0.2, 0.6)),
        Form('one_way', _F.ONE_WAY, between((-0.5, -0.2), (0.2, 0.5))),
        held('hess_soom', _F.HESS_SOOM), held('rising', _F.RISING, share(0.7, 1.0))),
    'presliding_friction': (
        Form('lugre', _F.LUGRE), Form('dahl', _F.BRISTLE_DAHL), held('bouc_wen', _F.BOUC_WEN)),
    'asymmetric_friction': (
        Form('viscous_too', _F.VISCOUS_TOO), held('fading', _F.FADING, share(1.0, 4.0))),
    'load_dependent_friction': (
        Form('threshold', _F.THRESHOLD, share(0.05, 0.3)), Form('square', _F.SQUARE),
        held('driven', _F.DRIVEN, share(0.3, 0.7))),
    'thermal_viscosity': (Form('losses', _F.LOSSES),
                          held('two_constants', _F.TWO_CONSTANTS)),
    'position_dependent_friction': (
        Form('two_orders', _F.TWO_ORDERS, share(0.2, 0.6), angle()),
        held('bump', _F.BUMP, share(-0.3, 0.3), share(0.08, 0.2))),
    'link_bearing_friction': (
        Form('wide', _F.WIDE, share(8.0, 25.0)),
        held('stribeck', _F.BEARING_STRIBECK, share(0.2, 0.6), share(0.1, 0.4))),
    'torque_ripple': (
        Form('with_torque', _D.WITH_TORQUE, share(0.0, 0.5)),
        held('more_orders', _D.MORE_ORDERS, share(0.2, 0.5), angle())),
    'motor_cogging': (
        Form('two_orders', _D.TWO_ORDERS, share(0.2, 0.5), angle()),
        held('peaked', _D.PEAKED, share(0.2, 0.4))),
    'torque_constant_error': (
        Form('iron', _D.IRON, share(0.1, 0.4)),
        held('warm_magnet', _D.WARM_MAGNET, share(10.0, 30.0))),
    'drive_offset': (
        Form('warming', _D.WARMING, share(10.0, 30.0)),
        held('wandering', _D.WANDERING, share(0.2, 0.5), share(15.0, 40.0))),
    'current_loop_lag': (
        Form('second_order', _D.SECOND_ORDER, share(0.5, 1.0), also=('command_delay',)),
        held('two_lags', _D.TWO_LAGS, share(0.2, 0.5), also=('command_delay',))),
    'command_delay': (
        Form('jitter', _D.JITTER, share(0.3, 0.9)), held('slowing', _D.SLOWING, share(0.1, 0.4))),
    'torque_saturation': (
        Form('soft', _D.SOFT), Form('knee', _D.KNEE, share(4.0, 10.0)),
        held('falling', _D.FALLING, share(0.05, 0.15))),
    'motor_inertia_error': (
        Form('oldham', plant.OLDHAM, share(0.2, 0.6)),
        held('dragged_disc', plant.DRAGGED_DISC, share(0.001, 0.003))),
    'stiffness_error': (
        Form('whole', torsion.WHOLE), held('in_series', torsion.IN_SERIES)),
    'stiffening_error': (
        Form('cubic', torsion.CUBIC), held('blended', torsion.BLENDED)),
    'wave_generator_compliance': (
        Form('tanh', torsion.TANH, share(0.7, 1.4)), held('band', torsion.BAND, share(0.6, 1.2))),
    'torsional_hysteresis': (
        Form('dahl', _G.DAHL), Form('power', _G.POWER), held('bouc_wen', _G.BOUC_WEN)),
    'structural_damping': (
        Form('with_torsion', _G.WITH_TORSION, share(0.6, 1.2)),
        held('hysteretic', _G.HYSTERETIC, share(10.0, 30.0))),
    'backlash': (
        Form('off_centre', _G.OFF_CENTRE, between((-0.8, -0.3), (0.3, 0.8))),
        Form('rounded', _G.ROUNDED, share(0.2, 0.5)),
        held('soft_walls', _G.SOFT_WALLS, share(0.04, 0.12))),
    'kinematic_error': (
        Form('more_orders', _G.MORE_ORDERS, share(0.2, 0.5), angle()),
        held('beating', _G.BEATING, share(0.2, 0.5), angle())),
    'loaded_kinematic_error': (
        Form('signed', _G.SIGNED), held('levelling', _G.LEVELLING, share(1.0, 4.0))),
    'bearing_crosstalk': (
        Form('steepening', _E.STEEPENING, share(0.2, 0.6)),
        held('levelling', _E.LEVELLING, share(0.2, 0.5))),
    'link_encoder_eccentricity': (
        Form('third_order', _E.THIRD_ORDER, share(0.1, 0.4), angle()),
        held('dent', _E.DENT, share(0.1, 0.4), share(-0.3, 0.3))),
    'motor_encoder_eccentricity': (
        Form('two_orders', _E.TWO_ORDERS, share(0.2, 0.5), angle()),
        Form('fourth_order', _E.FOURTH_ORDER, share(0.1, 0.3), angle()),
        held('peaked', _E.PEAKED, share(0.2, 0.6))),
    'encoder_scale_error': (
        Form('warming', _E.WARMING, share(10.0, 30.0)),
        held('curved', _E.CURVED, share(0.1, 0.4))),
    'encoder_interpolation_error': (
        Form('third_harmonic', _E.THIRD_HARMONIC, share(0.1, 0.4), angle()),
        held('quadrature', _E.QUADRATURE, share(0.2, 0.6), angle())),
    'coarse_quantisation': (
        Form('uneven', _E.UNEVEN, NONE, share(0.1, 0.4)),
        held('missing_codes', _E.MISSING_CODES, one_of(4, 8, 16))),
    'clock_skew': (
        Form('unsteady', _E.UNSTEADY, share(0.05, 0.2)),
        held('drifting', _E.DRIFTING, share(0.2, 0.6))),
    'dropped_samples': (
        Form('bursts', recording.BURSTS), held('right_stamps', recording.RIGHT_STAMPS)),
    'clock_jitter': (
        Form('sampled', recording.SAMPLED), held('busy', recording.BUSY)),
    'payload': (
        Form('own_inertia', _L.OWN_INERTIA, share(0.2, 0.6)),
        held('short', _L.SHORT, share(0.5, 0.9))),
    'link_inertia_error': (
        Form('mass', _L.MASS, also=('payload',)), held('coupling', _L.COUPLING)),
    'inertial_coupling': (
        Form('partial', _L.PARTIAL, share(0.4, 0.8)), held('balanced', _L.BALANCED)),
    'base_tilt': (
        Form('sinking', _L.SINKING, share(0.1, 0.4)),
        held('flexing', _L.FLEXING, share(0.1, 0.3))),
    'cable_spring': (
        Form('progressive', _L.PROGRESSIVE, share(0.1, 0.5)),
        held('kinked', _L.KINKED, share(0.2, 0.6))),
    'external_contact': (
        Form('half_sine', _L.HALF_SINE), Form('trapezoid', _L.TRAPEZOID),
        Form('several', _L.SEVERAL, share(5.0, 10.0), one_of(2, 3)), held('impact', _L.IMPACT)),
    'base_vibration': (
        Form('overdamped', _L.OVERDAMPED, share(0.7, 2.0)),
        held('hard_spring', _L.HARD_SPRING, share(0.001, 0.003))),
}


def forms_of(effect: str, *, final: bool) -> tuple[Form, ...]:
    """Return the forms that a study draws: all in the final one, else those not held out."""
    return tuple(form for form in FORMS.get(effect, ()) if final or not form.held_out)


def formed(hidden: Hidden, form: str, rng: np.random.Generator) -> Hidden:
    """Return an effect whose law has another form; raises TruthError if there is none so named."""
    for one in FORMS.get(hidden.effect, ()):
        if one.name == form:
            numbers = hidden.parameters
            return replace(hidden, form=form, law=(
                float(one.code), one.first(rng, numbers), one.second(rng, numbers)))
    names = ', '.join(one.name for one in FORMS.get(hidden.effect, ()))
    raise TruthError(
        f'{hidden.effect} has the forms {names or "of README.md alone"}, got {form!r}')
