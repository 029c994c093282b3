"""Gears without a model of their links are held against torques that sensors of theirs show."""

from dataclasses import replace
from pathlib import Path

from hda_arm_sim.model.parts import SensorErrors
from hda_torque_estimator.diagnosis.balances.balance import Balancer
from hda_torque_estimator.diagnosis.balances.reference_torques import torque_behind
from hda_torque_estimator.diagnosis.balances.stand_in import with_stand_in
from hda_torque_estimator.diagnosis.detectability.one_sided import one_sided
from hda_torque_estimator.diagnosis.diagnose import diagnose
from hda_torque_estimator.measurements.measurement import Measurement
from hda_torque_estimator.measurements.sample_grid import measurement_from
import numpy as np
import pytest
from real_commands import hda, log_of
import real_lara8
from scipy.signal import lfilter
from truth import worlds
from world_samples import arm_of, logged, sensed

SECONDS, DT = 20.0, 1e-3
LARA8 = Path(__file__).parents[2] / 'shared' / 'data' / real_lara8.FILE
further = pytest.mark.study


def recorded(effect, seed, joints=1, seconds=SECONDS, gain=None):
    """Return a recording with torque sensors of an arm whose links nobody knows, and that arm."""
    world = worlds.draw(seed, (effect,) if effect else (), motion='rich', rate=1000,
                        joints=joints, seconds=seconds, form='')
    world = replace(world, logger=world.logger._replace(jitter=0.0))
    arm = arm_of(world)
    measurement = measurement_from(arm.labels, logged(world, arm),
                                   references=sensed(world, arm, gain))
    return measurement, replace(arm, links=None)


@pytest.mark.parametrize('effect, seed', [
    ('stribeck_friction', 6202), ('torque_constant_error', 6202),
    pytest.param('stiffness_error', 6103, marks=further),
    pytest.param('stiffness_error', 6202, marks=further),
    pytest.param('torque_constant_error', 6108, marks=further),
    pytest.param('kinematic_error', 6106, marks=further),
    pytest.param('torsional_hysteresis', 6202, marks=further),
    pytest.param('load_dependent_friction', 6109, marks=further),
    pytest.param('load_dependent_friction', 6202, marks=further),
    pytest.param('encoder_interpolation_error', 6110, marks=further)])
def test_a_cause_is_named_beside_errors_of_the_sensor(effect, seed):
    """Or told with what explains as much: a stiffness with a compliance in series."""
    measurement, arm = recorded(effect, seed)
    said = diagnose(measurement, arm).diagnosis
    told = {cause.effect for cause in said.findings}
    alike = {name for pair in said.ambiguous for name, _ in pair.effects}
    assert (told == {effect} and not alike) or (not told and effect in alike)
    assert said.unexplained is None


@pytest.mark.parametrize('seed, joints', [
    (6102, 1), *(pytest.param(*case, marks=further) for case in (
        (6101, 1), (6112, 1), (6113, 2), (6201, 2)))])
def test_nobody_is_accused_of_what_the_sensor_has_wrong(seed, joints):
    measurement, arm = recorded(None, seed, joints)
    said = diagnose(measurement, arm).diagnosis
    assert said.verdict in ('no_discrepancy', 'insufficient_excitation')
    assert any('held against the reference torque' in remark for remark in said.remarks)


@pytest.mark.parametrize('seed, gain', [
    (6102, -0.12), *(pytest.param(*case, marks=further) for case in (
        (6202, -0.12), (6109, -0.12), (6202, 0.15), (6109, 0.15), (6202, -2.0), (6109, -2.0)))])
def test_a_wrong_gain_or_sign_of_the_sensor_is_no_cause_of_the_arm(seed, gain):
    """It was told as a motor inertia beside a compliance, which together scale both balances."""
    said = diagnose(*recorded(None, seed, gain=gain)).diagnosis
    assert said.verdict == 'unknown' and not said.findings and not said.ambiguous


@pytest.mark.skipif(not LARA8.exists(), reason='the recordings of the LARA8 are kept apart')
def test_a_sweep_of_a_real_joint_accuses_no_encoder(tmp_path):
    arm = tmp_path / 'arm.yaml'
    hda('new', '--gear', 'CSG-32-100', '--ratio', real_lara8.RATIO, '--joints', real_lara8.JOINT,
        '--motor-inertia', '4e-4', '--motor-torque', 2, '--motor-counts', real_lara8.TURN,
        '--link-counts', real_lara8.TURN, '--out', arm)
    said = real_lara8.referenced(log_of(LARA8), tmp_path, arm)
    assert said['verdict'] == 'unknown' and not said['alike']
    assert said['named'] == ['clock_jitter']        # its host stamps 0.2 ms late of 4
    assert said['one_way'] and said['one_load'] and said['unseen']


def test_both_balances_hold_and_a_joint_without_a_sensor_has_one():
    measurement, arm = recorded(None, 6113, 2, seconds=5.0)
    reference = measurement.reference.copy()
    reference[:, 1] = np.nan
    one = replace(measurement, led=True, reference=reference)
    assert one.held_against.tolist() == [True, False] and one.unloaded.tolist() == [False, True]
    valid = Balancer(one)(with_stand_in(arm)).valid
    assert valid[:, [0, 1, 2]].any(axis=0).all() and not valid[:, 3].any()


def test_balances_hold_nothing_where_the_reference_was_not_recorded():
    measurement, arm = recorded(None, 6102, seconds=5.0)
    reference = measurement.reference.copy()
    reference[2000:2500] = np.nan
    balancer = Balancer(replace(measurement, led=True, reference=reference))
    balance = balancer(with_stand_in(arm))
    within = (balancer.time > 2.0) & (balancer.time < 2.499)
    assert not balance.valid[within].any() and balance.valid[~within].any()
    assert np.isfinite(balance.residual).all()


def test_the_torque_behind_what_a_sensor_shows():
    """The response of a low-pass has the mean T and the variance T^2."""
    time, wait = DT * np.arange(5000), 5e-3
    torque, kept = 30.0 * np.sin(2.0 * np.pi * 1.5 * time), np.exp(-DT / 5e-3)
    shown = 1.02 * lfilter([1.0 - kept], [1.0, -kept], torque) + 2.0
    found = torque_behind(shown, SensorErrors(2.0, 0.02, wait, wait ** 2), DT)
    inner = slice(500, -500)
    assert np.abs(found - torque)[inner].max() < 0.005 * np.abs(shown - torque)[inner].max() + 0.15
    np.testing.assert_array_equal(torque_behind(shown, SensorErrors(), DT), shown)


def test_what_one_direction_and_one_load_cannot_show_is_said():
    time = DT * np.arange(8000)
    sweep = 5.0 * time / time[-1]
    there_and_back = 2.0 * np.sin(time)
    for angle, torque, said in (
            (sweep, 80.0 * np.cos(sweep), ('turns one way', 'bears one load')),
            (there_and_back, 80.0 * np.cos(3.0 * time), ())):
        reading = np.stack([100.0 * angle, angle], axis=1)[:, None, :]
        measurement = Measurement(('joint1',), DT, reading, np.zeros((8000, 1)), led=True,
                                  reference=torque[:, None])
        found = one_sided(measurement)
        assert len(found) == len(said) and all(
            words in sentence for words, sentence in zip(said, found))
