"""A table becomes bags as its column map says, or one line says why it cannot."""

import gzip
import math
from pathlib import Path
from typing import Any

from hda_arm_sim.foundation.parameter import ParameterError
from hda_msgs_json.bag import BagError, open_recording
from hda_torque_estimator.importing.column_map import ColumnMapError
from hda_torque_estimator.importing.convert import convert, Imported
from hda_torque_estimator.importing.map_document import read_column_map
from hda_torque_estimator.importing.run import run_import, shipped_maps
from hda_torque_estimator.importing.tables import read_table, TableError
from hda_torque_estimator.importing.units import ANGLE, SPEED, TIME, TORQUE
import numpy as np
import pyarrow as pa
import pyarrow.parquet
import pytest
from scipy.io import savemat
import yaml

MEASURED = Path(__file__).parents[2] / 'shared' / 'data'
RATIO = 100.0
ROWS = 5
TIMES = 0.25 + 0.01 * np.arange(ROWS)
LINK = np.linspace(-0.5, 1.0, ROWS)


def one_joint(**entries: Any) -> dict[str, Any]:
    """Return the document of a map with one joint and a time column."""
    return {'time': {'column': 't'}, 'joints': {'joint1': {'ratio': RATIO, **entries}}}


def imported(document: dict[str, Any], **columns: Any) -> Imported:
    """Return the only recording of a table with the times and these columns."""
    table = {'t': TIMES, **{name: np.asarray(values) for name, values in columns.items()}}
    recording, = convert(read_column_map(document), table)
    return recording


@pytest.mark.parametrize('quantity, entry, unit', [
    (quantity, entry, unit)
    for quantity, entry in ((ANGLE, 'position'), (SPEED, 'velocity'), (TORQUE, 'effort'))
    for unit in quantity.units])
@pytest.mark.parametrize('side', ['motor', 'link'])
@pytest.mark.parametrize('sign', [1, -1])
def test_a_quantity_survives_every_unit_side_and_sign(quantity, entry, unit, side, sign):
    constants = {'turn': 2 * math.pi, 'count': 2 * math.pi / 4096, 'deg': math.pi / 180}
    spelled = unit.removesuffix('/s')
    scale = {'rpm': math.pi / 30, 'mN*m': 1e-3, 'A': 0.05, 'mA': 5e-5, **constants}.get(spelled, 1)
    across = 1.0 if side == 'motor' else (1 / RATIO if entry == 'effort' else RATIO)
    raw = LINK * sign / (scale * across)
    given = {'column': 'x', 'unit': unit, 'side': side, 'sign': sign}
    if 'count' in unit:
        given['counts_per_turn'] = 4096
    if 'A' in unit:
        given['torque_constant'] = 0.05
    states = imported(one_joint(motor={entry: given}), x=raw).joint_states
    assert states.names == ('joint1_motor',)
    np.testing.assert_allclose(getattr(states, entry)[:, 0], LINK, rtol=1e-14)


def test_what_the_table_does_not_have_is_nan_and_its_side_has_no_name():
    states = imported(one_joint(motor={'position': 'x'}), x=LINK).joint_states
    assert states.names == ('joint1_motor',)
    assert np.isnan(states.velocity).all() and np.isnan(states.effort).all()


def test_a_link_angle_stated_at_the_motor_is_divided_by_the_ratio():
    states = imported(one_joint(link={'position': {'column': 'x', 'side': 'motor'}}),
                      x=LINK * RATIO).joint_states
    np.testing.assert_allclose(states.position[:, 0], LINK, rtol=1e-15)


def test_references_average_their_columns_and_share_the_stamps():
    recording = imported(one_joint(reference=['a', 'b']), a=LINK + 0.25, b=LINK - 0.25)
    wrench = recording.references['joint1']
    np.testing.assert_allclose(wrench.torque[:, 2], LINK, atol=1e-15)
    assert wrench.frame_id == 'joint1_link'
    np.testing.assert_array_equal(wrench.stamps, recording.joint_states.stamps)


@pytest.mark.parametrize('formula, expected', [
    ('0.05 * (24 * x - y / 10) / 1.5', 0.05 * (24 * LINK - (LINK + 1) / 10) / 1.5),
    ('-x + `motor load [%]`', LINK ** 2 - LINK), ('x_{n} - 1', LINK + 2),
    ('+x / 0', LINK * np.nan),
    ('-' * 280 + 'x', LINK)])
def test_a_formula_of_columns(formula, expected):
    states = imported(one_joint(motor={'effort': {'formula': formula, 'sign': -1}}), x=LINK,
                      y=LINK + 1, x_1=LINK + 3, **{'motor load [%]': LINK ** 2}).joint_states
    np.testing.assert_allclose(states.effort[:, 0], -expected, rtol=1e-14)


def test_six_columns_are_a_wrench_on_the_tip(tmp_path):
    axes = {axis: LINK + place for place, axis in enumerate(('fx', 'fy', 'fz', 'a', 'b', 'c'))}
    save_csv(tmp_path / 'log.csv', {'t': TIMES, 'q': LINK, **axes})
    document = {**one_joint(link={'position': 'q'}),
                'wrench': {'column': list(axes), 'sign': -1, 'zero': 'first'}}
    (tmp_path / 'map.yaml').write_text(yaml.safe_dump(document))
    bag, = run_import(tmp_path / 'log.csv', tmp_path / 'map.yaml', tmp_path / 'bag')
    wrench = open_recording(bag).wrenches('reference/tip/wrench')
    assert wrench.frame_id == 'base'
    for values in (*wrench.force.T, *wrench.torque.T):
        np.testing.assert_allclose(values, LINK[0] - LINK, atol=1e-15)


@pytest.mark.parametrize('zero, expected', [
    (0.5, LINK - 0.5), ('first', LINK - LINK[0]), ('mean', LINK - LINK.mean())])
def test_the_zero_is_in_the_units_of_the_table(zero, expected):
    entry = {'column': 'x', 'unit': 'deg', 'zero': zero}
    states = imported(one_joint(link={'position': entry}), x=LINK).joint_states
    np.testing.assert_allclose(states.position[:, 0], np.radians(expected), atol=1e-16)


def test_each_holds_what_joints_share_and_a_joint_overrides_single_columns():
    recording, = convert(read_column_map({
        'time': {'rate': 500.0},
        'each': {'ratio': 10, 'motor': {'position': 'm{n}', 'velocity': 'v{n}'},
                 'link': {'position': '{joint}_angle'}},
        'joints': {'base': {}, 'elbow': {'motor': {'position': 'other'}}},
    }), {'m1': LINK, 'other': LINK + 1, 'v1': LINK, 'v2': LINK + 2,
         'base_angle': LINK, 'elbow_angle': LINK + 3})
    states = recording.joint_states
    assert states.names == ('base', 'base_motor', 'elbow', 'elbow_motor')
    np.testing.assert_array_equal(states.select(['elbow_motor']).position[:, 0], LINK + 1)
    np.testing.assert_array_equal(states.select(['elbow_motor']).velocity[:, 0], LINK + 2)
    np.testing.assert_array_equal(states.select(['elbow']).position[:, 0], LINK + 3)
    np.testing.assert_array_equal(states.stamps, 2_000_000 * np.arange(ROWS))


@pytest.mark.parametrize('unit', TIME.units)
@pytest.mark.parametrize('whole', [True, False])
def test_stamps_are_whole_nanoseconds_in_every_unit_of_time(unit, whole):
    per_second = {'s': 1, 'ms': 10 ** 3, 'us': 10 ** 6, 'ns': 10 ** 9}[unit]
    count = np.arange(ROWS) + 1_700_000_000 * (per_second if whole else 1) // 10
    stamps = imported(
        {'time': {'column': 'when', 'unit': unit}, 'joints': {'joint1': {'reference': 'x'}}},
        when=count if whole else count.astype(float), x=LINK).joint_states.stamps
    assert stamps.tolist() == [int(c) * (10 ** 9 // per_second) for c in count]


def test_time_can_start_at_its_first_row():
    document = one_joint(reference='x')
    document['time'] = {'column': 't', 'zero': 'first'}
    stamps = imported(document, x=LINK).joint_states.stamps
    np.testing.assert_array_equal(stamps, 10_000_000 * np.arange(ROWS))


@pytest.mark.parametrize('values, labels', [
    ([7.0, 7.0, 7.0, 2.0, 2.0], ['7', '2']), (list('bbbaa'), ['b', 'a']),
    ([3, 1, 3, 1, 1], ['3', '1'])])
def test_a_split_makes_one_recording_for_each_value_in_order(values, labels):
    document = {**one_joint(reference='x'), 'split': 'run'}
    recordings = convert(read_column_map(document),
                         {'t': TIMES, 'x': LINK, 'run': np.array(values)})
    assert [recording.label for recording in recordings] == labels
    joined = np.concatenate([r.references['joint1'].torque[:, 2] for r in recordings])
    np.testing.assert_array_equal(np.sort(joined), LINK)


def save_csv(path: Path, columns: dict[str, Any], opened: Any = open, mark: str = ',') -> None:
    with opened(path, 'wt') as lines:
        lines.write(mark.join(columns) + '\n')
        lines.writelines(mark.join(map(repr, row.tolist())) + '\n'
                         for row in np.column_stack(list(columns.values())))


SAVE = {
    'table.csv': save_csv,
    'semicolon.csv': lambda path, columns: save_csv(path, columns, mark=';'),
    'table.csv.gz': lambda path, columns: save_csv(path, columns, gzip.open),
    'table.parquet': lambda path, columns: pyarrow.parquet.write_table(pa.table(columns), path),
    'table.mat': savemat,
    'table.npz': lambda path, columns: np.savez(path, **columns),
}


@pytest.mark.parametrize('name', SAVE)
def test_every_kind_of_file_gives_the_same_columns(name, tmp_path):
    columns = {'t': TIMES, 'x_1': LINK, 'x_2': LINK ** 2}
    SAVE[name](tmp_path / name, columns)
    table = read_table(tmp_path / name)
    assert sorted(table) == sorted(columns)
    for column, values in columns.items():
        np.testing.assert_array_equal(table[column], values)


@pytest.mark.parametrize('name', ['table.mat', 'table.npz'])
def test_the_columns_of_a_matrix_are_numbered_from_one(name, tmp_path):
    SAVE[name](tmp_path / name, {'x': np.column_stack([LINK, LINK ** 2])})
    table = read_table(tmp_path / name)
    np.testing.assert_array_equal(table['x_2'], LINK ** 2)


def test_a_struct_of_matlab_gives_dotted_names(tmp_path):
    savemat(tmp_path / 'log.mat', {'log': {'t': TIMES, 'q': np.column_stack([LINK, LINK])}})
    assert set(read_table(tmp_path / 'log.mat')) == {'log.t', 'log.q_1', 'log.q_2'}


BAD_MAPS = {
    "needs 'time' and 'joints', got 'joints'": {'joints': ['joint1']},
    "unknown key 'joint'; it may hold": {'joint': {}},
    'joints must be a list or a mapping of joint names': {'time': {'rate': 1}, 'joints': 3},
    "different names, got 'a', 'a'": {'time': {'rate': 1}, 'joints': ['a', 'a']},
    'joints.joint1 names no column': one_joint(),
    'time.rate must lie in': {'time': {'rate': 0}, 'joints': ['joint1']},
    "time has an unknown key 'unit'": {'time': {'rate': 9, 'unit': 's'}, 'joints': ['joint1']},
    'time.zero must be a number or': {'time': {'column': 't', 'zero': 'mean'}, 'joints': ['a']},
    'wrench.column must list six columns': {**one_joint(reference='x'), 'wrench': ['x'] * 5},
    "wrench has an unknown key 'frame'": {**one_joint(reference='x'), 'wrench': {'frame': 'a'}},
    'wrench.column must be a name, got 3': {**one_joint(reference='x'), 'wrench': [3] * 6},
    'has both a column and a formula': one_joint(reference={'column': 'x', 'formula': 'x'}),
    'formula must be a text of 1 to 300': one_joint(reference={'formula': 3}),
    **{f'formula {text!r} {said}': one_joint(reference={'formula': text}) for text, said in {
        '2 + 3': 'names no column', 'x +': 'cannot be read', '`x` `y`': 'cannot be read',
        '-' * 290 + '(' * 9: 'cannot be read', 'x ** 9': 'may hold columns',
        '__import__("os")': 'may hold columns', 'x.real': 'may hold columns',
        'x[0]': 'may hold columns', '(y := x)': 'may hold columns', '"a" * x': 'may hold columns',
        'x if x else y': 'may hold columns', '1j * x': 'may hold columns'}.items()},
    'joints.joint1.ratio must lie in [1, 10000]': one_joint(ratio=0.01, reference='x'),
    "unit of angle, one of 'rad', 'deg', 'turn', 'count', got 'N*m'":
        one_joint(link={'position': {'column': 'x', 'unit': 'N*m'}}),
    'needs counts_per_turn [1/turn]': one_joint(link={'position': {'column': 'x',
                                                                   'unit': 'count'}}),
    'torque_constant has no use': one_joint(
        motor={'effort': {'column': 'x', 'torque_constant': 1.0}}),
    'sign must be 1 or -1, got 2': one_joint(reference={'column': 'x', 'sign': 2}),
    "side must be 'motor' or 'link', got 'left'": one_joint(
        reference={'column': 'x', 'side': 'left'}),
    "zero must be a number, 'first' or 'mean', got 'last'": one_joint(
        reference={'column': 'x', 'zero': 'last'}),
    'reference.column must be a name, got None': one_joint(reference={'unit': 'N*m'}),
    "joints.joint1.link has an unknown key 'effort'": one_joint(link={'effort': 'x'}),
    'so joints.joint1.ratio is needed': {
        'time': {'rate': 1},
        'joints': {'joint1': {'motor': {'position': {'column': 'x', 'side': 'link'}}}}},
}


@pytest.mark.parametrize('message', BAD_MAPS)
def test_a_wrong_map_is_refused_in_one_line_that_names_the_entry(message):
    with pytest.raises((ColumnMapError, ParameterError)) as caught:
        read_column_map(BAD_MAPS[message])
    assert message in str(caught.value) and '\n' not in str(caught.value)


def test_a_missing_column_is_named_with_its_entry_and_the_nearest_that_exist():
    document = {'time': {'rate': 100}, 'joints': ['joint1', 'joint2'],
                'each': {'motor': {'position': 'motor_position_{n}'}}}
    columns = {'motor_position_1': LINK, 'motor_positon_2': LINK, 'temperature': LINK}
    with pytest.raises(ColumnMapError) as caught:
        convert(read_column_map(document), columns)
    assert str(caught.value).startswith(
        "joints.joint2.motor.position names the column 'motor_position_2', which the table does "
        "not have; the nearest it has: 'motor_positon_2'")
    assert 'temperature' not in str(caught.value)


BAD_COLUMNS = {
    'must grow from row to row of a recording, got 0.1 s in row 3': {'t': [0, .1, .1, .2, .3]},
    'must lie in [0, 2147483648) s, got -1 s in row 1': {'t': [-1.0, 0, 1, 2, 3]},
    'got 3e+09 s in row 5; check its unit': {'t': [0, 1, 2, 3, 3e9]},
    'got nan s in row 2': {'t': [0, math.nan, 2, 3, 4]},
    "reference needs numbers in the column 'x', got 'a' in row 1": {'x': list('abcde')},
    "equally long, got 3 rows in 'x' and 5 in 't'": {'x': [1, 2, 3]},
    'the table has no rows': {'t': [], 'x': []},
}


@pytest.mark.parametrize('message', BAD_COLUMNS)
def test_columns_that_cannot_be_what_the_map_says_are_refused(message):
    with pytest.raises(ColumnMapError) as caught:
        imported(one_joint(reference='x'), **{'x': LINK, **BAD_COLUMNS[message]})
    assert message in str(caught.value) and '\n' not in str(caught.value)


@pytest.mark.parametrize('name', [*SAVE, 'table.xlsx', 'absent.csv'])
def test_a_broken_table_is_refused_in_one_line(name, tmp_path):
    if name != 'absent.csv':
        (tmp_path / name).write_bytes(b'\x00\xff\x1b not a table, "and more\n,,,\n' * 9)
    with pytest.raises(TableError) as caught:
        read_table(tmp_path / name)
    assert name in str(caught.value) and '\n' not in str(caught.value)


@pytest.mark.parametrize('name', SAVE)
def test_a_cut_off_table_is_read_in_part_or_refused(name, tmp_path):
    SAVE[name](tmp_path / name, {'t': np.arange(200.0), 'x': np.arange(200.0)})
    whole = (tmp_path / name).read_bytes()
    for length in range(0, len(whole), max(1, len(whole) // 40)):
        (tmp_path / name).write_bytes(whole[:length])
        try:
            table = read_table(tmp_path / name)
        except TableError as refused:
            assert '\n' not in str(refused)
        else:
            assert all(isinstance(column, np.ndarray) for column in table.values())


def save_split(folder: Path, **changes: Any) -> tuple[Path, Path]:
    """Save a table of two runs and its map; returns their paths."""
    columns = {'t': np.tile(TIMES, 2), 'run': np.repeat([5.0, 3.0], ROWS),
               'm': np.tile(LINK * RATIO, 2), 'q': np.tile(LINK, 2), 'sensor': np.arange(10.0)}
    document = {**one_joint(motor={'position': 'm'}, link={'position': 'q'}, reference='sensor'),
                'split': 'run', **changes}
    save_csv(folder / 'log.csv', columns)
    (folder / 'map.yaml').write_text(yaml.safe_dump(document))
    return folder / 'log.csv', folder / 'map.yaml'


def test_an_imported_bag_holds_the_angles_and_the_reference(tmp_path):
    table, map_file = save_split(tmp_path)
    bags = run_import(table, map_file, tmp_path / 'bag')
    assert bags == [tmp_path / 'bag_5', tmp_path / 'bag_3']
    recording = open_recording(bags[1])
    states = recording.joint_states()
    np.testing.assert_allclose(
        states.select(['joint1_motor']).position[:, 0], RATIO * LINK, rtol=1e-15)
    wrench = recording.wrenches('reference/joint1/torque')
    np.testing.assert_array_equal(wrench.torque[:, 2], [5, 6, 7, 8, 9])
    np.testing.assert_array_equal(wrench.stamps, states.stamps)


def test_bags_appear_all_or_none(tmp_path):
    table, map_file = save_split(tmp_path)
    (tmp_path / 'bag_3').mkdir()
    (tmp_path / 'bag_3' / 'mine').touch()
    before = sorted(tmp_path.rglob('*'))
    with pytest.raises(BagError, match='bag_3 exists'):
        run_import(table, map_file, tmp_path / 'bag')
    assert sorted(tmp_path.rglob('*')) == before


@pytest.mark.parametrize('text, message', [
    ('time: [', 'map.yaml: not YAML at line 1'),
    ('', 'map.yaml: the column map must hold some of'),
    (yaml.safe_dump(one_joint(reference='senzor')),
     "names the column 'senzor', which the table does not have; the nearest it has: 'sensor'"),
])
def test_an_error_of_a_map_names_its_file_and_nothing_is_left(text, message, tmp_path):
    table, map_file = save_split(tmp_path)
    map_file.write_text(text)
    before = sorted(tmp_path.rglob('*'))
    with pytest.raises(ColumnMapError) as caught:
        run_import(table, map_file, tmp_path / 'bag')
    assert message in str(caught.value) and '\n' not in str(caught.value)
    assert sorted(tmp_path.rglob('*')) == before


def test_values_that_give_the_same_name_of_a_bag_are_refused(tmp_path):
    table, map_file = save_split(tmp_path, split='kind')
    lines = table.read_text().splitlines()
    kinds = ['kind', *['a b'] * ROWS, *['a/b'] * ROWS]
    table.write_text('\n'.join(f'{line},{kind}' for line, kind in zip(lines, kinds)))
    with pytest.raises(ColumnMapError, match="'a b' and 'a/b' both give the name 'bag_a_b'"):
        run_import(table, map_file, tmp_path / 'bag')


def test_an_unknown_map_gets_the_list_of_shipped_ones(tmp_path):
    with pytest.raises(ColumnMapError, match='voraus_yucobot.yaml'):
        run_import(tmp_path / 'x.csv', Path('nowhere.yaml'), tmp_path / 'bag')


@pytest.mark.parametrize('name', shipped_maps())
def test_shipped_maps_can_be_read(name):
    column_map = read_column_map(yaml.safe_load(
        (Path(__file__).parents[1] / 'config' / 'maps' / name).read_text()))
    assert len(column_map.joints) >= 6


def measured(name: str) -> Path:
    """Return a table of real measurements, or skip: its licence keeps it out of the project."""
    if not (MEASURED / name).is_file():
        pytest.skip(f'{name} is not at ../shared/data: its licence keeps it out of the project')
    return MEASURED / name


def test_the_yucobot_table_becomes_four_bags_with_references(tmp_path):
    bags = run_import(measured('voraus_yucobot/test.parquet'), Path('voraus_yucobot.yaml'),
                      tmp_path / 'yucobot')
    assert [bag.name for bag in bags] == [f'yucobot_{run}' for run in (12, 755, 1702, 1703)]
    recording = open_recording(bags[0])
    states = recording.joint_states()
    assert len(states) == 100 and len(states.names) == 12
    shaft, link = (states.select([name]).position[:, 0] for name in ('joint1_motor', 'joint1'))
    assert np.ptp(shaft / 100.0 - link) < 2e-3          # the two sides differ by the torsion only
    assert np.ptp(recording.wrenches('reference/joint1/torque').torque[:, 2]) > 10.0


def test_a_kinova_table_becomes_a_bag_of_the_motor_side(tmp_path):
    bag, = run_import(measured('kinova_gen3_jointwise/joint_3_trapez.csv.gz'),
                      Path('kinova_gen3.yaml'), tmp_path / 'kinova')
    states = open_recording(bag).joint_states()
    assert states.names == tuple(f'joint{number}_motor' for number in range(1, 8))
    shaft = states.select(['joint3_motor'])
    travelled = float(np.sum(shaft.velocity[1:, 0] * np.diff(shaft.stamps) * 1e-9))
    assert travelled == pytest.approx(np.ptp(shaft.position[:, 0]), rel=5e-3)
