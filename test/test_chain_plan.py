"""Motions are planned for chains: within the limits of every joint, about a home of their own."""

from chains import narrow
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.model.kernel import LINK_ANGLE, MOTOR_VELOCITY
from hda_arm_sim.motions import home_of
from hda_torque_estimator.cli import main
from hda_torque_estimator.diagnosis.judging.selection_criteria import LOOKED_AT
from hda_torque_estimator.planning.paths import candidates, Path
from hda_torque_estimator.planning.plan import planned_motion
from hda_torque_estimator.planning.question import question, shown
from hda_torque_estimator.planning.separation import load_of, separation
from hda_torque_estimator.simulating.closed_loop import run
import numpy as np
import pytest

COBOT = read_arm('cobot7.yaml')
ASKED = shown(COBOT, ['backlash@joint4'])
LIMITS = np.array([[joint.angle_limit, joint.velocity_limit / joint.ratio]
                   for joint in COBOT.joints]).T


@pytest.mark.parametrize('path', candidates(7), ids=lambda path: path.label)
def test_every_joint_of_a_candidate_moves_within_its_limits(path):
    made = planned_motion(ASKED, path, 20.0, 2e-3)
    assert (np.abs(made.angle) < LIMITS[0]).all() and (np.abs(made.rate) < LIMITS[1]).all()
    assert made.angle[-1] == pytest.approx(made.angle[0], abs=1e-9)
    assert made.rate[[0, -1]] == pytest.approx(0.0, abs=1e-3)
    assert np.ptp(made.angle, axis=0).min() > 0.05


@pytest.mark.parametrize('path', candidates(7), ids=lambda path: path.label)
def test_a_candidate_keeps_the_range_of_the_description(path):
    """Of 0.9 rad, 1.55 to 2.45 rad away from zero; a plan leaves some of it for overshoot."""
    asked = shown(narrow(-2.45, -1.55), ['backlash@joint4'])
    angle = planned_motion(asked, path, 20.0, 2e-3).angle[:, 3]
    assert angle.min() > -2.43 and angle.max() < -1.57
    assert np.ptp(angle) > 0.05


def test_a_load_is_the_share_of_the_range():
    arm = narrow(-2.45, -1.55)
    path = planned_motion(shown(arm, ['backlash@joint4']), Path('full turn', (1.8,) * 7), 10.0,
                          1e-3)
    load = load_of(arm, run(arm, arm, path, 3, estimator=None))
    assert 0.8 < load.angle[3] < 1.0


def test_a_small_motion_goes_on_about_the_home_of_the_chain():
    made = planned_motion(ASKED, Path('wave', (0.05,) * 7), 20.0, 2e-3)
    np.testing.assert_allclose(made.angle[0], home_of(COBOT), atol=1e-9)


def test_an_arm_keeps_its_limits_on_the_way():
    path = Path('full turn', (1.8,) * 7)
    made = run(COBOT, COBOT, planned_motion(ASKED, path, 10.0, 1e-3), 3, estimator=None)
    for column, joint in enumerate(COBOT.joints):
        assert np.abs(made.command[:, column]).max() < joint.torque_limit
        assert np.abs(made.state[:, column, MOTOR_VELOCITY]).max() < joint.velocity_limit
        assert np.abs(made.state[:, column, LINK_ANGLE]).max() < joint.angle_limit
    assert 0.3 < load_of(COBOT, made).largest < 1.0


def test_a_motion_shows_a_play_of_an_elbow_or_does_not():
    seen = {}
    for name, size in (('far', 1.8), ('nearly at rest', 0.003)):
        path = planned_motion(ASKED, Path('full turn', (size,) * 7), 10.0, 2e-3)
        healthy = run(COBOT, COBOT, path, 7, estimator=None)
        seen[name] = separation(ASKED, path, healthy).least
    assert seen['far'] > LOOKED_AT > 0.2 * LOOKED_AT > seen['nearly at rest']


def test_a_motion_distinguishes_two_joints():
    asked = question(COBOT, 'backlash@joint2', 'backlash@joint4')
    path = planned_motion(asked, Path('full turn', (1.8,) * 7), 10.0, 2e-3)
    healthy = run(COBOT, COBOT, path, 7, estimator=None)
    assert separation(asked, path, healthy).least > 20.0


def test_what_is_not_looked_for_on_a_chain_is_refused_in_one_line(tmp_path, capsys):
    assert main(['plan', '--arm', 'cobot7.yaml', '--show', 'inertial_coupling', '--out',
                 str(tmp_path / 'motion.csv')]) == 2
    said = capsys.readouterr().err
    assert len(said.splitlines()) == 1 and 'does not look for it on a chain' in said
