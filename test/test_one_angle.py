"""Robots with one angle for each joint, and with no motor side: what commands make of them."""

import json

from hda_msgs_json.bag import BagWriter
from hda_msgs_json.samples import JointSamples, WrenchSamples
from hda_msgs_json.topics import JOINT_STATES, reference_joint_torque
from hda_torque_estimator.cli import main
import numpy as np
import pytest

TIME = 0.005 * np.arange(2400)
STAMPS = 1 + np.rint(1e9 * TIME).astype(np.int64)
LABELS = 'joint1', 'joint2'
RATIO = 100.0


def bag(path, *, motors=True):
    """Write two joints with one angle each: that of the motor with its torque, or of the link."""
    angle = np.column_stack([np.sin(0.8 * TIME), np.cos(0.5 * TIME)])
    torque = np.column_stack([0.05 * np.sign(np.cos(0.8 * TIME)) + 0.1 * np.sin(0.8 * TIME),
                              -0.03 * np.sign(np.sin(0.5 * TIME))])
    nothing = np.full_like(angle, np.nan)
    names = tuple(f'{label}_motor' for label in LABELS) if motors else LABELS
    with BagWriter(path, {}) as writer:
        writer.write_joint_states(JOINT_STATES, JointSamples(
            STAMPS, names, (RATIO if motors else 1.0) * angle, nothing,
            torque if motors else nothing))
        for place, label in enumerate(LABELS):
            load = np.zeros((len(TIME), 3))
            load[:, 2] = 10.0 * angle[:, place]
            writer.write_wrenches(reference_joint_torque(label), WrenchSamples(
                STAMPS, label, np.full_like(load, np.nan), load))
    return str(path)


@pytest.fixture
def arm(tmp_path, capsys):
    """Return a function that writes an arm with dry frictions for its two joints."""
    def write(*friction):
        path = str(tmp_path / 'arm.yaml')
        assert main(['new', '--joints', *LABELS, '--gear', 'CSG-20-100', '--motor-inertia', '1e-4',
                     '--motor-torque', '1', '--motor-counts', '0', '--link-counts', '0',
                     '--starting-torque', *map(str, friction), '--out', path, '--force']) == 0
        capsys.readouterr()
        return path
    return write


def test_a_motor_that_nobody_knows_does_not_keep_the_others_from_being_estimated(
        tmp_path, arm, capsys):
    """A calibration may leave one joint as it was; the others tell their torques."""
    words = ['estimate', bag(tmp_path / 'bag'), '--arm', arm(0.05, 0.0), '--out',
             str(tmp_path / 'estimates')]
    assert main([*words, '--json']) == 0
    report = json.loads(capsys.readouterr().out)
    assert report['by_motor'] == ['joint1', 'joint2'] and report['unknown'] == ['joint2']
    assert report['errors']['reference/joint1/torque']['rms'] < 3.0
    assert main([*words, '--force']) == 0
    said = capsys.readouterr().out
    assert 'joint1: no link angle is in the bag; its motor alone' in said
    assert 'joint2: no link angle is in the bag; nothing is known of the friction' in said


def test_motors_of_which_nobody_knows_anything_are_refused_by_that_name(tmp_path, arm, capsys):
    assert main(['estimate', bag(tmp_path / 'bag'), '--arm', arm(0.0), '--out',
                 str(tmp_path / 'estimates')]) == 2
    said = capsys.readouterr().err
    assert 'no link angle of joint1, joint2; nothing is known of the friction' in said


def test_links_alone_are_refused_by_what_is_missing(tmp_path, arm, capsys):
    """Such as a robot that publishes its joints and their torque sensors, and no motor."""
    path, model = bag(tmp_path / 'bag', motors=False), arm(0.05)
    assert main(['diagnose', path, '--arm', model, '--out', str(tmp_path / 'found')]) == 2
    assert 'the motor side of joint1 was not recorded' in capsys.readouterr().err
    assert main(['calibrate', path, '--arm', model, '--out', str(tmp_path / 'new.yaml')]) == 2
    assert 'nothing can be calibrated: joint1, joint2: no recording has its motor angle, its ' \
        'reference/JOINT/torque' in capsys.readouterr().err


def test_what_motors_alone_cannot_show_is_said(tmp_path, capsys):
    standing = np.stack([100.0 * np.sin(TIME), np.full(len(TIME), 3.0)], axis=1)
    with BagWriter(tmp_path / 'bag', {}) as writer:
        writer.write_joint_states(JOINT_STATES, JointSamples(
            STAMPS, ('joint1_motor', 'joint2_motor'), standing, np.full_like(standing, np.nan),
            0.1 * standing))
    assert main(['info', str(tmp_path / 'bag')]) == 0
    said = capsys.readouterr().out
    assert 'no torsion of joint1, joint2: there is no link angle' in said
    assert 'nothing that needs motion of joint2: the motor stands still' in said
