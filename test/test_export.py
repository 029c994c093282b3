"""A bag becomes a table whose every number is one that was recorded."""

from dataclasses import replace
from pathlib import Path

from bag_content import joint_samples, START, wrench_samples
from hda_msgs_json.bag import BagWriter, open_recording
from hda_msgs_json.cdr_fields import FieldWriter
from hda_msgs_json.samples import NumberSamples
from hda_msgs_json.schemas import Schema
from hda_msgs_json.topics import (
    ESTIMATOR_STATE, JOINT_STATES, JOINT_TORQUES, reference_joint_torque, state_number,
    TIP_WRENCH)
from hda_torque_estimator.cli import main
from hda_torque_estimator.importing.exported import at_stamps
from hda_torque_estimator.importing.tables import read_table
import numpy as np
import pytest

COUNT = 40
STATES = joint_samples(COUNT)
TORQUES = wrench_samples(COUNT)
PUSHES = wrench_samples(9, offset=400_000, step=4_000_000)      # [ns], slower and later


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    """Return a bag with several topics, one of them slower."""
    with BagWriter(tmp_path / 'bag', {}) as bag:
        bag.write_joint_states(JOINT_STATES, STATES)
        bag.write_joint_states(JOINT_TORQUES, STATES.select(['joint1']))
        bag.write_wrenches(reference_joint_torque('joint1'), TORQUES)
        bag.write_wrenches(TIP_WRENCH, PUSHES)
        bag.write_numbers(state_number('payload'), NumberSamples(
            PUSHES.stamps, PUSHES.force[:, 1]))
        bag.write(ESTIMATOR_STATE, START, b'\x00\x01\x00\x00\x01\x00\x00\x00\x00\x00\x00\x00')
    return tmp_path / 'bag'


@pytest.mark.parametrize('name', ['table.csv', 'table.parquet'])
def test_a_table_holds_the_bits_of_the_bag(name, bag, capsys):
    out = bag.with_name(name)
    assert main(['export', str(bag), '--out', str(out)]) == 0
    assert 'left out: /estimator_state' in capsys.readouterr().out
    table = read_table(out)
    np.testing.assert_array_equal(table['stamp'], STATES.stamps)
    np.testing.assert_array_equal(table['time'], np.arange(COUNT) / 1000)
    np.testing.assert_array_equal(table['joint1_motor.effort'], STATES.effort[:, 1])
    np.testing.assert_array_equal(table['joint_torques.joint1.position'], STATES.position[:, 0])
    np.testing.assert_array_equal(table['reference/joint1/torque.torque.z'], TORQUES.torque[:, 2])
    assert 'joint1_motor.velocity' not in table         # never recorded
    force = table['tip/wrench.force.x']
    assert np.isfinite(force).sum() == len(PUSHES)
    np.testing.assert_array_equal(force[np.isfinite(force)], PUSHES.force[:, 0])
    payload = table['estimator_state/payload']
    np.testing.assert_array_equal(payload[np.isfinite(force)], PUSHES.force[:, 1])


def test_one_topic_has_a_row_for_each_of_its_messages(bag):
    out = bag.with_name('tip.csv')
    assert main(['export', str(bag), '--topic', '/tip/wrench', '--out', str(out)]) == 0
    table = read_table(out)
    np.testing.assert_array_equal(table['stamp'], PUSHES.stamps)
    np.testing.assert_array_equal(table['tip/wrench.torque.y'], PUSHES.torque[:, 1])


def test_motor_and_link_in_two_topics_of_a_stranger_become_a_bag(tmp_path):
    late = replace(STATES, stamps=STATES.stamps + 100_000)
    with BagWriter(tmp_path / 'theirs', {}) as bag:
        for topic, samples in (('/r/drive', STATES), ('/r/load', late)):
            bag.write_joint_states(replace(JOINT_STATES, name=topic), samples.select(['joint1']))
    out, map_file = tmp_path / 'table.parquet', tmp_path / 'map.yaml'
    assert main(['export', str(tmp_path / 'theirs'), '--topic', '/r/drive', '--topic', '/r/load',
                 '--out', str(out)]) == 0
    map_file.write_text('time: {column: stamp, unit: ns}\njoints: {elbow: {'
                        'motor: {position: joint1.position}, '
                        'link: {position: r/load.joint1.position}}}\n')
    assert main(['import', str(out), '--map', str(map_file), '--out', str(tmp_path / 'ours')]) == 0
    states = open_recording(tmp_path / 'ours').joint_states().select(['elbow', 'elbow_motor'])
    np.testing.assert_array_equal(states.position, STATES.position[:, [0, 0]])


def dynamic_joint_state(stamp, joints):
    """Return a control_msgs/DynamicJointState of the interfaces of joints, as bytes."""
    fields = FieldWriter()
    fields.stamp(stamp)
    fields.string('', 'frame_id')
    fields.uint32(len(joints))
    for joint in joints:
        fields.string(joint, 'joint')
    fields.uint32(len(joints))
    for interfaces in joints.values():
        fields.uint32(len(interfaces))
        for name in interfaces:
            fields.string(name, 'interface')
        fields.uint32(len(interfaces))
        fields.doubles(np.array(list(interfaces.values())))
    return bytes(fields)


def dynamic_bag(path, messages):
    """Write a bag of DynamicJointStates."""
    kind = 'control_msgs/msg/DynamicJointState'
    topic = replace(JOINT_STATES, name='dynamic_joint_states', message_type=kind)
    with BagWriter(path, {}) as bag:
        bag.define(topic, Schema('', ''))
        for number, message in enumerate(messages):
            bag.write(topic, START + number, message)
    return [str(path), '--topic', 'dynamic_joint_states', '--out', str(path.with_name('d.csv'))]


def test_dynamic_joint_states_have_a_column_for_each_interface(tmp_path):
    words = dynamic_bag(tmp_path / 'bag', [dynamic_joint_state(number, {
        'elbow': {'position': number + 0.5, 'motor_position': 100.0 * number},
        'base': {'effort': -number}}) for number in range(5)])
    assert main(['export', *words]) == 0
    table = read_table(tmp_path / 'd.csv')
    np.testing.assert_array_equal(table['stamp'], range(5))
    np.testing.assert_array_equal(table['elbow.motor_position'], 100.0 * np.arange(5))
    np.testing.assert_array_equal(table['base.effort'], -np.arange(5.0))


WHOLE = dynamic_joint_state(1, {'elbow': {'position': 1.0, 'effort': 2.0}})


@pytest.mark.parametrize('messages, said', [
    ([WHOLE[:-9]], 'message 0'), ([b''], 'message 0'), ([WHOLE, WHOLE[:20]], 'message 1'),
    ([WHOLE, dynamic_joint_state(2, {'elbow': {}})], 'other joints or interfaces'),
    ([WHOLE[:20] + b'\xff' * 40], 'message 0'), ([WHOLE + bytes(99)], 'follow the end')])
def test_broken_dynamic_joint_states_are_one_line(messages, said, tmp_path, capsys):
    assert main(['export', *dynamic_bag(tmp_path / 'bag', messages)]) == 2
    line = capsys.readouterr().err
    assert said in line and len(line.splitlines()) == 1 and 'unforeseen' not in line


def test_what_is_exported_can_be_imported(bag):
    out, map_file = bag.with_name('table.csv'), bag.with_name('map.yaml')
    assert main(['export', str(bag), '--out', str(out)]) == 0
    map_file.write_text('time: {column: stamp, unit: ns}\njoints: {joint1: {'
                        'motor: {position: joint1_motor.position, effort: joint1_motor.effort}, '
                        'link: {position: joint1.position, velocity: joint1.velocity}}}\n')
    assert main(['import', str(out), '--map', str(map_file),
                 '--out', str(bag.with_name('again'))]) == 0
    again = open_recording(bag.with_name('again')).joint_states().select(STATES.names)
    np.testing.assert_array_equal(again.position, STATES.position)
    np.testing.assert_array_equal(again.stamps, STATES.stamps)


@pytest.mark.parametrize('stamps', [[], [7], [30, 10, 20, 500]])
def test_the_nearest_message_counts_within_half_a_period(stamps):
    given = np.array(stamps, np.int64)
    grid = np.array([4, 14, 24, 34], np.int64)
    found = at_stamps({'x': given.astype(float)}, given, grid)['x']
    for at, value in zip(grid, found):
        near = [stamp for stamp in stamps if abs(stamp - at) <= 5]
        assert value == min(near, key=lambda stamp: abs(stamp - at)) if near else np.isnan(value)


@pytest.mark.parametrize('words, said', [
    (['--out', 'x.xlsx'], 'must end in .csv or .parquet'), (['--out', 'x'], 'must end in'),
    (['--out', 'x.csv', '--topic', 'nothing'], 'has no topic nothing'),
    (['--out', 'x.csv', '--topic', 'estimator_state'], 'the type must be'),
    (['--out', 'taken.csv'], 'taken.csv exists'), (['--out', 'folder.csv'], 'is a directory')])
def test_wrong_use_is_one_line_and_leaves_nothing(words, said, bag, monkeypatch, capsys):
    monkeypatch.chdir(bag.parent)
    Path('taken.csv').write_text('mine')
    Path('folder.csv').mkdir()
    before = sorted(bag.parent.rglob('*'))
    assert main(['export', str(bag), *words]) == 2
    line = capsys.readouterr().err
    assert said in line and len(line.splitlines()) == 1
    assert sorted(bag.parent.rglob('*')) == before and Path('taken.csv').read_text() == 'mine'


def test_force_replaces_a_table_and_never_what_is_read(bag, capsys):
    out = bag.with_name('table.csv')
    out.write_text('old')
    assert main(['export', str(bag), '--out', str(out), '--force']) == 0
    assert 'joint1.position' in out.read_text()
    loose = next(bag.glob('*.mcap')).rename(bag / 'bag.csv')
    assert main(['export', str(loose), '--out', str(loose), '--force']) == 2
    assert 'is read from there' in capsys.readouterr().err


def test_a_bag_without_messages_is_one_line(tmp_path, capsys):
    with BagWriter(tmp_path / 'bag', {}) as bag:
        bag.write_joint_states(JOINT_STATES, replace(STATES).rows(slice(0, 0)))
    assert main(['export', str(tmp_path / 'bag'), '--out', str(tmp_path / 'x.csv')]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1
