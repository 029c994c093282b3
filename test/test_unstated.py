"""Nothing that an arm file or a bag leaves open is filled in, or left out, without a word."""

import logging
from pathlib import Path
import re

from hda_arm_sim.model import files
from hda_arm_sim.model.arm import ArmError
from hda_arm_sim.model.files import arm_from_text, read_arm, read_effects, shipped_arms
from hda_arm_sim.model.typical_sizes import SIZED, typical
from hda_arm_sim.model.writing import arm_to_text
from hda_msgs_json.bag import BagError, BagWriter, open_recording
from hda_msgs_json.samples import WrenchSamples
from hda_msgs_json.topics import JOINT_STATES, Topic, WRENCH_STAMPED
from hda_torque_estimator.cli import main
from hda_torque_estimator.commands.fleet_bags import bags_in
from hda_torque_estimator.measurements.recorded_readings import recorded_readings
import numpy as np
from project_files import ROOT
import pytest

BARE = 'joints: [{{name: {}}}]\nlinks: none\n'


@pytest.fixture
def said(caplog):
    """Return what is said while arms are read, each line as if for the first time."""
    files._say.cache_clear()
    caplog.set_level(logging.WARNING)
    return caplog


def test_a_gear_that_is_not_stated_is_said_once_for_each_joint(said, tmp_path):
    path = tmp_path / 'arm.yaml'
    path.write_text(BARE.format('elbow') + '')
    for _ in range(2):
        read_arm(path)
    line, = said.messages
    assert line == (f'{path}: elbow does not state what its gear is; class defaults stand for '
                    'ratio (100), motor_inertia (0.0001289 kg*m^2), torsion (a flexspline of '
                    '9743.94 N*m/rad, known to 100 %)')


@pytest.mark.parametrize(('torsion', 'stiffness', 'damping'), [
    ('', 1.0, 1.0), (', torsion: {damping: 2.0}', 1.0, 0.1),
    (', torsion: {flexspline_stiffness: 2.0e+4}', 0.01, 1.0),
    (', tolerances: {stiffness: 0.4}', 0.4, 1.0)])
def test_class_defaults_have_wide_tolerances(torsion, stiffness, damping):
    other = 'torsion: {flexspline_stiffness: 2.0e+4, damping: 0.0}'
    arm = arm_from_text(f'joints: [{{name: a, ratio: 50{torsion}}}, {{name: b, ratio: 50, {other}'
                        '}]\nlinks: none\n', 'arm')
    assert (arm.tolerances_of('a').stiffness, arm.tolerances_of('a').damping) == (
        stiffness, damping)
    assert arm.tolerances_of('b') == arm.tolerances


def test_parts_of_a_law_that_are_missing_are_named(said, tmp_path):
    path = tmp_path / 'arm.yaml'
    path.write_text('joints: [{name: a, ratio: 50.0, motor_inertia: 1.0e-4, torsion: {'
                    'flexspline_stiffness: 1.0e+4, wave_generator_stiffness: .inf, damping: 0.0, '
                    'valid_torque: 50.0}}]\nlinks: none\n')
    read_arm(path)
    assert [line.rpartition('stand for ')[2] for line in said.messages] == [
        'torsion.flexspline_curvature (0.0831 1/(N*m))']


def test_a_command_that_refuses_its_input_says_that_alone(said, tmp_path, capsys):
    path = tmp_path / 'arm.yaml'
    path.write_text(re.sub('ratio: .*', '', (ROOT / 'config' / 'hda_arm.yaml').read_text()))
    words = ['simulate', '--arm', str(path), '--out', str(tmp_path / 'bag'), '--motion']
    assert main([*words, 'nowhere.csv']) == 2
    assert capsys.readouterr().err == (
        'hda simulate: nowhere.csv does not exist, or is not a file\n')
    files._say.cache_clear()
    assert main([*words, 'rich', '--duration', '2']) == 0
    assert [line.rpartition('stand for ')[2] for line in capsys.readouterr().err.splitlines()] == [
        'ratio (100)'] * 2


@pytest.mark.parametrize('name', shipped_arms())
def test_what_is_shipped_or_written_leaves_nothing_open(name, said, tmp_path):
    path = tmp_path / 'written.yaml'
    path.write_text(arm_to_text(read_arm(name)))
    read_arm(path)
    assert not said.messages


def test_an_effect_without_parameters_has_its_typical_size(tmp_path):
    arm, path = read_arm('hda_arm.yaml'), tmp_path / 'effects.yaml'
    path.write_text('- {effect: stribeck_friction, joint: joint2}\n- {effect: payload}\n')
    for placed in read_effects(path, arm):
        assert placed.effect == typical(arm, placed.effect.name, placed.joint)
        assert not placed.effect.is_neutral()
    whole = arm_from_text(arm_to_text(arm).replace(
        'effects: []', 'effects: [{effect: payload, parameters: {}}]'), 'arm')
    assert whole.effect('payload') == typical(arm, 'payload', None)


def test_an_effect_without_a_typical_size_needs_parameters(tmp_path):
    path = tmp_path / 'effects.yaml'
    path.write_text('- {effect: dropped_samples}\n')
    assert 'dropped_samples' not in SIZED
    with pytest.raises(ArmError, match='dropped_samples is listed without parameters, which is '
                                       'nothing; give some of: rate$'):
        read_effects(path, read_arm('hda_arm.yaml'))


def test_an_effect_stands_once_in_a_file(tmp_path):
    path = tmp_path / 'effects.yaml'
    path.write_text('- {effect: payload, parameters: {mass: 1.0}}\n' * 2)
    with pytest.raises(ArmError, match='payload of the arm is listed twice'):
        read_effects(path, read_arm('hda_arm.yaml'))


@pytest.mark.parametrize('label', ['é', 'a__b', 'a b', 'a/b', '1a', '', 'a' * 101, 'name\n'])
def test_a_joint_has_a_name_that_topics_can_have(label):
    with pytest.raises(ArmError, match='must be a name like joint1') as refused:
        arm_from_text(BARE.format(repr(label) if label.isprintable() else '"name\\n"'), 'arm')
    assert '\n' not in str(refused.value)


def test_a_joint_is_not_named_as_the_motor_of_another():
    text = 'joints: [{name: joint1}, {name: joint1_motor}]\nlinks: none\n'
    with pytest.raises(ArmError, match='joint1_motor is the name of the motor of joint1'):
        arm_from_text(text, 'arm')


def wrenches(path: Path, topic: Topic) -> Path:
    """Write a bag with ten wrenches."""
    stamps = np.arange(1, 11) * 10 ** 6
    with BagWriter(path, {}) as bag:
        bag.write_wrenches(topic, WrenchSamples(stamps, 'base', np.ones((10, 3)),
                                                np.ones((10, 3))))
    return path


def test_joint_states_of_another_type_are_refused(tmp_path):
    bag = wrenches(tmp_path / 'bag', Topic(JOINT_STATES.name, WRENCH_STAMPED, 10))
    with pytest.raises(BagError, match='joint_states: the type must be sensor_msgs/msg/'
                                       'JointState, got geometry_msgs/msg/WrenchStamped'):
        recorded_readings(read_arm('hda_arm.yaml'), open_recording(bag))


def test_a_file_that_is_named_often_is_read_once(tmp_path):
    bag = wrenches(tmp_path / 'bag', Topic('pushes', WRENCH_STAMPED, 10))
    about = bag / 'metadata.yaml'
    named = next(line for line in about.read_text().splitlines() if line.endswith('.mcap')
                 and line.lstrip().startswith('-'))
    about.write_text(about.read_text().replace(named, '\n'.join([named] * 1000), 1))
    recording = open_recording(bag)
    assert len(recording.wrenches('pushes')) == 10
    assert recording.warnings == ['metadata.yaml names a file more than once']


def test_every_bag_of_a_directory_is_found(tmp_path):
    """Interrupted ones without metadata and loose files are bags beside the others."""
    topic = Topic('pushes', WRENCH_STAMPED, 10)
    for name in ('whole', 'cut', 'other'):
        wrenches(tmp_path / name, topic)
    (tmp_path / 'cut' / 'metadata.yaml').unlink()
    file, = (tmp_path / 'other').glob('*.mcap')
    file.rename(tmp_path / 'loose.mcap')
    (tmp_path / 'other' / 'metadata.yaml').unlink()
    assert [bag.name for bag in bags_in(tmp_path)] == ['cut', 'loose.mcap', 'whole']
    assert bags_in(tmp_path / 'cut') == [tmp_path / 'cut']


def test_files_of_one_split_recording_are_one_bag(tmp_path):
    for name in ('run_0.mcap', 'run_1.mcap'):
        (tmp_path / name).touch()
    assert bags_in(tmp_path) == [tmp_path]
    (tmp_path / 'walk_0.mcap').touch()
    assert [bag.name for bag in bags_in(tmp_path)] == ['run_0.mcap', 'run_1.mcap', 'walk_0.mcap']
