"""Every joint and column is guessed by its own numbers: signs, sides, units, dead columns."""

from pathlib import Path

from hda_torque_estimator.importing.convert import convert, Imported
from hda_torque_estimator.importing.guess import guess
from hda_torque_estimator.importing.guess_text import FILL_IN, map_text
from hda_torque_estimator.importing.map_document import read_column_map
from hda_torque_estimator.importing.tables import read_table
import numpy as np
import pytest
import yaml

MEASURED = Path(__file__).parents[2] / 'shared' / 'data'
TIME = np.arange(1000) / 500.0
ANGLES = {1: np.sin(3 * TIME), 2: 0.5 * np.sin(5 * TIME + 1), 3: 0.1 * np.cos(4 * TIME)}
RATES = {1: 3 * np.cos(3 * TIME), 2: 2.5 * np.cos(5 * TIME + 1), 3: -0.4 * np.sin(4 * TIME)}
RATIOS = {1: 121.0, 2: 101.0, 3: 80.0}
TURN = 2.0 * np.pi
COUNTS = 2.0 ** 24

Table = dict[str, np.ndarray]


def table(*, ratio: float = 100.0) -> Table:
    """Return what a right log of three joints holds."""
    columns: Table = {'t': TIME}
    for n, angle in ANGLES.items():
        columns |= {f'motor_pos_{n}': ratio * angle + 0.1, f'link_pos_{n}': angle,
                    f'motor_vel_{n}': ratio * RATES[n], f'tau_cmd_{n}': 0.1 * RATES[n]}
    return columns


def imported(columns: Table, value: str = '100') -> Imported:
    """Return what a table becomes by its guessed map, every gap filled in."""
    text = map_text(guess(columns), 'table.csv').replace(FILL_IN, value)
    recording, = convert(read_column_map(yaml.safe_load(text)), columns)
    return recording


@pytest.mark.parametrize('reversed_joint', [1, 2, 3])
def test_a_sign_reversed_at_one_joint_is_reversed_there_alone(reversed_joint):
    columns = table()
    columns[f'motor_pos_{reversed_joint}'] = -columns[f'motor_pos_{reversed_joint}']
    columns[f'motor_vel_{reversed_joint}'] = -columns[f'motor_vel_{reversed_joint}']
    states = imported(columns).joint_states
    for n in ANGLES:
        shaft = states.select([f'joint{n}_motor'])
        assert np.ptp(shaft.position[:, 0] - 100.0 * ANGLES[n]) < 1e-9
        np.testing.assert_allclose(shaft.velocity[:, 0], 100.0 * RATES[n])


def test_a_speed_that_runs_against_its_angle_gets_a_sign():
    columns = table()
    columns['motor_vel_2'] = -columns['motor_vel_2']
    states = imported(columns).joint_states
    np.testing.assert_allclose(states.select(['joint2_motor']).velocity[:, 0], 100.0 * RATES[2])


def test_a_joint_that_stands_determines_no_sign():
    columns = table()
    columns['motor_pos_3'], columns['link_pos_3'] = np.full(1000, 7.0), np.full(1000, 0.07)
    entry = guess(columns).entries['motor.position']
    assert entry.signs == {} and 'its sign is not known at 3' in entry.reason


def test_a_column_of_zeros_is_no_encoder():
    columns = {**table(), **{f'link_encoder_{n}': np.zeros(1000) for n in ANGLES}}
    first = dict(reversed(columns.items()))                 # dead ones stand before the others
    assert guess(first).entries['link.position'].patterns[0].name == 'link_pos_{n}'
    states = imported({**table(), 'link_pos_2': np.zeros(1000)}).joint_states
    assert 'joint2' not in states.names and 'joint2_motor' in states.names


def test_a_joint_of_zeros_is_nothing_that_was_measured():
    dead = {name: np.zeros(1000) for name in ('motor_pos_2', 'link_pos_2', 'motor_vel_2',
                                              'tau_cmd_2', 'torque_sensor_2')}
    found = guess({**table(), **dead})
    assert not {*dead} - {*found.unused} and found.joints == (1, 3)
    assert 'reference' not in found.entries
    standing = guess({**table(), 'tau_cmd_2': np.zeros(1000)})      # a brake holds it, perhaps
    assert standing.entries['motor.effort'].patterns[0].columns.keys() == {1, 2, 3}


@pytest.mark.parametrize('names', [('enc_a_{}', 'enc_b_{}'), ('theta_{}', 'q_{}'),
                                   ('link_pos_{}', 'motor_pos_{}')])
def test_the_motor_is_what_moves_more(names):
    """Whatever their names, behind a gear the motor turns further than the link."""
    for more, less in (names, names[::-1]):
        columns: Table = {'t': TIME}
        for n, angle in ANGLES.items():
            columns |= {more.format(n): 100.0 * angle, less.format(n): angle}
        entries = guess(columns).entries
        assert entries['motor.position'].patterns[0].name == more.format('{n}')
        assert entries['link.position'].patterns[0].name == less.format('{n}')


def test_words_that_are_written_as_one_state_the_side():
    columns: Table = {'t': TIME}
    for n, angle in ANGLES.items():
        columns |= {f'encoder_loadinc_{n}': np.rint(angle / TURN * COUNTS),
                    f'encoder_motorinc_{n}': np.rint(-RATIOS[n] * angle / TURN * 4096)}
    entries = guess(columns).entries
    assert entries['motor.position'].patterns[0].name == 'encoder_motorinc_{n}'
    assert entries['link.position'].unit == entries['motor.position'].unit == 'count'
    assert entries['motor.position'].sign == -1


def test_ratios_that_differ_are_stated_one_by_one():
    columns: Table = {'t': TIME}
    for n, angle in ANGLES.items():
        columns |= {f'motor_pos_{n}': RATIOS[n] * angle, f'link_pos_{n}': angle}
    found = guess(columns)
    assert found.ratios == RATIOS and found.ratio is None
    assert [line.split()[1] for line in map_text(found, 'table.csv').splitlines()
            if 'ratio:' in line] == ['121', '101', '80']


def test_degrees_beside_counts_keep_their_units():
    """A link in degrees and a motor in counts, joint by joint, or the other way round."""
    columns: Table = {'t': TIME}
    for n, angle in ANGLES.items():
        columns |= {f'motor_pos_{n}': np.rint(100.0 * angle / TURN * 65536),
                    f'link_pos_{n}': np.degrees(angle)}
    entries = guess(columns).entries
    assert (entries['motor.position'].unit, entries['link.position'].unit) == ('count', 'deg')
    columns['motor_pos_2'] = 100.0 * np.degrees(ANGLES[2])
    entry = guess(columns).entries['motor.position']
    assert [entry.unit_of(n) for n in ANGLES] == ['count', 'deg', 'count']
    for n, angle in ANGLES.items():
        columns |= {f'motor_pos_{n}': 100.0 * np.degrees(angle),
                    f'link_pos_{n}': np.rint(angle / TURN * COUNTS)}
    text = map_text(guess(columns), 'table.csv')
    assert "position: {column: 'motor_pos_{n}', unit: FILL_IN}" in text


@pytest.mark.parametrize('name', ['sweep_joint3', 'jogging_linear_mass'])
def test_the_lara_has_its_encoders_where_they_are(name):
    path = MEASURED / 'neura_lara8' / f'{name}.csv.gz'
    if not path.is_file():
        pytest.skip(f'{name} is not at ../shared/data: it stays outside the project')
    columns = read_table(path)
    entries = guess(columns).entries
    assert entries['motor.position'].patterns[0].name == 'encoder_motorinc_{n}'
    assert entries['link.position'].patterns[0].name == 'encoder_loadinc_{n}'
    for n in (1, 2, 3, 6):
        angle = columns[f'joint_angles_{n}']
        for place, raw in (('motor.position', 'motorinc'), ('link.position', 'loadinc')):
            runs = np.polyfit(angle, columns[f'encoder_{raw}_{n}'], 1)[0]
            assert np.ptp(angle) < 0.05 or entries[place].sign_of(n) == np.sign(runs)


def test_a_flag_is_no_torque():
    path = MEASURED / 'bam_xl330' / 'sin_sin_kp100.csv.gz'
    if not path.is_file():
        pytest.skip('the bench is not at ../shared/data: it stays outside the project')
    assert set(guess(read_table(path)).entries) == {'link.position', 'link.velocity'}
