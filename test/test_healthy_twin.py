"""A healthy twin is the closed loop without an estimator: nobody reads its torques."""

from dataclasses import replace

from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import motion
from hda_torque_estimator.controlling.controller import ControllerSettings
from hda_torque_estimator.diagnosis.balances.balance import Balancer
from hda_torque_estimator.diagnosis.balances.healthy_twin import healthy_twin
from hda_torque_estimator.measurements import upsampling
from hda_torque_estimator.measurements.measurement import Measurement
from hda_torque_estimator.measurements.upsampling import is_held
from hda_torque_estimator.simulating.closed_loop import ClosedLoopRun, run
import numpy as np
import pytest

ARMS = ('hda_arm.yaml', 'paper_single_axis.yaml')


def loop(arm_file: str, **settings) -> ClosedLoopRun:
    """Return 3 s of a push, with the noise of one seed."""
    arm = read_arm(arm_file)
    return run(arm, arm, motion('push', len(arm.joints), 3.0, 1e-3, 4), 4, **settings)


@pytest.mark.parametrize('arm_file', ARMS)
def test_without_an_estimator_an_arm_moves_as_with_it(arm_file):
    with_it, without = loop(arm_file), loop(arm_file, estimator=None)
    for field in ('reading', 'command', 'joint_torque', 'state'):
        np.testing.assert_array_equal(getattr(without, field), getattr(with_it, field))
    assert np.isnan(without.estimated_torque).all()
    assert np.isfinite(with_it.estimated_torque).all()


def test_torque_feedback_without_an_estimator_is_refused():
    with pytest.raises(ValueError, match='^torque feedback needs an estimator: .* is -1 and'):
        loop(ARMS[0], controller=ControllerSettings(torque_feedback=-1.0), estimator=None)


def test_a_twin_estimates_no_torque(monkeypatch):
    made, arm = loop(ARMS[1]), read_arm(ARMS[1])
    balancer = Balancer(Measurement(arm.labels, 1e-3, made.reading[:, :, :2].copy(),
                                    made.command))
    runs: list[ClosedLoopRun] = []
    monkeypatch.setattr('hda_torque_estimator.diagnosis.balances.healthy_twin.run',
                        lambda *args, **more: runs.append(run(*args, **more)) or runs[-1])
    twin = healthy_twin(balancer, arm, 1)
    assert [np.isnan(each.estimated_torque).all() for each in runs] == [True]
    np.testing.assert_array_equal(twin.command, runs[0].command)


def test_noise_of_drives_moves_the_arm_and_the_loop_answers():
    """It is none of what was commanded, but of what commands answer."""
    arm, quiet = read_arm(ARMS[0]), loop(ARMS[0], estimator=None)
    drawn = np.zeros_like(quiet.command)
    still = loop(ARMS[0], estimator=None, drive_noise=drawn)
    np.testing.assert_array_equal(still.state, quiet.state)
    drawn[:, 0] = 0.01 * np.random.default_rng(1).standard_normal(len(drawn))
    noisy = loop(ARMS[0], estimator=None, drive_noise=drawn)
    moved = np.diff(noisy.state[:, 0, 1] - quiet.state[:, 0, 1]) / 1e-3     # of the shaft
    felt = moved * arm.joints[0].motor_inertia
    assert np.corrcoef(felt, drawn[:-1, 0])[0, 1] > 0.9
    answered = (noisy.command - quiet.command)[:, 0]
    assert answered.std() > 0.0 and abs(np.corrcoef(answered, drawn[:, 0])[0, 1]) < 0.1


def test_noise_of_drives_is_held_where_a_loop_is_faster_than_its_log():
    asked = motion('sine', 2, 2.0, 5e-3, 0)
    arm, drawn = read_arm(ARMS[0]), np.zeros((len(asked.time), 2))
    drawn[200:] = 0.02
    quiet, pushed = (run(arm, arm, asked, 0, estimator=None, drive_noise=noise)
                     for noise in (None, drawn))
    np.testing.assert_array_equal(pushed.state[:201], quiet.state[:201])
    assert (np.abs(pushed.state[201] - quiet.state[201]).max(axis=1) > 0.0).all()


def test_a_twin_is_known_to_be_held_as_its_recording_was():
    """Noise that the loop of a twin did not read makes its commands look like those of another."""
    made, arm = loop(ARMS[0]), read_arm(ARMS[0])
    noisy = made.reading[:, :, :2] + 1e-4 * np.random.default_rng(1).standard_normal(
        made.reading[:, :, :2].shape)
    log = Measurement(arm.labels, 1e-3, noisy, made.command, held=True)
    twin = healthy_twin(Balancer(log), arm, 1)
    assert twin.held and not is_held(replace(twin, held=None))


def test_whether_commands_were_held_is_asked_once(monkeypatch):
    """It takes as long as a twin, and every twin and every curve asks."""
    asked = []
    monkeypatch.setattr(upsampling, '_seems_held', lambda log: asked.append(log) or True)
    made, arm = loop(ARMS[0]), read_arm(ARMS[0])
    one, other = (Measurement(arm.labels, 1e-3, made.reading[:, :, :2].copy(), made.command)
                  for _ in range(2))
    assert is_held(one) and is_held(one) and is_held(other)
    assert asked == [one, other]
