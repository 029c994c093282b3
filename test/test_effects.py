"""What holds for every effect of the catalogue, and what holds for each law."""

from dataclasses import replace
import inspect

from hda_arm_sim.foundation.compiled import Record
from hda_arm_sim.foundation.parameter import ParameterError
from hda_arm_sim.foundation.rigid import Inertia
from hda_arm_sim.model.arm import Arm, ArmError
from hda_arm_sim.model.effects import (Backlash, BaseVibration, Effect, effect_named, EFFECTS,
                                       effects_of, KinematicError, PreslidingFriction, Scope,
                                       Site, TorsionalHysteresis)
from hda_arm_sim.model.effects.catalogue import effects_at
from hda_arm_sim.model.effects.place import Bent, DRAG, STAMP, Turned
from hda_arm_sim.model.effects.transmission import LoadedKinematicError
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.model.kernel import growth
from hda_arm_sim.model.motor_side import drag
from hda_arm_sim.model.typical_sizes import SIZED, typical
from hda_arm_sim.motions import motion
from hda_arm_sim.plant import Plant
from hda_arm_sim.simulate import rest
from hda_arm_sim.stamping import Stamper
from hda_torque_estimator.estimating.laws.torsion_torque import torque_through_gear
from hypothesis import given, strategies as st
import numpy as np
import pytest

MOTOR, TORSION, LINK, TIMING, SENSING = Site
JOINT, ARM = Scope

# Names that bags, reports and arm files carry: they stay, and others may come.
CATALOGUE = {
    'coulomb_friction': (JOINT, MOTOR), 'viscous_friction': (JOINT, MOTOR),
    'nonlinear_viscous_friction': (JOINT, MOTOR), 'stribeck_friction': (JOINT, MOTOR),
    'presliding_friction': (JOINT, MOTOR), 'asymmetric_friction': (JOINT, MOTOR),
    'load_dependent_friction': (JOINT, MOTOR), 'thermal_viscosity': (JOINT, MOTOR),
    'position_dependent_friction': (JOINT, MOTOR), 'torque_ripple': (JOINT, MOTOR),
    'motor_cogging': (JOINT, MOTOR), 'torque_constant_error': (JOINT, MOTOR),
    'drive_offset': (JOINT, MOTOR), 'current_loop_lag': (JOINT, MOTOR),
    'command_delay': (JOINT, MOTOR), 'torque_saturation': (JOINT, MOTOR),
    'motor_inertia_error': (JOINT, MOTOR), 'stiffness_error': (JOINT, TORSION),
    'stiffening_error': (JOINT, TORSION), 'wave_generator_compliance': (JOINT, TORSION),
    'torsional_hysteresis': (JOINT, TORSION), 'structural_damping': (JOINT, TORSION),
    'backlash': (JOINT, TORSION), 'kinematic_error': (JOINT, TORSION),
    'link_encoder_eccentricity': (JOINT, TORSION), 'motor_encoder_eccentricity': (JOINT, TORSION),
    'encoder_scale_error': (JOINT, TORSION), 'encoder_interpolation_error': (JOINT, SENSING),
    'coarse_quantisation': (JOINT, SENSING), 'clock_skew': (JOINT, TIMING),
    'dropped_samples': (ARM, TIMING), 'clock_jitter': (ARM, TIMING),
    'link_bearing_friction': (JOINT, LINK),
    'payload': (ARM, LINK), 'link_inertia_error': (JOINT, LINK), 'inertial_coupling': (ARM, LINK),
    'base_tilt': (ARM, LINK), 'cable_spring': (JOINT, LINK), 'external_contact': (ARM, LINK),
    'base_vibration': (ARM, LINK), 'bearing_crosstalk': (JOINT, TORSION)}

# A size that a recording shows, where it is not the typical one.
SIZES: dict[str, dict[str, float]] = {
    'coulomb_friction': {'level': 0.05}, 'viscous_friction': {'slope': 2e-4},
    'nonlinear_viscous_friction': {'coefficient': 0.002}, 'stribeck_friction': {'excess': 0.02},
    'presliding_friction': {'stiffness': 3.0, 'damping': 0.01},
    'asymmetric_friction': {'asymmetry': 0.3}, 'load_dependent_friction': {'coefficient': 0.2},
    'thermal_viscosity': {'amplitude': 2e-4, 'time_constant': 20.0},
    'position_dependent_friction': {'amplitude': 0.4, 'order': 3.0},
    'torque_ripple': {'amplitude_2': 0.008, 'amplitude_4': 0.003},
    'motor_cogging': {'amplitude': 0.006}, 'torque_constant_error': {'error': 0.08},
    'drive_offset': {'offset': 0.01}, 'current_loop_lag': {'time_constant': 0.004},
    'command_delay': {'delay': 0.0023}, 'torque_saturation': {'limit': 0.06},
    'motor_inertia_error': {'error': 0.2}, 'stiffness_error': {'error': 0.15},
    'stiffening_error': {'error': 0.5}, 'wave_generator_compliance': {'compliance': 0.3},
    'torsional_hysteresis': {'level': 1.0}, 'structural_damping': {'coefficient': 30.0},
    'backlash': {'half_width': 1e-4}, 'kinematic_error': {'amplitude_2': 1e-4},
    'link_encoder_eccentricity': {'amplitude_1': 2e-4, 'amplitude_2': 1e-4},
    'motor_encoder_eccentricity': {'amplitude': 0.01}, 'encoder_scale_error': {'error': 3e-4},
    'encoder_interpolation_error': {'amplitude': 1e-5, 'lines': 5000.0},
    'coarse_quantisation': {'motor_step': 0.006, 'link_step': 1e-5},
    'clock_skew': {'skew': 2e-4}, 'dropped_samples': {'rate': 0.02},
    'clock_jitter': {'jitter': 1e-4},
    'link_bearing_friction': {'level': 1.0}, 'payload': {'mass': 1.0},
    'link_inertia_error': {'error': 0.1}, 'inertial_coupling': {'share': -1.0},
    'base_tilt': {'tilt': 0.03, 'direction': 1.0},
    'cable_spring': {'stiffness': 1.0, 'rest_angle': -0.5},
    'external_contact': {'force': 20.0, 'onset': 0.2, 'duration': 0.5},
    'base_vibration': {'amplitude': 0.02}, 'bearing_crosstalk': {'coefficient': 1e-5}}

# An arm none of whose own numbers is an effect of the catalogue.
HEALTHY = read_arm('hda_arm.yaml')
BARE = replace(HEALTHY, joints=tuple(
    replace(joint, dry_friction=0.0, viscous_friction=0.0, torque_limit=1e4,
            torsion=replace(joint.torsion, damping=0.0),
            motor_encoder=replace(joint.motor_encoder, counts=0.0),
            link_encoder=replace(joint.link_encoder, counts=0.0)) for joint in HEALTHY.joints))
KINDS = pytest.mark.parametrize('kind', EFFECTS, ids=lambda kind: kind.name)


def sized(kind: type[Effect]) -> Effect:
    """Return an effect of a size that shows."""
    if kind.name in SIZES:
        return kind(**SIZES[kind.name])
    return typical(BARE, kind.name, place(kind))


def place(kind: type[Effect]) -> str | None:
    """Return where an effect is put: the first joint, or the arm."""
    return None if kind.scope is ARM else 'joint1'


def trace(arm: Arm) -> tuple[np.ndarray, np.ndarray]:
    """Return readings and true states of an arm that is driven for 0.8 s."""
    path = motion('rich', 2, 2.0, 1e-3, 3)
    plant = Plant(arm, rest(arm, path.angle[0]), 1e-3, 5)
    readings, states = [], []
    for k in range(800):
        readings.append(plant.sample().copy())
        states.append(plant.state)
        swing = np.sin(np.array([0.011, 0.017]) * k)
        plant.advance(0.1 * swing, np.array([0.0, 5.0 * swing[0]]))
    return np.array(readings), np.array(states)


BARE_TRACE, HEALTHY_TRACE = trace(BARE), trace(HEALTHY)


def signals(kind: type[Effect], random: np.random.Generator, size: int) -> dict[str, object]:
    """Return random signals of the place of an effect, arrays where they vary over time."""
    values = {name: random.uniform(0.1, 1.0, size) for name in kind.place.reads._fields}
    known = {'sense': np.sign(random.uniform(-1.0, 1.0, size)),
             'inertia': Inertia(0.876, 0.25, 0.18, 2.925, 1.2, 1.0),
             'length1': 0.15, 'length2': 0.15}
    return {name: known.get(name, value) for name, value in values.items()}


def test_names_that_users_know_stay_what_they_are():
    found = {kind.name: (kind.scope, kind.site) for kind in EFFECTS}
    assert CATALOGUE.items() <= found.items()
    assert len(EFFECTS) == len(found)
    assert {*effects_of(JOINT), *effects_of(ARM)} == set(EFFECTS)


def test_every_effect_has_a_size_here_or_a_typical_one():
    assert {kind.name for kind in EFFECTS} - set(SIZES) <= set(SIZED)


def test_an_unknown_name_is_answered_with_the_valid_ones():
    with pytest.raises(ParameterError, match=r"no effect is named 'rust'; valid names: coulomb"):
        effect_named('rust')


@KINDS
def test_neutral_does_nothing_to_the_bit(kind):
    readings, states = trace(BARE.with_effect(kind(), place(kind)))
    np.testing.assert_array_equal(readings, BARE_TRACE[0])
    np.testing.assert_array_equal(states, BARE_TRACE[1])


@KINDS
def test_effect_shows_in_what_the_encoders_say_or_in_their_stamps(kind):
    arm = HEALTHY.with_effect(sized(kind), place(kind))
    readings, _ = trace(arm)
    assert np.isfinite(readings[1:]).all()
    change = np.abs(readings - HEALTHY_TRACE[0])[1:, :, :2]
    taken = 1_000_000 * np.arange(len(readings))
    late = Stamper(arm, 5)(taken) - taken
    assert (change.max() > 1e-6, late.max() > 1000) == (
        kind.place is not STAMP, kind.place is STAMP)


@KINDS
def test_effects_of_the_senses_leave_the_arm_alone(kind):
    _, states = trace(HEALTHY.with_effect(sized(kind), place(kind)))
    senses = kind.site in (TIMING, SENSING) or kind.name in (
        'link_encoder_eccentricity', 'motor_encoder_eccentricity', 'encoder_scale_error',
        'bearing_crosstalk')
    assert np.array_equal(states, HEALTHY_TRACE[1]) == senses


@KINDS
def test_effects_of_one_joint_leave_the_other_joints_motor_alone_at_first(kind):
    if kind.scope is JOINT:
        _, states = trace(HEALTHY.with_effect(sized(kind), 'joint2'))
        np.testing.assert_array_equal(states[:2, 0, 0], HEALTHY_TRACE[1][:2, 0, 0])


@KINDS
def test_law_reads_its_own_record_and_the_signals_of_its_place(kind):
    own, at = inspect.signature(kind.law.py_func).parameters.values()
    assert (own.name, own.annotation) == ('own', Record)
    assert (at.name, at.annotation) == ('at', kind.place.reads)
    assert set(kind.acts) <= {rule.name for rule in kind.declarations()}


@KINDS
def test_effect_does_nothing_unless_a_number_of_those_that_act_is_not_zero(kind):
    neutral = kind()
    assert all(getattr(neutral, name) == 0.0 for name in kind.acts)


@given(st.floats(-50.0, 50.0), st.floats(0.0, 200.0))
def test_effects_of_a_place_add_up(angle, velocity):
    arm = HEALTHY.with_effect(sized(effect_named('thermal_viscosity')), 'joint1')
    arm = arm.with_effect(sized(effect_named('nonlinear_viscous_friction')), 'joint1')
    placed = [arm.effect(kind.name, 'joint1') for kind in effects_at(DRAG)]
    assert len(placed) == 3
    assert drag(arm.record().joints[0], velocity, angle) == pytest.approx(sum(
        effect(motor_velocity=velocity, time=angle) for effect in placed), rel=1e-12)


@KINDS
def test_law_takes_scalars_and_arrays_alike(kind):
    effect = sized(kind)
    many = signals(kind, np.random.default_rng(7), 6)
    at_once = effect(**many)
    for i in range(6):
        single = effect(**{name: value[i] if isinstance(value, np.ndarray) else value
                           for name, value in many.items()})
        if isinstance(single, tuple):
            for alone, together in zip(single, at_once):
                assert alone == pytest.approx(np.broadcast_to(together, 6)[i], rel=1e-14)
        else:
            assert single == pytest.approx(np.broadcast_to(at_once, 6)[i], rel=1e-14)


@KINDS
def test_every_parameter_is_declared_with_sense(kind):
    assert kind.declarations()
    assert kind.cause and not kind.cause.endswith('.')
    for rule in kind.declarations():
        assert rule.low <= rule.default <= rule.high
        assert rule.meaning
        for bad in (np.nan, rule.low - 1.0, 'high'):
            with pytest.raises(ParameterError, match=f'{kind.name}.{rule.name} must'):
                kind(**{rule.name: bad})


@KINDS
def test_placing_and_removing_an_effect(kind):
    effect, where = sized(kind), place(kind)
    arm = HEALTHY.with_effect(effect, where)
    assert arm.effect(kind.name, where) == effect
    assert arm.with_effect(kind(), where).effect(kind.name, where) == kind()
    assert arm.without(kind.name, where) == HEALTHY
    wrong = 'joint1' if where is None else None
    with pytest.raises(ArmError, match=kind.name):
        HEALTHY.with_effect(effect, wrong)


@KINDS
def test_the_nominal_effect_put_in_the_list_changes_nothing(kind):
    where = place(kind)
    _, states = trace(HEALTHY.with_effect(HEALTHY.effect(kind.name, where), where))
    np.testing.assert_array_equal(states, HEALTHY_TRACE[1])


ODD = ('viscous_friction', 'nonlinear_viscous_friction', 'thermal_viscosity', 'structural_damping')
BUDGETS = ('coulomb_friction', 'stribeck_friction', 'load_dependent_friction',
           'link_bearing_friction')


@pytest.mark.parametrize('name', ODD)
@given(st.floats(0.0, 1e3))
def test_drag_is_odd_and_takes_power(name, speed):
    effect = sized(effect_named(name))
    rate = 'torsion_rate' if name == 'structural_damping' else 'motor_velocity'
    forth, back = effect(**{rate: speed}), effect(**{rate: -speed})
    assert forth == -back
    assert forth * speed >= 0.0


@pytest.mark.parametrize('name', BUDGETS)
@given(st.floats(-1e3, 1e3), st.floats(-100.0, 100.0))
def test_dry_friction_is_a_budget(name, speed, torque):
    effect = sized(effect_named(name))
    at = {} if name == 'link_bearing_friction' else {
        'motor_velocity': speed, 'joint_torque': torque}
    assert effect(**at) >= 0.0


@given(st.floats(-0.95, 0.95), st.floats(0.0, 1.0), st.sampled_from([-1.0, 0.0, 1.0]),
       st.floats(-7.0, 7.0))
def test_variations_of_a_budget_leave_a_budget(share, budget, sense, angle):
    at = {'budget': budget, 'sense': sense, 'link_angle': angle}
    assert budget + effect_named('asymmetric_friction')(asymmetry=share)(**at) >= 0.0
    assert budget + effect_named('position_dependent_friction')(amplitude=abs(share))(**at) >= 0.0


@given(st.integers(0, 3), st.floats(-1.0, 1.0), st.floats(-1e-3, 1e-3))
def test_hysteresis_gives_back_no_more_than_it_took(place, share, change):
    own = TorsionalHysteresis(width=1e-4).record()
    reach = TorsionalHysteresis.law_after(own, 0.0, 1.0, place)
    before, after = share * reach, TorsionalHysteresis.law_after(own, share * reach, change, place)
    slides = change - (after - before)
    assert after * slides >= -1e-18                 # what slides is lost, never won
    assert abs(after) <= reach


@given(st.floats(-200.0, 200.0), st.floats(-1.2, 1.2), st.floats(0.01, 0.1))
def test_bristles_give_back_no_more_than_they_took(speed, bend, budget):
    state = bend * budget / 3.0
    own = PreslidingFriction(stiffness=3.0).record()
    rate = PreslidingFriction.law_rate(own, Bent(speed, state, 0.0, budget))
    stored = 3.0 * state * rate
    slides = abs(speed) * 3.0 / budget > 2000.0     # then the bristles are not followed further
    if abs(bend) <= 1.0:
        assert slides or 3.0 * state * speed - stored >= -1e-12
    assert abs(bend) < 1.0 or rate * state <= 0.0


@given(st.floats(-1e-2, 1e-2), st.floats(0.0, 1e-3))
def test_play_takes_away_its_width_and_no_more(torsion, half_width):
    left = effect_named('backlash')(half_width=half_width)(torsion=torsion)
    assert abs(left) == pytest.approx(max(abs(torsion) - half_width, 0.0), abs=1e-18)
    assert left * torsion >= 0.0


@given(st.floats(-1e-2, 1e-2), st.floats(0.0, 1e-3), st.floats(-1.0, 1.0))
def test_nothing_goes_through_the_gear_within_the_play(torsion, half_width, rate):
    arm = read_arm('hda_arm.yaml').with_effect(Backlash(half_width=half_width), 'joint1')
    joint = arm.record().joints[0]
    torque = torque_through_gear(joint, 0.0, torsion, rate, 0.0)
    loose = abs(torsion) < half_width
    assert (torque == 0.0) == (loose or (rate == 0.0 and abs(torsion) == half_width))


@given(st.floats(-50.0, 50.0))
def test_slope_of_the_kinematic_error_is_its_derivative(angle):
    effect = KinematicError(amplitude_1=3e-5, phase_1=0.3, amplitude_2=1e-4, phase_2=-1.0,
                            amplitude_4=2e-5, phase_4=2.0)
    step = 1e-5
    ahead, behind = (effect(motor_angle=angle + s) for s in (step, -step))
    assert KinematicError.law_slope(effect.record(), Turned(angle)) == pytest.approx(
        (ahead - behind) / (2.0 * step), abs=1e-12)


@given(st.floats(-50.0, 50.0), st.floats(0.0, 2e-5))
def test_an_error_that_grows_with_torque_leaves_a_gear_that_gives_way(angle, amplitude):
    arm = BARE.with_effect(LoadedKinematicError(amplitude=amplitude, phase=0.3), 'joint1')
    joint, step = arm.record().joints[0], 1e-5
    most = 0.9 / float(joint['torsion']['last_stiffness'])
    growing, slope = growth(joint, angle)
    assert abs(growing) <= most * (1.0 + 1e-12)
    ahead, behind = (growth(joint, angle + s)[0] for s in (step, -step))
    if (abs(ahead) < most) == (abs(behind) < most):
        assert slope == pytest.approx((ahead - behind) / (2.0 * step), abs=1e-13)


@given(st.floats(1e-5, 0.05), st.floats(1e-6, 1e-2))
def test_lag_is_a_first_order_one(time_constant, elapsed):
    effect = effect_named('current_loop_lag')(time_constant=time_constant)
    stepped = effect(command=1.0, last_command=1.0, state=0.0, elapsed=elapsed)
    assert stepped == pytest.approx(-np.expm1(-elapsed / time_constant), rel=1e-9, abs=1e-12)
    half = effect(command=1.0, last_command=1.0, state=0.0, elapsed=0.5 * elapsed)
    twice = effect(command=1.0, last_command=1.0, state=half, elapsed=0.5 * elapsed)
    assert twice == pytest.approx(stepped, rel=1e-9, abs=1e-12)


def test_a_contact_begins_and_ends_softly():
    effect = effect_named('external_contact')(force=20.0, onset=1.0, duration=2.0, direction=0.5)
    force_x, force_y = effect(time=np.array([0.0, 1.0, 1.1, 2.0, 2.9, 3.0, 9.0]))
    size = np.hypot(force_x, force_y)
    np.testing.assert_allclose(size, [0.0, 0.0, 10.0, 20.0, 10.0, 0.0, 0.0], atol=1e-12)
    assert np.arctan2(force_y[3], force_x[3]) == pytest.approx(0.5)


def test_a_base_lighter_than_what_the_links_throw_about_is_refused():
    with pytest.raises(ArmError, match=r'amplitude must lie below .* 1/kg, got 0.5'):
        HEALTHY.with_effect(BaseVibration(amplitude=0.5))
