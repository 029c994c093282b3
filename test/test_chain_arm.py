"""Arms with a chain of links in motion: as two links in a plane, and by the laws of any arm."""

from dataclasses import replace
import math
import re

from chains import narrow, planar
from hda_arm_sim.foundation.chain import OFFSET, ROTATION
from hda_arm_sim.live import LiveArm, SimulationSettings
from hda_arm_sim.model.arm import Arm, ArmError
from hda_arm_sim.model.chain_links import ChainLinks, kept
from hda_arm_sim.model.description import urdf
from hda_arm_sim.model.effects import (BaseTilt, BaseVibration, BearingCrosstalk, Effect, EFFECTS,
                                       ExternalContact, InertialCoupling, LinkBearingFriction,
                                       LinkInertiaError, Payload, Scope,
                                       TorqueSaturation)
from hda_arm_sim.model.energy import energy
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.model.kernel import BASE_OFFSET, LINK_VELOCITY
from hda_arm_sim.model.parts import Joint, Links
from hda_arm_sim.model.torsion import TorsionLaw
from hda_arm_sim.model.typical_sizes import SIZED, typical
from hda_arm_sim.motions import home_of, motion_of, MOTIONS
from hda_arm_sim.plant import Plant
from hda_arm_sim.sensors import LINK
from hda_arm_sim.simulate import InputHistory, longest_step, rest, rollout, STEP
from hda_torque_estimator.controlling.controller import ControllerSettings
from hda_torque_estimator.simulating.closed_loop import run
import numpy as np
import pytest

DT = 1e-3
PAIR = Links(length1=0.3, length2=0.2, p1=2.0, p2=0.35, p3=0.3, first=4.0, second=1.0)
JOINTS = tuple(Joint(label=f'joint{j}', dry_friction=0.03) for j in (1, 2))
FLAT = Arm(JOINTS, PAIR)
SPACE = Arm(JOINTS, ChainLinks(kept(planar(PAIR)), 'tip', ('joint1', 'joint2')))
COBOT = read_arm('cobot7.yaml')
ON_BOTH = {
    'nothing': (), 'tilt': (BaseTilt(tilt=0.4, direction=0.7),), 'payload': (Payload(mass=2.0),),
    'base': (BaseVibration(amplitude=0.02, direction=0.5, damping=0.05), BaseTilt(tilt=0.2)),
    'contact': (ExternalContact(force=20.0, direction=0.4, onset=0.05, duration=0.2),)}


def inputs(joints: int, samples: int = 400, size: float = 0.08) -> tuple[np.ndarray, np.ndarray]:
    """Return motor torques (k, n) and forces on the tip (k, 2)."""
    time = DT * np.arange(samples)
    torque = size * np.sin(np.outer(time, 7.0 + 3.0 * np.arange(joints)))
    return torque, np.stack([8.0 * np.sin(6.0 * time), -5.0 * np.cos(8.0 * time)], axis=1)


def pair_with(arm: Arm, effects: tuple[Effect, ...]) -> Arm:
    """Return an arm with effects of the whole arm."""
    for effect in effects:
        arm = arm.with_effect(effect)
    return arm


@pytest.mark.parametrize('name', ON_BOTH)
def test_a_chain_in_a_plane_is_two_links(name):
    torque, force = inputs(2)
    flat, space = (rollout(arm, rest(arm, (0.3, 0.8)), InputHistory(torque, force), DT)
                   for arm in (pair_with(FLAT, ON_BOTH[name]), pair_with(SPACE, ON_BOTH[name])))
    np.testing.assert_allclose(space.state, flat.state, atol=1e-9)
    np.testing.assert_allclose(space.joint_torque, flat.joint_torque, atol=1e-6)


def test_bearings_of_a_chain_stick_as_those_of_two_links():
    torque, force = inputs(2, 600)
    made = []
    for arm in (FLAT, SPACE):
        held = arm.with_effect(LinkBearingFriction(level=6.0), 'joint1').with_effect(
            LinkBearingFriction(level=1.0), 'joint2')
        made.append(rollout(held, rest(held, (0.3, 0.8)), InputHistory(torque, force), DT))
    assert (made[0].link_velocity[:, 0] == 0.0).mean() > 0.1
    np.testing.assert_allclose(made[1].state, made[0].state, atol=1e-8)


def test_tilted_bearings_of_a_chain_read_as_those_of_two_links():
    seen = []
    for arm in (FLAT, SPACE):
        leaning = arm.with_effect(BearingCrosstalk(coefficient=1e-5), 'joint1').with_effect(
            BearingCrosstalk(coefficient=1e-5), 'joint2')
        plant = Plant(leaning, rest(leaning, (0.3, 0.0)), DT, 0)       # all in one line
        seen.append(plant.sample()[:, LINK].copy())
    np.testing.assert_allclose(seen[1], seen[0], atol=1e-13)
    assert abs(seen[1][0] - 0.3) > 1e-5


def frictionless() -> Arm:
    """Return the seven-joint arm without anything that takes energy."""
    return replace(COBOT, joints=tuple(
        replace(joint, dry_friction=0.0, viscous_friction=0.0,
                torsion=replace(joint.torsion, damping=0.0)) for joint in COBOT.joints))


@pytest.mark.parametrize('effects', [(), (BaseVibration(amplitude=0.01, damping=0.0),)])
def test_seven_joints_that_fall_keep_their_energy(effects):
    arm = pair_with(frictionless(), effects)
    idle = np.zeros((800, 7)), np.zeros((800, 2))
    states = rollout(arm, rest(arm, home_of(arm)), InputHistory(*idle), DT,
                     step=DT / 16).state[::100]
    found = [energy(arm, state) for state in states]
    moved = 0.5 * np.abs(states[-1, :, LINK_VELOCITY]).max()
    assert moved > 0.5
    np.testing.assert_allclose(found, found[0], atol=1e-5)


def test_friction_of_seven_joints_only_takes_energy():
    idle = np.zeros((800, 7)), np.zeros((800, 2))
    states = rollout(COBOT, rest(COBOT, home_of(COBOT)), InputHistory(*idle), DT).state[::10]
    found = np.array([energy(COBOT, state) for state in states])
    assert np.diff(found).max() < 1e-6
    assert found[-1] < found[0] - 0.1


def test_a_wrench_on_the_tip_has_moments_too():
    torque, idle = np.zeros((200, 7)), np.zeros((200, 6))
    turned = idle.copy()
    turned[:, 5] = 3.0
    start = rest(COBOT, home_of(COBOT))
    free, pushed = (rollout(COBOT, start, InputHistory(torque, force), DT).link_angle
                    for force in (idle, turned))
    assert np.abs(pushed - free).max() > 1e-5
    flat = rollout(COBOT, start, InputHistory(torque, idle[:, :2]), DT).link_angle
    np.testing.assert_array_equal(flat, free)


@pytest.mark.parametrize('kind', [
    kind for kind in EFFECTS if kind.name in SIZED
    and kind.name not in ('inertial_coupling', 'external_contact')], ids=lambda kind: kind.name)
def test_every_effect_acts_on_seven_joints(kind):
    label = None if kind.scope is Scope.ARM else 'joint4'
    size = typical(COBOT, kind.name, label)
    if isinstance(size, TorqueSaturation):
        size = TorqueSaturation(limit=0.2)      # of what the motion needs of it
    arm = COBOT.with_effect(size, label)
    path = motion_of(COBOT, 'rich', 2.0, DT, 1)
    with_it, without = (run(each, COBOT, path, 3).reading for each in (arm, COBOT))
    assert not np.array_equal(with_it, without, equal_nan=True)


def test_a_swinging_base_moves_with_seven_joints():
    arm = COBOT.with_effect(BaseVibration(amplitude=0.02, frequency=9.0))
    idle = np.zeros((300, 7)), np.zeros((300, 2))
    offset = rollout(arm, rest(arm, home_of(arm)), InputHistory(*idle), DT).state[:, 0,
                                                                                  BASE_OFFSET]
    assert 1e-5 < np.abs(offset).max() < 0.1


def test_seven_joints_follow_their_motion():
    path = motion_of(COBOT, 'sine', 4.0, DT, 0)
    made = run(COBOT, COBOT, path, 0)
    assert np.abs(made.state[:, :, 2] - path.angle).max() < 0.05
    assert (np.abs(path.angle) <= [joint.angle_limit for joint in COBOT.joints]).all()


def test_motions_stay_within_what_the_description_allows():
    """Around a home of its own: the middle half of the range is where a motion may start."""
    arm = narrow(-2.0, -1.5)
    assert arm.ranges()[3].tolist() == [-2.0, -1.5]
    assert -1.875 <= home_of(arm)[3] <= -1.625
    for name in MOTIONS:
        angle = motion_of(arm, name, 8.0, DT, 1).angle[:, 3]
        assert angle.min() >= -2.0 - 1e-9 and angle.max() <= -1.5 + 1e-9


def test_the_published_description_states_the_range():
    assert 'lower="-2" upper="-1.5"' in urdf(narrow(-2.0, -1.5))


def test_a_range_that_the_angle_limit_excludes_is_one_line():
    with pytest.raises(ArmError, match='joint4 cannot turn: its angle_limit is 2.6 rad, and the '
                                       'description states -3 rad at most'):
        narrow(-4.0, -3.0)


def test_a_live_arm_takes_commands_and_wrenches():
    live = LiveArm(COBOT, SimulationSettings(), 1_000_000_000)
    live.push(np.array([1.0, 2.0, 3.0, np.nan, np.nan, np.nan]))
    live.command(live.stamp, np.full(7, 0.01))
    live.advance()
    assert np.isfinite(live.sample().reading[:, :2]).all()
    assert live.sample().tip_force.tolist() == [1.0, 2.0, 3.0, 0.0, 0.0, 0.0]


def test_light_links_behind_stiff_gears_take_shorter_steps():
    assert longest_step(FLAT) == math.inf
    stiff = replace(COBOT, joints=tuple(
        replace(joint, torsion=TorsionLaw(flexspline_stiffness=4e5, damping=200.0))
        for joint in COBOT.joints))
    assert longest_step(stiff) < 0.3 * STEP
    idle = np.zeros((100, 7)), np.zeros((100, 2))
    assert np.isfinite(rollout(stiff, rest(stiff, home_of(stiff)), InputHistory(*idle),
                               DT).state).all()


@pytest.mark.parametrize(('effect', 'label', 'reported'), [
    (InertialCoupling(share=-1.0), None, 'two links in a plane'),
    (LinkInertiaError(error=-0.9), 'joint2', 'no body has'),
    (BaseVibration(amplitude=0.5), None, 'one over the mass')])
def test_what_a_chain_cannot_be_is_refused(effect, label, reported):
    with pytest.raises(ArmError, match=reported):
        COBOT.with_effect(effect, label)


@pytest.mark.parametrize(('effect', 'label'), [
    (Payload(mass=1.0, y=0.1), None), (Payload(mass=1.0, z=0.1), None),
    (LinkInertiaError(centre_x=0.1), 'joint1'), (LinkInertiaError(centre_z=0.1), 'joint1')])
def test_numbers_of_chains_are_refused_by_links_in_a_plane(effect, label):
    with pytest.raises(ArmError, match='is for chains'):
        FLAT.with_effect(effect, label)
    assert SPACE.with_effect(effect, label) is not None


def test_a_body_beyond_the_tip_is_one_of_two_links_in_a_plane():
    torque, force = inputs(2)
    held = Payload(mass=1.5, x=0.1, radius=0.05)
    flat, space = (rollout(arm, rest(arm, (0.3, 0.8)), InputHistory(torque, force), DT)
                   for arm in (FLAT.with_effect(held), SPACE.with_effect(held)))
    np.testing.assert_allclose(space.state, flat.state, atol=1e-9)


def test_a_heavier_link_is_one_of_a_heavier_description():
    """Mass, moment and inertia of the only body behind a joint grow together."""
    text = planar(PAIR)
    body = text.index('<link name="two">')
    heavy = text[:body] + re.sub(r'(?<=mass value=")[^"]+|(?<=i[xyz][xyz]=")[^"]+',
                                 lambda found: repr(1.3 * float(found[0])), text[body:])
    made = SPACE.with_effect(LinkInertiaError(mass=0.3), 'joint2').moving_parts()
    other = ChainLinks(kept(heavy), 'tip', ('joint1', 'joint2')).parts
    np.testing.assert_allclose(made[1:], other[1:], rtol=1e-12, atol=1e-15)


def test_a_heavier_second_link_is_the_same_in_a_plane_if_its_centre_is_halfway():
    torque, force = inputs(2)
    rod = Arm(JOINTS, ChainLinks(kept(planar(PAIR, (10.0, 10.0))), 'tip', ('joint1', 'joint2')))
    heavier, tilt = LinkInertiaError(mass=0.2, error=0.1), BaseTilt(tilt=0.4, direction=0.7)
    flat, space = (rollout(arm, rest(arm, (0.3, 0.8)), InputHistory(torque, force), DT)
                   for arm in (each.with_effect(heavier, 'joint2').with_effect(tilt)
                               for each in (FLAT, rod)))
    np.testing.assert_allclose(space.state, flat.state, atol=1e-9)


def test_what_turns_about_joint_1_is_heavier_with_its_moment():
    made = FLAT.with_effect(LinkInertiaError(mass=0.2, error=0.1), 'joint1').moving_links()
    assert (made.p1, made.first) == pytest.approx((1.1 * 1.2 * PAIR.p1, 1.2 * PAIR.first))
    assert made == replace(PAIR, p1=made.p1, first=made.first)


def test_more_than_two_joints_get_advice_how_to_give_links():
    arm = replace(COBOT, links=None)
    with pytest.raises(ArmError, match='urdf: FILE'):
        rollout(arm, rest(arm, home_of(COBOT)), InputHistory(np.zeros((2, 7)), np.zeros((2, 2))),
                DT)
    with pytest.raises(ArmError, match='urdf: FILE'):
        replace(COBOT, links=PAIR)
    with pytest.raises(ArmError, match='chain of 7 joints'):
        replace(COBOT, joints=COBOT.joints[:6])


def test_torque_feedback_and_estimates_reach_every_joint():
    path = motion_of(COBOT, 'sine', 3.0, DT, 0)
    made = run(COBOT, COBOT, path, 0, controller=ControllerSettings(torque_feedback=0.3))
    assert np.abs(made.estimated_torque - made.joint_torque)[1000:].max() < 3.0


def test_the_description_of_a_chain_puts_every_frame_where_it_is():
    links = COBOT.links
    again = ChainLinks(kept(with_masses(urdf(COBOT))), 'tool', COBOT.labels)
    for column, count in ((OFFSET, 3), (ROTATION, 9)):
        np.testing.assert_allclose(again.parts[:, column:column + count],
                                   links.parts[:, column:column + count], atol=1e-9)


def with_masses(text: str) -> str:
    """Return a description of frames with a mass in every link."""
    mass = ('<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
            '</inertial>')
    text = re.sub(r'<visual>.*?</visual>', '', text, flags=re.DOTALL)
    text = re.sub(r'<link name="(\w+)">\s*</link>', r'<link name="\1" />', text)
    return re.sub(r'<link name="(\w+)" />', rf'<link name="\1">{mass}</link>', text)
