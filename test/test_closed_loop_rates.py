"""The built-in controller is stable at every rate at which an arm is recorded."""

from dataclasses import replace

from hda_arm_sim.model.effects import DroppedSamples
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import motion
from hda_torque_estimator.controlling.controller import bearable, ControllerSettings
from hda_torque_estimator.simulating.closed_loop import run
import numpy as np
import pytest

SHIPPED = read_arm('hda_arm.yaml')


def scaled(*, links, stiffness, motor, torque):
    """Return the shipped arm with other sizes, each as a multiple."""
    law = SHIPPED.joints[0].torsion
    law = replace(law, flexspline_stiffness=stiffness * law.flexspline_stiffness,
                  wave_generator_stiffness=stiffness * law.wave_generator_stiffness,
                  valid_torque=torque * law.valid_torque, damping=stiffness * law.damping,
                  flexspline_curvature=law.flexspline_curvature / torque,
                  wave_generator_curvature=law.wave_generator_curvature / torque)
    joints = tuple(replace(joint, torsion=law, motor_inertia=motor * joint.motor_inertia,
                           torque_limit=torque * joint.torque_limit,
                           dry_friction=motor * joint.dry_friction) for joint in SHIPPED.joints)
    old = SHIPPED.links
    return replace(SHIPPED, joints=joints, links=replace(
        old, p1=links * old.p1, p2=links * old.p2, p3=links * old.p3))


ARMS = {
    'shipped': SHIPPED, 'single axis': read_arm('paper_single_axis.yaml'),
    'paper': read_arm('paper_table1.yaml'),
    'medium': scaled(links=4.0, stiffness=3.0, motor=1.5, torque=4.0),
    'stiff': scaled(links=1.0, stiffness=10.0, motor=1.0, torque=2.0),
    'light': scaled(links=0.1, stiffness=0.5, motor=0.1, torque=0.5),
}


def largest(arm, rate):
    """Return the largest torques (n,) through the gears [N*m]."""
    asked = motion('rich', len(arm.joints), 4.0, 1.0 / rate, 0)
    made = run(arm, arm, asked, 0, controller=bearable(arm, ControllerSettings()))
    assert len(made.time) == len(asked.time) == len(made.reading)
    np.testing.assert_allclose(np.nanmax(np.abs(made.state[:, :, 2] - asked.angle)), 0.0, atol=0.1)
    return np.abs(made.joint_torque).max(axis=0)


@pytest.mark.parametrize('arm', ARMS.values(), ids=ARMS)
def test_torques_do_not_depend_on_the_rate(arm):
    usual = largest(arm, 1000.0)
    for rate in (50.0, 100.0, 200.0, 300.0, 500.0, 2000.0):
        share = largest(arm, rate) / usual
        # 47 for the light arm at 200 Hz and 19 for the shipped at 50 with a loop of that rate
        assert (share < 1.25).all(), (rate, share)
        assert (share > 0.6).all(), (rate, share)       # a slow log misses the peaks


def test_shipped_gains_are_those_of_the_controller():
    for name in ('shipped', 'single axis', 'paper'):
        assert bearable(ARMS[name], ControllerSettings()) == ControllerSettings()


def test_a_light_rotor_does_not_chatter_under_gains_that_nobody_gave():
    arm = ARMS['light']
    asked = motion('rich', 2, 4.0, 1e-3, 0)
    limit = np.array([joint.torque_limit for joint in arm.joints])
    assert (np.abs(run(arm, arm, asked, 0, estimator=None).command) < limit).all()
    chatters = run(arm, arm, asked, 0, controller=ControllerSettings(), estimator=None)
    assert (np.abs(chatters.command) >= limit).any(axis=0).all()


def test_a_slow_recording_is_that_of_a_faster_loop():
    asked = motion('sine', 2, 2.0, 5e-3, 0)
    slow = run(SHIPPED, SHIPPED, asked, 0)
    np.testing.assert_allclose(slow.reading[1:, :, 2:],
                               np.diff(slow.reading[:, :, :2], axis=0) / 5e-3, rtol=1e-12)
    np.testing.assert_array_equal(slow.time, asked.time)


def test_lost_samples_of_a_slow_recording_repeat_the_last_one_sent():
    arm = SHIPPED.with_effect(DroppedSamples(rate=0.2))
    slow = run(arm, SHIPPED, motion('sine', 2, 4.0, 1e-2, 0), 0).reading[100:300]
    repeats = (np.diff(slow[:, 0, 1]) == 0.0).mean()
    assert 0.1 < repeats < 0.3


def test_clock_that_is_hardly_slower_changes_no_rate():
    path = motion('rich', 2, 2.0, 1e-3, 1)
    slower = path._replace(time=path.time * (1.0 + 2e-6))
    plain, same = (run(SHIPPED, SHIPPED, each, 3).command for each in (path, slower))
    assert (same - plain).std() < 0.05 * plain.std()        # a loop of 2 kHz differs by 0.2
