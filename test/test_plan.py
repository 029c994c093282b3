"""
A planned motion separates what it was planned for, within the limits, and says when none can.

That it separates is tried with the hidden truth of `truth/`, other seeds and other sizes.
"""

import json

from hda_arm_sim.model.effects import effect_named, Scope
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.model.kernel import LINK_ANGLE, MOTOR_VELOCITY
from hda_arm_sim.model.typical_sizes import SIZED, typical
from hda_arm_sim.motion_file import read_motion, write_motion
from hda_arm_sim.motions import motion, MotionError
from hda_torque_estimator.cli import main
from hda_torque_estimator.diagnosis.diagnose import diagnose
from hda_torque_estimator.diagnosis.fitting.hypotheses import HYPOTHESES
from hda_torque_estimator.diagnosis.judging.selection_criteria import LOOKED_AT
from hda_torque_estimator.measurements.measurement import Measurement
from hda_torque_estimator.planning.paths import candidates, Path
from hda_torque_estimator.planning.question import question, shown
from hda_torque_estimator.planning.separation import separation
from hda_torque_estimator.simulating.closed_loop import run
import numpy as np
import pytest
from truth import draw, record, Reference

ARM = read_arm('hda_arm.yaml')
PAIR = ('link_encoder_eccentricity', 'encoder_scale_error')     # alike until a link turns far
TIED = 16.0


@pytest.fixture(scope='module')
def planned(tmp_path_factory):
    """Return the motion that `hda plan` writes for PAIR."""
    file = tmp_path_factory.mktemp('plan') / 'motion.csv'
    assert main(['plan', '--arm', 'hda_arm.yaml', '--between', *PAIR, '--duration', '10', '--out',
                 str(file)]) == 0
    return read_motion(file, ARM.labels, 1e-3)


def hidden(name, joint, seed):
    """Return an effect of the truth, drawn until it is at this joint."""
    random = np.random.default_rng(seed)
    return next(drawn for drawn in iter(lambda: draw(name, random), None) if drawn.joint == joint)


@pytest.mark.parametrize('name', PAIR)
def test_planned_motion_separates_what_is_really_hidden(name, planned):
    made = record([hidden(name, 'joint1', 17)], Reference(planned.angle, planned.rate, 1e-3),
                  seed=931)
    measured = Measurement(ARM.labels, 1e-3, np.stack([made.motor_angle, made.link_angle], axis=2),
                           made.command)
    found = diagnose(measured, ARM, names=PAIR).diagnosis
    assert [(one.effect, one.joint) for one in found.findings] == [(name, 'joint1')]
    assert found.ambiguous == ()


def test_planned_motion_keeps_the_limits_of_the_arm(planned):
    made = run(ARM, ARM, planned, 3)
    for column, joint in enumerate(ARM.joints):
        assert np.abs(made.command[:, column]).max() < joint.torque_limit
        assert np.abs(made.state[:, column, MOTOR_VELOCITY]).max() < joint.velocity_limit
        assert np.abs(made.state[:, column, LINK_ANGLE]).max() < joint.angle_limit


def test_planned_motion_ends_where_it_began_at_rest(planned):
    assert planned.angle[-1] == pytest.approx(planned.angle[0], abs=1e-6)
    assert planned.rate[[0, -1]] == pytest.approx(0.0, abs=1e-3)


def test_pair_that_no_motion_separates_is_reported(tmp_path, capsys):
    file = tmp_path / 'motion.csv'
    words = ['plan', '--arm', 'hda_arm.yaml', '--between', 'asymmetric_friction', 'drive_offset',
             '--duration', '10', '--out', str(file), '--json']
    assert main(words) == 0
    report = json.loads(capsys.readouterr().out)
    assert report['separates'] is False and report['out'] is None
    assert report['strength'] < 1.0 < report['needed'] == TIED
    assert report['between'] == [['asymmetric_friction', 'joint1'], ['drive_offset', 'joint1']]
    assert not file.exists()


@pytest.mark.parametrize(('between', 'says'), [
    (('stickiness', 'payload'), "no effect is named 'stickiness'"),
    (('payload', 'payload'), 'two different effects, got payload twice'),
    (('backlash@joint1', 'backlash'), 'two different effects, got backlash@joint1 twice'),
    (('backlash@joint3', 'payload'), "no joint 'joint3'"),
    (('payload@joint1', 'backlash'), 'payload belongs to the arm as a whole'),
    (('backlash@', 'payload'), 'name a joint after the @'),
    (('coarse_quantisation', 'backlash'), 'no motion is planned for coarse_quantisation'),
])
def test_pair_that_cannot_be_asked_is_one_line(between, says, tmp_path, capsys):
    words = ['--between', *between, '--out', str(tmp_path / 'motion.csv')]
    assert main(['plan', '--arm', 'hda_arm.yaml', *words]) == 2
    said = capsys.readouterr().err
    assert len(said.splitlines()) == 1 and says in said


@pytest.mark.parametrize(('words', 'says'), [
    (['--arm', 'voraus_yucobot.yaml', '--out', 'motion.csv'], 'without links'),
    (['--arm', 'hda_arm.yaml', '--out', 'nowhere/motion.csv'], 'a folder that exists'),
    (['--arm', 'hda_arm.yaml', '--out', 'motion.csv', '--duration', '3'], '10 to 120 s'),
])
def test_place_or_arm_that_cannot_be_used_is_one_line(words, says, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(['plan', '--between', 'payload', 'backlash', *words]) == 2
    said = capsys.readouterr().err
    assert len(said.splitlines()) == 1 and says in said


def test_every_effect_that_balances_show_has_a_typical_size_that_an_arm_can_have():
    assert set(HYPOTHESES) <= set(SIZED)
    for name in SIZED:
        joint = None if effect_named(name).scope is Scope.ARM else 'joint2'
        arm = ARM.with_effect(typical(ARM, name, joint), joint)
        assert repr(arm.record()) != repr(ARM.record()), name


def test_joint_of_one_effect_is_the_joint_of_the_other():
    asked = question(ARM, 'backlash', 'clock_skew@joint2')
    assert [suspect.label for suspect in asked.suspects] == ['backlash@joint2',
                                                             'clock_skew@joint2']


def test_a_motion_shows_an_effect_or_does_not():
    asked = shown(ARM, ['cable_spring'])
    assert [suspect.label for suspect in asked.suspects] == ['cable_spring@joint1']
    seen = {}
    for name, size in (('wide', 0.5), ('nearly at rest', 0.002)):
        path = Path('wave', (size, size), harmonics=(1, 6), seed=1).motion(2, 10.0, 2e-3, [3, 3])
        healthy = run(ARM, ARM, path, 7, estimator=None)
        seen[name] = separation(asked, path, healthy).least
    assert seen['wide'] > LOOKED_AT > 0.2 * LOOKED_AT > seen['nearly at rest']


def test_what_cannot_be_shown_is_one_line(tmp_path, capsys):
    for words, says in ((['dropped_samples'], 'no motion is planned for dropped_samples'),
                        (['backlash@'], "--show got 'backlash@'"),
                        (['friction'], "no effect is named 'friction'")):
        assert main(['plan', '--arm', 'hda_arm.yaml', '--show', *words, '--out',
                     str(tmp_path / 'motion.csv')]) == 2
        assert says in capsys.readouterr().err


@pytest.mark.parametrize('path', candidates(2), ids=lambda path: path.label)
def test_candidates_begin_and_end_at_the_same_place_at_rest(path):
    made = path.motion(2, 20.0, 2e-3, [3.0, 3.0])
    assert made.angle[-1] == pytest.approx(made.angle[0], abs=1e-9)
    assert made.rate[[0, -1]] == pytest.approx(0.0, abs=1e-3)
    assert np.abs(made.angle).max() <= 3.0
    assert np.ptp(made.angle, axis=0).min() > 0.05


def test_motion_file_gives_the_motion_back(tmp_path):
    asked = motion('rich', 2, 20.0, 1e-3, 0)
    write_motion(tmp_path / 'rich.csv', asked, ARM.labels)
    back = read_motion(tmp_path / 'rich.csv', ARM.labels, 1e-3)
    assert back.time == pytest.approx(asked.time)
    assert back.angle == pytest.approx(asked.angle, abs=1e-6)
    assert back.rate == pytest.approx(asked.rate, abs=1e-4)
    assert len(read_motion(tmp_path / 'rich.csv', ARM.labels, 2e-3, 10.0).time) == 5001


def test_simulate_runs_a_motion_file(tmp_path, capsys):
    write_motion(tmp_path / 'sine.csv', motion('sine', 2, 6.0, 1e-3, 0), ARM.labels)
    assert main(['simulate', '--arm', 'hda_arm.yaml', '--motion', str(tmp_path / 'sine.csv'),
                 '--out', str(tmp_path / 'bag'), '--json']) == 0
    assert json.loads(capsys.readouterr().out)['samples'] == 6001


HEADER = ('time [s],joint1 angle [rad],joint2 angle [rad],joint1 rate [rad/s],'
          'joint2 rate [rad/s]\n')


@pytest.mark.parametrize(('text', 'says'), [
    ('', "no column 'time [s]'"),
    (HEADER.replace('[rad]', '[deg]'), "no column 'joint1 angle [rad]'"),
    (HEADER, 'at least two rows'),
    (HEADER + '0,0,0,0,0\n0,0,0,0,0\n', 'times must grow'),
    (HEADER + '0,0,0,0,0\n1,0,0,0\n', 'row 3: expected 5 numbers'),
    (HEADER + '0,0,0,0,0\n7\n', 'row 3: expected 5 numbers'),
    (HEADER + '0,0,zero,0,0\n', 'row 2: expected 5 numbers'),
    (HEADER + '0,0,0,0,0\n1,0,nan,0,0\n', 'row 3: every number must be finite'),
    (HEADER + '0,0,0,0,0\n1,0,0,0,0\n', 'lasts 1 s, got a duration of 9 s'),
])
def test_motion_file_that_cannot_be_used_is_one_sentence(text, says, tmp_path):
    file = tmp_path / 'motion.csv'
    file.write_text(text)
    with pytest.raises(MotionError) as error:
        read_motion(file, ARM.labels, 1e-3, 9.0)
    assert says in str(error.value)
