"""The controller keeps its limits, takes over without a step, and its feedback has the sign."""

from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import HOME, motion
from hda_torque_estimator.controlling.control import law
from hda_torque_estimator.controlling.controller import (compiled_settings, Controller,
                                                         ControllerSettings)
from hda_torque_estimator.controlling.reference import hold, reference_from, TrajectoryError
from hda_torque_estimator.simulating.closed_loop import run
import numpy as np
import pytest

ARM = read_arm('hda_arm.yaml')
RATIO = ARM.joints[0].ratio
NOTHING = np.zeros(2)
MILLISECOND = 1_000_000


def commands(controller, angles, torques=None, begin=0):
    """Return the commands to shaft angles (k, 2) sampled every millisecond."""
    return np.array([
        controller.update((begin + k) * MILLISECOND, angle,
                          NOTHING if torques is None else torques[k]).copy()
        for k, angle in enumerate(angles)])


@pytest.mark.parametrize(('feedback', 'seen'), [(0.99, 0.01), (0.5, 0.5), (0.0, 1.0), (-1.0, 2.0)])
def test_load_that_the_motor_sees(feedback, seen):
    """The motor obeys J ddtheta = tau - tau_h / N: feedback leaves it (1 - K_J) of the load."""
    settings = compiled_settings(ARM, ControllerSettings(torque_feedback=feedback))
    load = 7.0
    command = law(settings, RATIO, 0.1, 0.0, 0.1 * RATIO, 0.0, load)
    assert (load / RATIO - command) == pytest.approx(seen * load / RATIO, abs=1e-12)


@pytest.mark.parametrize(('feedback', 'way'), [(-1.0, 'follows'), (0.8, 'rejects')])
def test_push_is_followed_or_rejected(feedback, way):
    asked = motion('standstill', 2, 8.0, 1e-3, 1)
    force = np.zeros_like(asked.force)
    force[3000:5000] = 35.0, 35.0
    moved = {}
    for gain in (0.0, feedback):
        made = run(ARM, ARM, asked._replace(force=force), 1,
                   controller=ControllerSettings(torque_feedback=gain))
        moved[gain] = np.abs(made.state[4900, :, 2] - HOME).max()
    assert (moved[feedback] > 1.3 * moved[0.0]) == (way == 'follows')
    assert (moved[feedback] < 0.8 * moved[0.0]) == (way == 'rejects')


def test_enabling_makes_no_step():
    controller = Controller(ARM)
    angles = np.tile([30.0, -80.0], (200, 1))
    angles[0] += 0.2                                    # even on an arm that moves
    controller.enable()
    torques = np.tile([8.0, -3.0], (200, 1))
    controller.tune(ControllerSettings(torque_feedback=-1.0))
    made = commands(controller, angles, torques)
    assert (made[0] == 0.0).all()
    steps = np.abs(np.diff(made, axis=0)).max()
    assert steps <= controller.settings.rate_limit * 1e-3 + 1e-12


def test_disabled_controller_is_silent_and_stop_is_at_once():
    controller = Controller(ARM)
    assert (commands(controller, np.full((3, 2), 5.0)) == 0.0).all()
    controller.enable()
    controller.follow(hold(np.array([1.0, 1.0])), 0)
    assert np.abs(commands(controller, np.zeros((400, 2)))[-1]).max() > 0.1
    controller.stop()
    assert (controller.command == 0.0).all()
    assert (commands(controller, np.zeros((3, 2)), begin=400) == 0.0).all()


def test_torque_and_its_rate_are_limited():
    controller = Controller(ARM, ControllerSettings(position_gain=50.0, rate_limit=5.0,
                                                    handover_time=1e-3))
    controller.enable()
    controller.follow(hold(np.array([3.0, -3.0])), 0)
    made = commands(controller, np.zeros((500, 2)))
    limits = [joint.torque_limit for joint in ARM.joints]
    assert np.abs(made).max(axis=0) == pytest.approx(limits)
    assert np.abs(np.diff(made, axis=0)).max() <= 5e-3 + 1e-12


def test_reference_goes_through_its_points_without_overshoot():
    now = np.array([[0.1, 0.0], [0.2, 0.0]])
    made = reference_from(ARM, ('joint2', 'joint1'), (1.0, 2.0), ((0.5, 1.0), (0.5, 1.2)), (),
                          now)
    np.testing.assert_allclose(made.at(0.0)[:, 0], (0.1, 0.2))
    np.testing.assert_allclose(made.at(1.0)[:, 0], (1.0, 0.5))
    path = np.array([made.at(time)[:, 0] for time in np.linspace(0.0, 3.0, 301)])
    assert path[:, 1].max() <= 0.5 + 1e-12
    np.testing.assert_allclose(made.at(9.0), [[1.2, 0.0], [0.5, 0.0]])
    slope = (made.at(0.5 + 1e-6)[:, 0] - made.at(0.5 - 1e-6)[:, 0]) / 2e-6
    np.testing.assert_allclose(made.at(0.5)[:, 1], slope, rtol=1e-6)


NOW = np.zeros((2, 2))
NAMES = ('joint1', 'joint2')


@pytest.mark.parametrize(('names', 'times', 'angles', 'rates', 'says'), [
    (('joint1',), (1.0,), ((0.1,),), (), 'joint_names must be joint1, joint2'),
    (NAMES, (), (), (), 'at least one point'),
    (NAMES, (1.0, 1.0), ((0, 0), (0, 0)), (), 'grow from point to point'),
    (NAMES, (1.0,), ((0.1, 0.2, 0.3),), (), 'point 0 must have 2 positions, got 3'),
    (NAMES, (1.0,), ((0.1, np.nan),), (), 'must be finite'),
    (NAMES, (1.0,), ((0.1, 9.0),), (), 'joint2 must stay within'),
    (NAMES, (0.0, 1.0), ((1.0, 0.0), (1.0, 0.0)), (), 'from the present reference'),
])
def test_bad_trajectory_is_refused_in_words(names, times, angles, rates, says):
    with pytest.raises(TrajectoryError, match=says):
        reference_from(ARM, names, times, angles, rates, NOW)


def test_closed_loop_is_deterministic_and_tracks():
    asked = motion('rich', 2, 8.0, 1e-3, 4)
    one, two = (run(ARM, ARM, asked, 9) for _ in range(2))
    np.testing.assert_array_equal(one.reading, two.reading)
    assert np.abs(one.state[:, :, 2] - asked.angle).max() < 0.03
    other = run(ARM, ARM, asked, 10)
    assert other.reading.shape == one.reading.shape
