"""Files that harm: each ends in one line, soon, with nothing of others read, run or changed."""

import io
import os
from pathlib import Path
import subprocess
import sys
import zipfile

from hda_msgs_json.bag import open_recording
from hda_msgs_json.cdr import decode_joint_state, encode_joint_state
from hda_msgs_json.errors import HdaError
from hda_msgs_json.schemas import schema
from hda_msgs_json.topics import JOINT_STATE
from hda_torque_estimator.cli import main
from hda_torque_estimator.importing.tables import MOST_COLUMNS
from mcap.writer import Writer
import numpy as np
from project_imports import PATHS
import pytest
from scipy.io import savemat

ARM = ['--arm', 'hda_arm.yaml']
MAP = 'time: t\njoints: {{joint1: {{link: {{position: {}}}}}}}\n'
BOMB = 'a: &a [x, x, x, x, x, x, x, x, x]\n' + ''.join(
    f'{after}: &{after} [{", ".join(["*" + before] * 9)}]\n'
    for before, after in zip('abcdefgh', 'bcdefghi'))


def line_of(capsys, *words):
    """Return the one line with which a command refuses."""
    assert main(list(words)) == 2
    said = capsys.readouterr()
    assert said.out == '' and len(said.err.splitlines()) == 1, said.err
    return said.err


@pytest.fixture(scope='module')
def states(tmp_path_factory):
    """Return joint states of a simulated motion."""
    path = tmp_path_factory.mktemp('bags') / 'rich'
    assert main(['simulate', *ARM, '--motion', 'rich', '--duration', '6', '--out',
                 str(path)]) == 0
    return [decode_joint_state(one) for one in open_recording(path).raw('joint_states')[1]]


def stamped(path, states, stamp):
    """Write joint states at other stamps [ns], their log times as they should be."""
    with path.open('wb') as stream:
        writer = Writer(stream)
        writer.start(profile='ros2', library='test')
        kind = writer.register_schema(JOINT_STATE, 'ros2msg', schema(JOINT_STATE).text.encode())
        channel = writer.register_channel('/joint_states', 'cdr', kind)
        for number, one in enumerate(states):
            writer.add_message(channel, 10 ** 9 + number * 10 ** 6, encode_joint_state(
                stamp(number, one.stamp_ns), '', list(one.names), one.position, one.velocity,
                one.effort), 0)
        writer.finish()
    return str(path)


@pytest.mark.parametrize(('stamp', 'says'), [
    (lambda number, _: 10 ** 9 + number, 'stamps are 1e-09 s apart'),
    (lambda number, _: 0, 'only 1 of'),
    (lambda number, true: true + (number > 1500) * 3600 * 10 ** 9, 'jump by 3600 s after 1.5 s'),
    (lambda number, true: true + (number > 1500) * 31 * 31_557_600 * 10 ** 9, 'jump by 9.783e+08'),
    (lambda number, true: true - (number > 1500) * 10 ** 9 * min(number, 3600), 'are later than'),
], ids=['1 ns', 'zero', 'an hour', '31 years', 'back'])
@pytest.mark.parametrize('command', ['calibrate', 'diagnose'])
def test_stamps_that_cannot_be_are_one_line(command, stamp, says, states, tmp_path, capsys):
    bag = stamped(tmp_path / 'bag.mcap', states, stamp)
    assert says in line_of(capsys, command, bag, *ARM, '--out', str(tmp_path / 'out'))
    assert [path.name for path in tmp_path.iterdir()] == ['bag.mcap']


@pytest.mark.parametrize('text', [
    'joints: 2001-99-99', 'joints: 2001-01-01T00:00:00+99:99', '!!int ""', '!!timestamp x',
    '!!float x', '- &a [*a]', BOMB + 'joints: *i\nlinks: none', 'joints: [{name: [a]}]',
    'joints: ' + '[' * 5000, f'joints: 0x{"f" * 9999}', 'joints: [1]\n' * 200_000,
    'effects: [{effect: payload, joint: [a]}]', '? [a]\n: b', 'links: !!binary x'],
    ids=range(14))
def test_yaml_of_any_kind_is_one_line(text, tmp_path, capsys):
    file = tmp_path / 'arm.yaml'
    file.write_text(text)
    simulate = ['simulate', '--motion', 'rich', '--out', str(tmp_path / 'out')]
    assert 'arm.yaml' in line_of(capsys, *simulate, '--arm', str(file))
    assert 'arm.yaml' in line_of(capsys, *simulate, *ARM, '--effects', str(file))
    (tmp_path / 'table.csv').write_text('t\n1\n')
    assert 'arm.yaml' in line_of(capsys, 'import', str(tmp_path / 'table.csv'), '--map',
                                 str(file), '--out', str(tmp_path / 'out'))


@pytest.mark.parametrize('entry', [
    '{column: q, unit: [deg]}', '{column: q, side: [link]}', '{column: q, sign: [1]}',
    '{column: q, zero: [first]}', '{column: [[q]]}', '{column: {q: q}}', '2001-99-99'])
def test_column_map_of_any_kind_is_one_line(entry, tmp_path, capsys):
    (tmp_path / 'table.csv').write_text('t,q\n0.0,1.0\n0.1,1.1\n')
    (tmp_path / 'map.yaml').write_text(MAP.format(entry))
    assert 'map.yaml' in line_of(capsys, 'import', str(tmp_path / 'table.csv'), '--map',
                                 str(tmp_path / 'map.yaml'), '--out', str(tmp_path / 'out'))


def damaged_npz(header):
    """Return an NPZ file with one array of this header."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, 'w') as archive:
        body = header.encode().ljust(117) + b'\n'
        archive.writestr('q.npy', b'\x93NUMPY\x01\x00' + len(body).to_bytes(2, 'little') + body)
    return stream.getvalue()


@pytest.mark.parametrize('header', [
    '{', "{'descr': '<f8', 'fortran_order': False, 'shape': (", "{'descr': lambda: 0}", '"',
    "{'descr': '<f8', 'fortran_order': False, 'shape': (4000000000000,)}", '\x00', "{'a': 1",
    "{'descr': '<f8', 'fortran_order': False, 'shape': (-1,)}"])
def test_npz_with_a_broken_header_is_one_line(header, tmp_path, capsys):
    (tmp_path / 'table.npz').write_bytes(damaged_npz(header))
    assert 'table.npz' in line_of(capsys, 'import', str(tmp_path / 'table.npz'), '--guess')


def test_a_mat_file_that_crashes_its_reader_is_one_line(tmp_path, capsys):
    stream = io.BytesIO()
    savemat(stream, {'t': np.arange(30.0)})
    tag = b'\x09\0\0\0\xf0\0\0\0'             # of 30 doubles
    assert tag in stream.getvalue()
    (tmp_path / 'table.mat').write_bytes(stream.getvalue().replace(tag, b'\x49' + tag[1:]))
    assert 'its reader crashes on it' in line_of(
        capsys, 'import', str(tmp_path / 'table.mat'), '--guess')


def test_a_table_with_too_many_columns_is_one_line(tmp_path, capsys):
    table = tmp_path / 'table.csv'
    for count in (MOST_COLUMNS + 1, 100_000, 1_000_000):
        table.write_text(','.join(f'q{number}' for number in range(count)) + '\n')
        assert 'table.csv' in line_of(capsys, 'import', str(table), '--guess')
    np.savez(tmp_path / 'table.npz', t=np.arange(2.0), turned=np.zeros((2, 50_000)))
    assert 'may be exchanged' in line_of(capsys, 'import', str(tmp_path / 'table.npz'), '--guess')


@pytest.mark.parametrize('name', ['bag_0.mcap', 'metadata.yaml'])
@pytest.mark.parametrize('kind', ['pipe', 'device'])
def test_a_pipe_or_a_device_in_a_bag_is_left_alone(kind, name, tmp_path, capsys):
    place = tmp_path / 'bag' / name
    place.parent.mkdir()
    if kind == 'pipe':
        os.mkfifo(place)
    else:
        place.symlink_to('/dev/zero')
    assert 'has no .mcap file' in line_of(capsys, 'info', str(place.parent))
    assert 'bag' in line_of(capsys, 'info', str(place))


def test_a_pipe_is_no_motion(tmp_path, capsys):
    os.mkfifo(tmp_path / 'motion.csv')
    assert 'is not a file' in line_of(capsys, 'simulate', *ARM, '--motion',
                                      str(tmp_path / 'motion.csv'), '--out', str(tmp_path / 'out'))


def test_an_error_that_nobody_foresaw_is_one_line(capsys, monkeypatch):
    def fail(options):
        raise KeyError('deep inside')

    monkeypatch.setattr('hda_torque_estimator.commands.info_command.execute', fail)
    assert 'unforeseen KeyError' in (said := line_of(capsys, 'info', 'bag'))
    assert 'HDA_DEBUG=1' in said
    monkeypatch.setenv('HDA_DEBUG', '1')
    assert main(['info', 'bag']) == 2
    assert 'Traceback' in capsys.readouterr().err


def test_every_error_of_the_packages_is_reported_in_one_line():
    for name in PATHS:
        __import__(name)
    waiting, found = [ValueError], []
    while waiting:
        waiting += (below := waiting.pop().__subclasses__())
        found += below
    own = [one for one in found if one.__module__ in PATHS]
    assert HdaError in own
    assert [one for one in own if not issubclass(one, HdaError)] == []


def test_a_name_does_not_move_the_cursor(states, tmp_path, capsys):
    named = [one._replace(names=(f'{one.names[0]}\x1b[2J\n', *one.names[1:]))
             for one in states[:50]]
    bag = stamped(tmp_path / 'bag\x1b[31m.mcap', named, lambda _, true: true)
    assert main(['info', bag]) == 0
    assert capsys.readouterr().out.replace('\n', '').isprintable()
    assert line_of(capsys, 'info', str(tmp_path / '\x1b[31mred\n')).rstrip('\n').isprintable()


def test_hda_has_one_thread_for_its_matrices(tmp_path):
    program = (
        'import os; from hda_torque_estimator.cli import main; main(["info", "nothing"]); '
        'import numpy, scipy.linalg; numpy.linalg.inv(numpy.eye(500)); '
        'print(len(os.listdir("/proc/self/task")))')
    free = {name: value for name, value in os.environ.items() if not name.endswith('_THREADS')}
    done = subprocess.run([sys.executable, '-c', program], env=free, cwd=tmp_path, check=True,
                          capture_output=True, text=True)
    assert done.stdout.split() == ['1']


def test_only_installed_types_are_imported(tmp_path, monkeypatch):
    topics = pytest.importorskip('hda_arm_sim.ros.topics')
    from hda_msgs_json.topics import Topic
    (tmp_path / 'evil').mkdir()
    (tmp_path / 'evil' / '__init__.py').write_text(f'open({str(tmp_path / "ran")!r}, "w")\n')
    (tmp_path / 'evil' / 'msg.py').write_text('class Joint: pass\n')
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(ValueError, match='evil'):
        topics.message_class(Topic('joint', 'evil/msg/Joint', 1))
    assert not Path(tmp_path, 'ran').exists()
    assert topics.message_class(Topic('joint', JOINT_STATE, 1)).__name__ == 'JointState'
