"""Files as other people's programs write them give the columns that they mean."""

import gzip
import json
from pathlib import Path

from hda_torque_estimator.cli import main
from hda_torque_estimator.importing.guess import guess
from hda_torque_estimator.importing.tables import read_table, TableError
import numpy as np
import pytest
from scipy.io import savemat

ROWS = 400
TIME = 0.002 * np.arange(ROWS)
LINK = np.sin(5 * TIME)
SPEED = 5 * np.cos(5 * TIME)


def saved(path: Path, text: str) -> dict[str, np.ndarray]:
    """Write a file and return its table."""
    path.write_text(text, encoding='utf-8')
    return read_table(path)


def same(table: dict[str, np.ndarray], **columns: object) -> None:
    """Check the names of a table and its numbers."""
    assert list(table) == list(columns)
    for name, values in columns.items():
        np.testing.assert_array_equal(table[name], values)


@pytest.mark.parametrize('text', [
    't q\n0 1.5\n0.1 2.5\n', '# t q\n0 1.5\n0.1 2.5\n', '% made by me\n% t\tq\n0\t1.5\n0.1\t2.5\n',
    'Rate 10 Hz, run 3\n\nt;q\n0;1.5\n0.1;2.5\n', '  t    q\n  0  1.5\n0.1  2.5\n',
    't,q\n0,1.5\n# a pause\n0.1,2.5\n', 't|q\n0|1.5\n0.1|2.5', 't q\n0 1.5\n0.1 2.5\n0.2',
    't;q\n0;1,5\n0,1;2,5\n', 't q\n0 1,5\n0,1 2,5\n', 't\tq\n0\t1,5\n0,1\t2,5\n'])
@pytest.mark.parametrize('ending', ['txt', 'dat', 'log'])
def test_text_with_any_marks_comments_and_decimal_points(text, ending, tmp_path):
    same(saved(tmp_path / f'log.{ending}', text), t=[0.0, 0.1], q=[1.5, 2.5])


@pytest.mark.parametrize('text', [
    't;q\n0,0;1,5\n0,1;2,5\n', '"t";"q"\n"0,0";"1,5"\n"0,1";"2,5"\n',
    't,q\n"0,0","1,5"\n"0,1","2,5"\n'])
def test_decimal_commas_in_csv(text, tmp_path):
    same(saved(tmp_path / 'log.csv', text), t=[0.0, 0.1], q=[1.5, 2.5])


@pytest.mark.parametrize('name', ['log.csv', 'log.txt'])
def test_a_line_of_units_joins_the_names(name, tmp_path):
    same(saved(tmp_path / name, 't,q,gain\ns,deg,-\n0,10,1\n0.5,20,1\n'),
         **{'t [s]': [0, 0.5], 'q [deg]': [10, 20], 'gain': [1, 1]})


@pytest.mark.parametrize('name', ['log.csv', 'log.txt'])
def test_columns_without_names_are_numbered(name, tmp_path):
    same(saved(tmp_path / name, '0,10\n0.5,20\n'), column_1=[0, 0.5], column_2=[10, 20])


@pytest.mark.parametrize('name', ['log.csv', 'log.csv.gz', 'log.txt'])
def test_a_last_row_that_is_cut_off_is_left_out(name, tmp_path):
    text = b't,a,b\n0,1.5,3\n1,2.5,4\n2,3.'
    (tmp_path / name).write_bytes(gzip.compress(text) if name.endswith('.gz') else text)
    same(read_table(tmp_path / name), t=[0, 1], a=[1.5, 2.5], b=[3, 4])


@pytest.mark.parametrize(('text', 'said'), [
    ('t,a\n0,1\n1\n2,3\n', 'line 3 has 1 columns, not 2'),
    ('t,a\n0,1\n1,2,3', 'line 3 has 3 columns, not 2'),
    ('t,a\n0,1\n1\n2,3\n4', 'Expected 2 columns, got 1')])
def test_a_row_of_another_length_is_no_cut(text, said, tmp_path):
    with pytest.raises(TableError, match=said):
        saved(tmp_path / 'log.csv', text)


def test_a_text_among_numbers_does_not_move_the_names(tmp_path):
    same(saved(tmp_path / 'log.csv', 'run,q\nfirst,1.5\n2,2.5\n'),
         run=['first', '2'], q=[1.5, 2.5])


def test_a_yarp_log_has_packets_times_and_values(tmp_path):
    rows = ['0 1464600523.25 (1.5 -2.5) [ok] (3 4)', '1 1464600523.26 (1.75 -2.0) [ok] (5 6)']
    same(saved(tmp_path / 'data.log', '\n'.join(rows)), packet=[0, 1],
         time=[1464600523.25, 1464600523.26], value_1=[1.5, 1.75], value_2=[-2.5, -2.0],
         value_3=[3, 5], value_4=[4, 6])


@pytest.mark.parametrize('name', ['log.jsonl', 'log.ndjson'])
def test_json_lines_have_dotted_names_and_numbered_lists(name, tmp_path):
    rows = [{'t': 0, 'joints': {'q': [1.5, 2]}, 'mode': 'run'}, {'t': 1, 'joints': {'q': [2, 3]}}]
    same(saved(tmp_path / name, '\n\n'.join(map(json.dumps, rows))), t=[0, 1],
         **{'joints.q_1': [1.5, 2], 'joints.q_2': [2, 3], 'mode': ['run', '']})


def test_a_value_that_a_json_line_lacks_is_nan(tmp_path):
    same(saved(tmp_path / 'log.jsonl', '{"t": 0}\n{"t": 1, "q": null}\n{"t": 2, "q": 3}'),
         t=[0, 1, 2], q=[np.nan, np.nan, 3])


@pytest.mark.parametrize('save', [savemat, lambda path, columns: np.savez(path, **columns)])
@pytest.mark.parametrize('vectors', [{'t': TIME, 'gains': np.ones(2)}, {}])
def test_channels_may_stand_in_rows(save, vectors, tmp_path):
    path = tmp_path / ('log.mat' if save is savemat else 'log.npz')
    save(path, {**vectors, 'q': np.stack([LINK, 2 * LINK]),
                'w': np.stack([LINK, 3 * LINK])[:, np.newaxis]})
    table = read_table(path)
    np.testing.assert_array_equal(table['q_2'], 2 * LINK)
    np.testing.assert_array_equal(table['w_2'], 3 * LINK)


def test_a_short_table_of_many_channels_stays_as_it_is(tmp_path):
    np.savez(tmp_path / 'log.npz', t=np.arange(3.0), q=np.arange(12.0).reshape(3, 4))
    np.testing.assert_array_equal(read_table(tmp_path / 'log.npz')['q_4'], [3, 7, 11])


HOSTILE = {
    'a.txt': 't q\n0 1\n1 2 3\n', 'b.txt': 't t\n0 1\n1 2\n', 'c.txt': '', 'd.dat': '\0' * 99,
    'e.txt': 'q' * (1 << 20), 'a.log': '((((((\n', 'b.log': '0 1 (2 3)\n1 2 (3\n2 3 4 5 6\n',
    'a.jsonl': '[' * 100_000, 'b.jsonl': '{"t": 1}\n[2]\n', 'c.jsonl': '{"t": 1', 'd.jsonl': '',
    'e.jsonl': '{"a":' * 50_000, 'f.jsonl': '{"t": 1' + '0' * 5000 + '}',
    'g.jsonl': '\n'.join(f'{{"q{number}": 1}}' for number in range(9000)),
    'h.jsonl': '{"q": [' + '1,' * 20_000 + '1]}', 'i.jsonl': '{"t": "\\ud800"}'}


@pytest.mark.parametrize('name', HOSTILE)
def test_a_broken_text_is_one_line(name, tmp_path, capsys):
    (tmp_path / name).write_text(HOSTILE[name])
    assert main(['import', str(tmp_path / name), '--guess']) == 2
    said = capsys.readouterr().err
    assert name in said and len(said.splitlines()) == 1 and 'unforeseen' not in said


@pytest.mark.parametrize('name', ['log.txt', 'log.jsonl', 'log.log'])
def test_bytes_that_are_no_text_are_refused(name, tmp_path):
    (tmp_path / name).write_bytes(b'\xff\xfe\x00 no text \x1b\n' * 9)
    with pytest.raises(TableError, match=name):
        read_table(tmp_path / name)


def test_the_struct_around_all_columns_says_nothing():
    found = guess({'arm1.t': TIME, 'arm1.motor_pos_1': 100 * LINK, 'arm1.q_1': LINK})
    assert found.time.column == 'arm1.t'
    assert {place: entry.patterns[0].name for place, entry in found.entries.items()} == {
        'motor.position': 'arm1.motor_pos_{n}', 'link.position': 'arm1.q_{n}'}


@pytest.mark.parametrize('motor, link', [
    ('mot_3', 'load_3'), ('motor_positions_1', 'joint_positions_1'), ('motor_3', 'joint_3'),
    ('motor_side_pos', 'pos'), ('log.m.positions_2', 'log.l.positions_2')])
def test_foreign_names_are_understood(motor, link):
    found = guess({'time': TIME, motor: 100 * LINK, link: LINK})
    assert {place: entry.patterns[0].columns for place, entry in found.entries.items()} == {
        'motor.position': {_number(motor): motor}, 'link.position': {_number(link): link}}
    assert found.ratio == 100


def _number(name: str) -> int:
    return int(name[-1]) if name[-1].isdecimal() else 0


def test_the_sign_of_an_effort_is_that_of_its_work():
    friction = np.sign(SPEED) + 0.3 * SPEED + 2.0 * np.cos(LINK)
    table = {'t': np.concatenate([TIME, 0.8 + TIME])}
    for number, sign in ((1, 1), (2, -1)):
        there_and_back = np.concatenate([LINK, LINK[::-1]])
        table[f'motor_pos_{number}'] = 100 * there_and_back
        table[f'link_pos_{number}'] = there_and_back
        table[f'tau_{number}'] = sign * np.concatenate(
            [friction, (4.0 * np.cos(LINK) - friction)[::-1]])
    entry = guess(table).entries['motor.effort']
    assert [entry.sign_of(number) for number in (1, 2)] == [1, -1]
    assert 'takes work from the motion at 2' in entry.reason


def test_an_effort_of_a_joint_that_does_not_come_back_determines_no_sign():
    table = {'t': TIME, 'motor_pos_1': 100 * TIME, 'link_pos_1': TIME, 'tau_1': -1.0 - LINK}
    assert guess(table).entries['motor.effort'].sign_of(1) == 1
