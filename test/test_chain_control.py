"""A chain starts in equilibrium, and its controller holds the weight that it knows."""

from dataclasses import replace

from chains import narrow
from hda_arm_sim.live import LiveArm, SimulationSettings
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import (Backlash, BaseVibration, Effect, KinematicError, Payload,
                                       Scope, TorsionalHysteresis)
from hda_arm_sim.model.energy import energy
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import home_of, motion_of
from hda_arm_sim.simulate import InputHistory, rest, rollout
from hda_arm_sim.start import start_of
from hda_torque_estimator.controlling.controller import Controller, ControllerSettings
from hda_torque_estimator.controlling.reference import reference_from, TrajectoryError
from hda_torque_estimator.estimating.estimator import Estimator
from hda_torque_estimator.estimating.laws import layout
from hda_torque_estimator.estimating.laws.contact import contact_level, FREE
from hda_torque_estimator.simulating.closed_loop import run
import numpy as np
import pytest

COBOT, FLAT = read_arm('cobot7.yaml'), read_arm('hda_arm.yaml')
HOME = np.array(home_of(COBOT))
DT, MILLISECOND = 1e-3, 1_000_000
LOADED = {
    'nothing': (), 'payload': (Payload(mass=2.0),), 'play': (Backlash(half_width=1e-4),),
    'waves': (KinematicError(amplitude_2=3e-5, phase_2=0.7),),
    'loop': (TorsionalHysteresis(level=1.5),), 'base': (BaseVibration(amplitude=0.01),)}


def with_all(effects: tuple[Effect, ...]) -> Arm:
    """Return the seven-joint arm with effects, those of joints on the joint that bears most."""
    arm = COBOT
    for effect in effects:
        arm = arm.with_effect(effect, None if effect.scope is Scope.ARM else 'joint2')
    return arm


def weight(angles: np.ndarray) -> np.ndarray:
    """Return what gravity does to the joints (n,), as the slope of the energy at rest [N*m]."""
    rigid = replace(COBOT, joints=tuple(replace(joint, ratio=1.0) for joint in COBOT.joints))
    step, found = 1e-5, []
    for each in np.eye(len(angles)):
        sides = [energy(rigid, rest(rigid, angles + sign * step * each)) for sign in (1.0, -1.0)]
        found.append(-(sides[0] - sides[1]) / (2.0 * step))
    return np.array(found)


@pytest.mark.parametrize('name', LOADED)
def test_a_chain_starts_where_it_stays(name):
    arm, idle = with_all(LOADED[name]), np.zeros((400, 6))
    start = start_of(arm, HOME)
    made = rollout(arm, start.state, InputHistory(np.tile(start.command, (400, 1)), idle), DT)
    np.testing.assert_allclose(made.link_angle, np.tile(HOME, (400, 1)), atol=1e-9)
    assert np.abs(made.joint_torque - made.joint_torque[0]).max() < 1e-4
    dropped = rollout(arm, rest(arm, HOME), InputHistory(np.tile(start.command, (400, 1)), idle),
                      DT)
    assert np.abs(dropped.joint_torque - made.joint_torque[0]).max() > 10.0


def test_gears_are_wound_up_by_the_weight_alone():
    start = start_of(COBOT, HOME)
    held = InputHistory(np.tile(start.command, (2, 1)), np.zeros((2, 6)))
    made = rollout(COBOT, start.state, held, DT)
    np.testing.assert_allclose(made.joint_torque[0], -weight(HOME), atol=1e-5)
    np.testing.assert_allclose(start.command, -weight(HOME) / 100.0, atol=1e-6)


def test_links_in_a_plane_start_as_ever():
    start = start_of(FLAT, (0.3, 0.8))
    np.testing.assert_array_equal(start.state, rest(FLAT, (0.3, 0.8)))
    assert not start.command.any()


def test_an_arm_that_nobody_commands_is_held_until_somebody_does():
    live = LiveArm(COBOT, SimulationSettings(), 1_000_000_000)
    for _ in range(300):
        live.sample()
        live.advance()
    shown = live.sample().reading[:, 1]
    np.testing.assert_allclose(shown, HOME, atol=1e-5)
    live.command(live.stamp, np.zeros(7))
    for _ in range(300):
        live.sample()
        live.advance()
    assert np.abs(live.sample().reading[:, 1] - HOME).max() > 1e-3


@pytest.mark.parametrize('feedback', [0.0, -1.0, 0.6])
def test_the_weight_is_held_whatever_the_feedback(feedback):
    path = motion_of(COBOT, 'standstill', 3.0, DT, 0)
    sagged = [np.abs(run(COBOT, COBOT, path, 0, controller=ControllerSettings(
        torque_feedback=feedback, gravity_compensation=share)).state[:, :, 2] - HOME).max()
        for share in (1.0, 0.0)]
    assert sagged[0] < 2e-5 and sagged[1] > 1e-3


def test_a_controller_takes_over_at_the_weight_without_a_step():
    controller = Controller(COBOT)
    controller.enable()
    shafts = 100.0 * HOME
    first = controller.update(0, shafts, np.zeros(7)).copy()
    np.testing.assert_allclose(first, -weight(HOME) / 100.0, atol=1e-6)
    for k in range(1, 50):
        made = controller.update(k * MILLISECOND, shafts, np.zeros(7))
        np.testing.assert_allclose(made, first, atol=1e-9)


def test_two_links_on_a_tilted_base_are_controlled_as_ever():
    commands = []
    for share in (0.0, 1.0):
        path = motion_of(FLAT, 'sine', 2.0, DT, 0)
        leaning = replace(FLAT, base=replace(FLAT.base, tilt=0.3))
        commands.append(run(leaning, leaning, path, 0, controller=ControllerSettings(
            gravity_compensation=share)).command)
    np.testing.assert_array_equal(*commands)


@pytest.mark.parametrize('motion', ['standstill', 'sine', 'rich'])
def test_a_start_is_no_contact(motion):
    made = run(COBOT, COBOT, motion_of(COBOT, motion, 2.0, DT, 4), 4, estimator=None)
    stamps = np.round(made.time * 1e9).astype(np.int64) + 1
    found = Estimator(COBOT).run(stamps, made.reading, made.command)
    assert (found.tip[:, layout.CONTACT_LEVEL] == FREE).all()
    assert found.tip[:, layout.CONTACT_DEVIATIONS].max() < contact_level(4.0, 7)


@pytest.mark.parametrize(('angles', 'rate', 'said'), [
    ([-0.7], 0.0, 'joint4 must stay within -2 to -1 rad, got -0.7 rad'),
    ([-2.2], 0.0, 'joint4 must stay within -2 to -1 rad, got -2.2 rad'),
    ([-1.95, -1.5], -1.2, 'joint4: the angle must stay within -2 to -1 rad')])
def test_a_target_is_kept_within_what_the_description_allows(angles, rate, said):
    """Also between two points: the third passes one on its way out, and comes back."""
    arm, now = narrow(-2.0, -1.0), np.zeros((7, 2))
    now[:, 0] = home_of(arm)
    points, rates = np.tile(now[:, 0], (len(angles), 1)), np.zeros((len(angles), 7))
    points[:, 3], rates[0, 3] = angles, rate
    with pytest.raises(TrajectoryError) as caught:
        reference_from(arm, arm.labels, 2.0 + np.arange(len(angles)), points, rates, now)
    assert said in str(caught.value)
