"""Friction that builds up over an angle shows where a shaft turns round, and there alone."""

from dataclasses import replace

from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import motion
from hda_torque_estimator.diagnosis.assumptions import AsRecorded
from hda_torque_estimator.diagnosis.balances.balance import Balancer
from hda_torque_estimator.diagnosis.balances.healthy_twin import noise_of
from hda_torque_estimator.diagnosis.balances.reversals import bristled, turning_round
from hda_torque_estimator.diagnosis.readings.raw_readings import raw_readings
from hda_torque_estimator.measurements.measurement import Measurement
from hda_torque_estimator.measurements.sample_grid import measurement_from
from hda_torque_estimator.simulating.closed_loop import run
import numpy as np
import pytest
from truth import draw
from truth_samples import published

ARM = read_arm('hda_arm.yaml')


@pytest.mark.parametrize(('name', 'seed'), [
    ('presliding_friction', 4025), ('coulomb_friction', 4027), (None, 4021),
    pytest.param('presliding_friction', 4037, marks=pytest.mark.study),
    pytest.param('load_dependent_friction', 4031, marks=pytest.mark.study)])
def test_a_joint_whose_friction_builds_up_is_found(name, seed):
    hidden = [] if name is None else [draw(name, np.random.default_rng([seed, 1]))]
    balancer = Balancer(measurement_from(ARM.labels, published(ARM, hidden, seed)))
    found = turning_round(balancer, ARM, noise_of(balancer, ARM)[0])
    assert [ARM.labels[place] for place in found] == [
        one.joint for one in hidden if name == 'presliding_friction']


def test_bristles_that_were_found_are_asked_where_their_shaft_turns_round():
    """Without those rows some were accepted that explained little, and gained nothing unseen."""
    recorded = AsRecorded.of(raw_readings(measurement_from(ARM.labels, published(ARM, [], 4021)),
                                          ARM), ((0.0, 60.0),))
    plain = ARM.effect('presliding_friction', 'joint2')
    found = ARM.with_effect(replace(plain, stiffness=2.0), 'joint2')
    assert (bristled(ARM), bristled(found)) == ((), (1,))
    assert (recorded.turning(ARM), recorded.turning(found)) == ((), (1,))
    assert not recorded.bears_out(recorded.fitter((), ARM), found)


@pytest.mark.parametrize('seed', [
    26, *(pytest.param(seed, marks=pytest.mark.study) for seed in (27, 31))])
def test_stops_too_short_to_be_seen_are_not_friction_that_builds_up(seed):
    made = run(ARM, ARM, motion('rich', 2, 60.0, 1e-3, seed), seed)
    reading = np.ascontiguousarray(made.reading[:, :, :2])
    balancer = Balancer(Measurement(ARM.labels, 1e-3, reading, made.command))
    assert turning_round(balancer, ARM, noise_of(balancer, ARM)[0]) == ()


def test_rows_where_a_joint_turns_round_are_its_own():
    balancer = Balancer(measurement_from(ARM.labels, published(ARM, [], 4021)))
    plain, wider = balancer(ARM).valid, balancer.valid_if_turning(ARM, (1,))
    assert (wider[:, [0, 2, 3]] == plain[:, [0, 2, 3]]).all()
    assert wider[plain].all()
    assert 100 < (wider & ~plain).sum() < 1000


def test_a_shaft_that_turns_round_within_a_sample_stands_still_there():
    """It is never slow. What its friction leaves there looked like a fault of a healthy arm."""
    made = run(ARM, ARM, motion('rich', 2, 60.0, 1e-3, 992801), 992801)
    reading = np.ascontiguousarray(made.reading[:, :, :2])
    balance = Balancer(Measurement(ARM.labels, 1e-3, reading, made.command))(ARM)
    for joint in (0, 1):
        left = np.abs(balance.residual[balance.valid[:, joint], joint])
        assert left.max() < 20.0 * np.median(left)
