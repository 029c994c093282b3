"""Other forms of a law, what chance buys, and how noisy a balance is."""

from dataclasses import replace
import gc
from weakref import ref

from hda_arm_sim.model.effects.actuation import off_centre, TorqueRipple
from hda_arm_sim.model.files import read_arm
from hda_torque_estimator.diagnosis.balances.balance import Balancer
from hda_torque_estimator.diagnosis.balances.healthy_twin import healthy_twin, TorqueNoise
from hda_torque_estimator.diagnosis.diagnose import diagnose
from hda_torque_estimator.diagnosis.fitting.hypotheses import HYPOTHESES, terms_of
from hda_torque_estimator.diagnosis.fitting.starting_points import contacts_in
from hda_torque_estimator.diagnosis.judging.equal_noise import equal_noise_score, noise_in
from hda_torque_estimator.diagnosis.judging.law_forms import (
    evidence, factors_along, reformed)
from hda_torque_estimator.diagnosis.judging.null_distribution import by_chance
from hda_torque_estimator.diagnosis.judging.screening import screen
from hda_torque_estimator.significance import HARDLY
import numpy as np
import pytest
from truth import worlds
from truth.logs import Logger
from truth_cases import hide
import truth_fits
from world_fits import diagnosed, fitted, fitter_of


@pytest.mark.parametrize(('seed', 'motion', 'rate'), [
    (721001, 'rich', 200), (721002, 'fourier', 1000), (721003, 'sine', 125),
    (721004, 'rich', 500), (721005, 'chirp', 250)])
def test_a_healthy_arm_leaves_the_noise_of_its_readings(seed, motion, rate):
    world = worlds.draw(seed, motion=motion, rate=rate, seconds=20.0)
    world = replace(world, logger=world.logger._replace(jitter=0.0))
    fitter = fitter_of(world)
    fit = fitter.first
    left = np.array([np.sqrt(np.mean(column[valid] ** 2)) for column, valid in
                     zip(fit.balance.residual.T, fit.balance.valid.T)])
    # rounding may double what white noise makes, and a healthy arm has its tolerances
    assert (0.45 * fitter.noise < left).all() and (left < 1.7 * fitter.noise).all()


@pytest.mark.parametrize('seed', [
    722005, pytest.param(722006, marks=pytest.mark.study)])
def test_a_law_of_another_form_leaves_noise_and_another_law_does_not(seed):
    """A Stribeck friction that is stronger one way."""
    world = worlds.draw(seed, ('stribeck_friction',), form='one_way', motion='rich', rate=1000,
                        joints=1, seconds=20.0)
    fitter = fitter_of(replace(world, controller=1000, logger=Logger()))
    right, wrong = (fitted(fitter, name) for name in ('stribeck_friction', 'drive_offset'))
    left = [(fit.variance / fitter.noise ** 2)[0] - 1.0 for fit in (
        right, reformed(fitter, right), reformed(fitter, wrong))]
    assert left[0] > 0.2
    assert left[1] < 0.1 * left[0] and left[1] < 0.1 * left[2]
    assert evidence(fitter, right) < right.score
    assert evidence(fitter, right) < evidence(fitter, wrong)


@pytest.mark.parametrize('count', [1, 2, 3])
def test_a_cause_that_acts_in_fewer_rows_than_it_has_forms_has_fewer(count):
    world = worlds.draw(722005, ('stribeck_friction',), form='one_way', motion='rich', rate=1000,
                        joints=1, seconds=20.0)
    fitter = fitter_of(replace(world, controller=1000, logger=Logger()))
    fit = fitted(fitter, 'stribeck_friction')
    does = np.abs(fit.balance.residual - fitter.lacking(fit, fit.accepted[0]).balance.residual)
    few = np.argsort(np.where(fit.balance.valid, does, 0.0)[:, 0])[-count:]
    short = replace(fitter, rows=np.isin(np.arange(len(does)), few))
    assert evidence(short, short.at(fit.terms, 1, fit.slopes)) > 0.0


@pytest.mark.parametrize(('effect', 'form', 'seed'), [
    ('base_tilt', 'sinking', 994185),           # whose numbers move with its form
    ('encoder_scale_error', 'warming', 998145),
    pytest.param('cable_spring', 'progressive', 994190, marks=pytest.mark.study)])
def test_a_law_that_changes_along_a_coordinate_itself_leaves_noise(effect, form, seed):
    world = worlds.draw(seed, (effect,), form=form, motion='rich', rate=1000, seconds=20.0)
    fitter = fitter_of(replace(world, controller=1000, logger=Logger()))
    right = fitted(fitter, effect)
    left = [fit.variance / fitter.noise ** 2 - 1.0 for fit in (right, reformed(fitter, right))]
    assert left[1].max() < max(0.2, 0.02 * left[0].max())


@pytest.mark.parametrize('rest_angle', [-0.5, 0.3, 0.5])
def test_a_cable_that_stiffens_is_a_form_wherever_it_rests(rest_angle):
    """It does nothing where it rests, so its power says nothing of that angle."""
    time = np.arange(0.0, 60.0, 0.01)
    angle = 0.3 + 0.6 * np.sin(time)
    pull = angle - rest_angle
    factors = factors_along(pull ** 2, {'time': time, 'link_angle': angle}, ('link_angle',))
    law = np.stack([np.ones_like(angle), angle], axis=1)
    formed = np.concatenate([law, pull[:, None] * np.stack(list(factors), axis=1)], axis=1)
    left = [stiffening - columns @ np.linalg.lstsq(columns, stiffening, rcond=None)[0]
            for stiffening, columns in ((pull ** 3, law), (pull ** 3, formed))]
    assert np.sum(left[1] ** 2) < 1e-6 * np.sum(left[0] ** 2)


def test_a_law_of_several_numbers_is_weighed_with_all_of_them():
    """A cable rests between two angles of its grid, and was behind six other causes."""
    world = worlds.draw(998190, ('cable_spring',), form='progressive', motion='rich', rate=1000,
                        joints=1, seconds=20.0)
    fitter = fitter_of(replace(world, controller=1000, logger=Logger()))
    first, *_ = screen(fitter, fitter.first, sorted(HYPOTHESES))
    assert first.term.name == 'cable_spring'
    exact = fitted(fitter, 'cable_spring')
    assert fitter.first.score - first.score > 0.9 * (fitter.first.score - exact.score)


@pytest.mark.parametrize('seed', [980045, 991045])
def test_a_friction_that_builds_up_while_a_link_turns_round_is_a_form_of_a_dry_one(seed):
    world = worlds.draw(seed, ('link_bearing_friction',), form='wide', motion='rich', rate=1000,
                        seconds=12.0)
    fitter = fitter_of(replace(world, controller=1000, logger=Logger()))
    right = fitted(fitter, 'link_bearing_friction')
    before, after = ((fit.variance / fitter.noise ** 2 - 1.0).max() for fit in (
        right, reformed(fitter, right)))
    assert before > 5.0 and after < 0.3 * before


@pytest.mark.parametrize(('effect', 'form', 'seed'), [
    ('torsional_hysteresis', 'dahl', 760201),
    pytest.param('torsional_hysteresis', 'dahl', 760203, marks=pytest.mark.study),
    ('structural_damping', 'with_torsion', 760205),
    ('motor_encoder_eccentricity', 'fourth_order', 760201),
    pytest.param('motor_encoder_eccentricity', 'fourth_order', 760203, marks=pytest.mark.study)])
def test_a_published_law_of_the_torsion_is_a_form(effect, form, seed):
    world = worlds.draw(seed, (effect,), form=form, motion='rich', rate=1000, joints=1,
                        seconds=20.0)
    fitter = fitter_of(replace(world, controller=1000, logger=Logger()))
    right = fitted(fitter, effect)
    before, after = (fit.variance / fitter.noise ** 2 - 1.0 for fit in (
        right, reformed(fitter, right)))
    motor, torsion = 0, 1
    assert before[torsion] > 0.25 and after[torsion] < 0.05 * before[torsion]
    assert after[motor] < max(HARDLY, 0.15 * before[motor])


def test_a_ripple_at_its_bounds_has_a_wave_once_a_turn_within_its_own():
    """A diagnosis of an arm that creeps at rest ended there: both amplitudes are more than one."""
    made = off_centre(TorqueRipple(amplitude_2=1.0, amplitude_4=1.0))
    assert [one.amplitude for one in made] == [1.0, 1.0]


def test_the_noise_of_an_arm_counts_alike_for_all_causes():
    """
    A gear that is stiffer in all of its compliances, as no law has it.

    Of the stiffness a fit takes noise out of the columns, of the stiffening it does not.
    """
    world = worlds.draw(960092, ('stiffness_error',), motion='fourier', rate=1000, seconds=20.0,
                        form='whole')
    fitter = fitter_of(world)
    usual = noise_in(fitter, fitter.first)
    starts = [next(one for one in terms_of(fitter.arm, name) if one.joint == 'joint2')
              for name in ('stiffness_error', 'wave_generator_compliance')]
    right, wrong = (fitter.refined(fitter.refit(fitter.first, start)) for start in starts)
    assert equal_noise_score(fitter, right, usual) < equal_noise_score(fitter, wrong, usual)
    plain = fitter.at(right.terms, 1, right.slopes._replace(noise={}))
    assert equal_noise_score(fitter, plain,
                             usual) == pytest.approx(equal_noise_score(fitter, right, usual))


def test_nothing_remembers_a_fit_that_nobody_has():
    """Each holds columns and balances of a whole recording: a long run would fill the memory."""
    world = worlds.draw(722007, ('coulomb_friction',), motion='rich', rate=250, joints=1,
                        seconds=15.0)
    fitter = fitter_of(world)
    right = fitted(fitter, 'coulomb_friction')
    assert evidence(fitter, fitter.first) == fitter.first.score     # has no other form
    evidence(fitter, right)
    by_chance(fitter, right.accepted[-1])
    held = [ref(each) for each in (right, fitter.first, fitter.balancer, fitter)]
    del right, fitter
    gc.collect()
    assert [each() for each in held] == [None] * len(held)


def test_a_law_that_follows_noise_gains_as_much_on_a_healthy_twin():
    """Noise of drives that moves the arm, and that commands answer, makes a lag look right."""
    world = worlds.draw(400015, ('stribeck_friction',), motion='rich', rate=1000)
    fitter = fitter_of(world)
    lag = next(term for term in terms_of(fitter.arm, 'current_loop_lag')
               if term.joint == fitter.arm.labels[1]).at(np.array([0.01]))
    gains = [by_chance(replace(fitter, twin=Balancer(healthy_twin(
        fitter.balancer, fitter.arm, 2, TorqueNoise(np.full(2, more), np.zeros(2))))), lag)
        for more in (0.028, 0.0)]
    assert gains[0] > 300.0
    assert gains[1] < 60.0


def test_without_a_twin_nothing_is_chance():
    arm = read_arm('hda_arm.yaml')
    world = worlds.draw(722003, motion='rich', rate=1000, joints=1, seconds=6.0)
    fitter = replace(fitter_of(world), twin=None)
    assert by_chance(fitter, next(iter(terms_of(arm, 'current_loop_lag')))) == 0.0


@pytest.mark.parametrize(('effect', 'form', 'seed', 'rate'), [
    pytest.param('motor_encoder_eccentricity', 'two_orders', 610140, 1000,
                 marks=pytest.mark.study),
    pytest.param('motor_encoder_eccentricity', 'two_orders', 998140, 1000,
                 marks=pytest.mark.study),
    pytest.param('torque_saturation', 'soft', 998080, 1000, marks=pytest.mark.study),
    pytest.param('stribeck_friction', 'with_load', 993015, 1000, marks=pytest.mark.study),
    pytest.param('external_contact', 'trapezoid', 994195, 1000, marks=pytest.mark.study),
    pytest.param('external_contact', 'several', 997195, 1000, marks=pytest.mark.study),
    pytest.param('cable_spring', 'progressive', 780018, 1000, marks=pytest.mark.study),
    pytest.param('cable_spring', 'progressive', 780325, 1000, marks=pytest.mark.study),
    pytest.param('backlash', 'rounded', 799244, 1000, marks=pytest.mark.study),
    pytest.param('payload', 'own_inertia', 799530, 1000, marks=pytest.mark.study),
    ('coulomb_friction', 'smooth', 799538, None),
    ('torque_constant_error', 'iron', 800209, 1000),        # coarse encoders, so a noisy torque
    pytest.param('inertial_coupling', 'partial', 799611, 250, marks=pytest.mark.study),
    ('torque_ripple', 'with_torque', 630053, None)])
def test_a_cause_is_named_whose_law_has_another_form(effect, form, seed, rate):
    world = worlds.draw(seed, (effect,), motion='rich', rate=rate)
    if world.hidden[0].form != form:
        world = worlds.draw(seed, (effect,), form=form, motion='rich', rate=rate)
    assert_named_alone(world)


@pytest.mark.study
def test_a_body_at_the_tip_is_no_payload_with_a_link():
    """Fitted by its inertia about the centre it stopped short, and a link made up for that."""
    assert_named_alone(worlds.draw(799240, ('payload',), form='own_inertia', motion='rich',
                                   rate=1000))


def test_pushes_with_one_force_stand_out_together():
    """One of three does 6.6 times as much as the others, and stood out alone."""
    world = worlds.draw(993710, ('external_contact',), form='several', motion='rich', rate=1000)
    fitter = fitter_of(world)
    balance = fitter.first.balance
    found = contacts_in(fitter.balancer, fitter.arm, balance.residual, balance.valid, fitter.noise)
    assert found[0].power > 5.0 * found[1].power
    hidden, = world.hidden
    _, apart, count = hidden.law
    begins = hidden.parameters['onset'] + apart * np.arange(count)
    assert sorted(one.onset for one in found) == pytest.approx(begins, abs=0.3)


@pytest.mark.study
def test_pushes_are_alike_by_their_force_and_not_by_what_it_does():
    """Two more pushes with the force of the first do twice as much to the arm, where it is."""
    world = worlds.draw(997195, ('external_contact',), form='several', motion='rich', rate=1000)
    assert world.hidden[0].law[2] == 3.0
    assert_named_alone(world)


def assert_named_alone(world):
    """Assert that the one cause of a world is named, beside late stamps, and explains all."""
    hidden, = world.hidden
    late = world.logger.jitter > 0.0
    said = diagnosed(world)
    assert {(one.effect, one.joint) for one in said.findings} == {
        (hidden.effect, hidden.joint), *([('clock_jitter', None)] if late else [])}
    assert said.verdict == 'explained'


@pytest.mark.parametrize(('order', 'named'), [
    (1, ['torque_ripple']), pytest.param(12, ['torque_ripple', 'motor_cogging'],
                                         marks=pytest.mark.study)])
def test_a_wave_generator_off_its_centre_ripples_once_a_turn_and_is_no_cogging(order, named):
    ripple = hide('torque_ripple', 'joint1', amplitude_2=0.01, phase_2=0.3, amplitude_4=0.003,
                  phase_4=1.0)
    other = hide('motor_cogging', 'joint1', amplitude=0.004, order=order, phase=0.7)
    said = diagnose(truth_fits.measured([ripple, other], 24.0, 134), truth_fits.ARM).diagnosis
    assert (said.verdict, [one.effect for one in said.findings]) == ('explained', named)
    assert said.ambiguous == ()
