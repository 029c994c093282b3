"""The loop of a log: its gains are found, and a twin answers noise as the log's loop did."""

from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import motion
from hda_torque_estimator.controlling.control import JointGains
from hda_torque_estimator.controlling.controller import ControllerSettings, usual_gains
from hda_torque_estimator.diagnosis.balances import healthy_twin as twins
from hda_torque_estimator.diagnosis.balances.balance import Balancer
from hda_torque_estimator.diagnosis.balances.log_loop import is_twin, loop_of
from hda_torque_estimator.measurements import upsampling
from hda_torque_estimator.measurements.even_grid import as_stamped, as_taken, on_grid
from hda_torque_estimator.measurements.measurement import Measurement
from hda_torque_estimator.measurements.sample_grid import measurement_from
from hda_torque_estimator.measurements.upsampling import finer
from hda_torque_estimator.simulating.closed_loop import MotorLoop, run
from hidden_truth import published
import numpy as np
import pytest

ARM = read_arm('hda_arm.yaml')
GAINS = JointGains(np.array([0.2, 0.1]), np.array([0.008, 0.005]), np.array([60.0, 100.0]))
SECONDS = 10.0


def logged(loop, every=1):
    """Return a log of every so many samples of a loop at 1 kHz, on its fine grid."""
    made = run(ARM, ARM, motion('rich', 2, SECONDS, 1e-3, 4), 4, controller=loop, estimator=None)
    return finer(Measurement(ARM.labels, 1e-3 * every, made.reading[::every, :, :2].copy(),
                             made.command[::every]))


@pytest.mark.parametrize('held', [1, 4])
def test_gains_of_a_loop_are_found(held):
    """At 250 Hz the loop held its commands for four samples of the grid."""
    found = loop_of(logged(MotorLoop(GAINS, held), held), ARM)
    assert found.held == held
    np.testing.assert_allclose(found.gains.position, GAINS.position, rtol=0.03)
    np.testing.assert_allclose(found.gains.velocity, GAINS.velocity, rtol=0.03)


def test_gains_of_another_program_are_found_beside_a_clock_that_jitters():
    """Its low-pass is another formula: dt / (2 ms + dt) of a sample's speed."""
    log = on_grid(measurement_from(ARM.labels, published(ARM, [], 8, noise=1.0)))
    assert len(log.past)
    found = loop_of(log, ARM).gains
    np.testing.assert_allclose(found.position, 0.3, rtol=0.03)
    np.testing.assert_allclose(found.velocity, 0.012, rtol=0.03)
    np.testing.assert_allclose(found.bandwidth, np.log(1.5) / (2e-3 * np.pi), rtol=0.03)


def test_readings_as_taken_are_those_that_were_put_at_ticks():
    raw = measurement_from(ARM.labels, published(ARM, [], 8, noise=1.0))
    shown = as_taken(Measurement(raw.labels, raw.dt, as_stamped(raw), raw.command, past=raw.past))
    moved = np.abs(as_stamped(raw) - raw.reading).max(axis=0)
    assert (np.abs(shown - raw.reading).max(axis=0) < 0.05 * moved).all()


def test_a_log_of_a_faster_loop_shows_none():
    assert loop_of(logged(MotorLoop(GAINS), 4), ARM) is None


def test_a_joint_that_follows_no_such_law_has_the_usual_gains():
    log = logged(MotorLoop(GAINS))
    command = log.command.copy()
    command[:, 1] += 0.5 * np.random.default_rng(1).standard_normal(len(command)) * (
        np.diff(command[:, 1], 3).std())
    log = Measurement(log.labels, log.dt, log.reading, command, held=True)
    found, usual = loop_of(log, ARM).gains, usual_gains(ARM)
    assert [each[1] for each in found] == [each[1] for each in usual]
    assert found.velocity[0] == pytest.approx(GAINS.velocity[0], rel=0.03)


def test_usual_gains_are_the_shipped_ones_of_the_shipped_rotor():
    shipped = ControllerSettings()
    assert [each.tolist() for each in usual_gains(ARM)] == [
        [gain] * 2 for gain in (shipped.position_gain, shipped.velocity_gain,
                                shipped.velocity_bandwidth)]


def test_a_twin_answers_noise_as_the_loop_of_the_log():
    """Its quick commands are those of the log, which the usual loop has a half of."""
    loop = MotorLoop(GAINS._replace(velocity=np.full(2, 0.024), bandwidth=np.full(2, 150.0)))
    log = logged(loop)
    balancer = Balancer(log)
    quick = [np.diff(made.command, 3, axis=0).std(axis=0) for made in (
        log, twins.healthy_twin(balancer, ARM, 1),
        twins._twin(balancer, ARM, 1, twins.TorqueNoise.none(2), MotorLoop(usual_gains(ARM))))]
    np.testing.assert_allclose(quick[1], quick[0], rtol=0.1)
    assert (quick[2] < 0.7 * quick[0]).all()


def test_a_loop_that_shakes_in_the_twin_is_not_that_of_the_log(monkeypatch):
    log = logged(MotorLoop(GAINS))
    wild = MotorLoop(GAINS._replace(velocity=np.full(2, 0.2), bandwidth=np.full(2, 1e3)))
    monkeypatch.setattr(twins, 'loop_of', lambda measurement, arm: wild)
    balancer, none = Balancer(log), twins.TorqueNoise.none(2)
    assert not is_twin(twins._twin(balancer, ARM, 1, none, wild), log)
    usual = twins._twin(balancer, ARM, 1, none, MotorLoop(usual_gains(ARM)))
    np.testing.assert_array_equal(twins.healthy_twin(balancer, ARM, 1).command, usual.command)


def test_whether_commands_were_held_is_asked_once(monkeypatch):
    """It takes as long as a twin, and every twin and every curve asks."""
    asked = []
    monkeypatch.setattr(upsampling, '_seems_held', lambda log: asked.append(log) or True)
    one, other = logged(MotorLoop(GAINS)), logged(MotorLoop(GAINS))
    assert upsampling.is_held(one) and upsampling.is_held(one) and upsampling.is_held(other)
    assert asked == [one, other]
