"""Every command that takes a recording takes one of seven joints, and reports all of them."""

from dataclasses import replace
import json
from pathlib import Path
from typing import Any

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.model.writing import write_arm
from hda_torque_estimator.cli import main
import numpy as np
import pytest

COBOT = read_arm('cobot7.yaml')
SIMULATE = 'simulate --arm cobot7.yaml --motion rich --duration 12 --seed 1'
WORN = '- {effect: kinematic_error, joint: joint4}\n'


@pytest.fixture(scope='module')
def bags(tmp_path_factory):
    """Return a folder of two devices: one is as its file says, one has a worn elbow."""
    folder = tmp_path_factory.mktemp('bags')
    (folder / 'worn.yaml').write_text(WORN)
    for words in ('--out {}/sound/one', '--effects {}/worn.yaml --out {}/worn/one'):
        assert main(f'{SIMULATE} {words.format(folder, folder)}'.split()) == 0
    (folder / 'notes').mkdir()
    (folder / 'notes' / 'tuesday.bag').touch()
    return folder


def report_of(capsys: pytest.CaptureFixture[str], words: str) -> dict[str, Any]:
    """Run a command, and return what it says of itself."""
    capsys.readouterr()
    assert main([*words.split(), '--json']) == 0
    report: dict[str, Any] = json.loads(capsys.readouterr().out)
    return report


def test_info_lists_every_joint_and_the_wrench_on_the_tip(bags, capsys):
    report = report_of(capsys, f'info {bags}/sound/one')
    names = [fact['name'] for fact in report['joint_states']['names']]
    assert names == [*COBOT.labels, *(f'{label}_motor' for label in COBOT.labels)]
    steps = {fact['name']: fact['step'] for fact in report['joint_states']['names']}
    for joint in COBOT.joints:
        assert steps[f'{joint.label}_motor'] == pytest.approx(
            2.0 * np.pi / joint.motor_encoder.counts, rel=1e-3)
    assert not any('stands still' in said for said in report['joint_states']['cannot_show'])
    assert {'/truth/joint7/torque', '/truth/tip/wrench'} <= set(report['topics'])


def test_a_run_compared_with_itself_differs_nowhere(bags, tmp_path, capsys):
    report = report_of(capsys, f'compare {bags}/sound/one {bags}/sound/one --out {tmp_path}/same')
    assert len(report['signals']) >= 3 * 2 * len(COBOT.joints)
    assert not any(signal['start'] for signal in report['signals'])


def test_a_worn_elbow_makes_two_runs_of_one_motion_differ(bags, tmp_path, capsys):
    report = report_of(capsys, f'compare {bags}/sound/one {bags}/worn/one --align none '
                       f'--out {tmp_path}/differ')
    differing = {signal['name'] for signal in report['signals'] if signal['start'] is not None}
    assert any('joint4' in name for name in differing)
    assert (tmp_path / 'differ' / 'compare.html').stat().st_size > 1000


@pytest.mark.study
def test_a_fleet_of_chains_is_diagnosed_by_processes(bags, tmp_path, capsys):
    report = report_of(capsys, f'diagnose --each {bags} --arm cobot7.yaml --out {tmp_path}/fleet')
    found = {line['directory']: line for line in report['bags']}
    assert set(found) == {'sound/one', 'worn/one'}
    assert found['sound/one']['verdict'] == 'no_discrepancy'
    assert {(cause['effect'], cause['joint']) for cause in found['worn/one']['findings']} == {
        ('kinematic_error', 'joint4')}
    assert report['devices'][0]['device'] == 'worn'
    assert any('notes' in said for said in report['skipped'])
    assert 'joint 4' in (tmp_path / 'fleet' / 'fleet.html').read_text().replace('\u00a0', ' ')


def simulated(folder: Path, arm: Arm) -> int:
    """Return the exit code of a simulation of an arm that a file describes."""
    write_arm(arm, folder / 'arm.yaml')
    return main(['simulate', '--arm', str(folder / 'arm.yaml'), '--motion', 'sine', '--duration',
                 '2', '--out', str(folder / 'run')])


def test_a_motor_that_cannot_hold_its_arm_is_told(tmp_path, capsys):
    weak = tuple(replace(joint, torque_limit=0.3) if joint.label == 'joint2' else joint
                 for joint in COBOT.joints)
    assert simulated(tmp_path, replace(COBOT, joints=weak)) == 0
    said, = capsys.readouterr().err.splitlines()
    assert said.startswith('joint2 is up to') and 'all of its 0.3 N*m' in said


@pytest.mark.study
def test_a_planned_motion_of_seven_joints_is_simulated(tmp_path, capsys):
    motion = tmp_path / 'motion.csv'
    report = report_of(capsys, 'plan --arm cobot7.yaml --show backlash@joint4 --duration 10 '
                       f'--out {motion}')
    assert report
    table = np.genfromtxt(motion, delimiter=',', names=True)
    assert len(table.dtype.names) == 1 + 2 * len(COBOT.joints)      # angle and rate of each
    assert main(['simulate', '--arm', 'cobot7.yaml', '--motion', str(motion), '--out',
                 str(tmp_path / 'run')]) == 0
    assert 'samples' in capsys.readouterr().out
