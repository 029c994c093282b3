"""What a command writes appears whole, replaces nothing but its own, and follows no link."""

from pathlib import Path

from hda_arm_sim.model.files import read_arm
from hda_arm_sim.model.writing import write_arm
from hda_msgs_json.bag import BagWriter, open_recording
from hda_msgs_json.outputs import check_directory, OutputError, whole_directory, whole_file
from hda_msgs_json.topics import JOINT_STATES, Topic, truth_joint_torque
from hda_torque_estimator.cli import main
from hda_torque_estimator.commands.whole_directory import save_figures
from matplotlib.figure import Figure
import pytest

ARM = ['--arm', 'hda_arm.yaml']
OTHERS = 'what somebody else has written'
EFFECTS = ['--between', 'link_encoder_eccentricity', 'encoder_scale_error']


@pytest.fixture(scope='module')
def bag(tmp_path_factory):
    """Return a bag of a simulated push."""
    path = tmp_path_factory.mktemp('bags') / 'push'
    assert main(['simulate', *ARM, '--motion', 'push', '--duration', '8', '--seed', '3', '--out',
                 str(path)]) == 0
    return path


@pytest.fixture
def table(tmp_path):
    """Return a table and a map of it."""
    (tmp_path / 'table.csv').write_text('t,q\n0.0,1.0\n0.1,1.1\n')
    (tmp_path / 'map.yaml').write_text('time: t\njoints: {joint1: {link: {position: q}}}\n')
    return tmp_path / 'table.csv'


def words_of(command, bag, table, out):
    """Return a call of a command that writes to `out`."""
    words = {
        'simulate': [*ARM, '--motion', 'push', '--duration', '8'],
        'estimate': [str(bag), *ARM], 'calibrate': [str(bag), *ARM],
        'diagnose': [str(bag), *ARM], 'compare': [str(bag), str(bag)],
        'plan': [*ARM, *EFFECTS, '--duration', '10'], 'repair': [str(bag)],
        'import': [str(table), '--map', str(table.with_name('map.yaml'))],
        'reproduce': ['fig7'],
        'new': ['--gear', 'CSG-17-100', '--motor-inertia', '1e-4', '--motor-torque', '0.5',
                '--motor-counts', '4096', '--link-counts', '4096']}
    return [command, *words[command], '--out', str(out)]


def content(place):
    """Return every file below a place, and where every link leads."""
    return {path: path.readlink() if path.is_symlink() else path.read_bytes()
            for path in place.rglob('*') if path.is_symlink() or path.is_file()}


def something_at(out, kind):
    """Put something at a place that a command is asked to write to."""
    if kind == 'file':
        out.write_text(OTHERS)
    elif kind == 'folder':
        out.mkdir()
        (out / 'notes.txt').write_text(OTHERS)
    else:
        target = out.with_name('target')
        target.write_text(OTHERS)
        out.symlink_to(target if kind == 'link' else out.with_name('nowhere'))


@pytest.mark.parametrize('kind', ['file', 'folder', 'link', 'broken link'])
@pytest.mark.parametrize('command', ['simulate', 'estimate', 'calibrate', 'diagnose', 'compare',
                                     'plan', 'repair', 'import', 'reproduce', 'new'])
def test_nothing_that_exists_is_written_over(command, kind, bag, table, tmp_path, capsys):
    something_at(tmp_path / 'out', kind)
    before = content(tmp_path)
    assert main(words_of(command, bag, table, tmp_path / 'out')) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1
    assert content(tmp_path) == before


@pytest.mark.parametrize('command', ['simulate', 'estimate', 'compare', 'repair', 'import'])
def test_force_replaces_what_was_written_before(command, bag, table, tmp_path, capsys):
    out = tmp_path / 'out'
    assert main(words_of(command, bag, table, out)) == 0
    mark = next(path for path in out.iterdir() if path.suffix in ('.mcap', '.html'))
    mark.write_bytes(b'')
    assert main([*words_of(command, bag, table, out), '--force']) == 0
    assert mark.stat().st_size
    assert sorted(path.name for path in tmp_path.iterdir()) == ['map.yaml', 'out', 'table.csv']


def test_force_takes_no_directory_of_others(bag, tmp_path, capsys):
    (tmp_path / 'thesis').mkdir()
    (tmp_path / 'thesis' / 'chapter1.tex').write_text(OTHERS)
    mixed = tmp_path / 'mixed'
    assert main(['repair', str(bag), '--out', str(mixed)]) == 0
    (mixed / 'notes.txt').write_text(OTHERS)
    before = content(tmp_path)
    for out in (tmp_path / 'thesis', mixed):
        assert main(['estimate', str(bag), *ARM, '--out', str(out), '--force']) == 2
    assert content(tmp_path) == before


@pytest.mark.parametrize('command', ['estimate', 'diagnose', 'compare', 'repair', 'calibrate'])
def test_force_does_not_replace_what_is_read(command, bag, table, tmp_path, capsys):
    before = content(bag)
    place = next(iter(bag.glob('*.mcap'))) if command == 'calibrate' else bag
    assert main([*words_of(command, place, table, place), '--force']) == 2
    assert 'read from there' in capsys.readouterr().err
    assert content(bag) == before


def test_a_link_is_replaced_and_what_it_leads_to_stays(tmp_path):
    target, link = tmp_path / 'target.yaml', tmp_path / 'arm.yaml'
    target.write_text(OTHERS)
    link.symlink_to(target)
    write_arm(read_arm('hda_arm.yaml'), link, force=True)
    assert target.read_text() == OTHERS
    assert not link.is_symlink() and read_arm(link) == read_arm('hda_arm.yaml')


def test_a_file_that_happens_to_be_called_partial_stays(tmp_path):
    (tmp_path / 'arm.yaml.partial').write_text(OTHERS)
    write_arm(read_arm('hda_arm.yaml'), tmp_path / 'arm.yaml')
    assert (tmp_path / 'arm.yaml.partial').read_text() == OTHERS
    assert len(list(tmp_path.iterdir())) == 2


def test_who_comes_first_keeps_the_place(tmp_path):
    with pytest.raises(OutputError, match='cannot be written: File exists'), \
            whole_file(tmp_path / 'file') as stream:
        stream.write('ours')
        (tmp_path / 'file').write_text(OTHERS)
    with pytest.raises(OutputError, match='cannot be written'), \
            whole_directory(tmp_path / 'folder'):
        (tmp_path / 'folder').mkdir()
        (tmp_path / 'folder' / 'notes.txt').write_text(OTHERS)
    assert set(content(tmp_path).values()) == {OTHERS.encode()}


def test_nothing_is_left_of_what_fails(tmp_path):
    with pytest.raises(KeyboardInterrupt), whole_directory(tmp_path / 'new' / 'out') as partial:
        (partial / 'half').write_text('')
        raise KeyboardInterrupt
    with pytest.raises(KeyboardInterrupt), BagWriter(tmp_path / 'new' / 'bag', {}):
        raise KeyboardInterrupt
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize('command', ['estimate', 'plan', 'simulate'])
def test_a_place_without_a_name_is_one_line(command, bag, table, capsys):
    with pytest.raises(SystemExit) as stop:
        main(words_of(command, bag, table, ''))
    assert stop.value.code == 2
    assert 'it must name a place to write to' in capsys.readouterr().err


def test_a_disk_that_cannot_be_written_is_one_line(bag, table, capsys):
    for command in ('simulate', 'estimate', 'compare', 'import', 'repair'):
        assert main(words_of(command, bag, table, '/proc/nothing')) == 2
        assert '/proc/nothing cannot be written' in capsys.readouterr().err


def test_a_damaged_truth_leaves_no_estimate(bag, tmp_path, capsys):
    recording = open_recording(bag)
    truth = truth_joint_torque('joint1')
    with BagWriter(tmp_path / 'damaged', {}) as writer:
        for topic in (JOINT_STATES, truth):
            known = Topic(topic.name, recording.topics[f'/{topic.name}'].message_type, 1)
            for time, message in zip(*recording.raw(topic.name)):
                writer.write(known, int(time), message[:20] if topic is truth else message)
    assert main(['estimate', str(tmp_path / 'damaged'), *ARM, '--out', str(tmp_path / 'out')]) == 2
    assert truth.name in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ['damaged']


def test_an_empty_folder_is_free(tmp_path):
    (tmp_path / 'empty').mkdir()
    check_directory(tmp_path / 'empty')
    with whole_directory(Path(tmp_path / 'empty')) as partial:
        (partial / 'report.json').write_text('')
    assert content(tmp_path) == {tmp_path / 'empty' / 'report.json': b''}


def test_a_figure_has_the_same_bytes_each_time(tmp_path):
    for name in ('one', 'two'):
        (tmp_path / name).mkdir()
        figure = Figure()
        axes = figure.subplots()
        axes.plot([0.0, 1.0], [0.0, 1.0], 'o')
        axes.fill_between([0.0, 1.0], [0.0, 1.0], hatch='/')
        save_figures({'figure': figure}, tmp_path / name)
    one, two = (content(tmp_path / name) for name in ('one', 'two'))
    assert list(one.values()) == list(two.values())
