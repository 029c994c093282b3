"""An arm file from a recording: what it shows is taken, what it contradicts is refused."""

from hda_arm_sim.model.files import read_arm
from hda_msgs_json.bag import BagWriter
from hda_msgs_json.samples import JointSamples
from hda_msgs_json.topics import JOINT_STATES
from hda_torque_estimator.cli import main
import numpy as np
import pytest

TIME = 0.002 * np.arange(4000)
NAMES = ('shoulder', 'shoulder_motor')
STATED = ['--motor-inertia', '1e-4']


@pytest.fixture
def bag(tmp_path):
    """Return a function that writes a recording with encoders of these counts per turn."""
    def write(motor_counts, link_counts, *, travel=0.6, names=NAMES, ratio=80.0):
        link = travel * np.sin(TIME)
        angles = np.stack([link, ratio * link + 0.02 * np.cos(TIME)], axis=1)
        for column, counts in enumerate((link_counts, motor_counts)):
            if counts:
                step = 2.0 * np.pi / counts
                angles[:, column] = step * np.floor(angles[:, column] / step)
        nothing = np.full_like(angles, np.nan)
        effort = np.stack([nothing[:, 0], 0.21 * np.cos(TIME)], axis=1)
        with BagWriter(tmp_path / 'bag', {}) as writer:
            writer.write_joint_states(JOINT_STATES, JointSamples(
                1 + np.rint(1e9 * TIME).astype(np.int64), names, angles, nothing, effort))
        return str(tmp_path / 'bag')
    return write


def refusal(capsys, *words):
    """Return the one line with which a call is refused."""
    assert main(list(words)) == 2
    said, = capsys.readouterr().err.splitlines()
    return said


def test_names_counts_and_least_torque_come_from_the_recording(bag, tmp_path, capsys):
    out = tmp_path / 'arm.yaml'
    assert main(['new', '--from', bag(4096, 65536), '--gear', 'CSG-17-80', *STATED, '--out',
                 str(out)]) == 0
    joint, = read_arm(out).joints
    assert (joint.label, joint.ratio) == ('shoulder', 80.0)
    assert (joint.motor_encoder.counts, joint.link_encoder.counts) == (4096.0, 65536.0)
    assert joint.torque_limit == pytest.approx(0.21, rel=1e-3)
    assert '--motor-torque from bag, the largest seen: no less' in capsys.readouterr().out
    assert 'per turn, from bag' in out.read_text()


def test_what_is_stated_comes_first(bag, tmp_path):
    out = tmp_path / 'arm.yaml'
    assert main(['new', '--from', bag(4096, 65536), '--gear', 'CSG-17-80', *STATED,
                 '--motor-counts', '8192', '--motor-torque', '0.5', '--joints', 'elbow', '--out',
                 str(out)]) == 0
    joint, = read_arm(out).joints
    assert (joint.label, joint.motor_encoder.counts, joint.torque_limit) == ('elbow', 8192.0, 0.5)


def test_a_gear_of_another_ratio_is_refused(bag, tmp_path, capsys):
    said = refusal(capsys, 'new', '--from', bag(4096, 65536), '--gear', 'CSG-17-100', *STATED,
                   '--out', str(tmp_path / 'arm.yaml'))
    assert 'CSG-17-100 has the ratio 100, but its motor turns 80' in said


def test_an_output_at_the_circular_spline_has_one_turn_more(bag, tmp_path, capsys):
    path, out = bag(4096, 65536, ratio=101.0), tmp_path / 'arm.yaml'
    words = ['new', '--from', path, '--gear', 'CSG-17-100', *STATED, '--out', str(out)]
    assert main(words) == 0
    assert read_arm(out).joints[0].ratio == 101.0
    assert '--ratio from bag: one more than in the name' in capsys.readouterr().out
    assert main([*words, '--ratio', '100.5', '--force']) == 0
    assert read_arm(out).joints[0].ratio == 100.5
    assert 'has the ratio 160' in refusal(capsys, *words, '--ratio', '160', '--force')


def test_gears_of_the_recorded_ratio_are_offered(bag, tmp_path, capsys):
    said = refusal(capsys, 'new', '--from', bag(4096, 65536), *STATED, '--out',
                   str(tmp_path / 'arm.yaml'))
    assert 'CSF-14-80' in said and 'the ratio of the recording is 80' in said


@pytest.mark.parametrize(('counts', 'travel', 'missing'), [
    ((0, 65536), 0.6, '--motor-counts'), ((4096, 0), 0.6, '--link-counts'),
    ((4096, 65536), 0.0, '--link-counts')])
def test_what_it_does_not_know_must_be_stated(counts, travel, missing, bag, tmp_path, capsys,
                                              monkeypatch):
    monkeypatch.setattr('sys.stdin', None)
    assert missing in refusal(
        capsys, 'new', '--from', bag(*counts, travel=travel), '--gear', 'CSG-17-80', *STATED,
        '--out', str(tmp_path / 'arm.yaml'))


def test_other_names_are_mapped(bag, tmp_path, capsys):
    path = bag(4096, 65536, names=('load', 'drive'))
    words = ['new', '--from', path, '--gear', 'CSG-17-80', *STATED, '--out',
             str(tmp_path / 'arm.yaml')]
    assert 'names no joint with both sides' in refusal(capsys, *words)
    assert main([*words, '--name', 'load=joint1', '--name', 'drive=joint1_motor']) == 0


def test_a_motor_without_a_link_encoder_is_a_joint(tmp_path, capsys):
    """Most robots log one angle for each joint, which an import lays to the motor."""
    angle, nothing = 80.0 * np.sin(TIME)[:, np.newaxis], np.full((len(TIME), 1), np.nan)
    step = 2.0 * np.pi / 4096
    with BagWriter(tmp_path / 'bag', {}) as writer:
        writer.write_joint_states(JOINT_STATES, JointSamples(
            1 + np.rint(1e9 * TIME).astype(np.int64), ('elbow_motor',),
            step * np.floor(angle / step), nothing, 0.21 * np.cos(TIME)[:, np.newaxis]))
    out = tmp_path / 'arm.yaml'
    assert main(['new', '--from', str(tmp_path / 'bag'), '--gear', 'CSG-17-80', *STATED,
                 '--out', str(out)]) == 0
    joint, = read_arm(out).joints
    assert (joint.label, joint.ratio, joint.motor_encoder.counts) == ('elbow', 80.0, 4096.0)
    assert joint.link_encoder.counts == 0.0
    assert 'no such encoder was recorded' in capsys.readouterr().out
    assert 'from bag: no such encoder was recorded' in out.read_text()
