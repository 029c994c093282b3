"""A reference torque beside links is a third witness of what a gear carries."""

from dataclasses import replace

from hda_arm_sim.model.effects import effect_named
from hda_torque_estimator.diagnosis.balances.balance import Balancer
from hda_torque_estimator.diagnosis.balances.channels import channels_of
from hda_torque_estimator.diagnosis.balances.healthy_twin import healthy_twin, noise_of
from hda_torque_estimator.diagnosis.diagnose import diagnose
from hda_torque_estimator.diagnosis.fitting.nuisance import SensorError
from hda_torque_estimator.diagnosis.judging.site_pattern import BalancePair
from hda_torque_estimator.diagnosis.reporting.plots import figures
from hda_torque_estimator.diagnosis.showing import exhibits_of
from hda_torque_estimator.least_squares.term import with_terms
from hda_torque_estimator.measurements.sample_grid import measurement_from
import numpy as np
import pytest
from truth import worlds
from world_samples import arm_of, logged, sensed

SECONDS = 20.0
further = pytest.mark.study
A, B, C = 0, 2, 4               # of the first of two joints


def recorded(effect, seed, joints=2, seconds=SECONDS, gain=None, rate=1000):
    """Return a recording with torque sensors of an arm whose links are known, and that arm."""
    world = worlds.draw(seed, (effect,) if effect else (), motion='rich', rate=rate,
                        joints=joints, seconds=seconds, form='')
    world = replace(world, logger=world.logger._replace(jitter=0.0))
    arm = arm_of(world)
    return measurement_from(arm.labels, logged(world, arm),
                            references=sensed(world, arm, gain)), arm


@pytest.fixture(scope='module')
def healthy():
    return recorded(None, 6301, seconds=6.0)


def test_motor_and_torsion_are_as_without_the_sensor_which_has_a_balance_of_its_own(healthy):
    measurement, arm = healthy
    known = Balancer(measurement).apart(arm)(arm)
    plain = Balancer(replace(measurement, reference=np.zeros((0, 0))))(arm)
    np.testing.assert_array_equal(known.residual[:, :4], plain.residual)
    np.testing.assert_array_equal(known.valid[:, :4], plain.valid)
    assert known.residual.shape[1] == 6 and known.valid[:, 4:].any(axis=0).all()


def test_a_joint_without_a_sensor_has_two_balances(healthy):
    measurement, arm = healthy
    reference = measurement.reference.copy()
    reference[:, 0], reference[2000:2500, 1] = np.nan, np.nan
    one = replace(measurement, reference=reference)
    assert [channels_of(one, place) for place in (0, 1)] == [[0, 2], [1, 3, 5]]
    balancer = Balancer(one).apart(arm)
    balance = balancer(arm)
    lost = (balancer.time > 2.0) & (balancer.time < 2.499)
    assert not balance.residual[:, C].any() and not balance.valid[:, C].any()
    assert balance.valid[:, C + 1].any() and not balance.valid[lost, C + 1].any()
    assert balance.valid[lost][:, [A, B]].any()


@pytest.mark.parametrize('effect, numbers, shares', [
    ('torque_constant_error', {'error': 0.05}, lambda shared: (1.0, 0.0, 0.0)),
    ('stiffness_error', {'error': 0.05}, lambda shared: (0.0, 1.0, 1.0 - shared)),
    ('link_inertia_error', {'error': 0.1}, lambda shared: (1.0, 1.0, -shared)),
    ('sensor_gain', 0.05, lambda shared: (0.0, 0.0, 1.0))])
def test_each_site_has_its_pattern_in_three_balances(healthy, effect, numbers, shares):
    """Compare eq:balance-third; the torsion cancels in A but for the inertia of the motor."""
    measurement, arm = healthy
    balancer = Balancer(measurement).apart(arm)
    label = arm.labels[0]
    if effect == 'sensor_gain':
        other = with_terms(arm, [SensorError(label, effect, value=numbers)])
    else:
        other = arm.with_effect(effect_named(effect)(**numbers), label)
    change = balancer.change(other, arm)[:, [A, B, C]]
    expected = np.array(shares(balancer.shared[0]))
    reach = np.sqrt((change ** 2).sum(axis=0)) / np.sqrt((change ** 2).sum(axis=0)).max()
    np.testing.assert_allclose(reach, np.abs(expected) / np.abs(expected).max(), atol=0.02)


def test_slow_noise_of_the_third_balance_is_its_own(healthy):
    measurement, arm = healthy
    balancer = Balancer(measurement).apart(arm)
    noise = [balancer.like(healthy_twin(balancer, arm, seed))(arm) for seed in (3, 4)]
    valid = noise[0].valid & noise[1].valid
    apart = np.where(valid, noise[0].residual - noise[1].residual, 0.0)
    slow = np.fft.rfft(apart, axis=0)[1:20]
    power = (np.abs(slow) ** 2).sum(axis=0)
    across = (slow[:, B].conj() * slow[:, C]).real.sum() / np.sqrt(power[B] * power[C])
    assert abs(across) < 0.5
    plain, _ = noise_of(balancer, arm)
    assert np.isfinite(plain).all() and (plain > 0.0).all()


def test_what_a_sensor_has_wrong_is_at_the_sensor():
    random = np.random.default_rng(1)
    quiet = [0.1 * random.standard_normal(500) for _ in range(3)]
    rest = np.sin(np.linspace(0.0, 20.0, 500))
    for site, parts in (('sensor', (0.0, 0.0, 1.0)), ('motor', (1.0, 0.0, 0.0)),
                        ('torsion', (0.0, 1.0, 1.0)), ('link', (1.0, 1.0, 0.0))):
        motor, torsion, sensor = (one + part * rest for one, part in zip(quiet, parts))
        assert BalancePair(motor, torsion, 0.1, 0.1, sensor, 0.1).site() == site


@pytest.mark.parametrize('seed, joints, gain, rate', [
    (6301, 2, 0.05, 1000), *(pytest.param(*case, marks=further) for case in (
        (6320, 2, -0.05, 1000), (6302, 2, None, 1000), (6102, 1, None, 1000),
        (6401, 2, 0.05, 250), (6404, 1, None, 250)))])
def test_nobody_is_accused_of_what_a_sensor_is_allowed(seed, joints, gain, rate):
    measurement, arm = recorded(None, seed, joints, gain=gain, rate=rate)
    said = diagnose(measurement, arm).diagnosis
    assert said.verdict in ('no_discrepancy', 'insufficient_excitation')
    assert any('third witness' in remark for remark in said.remarks)
    assert not any('its scale tells nothing' in remark for remark in said.remarks)


@pytest.mark.parametrize('effect, seed, gain, told', [
    (None, 6301, 0.15, ()), *(pytest.param(*case, marks=further) for case in (
        (None, 6302, -2.0, ()), ('stiffness_error', 6303, 0.15, ('stiffness_error',)),
        ('viscous_friction', 6409, 0.15, ('viscous_friction',)),
        ('viscous_friction', 6409, -2.0, ('viscous_friction',))))])
def test_the_scale_of_a_sensor_that_others_contradict_is_no_cause(effect, seed, gain, told):
    """It was told as a payload, or made the stiffness `unknown` that was wrong beside it."""
    said = diagnose(*recorded(effect, seed, gain=gain)).diagnosis
    assert tuple(cause.effect for cause in said.findings) == told and not said.ambiguous
    assert said.unexplained is None
    assert any('its scale tells nothing' in remark for remark in said.remarks)


@pytest.mark.parametrize('effect, seed', [
    ('viscous_friction', 6409), *(pytest.param(*case, marks=further) for case in (
        ('stiffness_error', 6303), ('wave_generator_compliance', 6304),
        ('torque_constant_error', 6305), ('load_dependent_friction', 6306),
        ('link_bearing_friction', 6307), ('link_inertia_error', 6309),
        ('torsional_hysteresis', 6311), ('cable_spring', 6312)))])
def test_a_cause_is_named_by_three_witnesses(effect, seed):
    said = diagnose(*recorded(effect, seed)).diagnosis
    assert [cause.effect for cause in said.findings] == [effect] and said.verdict == 'explained'
    assert {row.site for row in said.residuals} == {'motor', 'torsion', 'sensor'}


def test_what_a_sensor_alone_has_wrong_is_said_and_drawn():
    """It reads more where the torque is large, of either sign."""
    measurement, arm = recorded(None, 6301)
    torque = measurement.reference - measurement.reference.mean(axis=0)
    found = diagnose(replace(measurement, reference=measurement.reference + 0.2 * np.abs(torque)),
                     arm)
    said = found.diagnosis
    assert not said.findings and not said.ambiguous
    assert any(remark.startswith('the reference torque of joint1 differs by')
               for remark in said.remarks)
    exhibits = exhibits_of(found.evidence)
    assert exhibits.missed().channels(0) == [A, B, C]
    drawn = figures(said, exhibits)['residuals']
    titles = [axes.get_title('left') for axes in drawn.axes]
    assert len(titles) == 6 and 'balance C, sensor' in titles[-1]
