"""`hda estimate --tare` takes the zero of the torsion as the live service does."""

import json

from hda_arm_sim.model.files import read_arm
from hda_arm_sim.model.writing import arm_to_text
from hda_msgs_json.bag import open_recording
from hda_msgs_json.topics import ESTIMATOR_STATE
from hda_torque_estimator.cli import main
from hda_torque_estimator.commands.tare_option import stretch
from hda_torque_estimator.estimating.estimator import Estimator, EstimatorSettings
from hda_torque_estimator.samples.readings import motor_commands, readings
import numpy as np
import pytest

ARM = 'hda_arm.yaml'
OFFSET = 0.02           # of the first motor's encoder, 0.2 mrad of torsion [rad]


def simulated(folder, motion):
    """Return a bag of an arm of which one encoder has another zero than its model says."""
    text = arm_to_text(read_arm(ARM))
    file, bag = folder / f'{motion}.yaml', folder / motion
    file.write_text(text.replace('zero: 0.0', f'zero: {OFFSET}', 1))
    assert main(['simulate', '--arm', str(file), '--motion', motion, '--duration', '3', '--out',
                 str(bag)]) == 0
    return bag


@pytest.fixture(scope='module')
def bag(tmp_path_factory):
    """Return a bag of an arm at rest."""
    return simulated(tmp_path_factory.mktemp('rest'), 'standstill')


def test_the_zero_is_taken_reported_and_used(bag, tmp_path, capsys):
    out = tmp_path / 'out'
    assert main(['estimate', str(bag), '--arm', ARM, '--fusion', 'off', '--tare', '1:2', '--out',
                 str(out), '--json']) == 0
    report = json.loads(capsys.readouterr().out.splitlines()[-1])['tare']
    assert (report['begin'], report['end'], report['samples']) == (1.0, 2.0, 1000)
    assert report['zero']['joint1'] == pytest.approx(OFFSET / 100.0, rel=0.1)
    assert abs(report['zero']['joint2']) < 1e-5
    recording = open_recording(out)
    assert json.loads(recording.metadata['tare']) == report
    wrenches = recording.wrenches('joint1/torque')
    time = (wrenches.stamps - wrenches.stamps[0]) * 1e-9
    torque = wrenches.torque[:, 2]
    assert np.abs(torque[(time > 0.5) & (time < 2.0)]).min() > 1.0
    assert np.abs(torque[time > 2.0]).max() < 0.2


def test_the_state_shows_the_tare_while_it_is_under_way(bag, tmp_path):
    out = tmp_path / 'out'
    assert main(['estimate', str(bag), '--arm', ARM, '--tare', '1:2', '--out', str(out)]) == 0
    states = open_recording(out).texts(ESTIMATOR_STATE.name)
    time = (states.stamps - states.stamps[0]) * 1e-9
    flagged = np.array(['a tare is under way' in text for text in states.texts])
    assert time[flagged].min() == pytest.approx(1.0, abs=0.02)
    assert time[flagged].max() == pytest.approx(2.0, abs=0.03)
    assert flagged.sum() == pytest.approx(50, abs=2)


def test_the_command_and_the_service_give_the_same_bits(bag):
    arm, samples = read_arm(ARM), open_recording(bag).joint_states()
    stamps, reading = samples.stamps, readings(arm.labels, samples)
    command = motor_commands(arm.labels, samples)
    begin, end = 500, 1200
    live = Estimator(arm, EstimatorSettings(tare_time=(end - begin) * 1e-3))
    results = []
    for index in range(2000):
        if index == begin:
            live.tare()
        live.update(int(stamps[index]), reading[index], command[index])
        results.append(live.joints.copy())
    whole, parts = Estimator(arm).in_parts(stamps[:2000], reading[:2000], command[:2000], 300,
                                           (int(stamps[begin]), int(stamps[end])))
    under_way = np.concatenate([np.full(len(part.stamps), part.taring) for part in parts])
    np.testing.assert_array_equal(whole.joints, np.array(results))
    np.testing.assert_array_equal(np.flatnonzero(under_way), np.arange(begin, end - 1))


@pytest.mark.parametrize('text', ['1', '2:1', '1:1', '-1:2', 'a:b', 'nan:1', '0:inf', '1:2:3', '',
                                  ':', '0:1\n2'])
def test_what_is_no_stretch_is_one_line(text, bag, tmp_path, capsys):
    with pytest.raises(SystemExit) as stop:
        main(['estimate', str(bag), '--arm', ARM, f'--tare={text}', '--out',
              str(tmp_path / 'out')])
    said = capsys.readouterr()
    assert stop.value.code == 2
    assert len(said.err.splitlines()) == 1
    assert '0 <= A < B' in said.err
    assert not (tmp_path / 'out').exists()


@pytest.mark.parametrize(('motion', 'asked', 'says'), [
    ('standstill', '0:4', 'outside'), ('standstill', '1e300:1e301', 'outside'),
    ('standstill', '1.00001:1.00002', 'no sample'), ('sine', '1:2', 'moves')])
def test_a_stretch_that_gives_no_zero_is_refused(motion, asked, says, bag, tmp_path, capsys):
    path = bag if motion == 'standstill' else simulated(tmp_path, motion)
    capsys.readouterr()
    out = tmp_path / 'out'
    assert main(['estimate', str(path), '--arm', ARM, '--tare', asked, '--out', str(out)]) == 2
    said = capsys.readouterr()
    assert len(said.err.splitlines()) == 1
    assert says in said.err
    assert not out.exists()


def test_a_whole_recording_can_be_named():
    assert stretch('0:3') == (0.0, 3.0)
