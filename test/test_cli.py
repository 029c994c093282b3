"""Every command does its job, and every mistake ends in one line, exit code 2 and no debris."""

import json
from pathlib import Path

from command_line import complaint_of
from hda_arm_sim.model.files import read_arm
from hda_msgs_json.bag import BagWriter, open_recording
from hda_msgs_json.samples import JointSamples
from hda_msgs_json.topics import JOINT_STATES, JOINT_TORQUES, TIP_WRENCH
from hda_torque_estimator.cli import COMMANDS, main
from hda_torque_estimator.commands.estimate_command import error_words
from hda_torque_estimator.estimating.accuracy import EstimateErrors
from hda_torque_estimator.estimating.estimator import Estimator
from hda_torque_estimator.samples.readings import motor_commands, readings
import numpy as np
import pytest


@pytest.fixture(scope='module')
def bag(tmp_path_factory):
    """Return a bag of a simulated push."""
    path = tmp_path_factory.mktemp('bags') / 'push'
    assert main(['simulate', '--arm', 'hda_arm.yaml', '--motion', 'push', '--duration', '8',
                 '--seed', '3', '--out', str(path)]) == 0
    return path


def report_of(capsys, *words):
    """Return the JSON report of a command that does its job."""
    assert main([*words, '--json']) == 0
    return json.loads(capsys.readouterr().out.splitlines()[-1])


def test_simulation_is_deterministic_by_seed(bag, tmp_path, capsys):
    again = tmp_path / 'again'
    report_of(capsys, 'simulate', '--arm', 'hda_arm.yaml', '--motion', 'push', '--duration', '8',
              '--seed', '3', '--out', str(again))
    one, two = (open_recording(path).joint_states() for path in (bag, again))
    np.testing.assert_array_equal(one.position, two.position)


def test_bag_carries_arm_seed_and_parameters(bag):
    about = open_recording(bag).metadata
    assert about['seed'] == '3'
    assert 'motor_inertia' in about['arm']
    assert json.loads(about['parameters'])['motion'] == 'push'


def test_info_states_rate_resolution_and_what_is_missing(bag, capsys):
    report = report_of(capsys, 'info', str(bag))
    joints = report['joint_states']
    assert joints['rate'] == pytest.approx(1000.0)
    assert joints['gaps'] == joints['not_later'] == 0
    steps = {fact['name']: fact['step'] for fact in joints['names']}
    assert steps['joint1_motor'] == pytest.approx(2 * np.pi / 16384, rel=1e-6)
    assert steps['joint1'] == pytest.approx(2 * np.pi / 4e6, rel=1e-4)
    assert any('absolute scale' in sentence for sentence in joints['cannot_show'])
    assert main(['info', str(bag)]) == 0
    assert 'sensor_msgs/msg/JointState' in capsys.readouterr().out


def test_estimate_is_near_the_truth_and_equals_the_estimator(bag, tmp_path, capsys):
    out = tmp_path / 'estimated'
    report = report_of(capsys, 'estimate', str(bag), '--arm', 'hda_arm.yaml', '--out', str(out))
    errors = report['errors']
    assert errors['truth/joint1/torque']['rms'] < 0.05
    assert errors['truth/tip/wrench.x']['rms'] < 1.5
    recording = open_recording(bag)
    arm = read_arm('hda_arm.yaml')
    samples = recording.joint_states()
    found = Estimator(arm).run(samples.stamps, readings(arm.labels, samples),
                               motor_commands(arm.labels, samples))
    written = open_recording(out)
    np.testing.assert_array_equal(written.joint_states(JOINT_TORQUES.name).effort, found.torque)
    np.testing.assert_array_equal(written.wrenches(TIP_WRENCH.name).force[:, :2],
                                  found.base_force)


def test_fusion_can_be_switched(bag, tmp_path, capsys):
    reports = [report_of(capsys, 'estimate', str(bag), '--arm', 'hda_arm.yaml', '--out',
                         str(tmp_path / switch), '--fusion', switch) for switch in ('on', 'off')]
    torques = [open_recording(tmp_path / switch).joint_states(JOINT_TORQUES.name).effort
               for switch in ('on', 'off')]
    assert reports[0]['samples'] == reports[1]['samples']
    assert not np.array_equal(*torques)
    arm, samples = read_arm('hda_arm.yaml'), open_recording(bag).joint_states()
    alone = Estimator(arm).run(samples.stamps, readings(arm.labels, samples))
    np.testing.assert_array_equal(torques[1], alone.torque)


def test_effects_file_changes_the_arm_but_not_its_model(tmp_path, capsys):
    effects = tmp_path / 'effects.yaml'
    effects.write_text('- {effect: backlash, joint: joint1, parameters: {half_width: 1.0e-4}}\n')
    out = tmp_path / 'bag'
    report_of(capsys, 'simulate', '--arm', 'hda_arm.yaml', '--effects', str(effects), '--motion',
              'sine', '--duration', '4', '--out', str(out))
    about = open_recording(out).metadata
    assert 'backlash' not in about['arm']
    assert 'backlash' in about['effects']


def test_help_lists_every_command(capsys):
    with pytest.raises(SystemExit) as stop:
        main(['--help'])
    assert stop.value.code == 0
    shown = capsys.readouterr().out
    assert all(name in shown for name in COMMANDS)
    assert main([]) == 2


@pytest.mark.parametrize(('words', 'says'), [
    (['simulate', '--arm', 'nowhere.yaml', '--motion', 'rich', '--out', 'OUT'],
     "no arm file 'nowhere.yaml'"),
    (['simulate', '--arm', 'hda_arm.yaml', '--motion', 'dance', '--out', 'OUT'],
     'valid names: rich'),
    (['simulate', '--arm', 'hda_arm.yaml', '--motion', 'rich', '--duration', '0.5', '--out',
      'OUT'], 'lasts from'),
    (['simulate', '--arm', 'hda_arm.yaml', '--motion', 'rich', '--duration', 'soon', '--out',
      'OUT'], 'invalid float value'),
    (['simulate', '--arm', 'hda_arm.yaml', '--motion', 'rich', '--duration', '3', '--rate', '0',
      '--out', 'OUT'], 'rate'),
    (['simulate', '--arm', 'voraus_yucobot.yaml', '--motion', 'rich', '--out', 'OUT'],
     'links: none'),
    (['estimate', 'NOTHING', '--arm', 'hda_arm.yaml', '--out', 'OUT'], 'no recording'),
    (['estimate', 'EMPTY', '--arm', 'hda_arm.yaml', '--out', 'OUT'], 'EMPTY'),
    (['estimate', 'FOREIGN', '--arm', 'hda_arm.yaml', '--out', 'OUT'], 'FOREIGN'),
    (['estimate', 'BAG', '--arm', 'hda_arm.yaml', '--out', 'BAG'], 'exists'),
    (['estimate', 'BAG', '--arm', 'voraus_yucobot.yaml', '--out', 'OUT'], 'joint3'),
    (['info', 'EMPTY'], 'EMPTY'),
    (['import', 'NOTHING', '--map', 'kinova_gen3.yaml', '--out', 'OUT'], 'NOTHING'),
    (['dance'], 'invalid choice'),
    (['live', '--port', '65536'], 'from 0 to 65535'),
    (['live', '--port', '-1'], 'from 0 to 65535'),
    (['info'], 'required'),
])
def test_mistake_is_one_line(words, says, bag, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path('EMPTY').mkdir()
    Path('FOREIGN.mcap').write_bytes(b'this is no recording at all, just a text' * 40)
    places = {'BAG': str(bag), 'FOREIGN': 'FOREIGN.mcap'}
    before = sorted(Path().rglob('*'))
    said = complaint_of(capsys, *(places.get(word, word) for word in words))
    assert says in said
    assert sorted(Path().rglob('*')) == before, 'nothing half-written may be left'


def test_an_error_without_common_times_is_unknown_and_no_number():
    assert error_words(EstimateErrors(*[np.nan] * 4), 'N') == (
        'unknown, as at no time both are known')
    assert error_words(EstimateErrors(1.0, 2.0, 3.0, 4.0), 'N').startswith('1.000 N rms')


@pytest.mark.parametrize(('stamps', 'angle', 'said'), [
    (range(5), np.nan, 'none of 5 joint states'), ([0] * 5, 0.0, 'only 1 of 5 joint states')])
def test_bag_without_usable_samples_is_refused(stamps, angle, said, tmp_path, capsys):
    angles = np.full((5, 4), angle)
    names = ('joint1', 'joint2', 'joint1_motor', 'joint2_motor')
    with BagWriter(tmp_path / 'blank', {}) as writer:
        writer.write_joint_states(JOINT_STATES, JointSamples(
            np.array(stamps, np.int64), names, angles, angles, angles))
    assert said in complaint_of(capsys, 'estimate', str(tmp_path / 'blank'), '--arm',
                                'hda_arm.yaml', '--out', str(tmp_path / 'out'))
