"""Logs of the shapes in which robots are published: what their maps must not get wrong."""

from hda_torque_estimator.cli import main
from hda_torque_estimator.importing.column_map import ColumnMapError
from hda_torque_estimator.importing.guess import Guess, guess
from hda_torque_estimator.importing.guess_text import map_text
from hda_torque_estimator.importing.headings import read_heading
from hda_torque_estimator.importing.side_by_side import read_tables
from hda_torque_estimator.importing.tables import read_table, TableError
import numpy as np
import pytest
import yaml

ROWS = np.arange(2000)
JOINTS = (1, 2, 3)
Table = dict[str, np.ndarray]


def angles(rate: float) -> Table:
    """Return time [s], angles [rad] and speeds [rad/s] of three joints at a rate [Hz]."""
    t = ROWS / rate
    columns: Table = {'t': t}
    for n in JOINTS:
        columns |= {f'q_{n}': np.sin((0.2 + 0.05 * n) * t + n),
                    f'qd_{n}': (0.2 + 0.05 * n) * np.cos((0.2 + 0.05 * n) * t + n)}
    return columns


def torques(columns: Table) -> Table:
    """Return torques that drive the joints."""
    return {f'tau_{n}': 3.0 * np.sign(columns[f'qd_{n}']) + columns[f'q_{n}'] for n in JOINTS}


def named(found: Guess, place: str) -> str:
    return found.entries[place].patterns[0].name


@pytest.mark.parametrize('name, kind, unit', [
    ('a1 q-axis [A]', 'current', 'A'), ('a1 q-axis cmd [A]', 'current', 'A'),
    ('c1 vel [Hz]', 'velocity', 'turn/s'), ('effort_1 [V]', None, None),
    ('position_1 [m]', None, None), ('motor temp 1 [C]', None, None), ('q_1 [A]', 'current', 'A'),
    ('q_1 (a)', 'position', None), ('force_1 [Nm]', 'torque', 'N*m'),
    ('velocity_1 [rad]', 'velocity', None), ('theta_1 (m)', 'position', None)])
def test_a_unit_in_brackets_counts_more_than_the_words(name, kind, unit):
    heading = read_heading(name)
    assert (heading.kind, heading.unit) == (kind, unit)


def test_a_dynamometer_keeps_its_currents_apart_from_its_angles():
    """A controller at the motor, an actuator behind the gear, currents by axis, a sensor."""
    columns: Table = {'time [s]': ROWS / 120.0}
    for n in (1, 2):
        q = np.sin(0.7 * n * ROWS / 120.0)
        columns |= {f'a{n} torque cmd [Nm]': q, f'a{n} position [rad]': q,
                    f'a{n} velocity [rad/s]': np.gradient(q) * 120.0,
                    f'a{n} torque [Nm]': np.gradient(q), f'a{n} q-axis [A]': 40.0 * q + n,
                    f'c{n} voltage [V]': 36.0 + q, f'motor temp {n} [C]': 30.0 + q}
    found = guess(columns)
    assert named(found, 'motor.effort') == 'a{n} torque [Nm]'
    assert all('q-axis' not in pattern.name for entry in found.entries.values()
               for pattern in entry.patterns)


def test_the_end_of_the_arm_is_no_motor():
    columns = angles(120.0)
    for n in JOINTS:
        columns |= {f'ee_pos_{n}': 0.1 * columns[f'q_{n}'] ** 2,
                    f'stage_pos_{n}': np.cos(ROWS * 0.01 * n)}
    found = guess(columns | torques(columns))
    assert not {'ee_pos_{n}', 'stage_pos_{n}'} & {
        pattern.name for entry in found.entries.values() for pattern in entry.patterns}
    assert 'ee_pos_1' in found.unused and 'stage_pos_1' in found.unused


@pytest.mark.parametrize('rate', [8.0, 30.0, 125.0, 1000.0, 5000.0])
@pytest.mark.parametrize('unit, factor', [('s', 1.0), ('ms', 1e3), ('us', 1e6)])
def test_the_unit_of_a_time_without_one(rate, unit, factor):
    """Slow logs too: speeds tell the unit, and without them steps tell it to a factor of 30."""
    columns = angles(rate)
    columns['t'] = columns['t'] * factor
    assert guess(columns).time.unit == unit
    if rate > 10.0:
        alone = {name: values for name, values in columns.items() if 'qd' not in name}
        assert guess(alone).time.unit == unit


def test_the_only_angle_is_that_of_the_motor():
    """Without a motor's angle neither a calibration nor a diagnosis had anything to start from."""
    columns = angles(100.0)
    found = guess(columns | torques(columns))
    assert named(found, 'motor.position') == 'q_{n}' and 'link.position' not in found.entries
    assert found.entries['motor.position'].side == found.entries['motor.velocity'].side == 'link'
    assert 'the only angle' in found.entries['motor.position'].reason
    assert named(guess(columns), 'link.position') == 'q_{n}'        # no torque: nothing to drive


@pytest.mark.parametrize('table, place', [
    ('curr_data', 'motor.effort'), ('joint_torques', 'motor.effort'),
    ('pos_read', 'link.position'), ('log', 'link.position'), ('pos_and_torque', 'link.position')])
def test_a_name_that_states_nothing_is_what_its_table_is_called(table, place, tmp_path):
    path = tmp_path / f'{table}.csv'
    values = angles(100.0)
    np.savetxt(path, np.column_stack([values[f'q_{n}'] for n in JOINTS]), delimiter=',',
               header='Joint_1,Joint_2,Joint_3', comments='')
    read = read_tables([path])
    found = guess(read.columns, read.tables)
    assert named(found, place) == 'Joint_{n}'
    said = 'no name says that it is an angle' in map_text(found, 'x.csv')
    assert said == (table in ('log', 'pos_and_torque'))


def test_tables_of_one_quantity_each_are_put_side_by_side(tmp_path, capsys):
    values = angles(100.0)
    values |= torques(values)
    paths = []
    for table, name in (('positions', 'q'), ('speeds', 'qd'), ('torque', 'tau')):
        paths.append(tmp_path / f'{table}.csv')
        np.savetxt(paths[-1], np.column_stack(
            [values['t'], *(values[f'{name}_{n}'] for n in JOINTS)]), delimiter=',',
            header='t,Joint_1,Joint_2,Joint_3', comments='')
    given = [str(path) for path in paths]
    assert main(['import', *given, '--guess']) == 0
    text = capsys.readouterr().out
    document = yaml.safe_load(text.replace('FILL_IN', '100'))
    assert document['time']['column'] == 't'
    assert document['each']['motor']['position']['column'] == 'positions.Joint_{n}'
    assert document['each']['motor']['effort']['column'] == 'torque.Joint_{n}'
    (tmp_path / 'map.yaml').write_text(text.replace('FILL_IN', '100'))
    assert main(['import', *given, '--map', str(tmp_path / 'map.yaml'),
                 '--out', str(tmp_path / 'bag')]) == 0
    np.savetxt(paths[0], np.zeros((5, 4)), delimiter=',', header='t,Joint_1,Joint_2,Joint_3',
               comments='')
    with pytest.raises(TableError, match='need the same rows: .* has 5, .* has 2000'):
        read_tables(paths)


def test_a_table_without_names_has_its_angles_where_their_rates_are(tmp_path):
    """The time, angles, speeds, currents: no name, as a controller of an industrial arm logs."""
    values = angles(100.0)
    stamps = values['t'] + 0.002 * np.sin(ROWS) + 700.0
    np.savetxt(tmp_path / 'log.csv', np.column_stack(
        [stamps, *(values[f'q_{n}'] for n in JOINTS), *(values[f'qd_{n}'] for n in JOINTS),
         *torques(values).values()]), delimiter=',')
    found = guess(read_table(tmp_path / 'log.csv'))
    assert found.time.column == 'column_1'
    assert found.entries['link.position'].patterns[0].columns == {
        1: 'column_2', 2: 'column_3', 3: 'column_4'}
    assert found.entries['link.velocity'].patterns[0].columns == {
        1: 'column_5', 2: 'column_6', 3: 'column_7'}
    document = yaml.safe_load(map_text(found, 'log.csv'))
    assert document['joints']['joint3']['link']['position']['column'] == 'column_4'
    assert 'no current was found' in map_text(found, 'log.csv')


def test_a_table_without_names_and_rates_says_how_to_name_its_columns(tmp_path):
    np.savetxt(tmp_path / 'log.csv', np.random.default_rng(1).normal(size=(50, 4)), delimiter=',')
    with pytest.raises(ColumnMapError, match='name the columns in a first line'):
        guess(read_table(tmp_path / 'log.csv'))
