"""A push on any link of a chain: what it does to the arm, and where it is said to be."""

from dataclasses import replace

from chains import tables
from hda_arm_sim.drive import act
from hda_arm_sim.foundation import chain as of
from hda_arm_sim.model.energy import energy
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.model.kernel import LINK_ANGLE, registers, STATE, STATES
from hda_arm_sim.model.link_side import loaded_inertia
from hda_arm_sim.motions import home_of, motion_of, MotionError
from hda_arm_sim.start import start_of
from hda_msgs_json.bag import BagWriter, open_recording
from hda_torque_estimator.cli import main
from hda_torque_estimator.estimating.contacts import Contact, contact_lines, contacts
from hda_torque_estimator.estimating.estimates import Estimates
from hda_torque_estimator.estimating.estimator import Estimator
from hda_torque_estimator.estimating.laws.contact import contact_level
from hda_torque_estimator.estimating.state_messages import touched_beyond
from hda_torque_estimator.simulating.closed_loop import ClosedLoopRun, run
from hda_torque_estimator.simulating.recorded import write_run
from hypothesis import given, strategies as st
import numpy as np
import pytest

COBOT = read_arm('cobot7.yaml')
LEVEL = contact_level(4.0, 7)
STEP = 1e-6
# The outermost joint that a force at the end of a link turns: axes pass through some ends.
FELT_BY = {2: 2, 3: 3, 4: 4, 5: 4, 6: 6, 7: 6}


def pushed_at(link: int, seed: int = 0) -> tuple[ClosedLoopRun, Estimates]:
    """Return a run with two pushes at the end of a link, 0 for the tip, and its estimates."""
    path = motion_of(COBOT, 'push', 8.0, 1e-3, seed)._replace(pushed=link)
    made = run(COBOT, COBOT, path, seed, estimator=None)
    stamps = np.round(made.time * 1e9).astype(np.int64) + 1
    return made, Estimator(COBOT).run(stamps, made.reading, made.command)


@given(tables(), st.data())
def test_a_wrench_on_a_link_does_its_work(table, data):
    """Virtual work: the torques are the slopes of the end's place and turn, (eq:chain)."""
    n = len(table) - 2
    link = data.draw(st.integers(1, n))
    wrench, angle = table[-1, of.WRENCH:of.WRENCH + 6].copy(), table[1:-1, of.ANGLE].copy()
    table[-1, of.WRENCH:of.WRENCH + 6] = 0.0
    with_wrench = table.copy()
    with_wrench[link, of.WRENCH:of.WRENCH + 6] = wrench
    for each in (table, with_wrench):
        of.place(each)
        of.inverse_dynamics(each)
    done = table[1:-1, of.TORQUE] - with_wrench[1:-1, of.TORQUE]
    for joint, move in enumerate(STEP * np.eye(n)):
        ends = []
        for sign in (1.0, -1.0):
            moved = table.copy()
            moved[1:-1, of.ANGLE] = angle + sign * move
            of.place(moved)
            ends.append(moved[link + 1, of.PLACE:of.PLACE + 3].copy())
        turned = table[joint + 1, of.TURNING:of.TURNING + 3] if joint < link else np.zeros(3)
        work = wrench[:3] @ (ends[0] - ends[1]) / (2.0 * STEP) + wrench[3:] @ turned
        assert abs(done[joint] - work) < 1e-6 * (1.0 + np.abs(table[1:-1, of.TORQUE]).max())


def test_the_end_of_the_last_link_is_the_tip():
    made = [pushed_at(link)[0].reading for link in (0, 7)]
    np.testing.assert_allclose(*made, atol=1e-9)
    assert np.nanmax(np.abs(pushed_at(3)[0].reading - made[0])) > 1e-3


def end_of(links: of.Chain, link: int, angles: np.ndarray) -> np.ndarray:
    """Return where the end of a link is (3,) [m]."""
    links.table[1:-1, of.ANGLE] = angles
    of.place(links.table)
    return links.table[link + 1, of.PLACE:of.PLACE + 3].copy()


@pytest.mark.parametrize('link', [2, 4, 7])
def test_a_push_gives_an_arm_the_energy_of_its_work(link):
    """Without losses and motors the energy grows by the force times the way of the link's end."""
    arm = replace(COBOT, joints=tuple(
        replace(joint, dry_friction=0.0, viscous_friction=0.0,
                torsion=replace(joint.torsion, damping=0.0)) for joint in COBOT.joints))
    record, force = arm.record(), np.array([30.0, -20.0, 25.0, 0.0, 0.0, 0.0])
    start, links = start_of(arm, home_of(arm)).state, loaded_inertia(record.body)
    w = registers(start, link)
    for _ in range(300):
        act(record, links, w, np.zeros(7), force, 1e-3, 16)
    state = w[:7, STATE:STATE + STATES]
    way = (end_of(links, link, state[:, LINK_ANGLE]) - end_of(links, link, start[:, LINK_ANGLE]))
    assert abs(force[:3] @ way) > 1e-2
    assert energy(arm, state) - energy(arm, start) == pytest.approx(force[:3] @ way, abs=1e-5)


@pytest.mark.parametrize('link', FELT_BY)
def test_the_joint_beyond_which_a_link_is_pushed_is_identified(link):
    made, found = pushed_at(link, 2)
    estimated = np.array(touched_beyond(COBOT.labels, found.joints, found.tip))
    hard = np.abs(made.force).max(axis=1) > 10.0
    assert (estimated[hard] == f'joint{FELT_BY[link]}').mean() > 0.6
    assert set(estimated[hard]) <= {'', *COBOT.labels[:link]}            # never further out
    first, second = contacts(COBOT, found, LEVEL)
    assert {first.beyond, second.beyond} <= set(COBOT.labels[:link])
    assert f'joint{FELT_BY[link]}' in (first.beyond, second.beyond)
    assert 2.9 < first.begin < 3.3 and 4.1 < first.end < 4.6 and 5.4 < second.begin < 5.8


def test_a_push_on_an_axis_and_free_motion_are_no_contacts():
    assert contacts(COBOT, pushed_at(1)[1], LEVEL) == []            # the shoulder carries it


def test_many_contacts_are_counted():
    one = Contact(1.0, 2.0, 'joint2')
    assert contact_lines([one]) == ['contact from 1.00 to 2.00 s, beyond joint2']
    assert contact_lines([one] * 7)[5:] == ['and 2 contacts more']


def test_a_bag_shows_where_the_push_was(tmp_path):
    made, _ = pushed_at(3)
    for name, each in (('elbow', made), ('tip', replace(made, pushed=0))):
        with BagWriter(tmp_path / name, {}) as bag:
            write_run(bag, COBOT, each)
    elbow, tip = (open_recording(tmp_path / name) for name in ('elbow', 'tip'))
    there, nothing = elbow.wrenches('truth/joint3/wrench'), elbow.wrenches('truth/tip/wrench')
    np.testing.assert_array_equal(np.column_stack([there.force, there.torque]), made.force)
    assert not nothing.force.any() and 'external_wrench' not in elbow.topics
    assert tip.wrenches('truth/tip/wrench').force.any()


@pytest.mark.parametrize(('arm', 'motion', 'place', 'reported'), [
    ('cobot7.yaml', 'sine', 'joint3', 'needs a motion that pushes'),
    ('cobot7.yaml', 'push', 'elbow', "no joint 'elbow'"),
    ('hda_arm.yaml', 'push', 'joint1', 'pushed at its tip')])
def test_a_push_that_cannot_be_is_refused_in_one_line(arm, motion, place, reported, tmp_path,
                                                      capsys):
    code = main(['simulate', '--arm', arm, '--motion', motion, '--duration', '4', '--push-at',
                 place, '--out', str(tmp_path / 'bag')])
    said = capsys.readouterr().err
    assert code != 0 and reported in said and said.count('\n') == 1
    assert not (tmp_path / 'bag').exists()


def test_a_link_that_is_not_there_cannot_be_pushed():
    path = motion_of(COBOT, 'push', 4.0, 1e-3, 0)
    with pytest.raises(MotionError, match='1 to 7'):
        run(COBOT, COBOT, path._replace(pushed=8), 0)
