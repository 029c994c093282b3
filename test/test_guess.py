"""A guessed column map: right where names or numbers suffice, FILL_IN where neither does."""

from pathlib import Path
from typing import Any

from hda_msgs_json.bag import open_recording
from hda_torque_estimator.cli import main
from hda_torque_estimator.importing.column_map import ColumnMapError
from hda_torque_estimator.importing.convert import convert, Imported
from hda_torque_estimator.importing.guess import guess
from hda_torque_estimator.importing.guess_text import FILL_IN, map_text
from hda_torque_estimator.importing.guess_wrench import wrench_columns
from hda_torque_estimator.importing.headings import KINDS, read_heading
from hda_torque_estimator.importing.map_document import read_column_map
from hda_torque_estimator.importing.run import run_import
from hda_torque_estimator.importing.tables import read_table
from hypothesis import example, given, strategies as st
import numpy as np
import pytest
import yaml

MEASURED = Path(__file__).parents[2] / 'shared' / 'data'
RATE, RATIO = 500.0, 80.0
TIME = np.arange(1000) / RATE
DEGREE = np.pi / 180.0
ANGLES = {1: np.sin(3 * TIME), 2: 0.5 * np.sin(5 * TIME + 1)}           # of the links [rad]
SPEEDS = {1: 3 * np.cos(3 * TIME), 2: 2.5 * np.cos(5 * TIME + 1)}
TORQUES = {1: 0.1 * np.cos(TIME), 2: 0.2 * np.sin(TIME)}                # of the motors [N*m]

Table = dict[str, np.ndarray]


def filled(columns: Table, value: str = '100') -> dict[str, Any]:
    """Return the guessed map of a table as a document, every gap filled in."""
    text = map_text(guess(columns), 'table.csv')
    return yaml.safe_load(text.replace(FILL_IN, value))


def imported(columns: Table) -> Imported:
    """Return what a table becomes by its guessed map."""
    recording, = convert(read_column_map(filled(columns)), columns)
    return recording


@pytest.mark.parametrize('name, kind, unit, number, words', [
    ('motor_pos_1_deg', 'position', 'deg', 1, {'motor', 'pos'}),
    ('q1', 'position', None, 1, {'q'}), ('theta_l2', 'position', None, 2, {'theta', 'l'}),
    ('tau_cmd [Nm]', 'torque', 'N*m', None, {'tau', 'cmd'}),
    ('current_A', 'current', 'A', None, {'current'}),
    ('Strom_3', 'current', None, 3, {'strom'}), ('Zeit [ms]', 'time', 'ms', None, {'zeit'}),
    ('Couple moteur [Nm]', 'torque', 'N*m', None, {'couple', 'moteur'}),
    ('tau_mNm', 'torque', 'mN*m', None, {'tau'}),
    ('iq_2 (mA)', 'current', 'mA', 2, {'iq'}),
    ('TorqueCur7', 'torque', None, 7, {'torque', 'cur'}),
    ('J1 Motor Angle (deg)', 'position', 'deg', 1, {'j', 'motor', 'angle'}),
    ('joint_1.velocity[rad/s]', 'velocity', 'rad/s', 1, {'joint', 'velocity'}),
    ('motorSpeedRPM3', 'velocity', 'rpm', 3, {'motor', 'speed'}),
    ('enc1_counts', 'position', 'count', 1, {'enc'}), ('Time [us]', 'time', 'us', None, {'time'}),
    ('timestamps', 'time', None, None, {'timestamp'}),
    ('joints_2', 'position', None, 2, {'joint'}),
    ('motor_efforts_1', 'torque', None, 1, {'motor', 'effort'}),
    ('status_velocities_1 (rads)', 'velocity', 'rad/s', 1, {'status', 'velocity'}),
    ('motor_2_deg', 'position', 'deg', 2, {'motor'}), ('a', None, None, None, {'a'}),
    ('category', None, None, None, {'category'})])
def test_a_name_states_quantity_unit_and_joint(name, kind, unit, number, words):
    heading = read_heading(name)
    assert (heading.kind, heading.unit, heading.number) == (kind, unit, number)
    assert heading.words == words
    assert heading.pattern.replace('{n}', str(number)) == name


@pytest.mark.parametrize('names, scale', [
    (('t', 'theta_m{}', 'theta_l{}', 'dtheta_m{}', 'dtheta_l{}', 'tau_cmd{} [Nm]'), 1.0),
    (('time_ms', 'motor_pos_{}_deg', 'link_pos_{}_deg', 'motor_vel_{}', 'link_vel_{}',
      'motor_torque_{} [mNm]'), 1 / DEGREE),
    (('timestamp', 'Motor{}Angle', 'q{}', 'Motor{}Speed', 'dq{}', 'TorqueCmd{}'), 1.0)])
def test_a_table_of_both_sides_comes_back(names, scale):
    """Angles, speeds and torques come back in SI units, and the ratio is seen."""
    time, motor, link, motor_speed, link_speed, torque = names
    columns: Table = {time: TIME * (1000 if 'ms' in time else 1)}
    for n in (1, 2):
        columns[motor.format(n)] = RATIO * ANGLES[n] * scale
        columns[link.format(n)] = ANGLES[n] * scale
        columns[motor_speed.format(n)] = RATIO * SPEEDS[n] * scale
        columns[link_speed.format(n)] = SPEEDS[n] * scale
        columns[torque.format(n)] = TORQUES[n] * (1000 if 'mNm' in torque else 1)
        columns[f'temperature_{n}'] = TIME
    assert FILL_IN not in str(filled(columns, FILL_IN))
    assert guess(columns).ratio == RATIO
    states = imported(columns).joint_states
    assert states.names == ('joint1', 'joint1_motor', 'joint2', 'joint2_motor')
    np.testing.assert_allclose(states.stamps, 1e9 * TIME, atol=1)
    for n in (1, 2):
        shaft, joint = states.select([f'joint{n}_motor']), states.select([f'joint{n}'])
        np.testing.assert_allclose(shaft.position[:, 0], RATIO * ANGLES[n], atol=1e-12)
        np.testing.assert_allclose(joint.position[:, 0], ANGLES[n], atol=1e-12)
        np.testing.assert_allclose(shaft.velocity[:, 0], RATIO * SPEEDS[n], atol=1e-11)
        np.testing.assert_allclose(joint.velocity[:, 0], SPEEDS[n], atol=1e-11)
        np.testing.assert_allclose(shaft.effort[:, 0], TORQUES[n], atol=1e-12)


@pytest.mark.parametrize('names', [
    ('Zeit', 'Winkel_Antrieb', 'Winkel_Abtrieb', 'Strom'),
    ('Temps', 'Position moteur', 'Position bras', 'Courant moteur'),
    ('Tempo', 'Posizione motore', 'Posizione giunto', 'Corrente motore'),
    ('Tiempo', 'Posicion motor', 'Posicion brazo', 'Corriente motor')])
def test_words_of_other_languages_are_read(names):
    time, motor, link, current = names
    there = filled({time: TIME, motor: RATIO * ANGLES[1], link: ANGLES[1], current: TORQUES[1]})
    assert there['time']['column'] == time
    assert there['each']['motor']['position']['column'] == motor
    assert there['each']['motor']['effort']['column'] == current
    assert there['each']['link']['position']['column'] == link


def test_numbers_determine_the_unit_of_angles_and_speeds():
    columns = {'t': TIME, 'motor_pos': np.rint(4096 * RATIO * ANGLES[1]),
               'link_pos': 90 * ANGLES[1], 'link_speed': 90 / 6 * SPEEDS[1]}
    entries = guess(columns).entries
    assert entries['motor.position'].unit == 'count'
    assert entries['link.position'].unit == 'deg'
    assert entries['link.velocity'].unit == 'rpm'
    assert filled(columns)['each']['motor']['position']['counts_per_turn'] == 100


@pytest.mark.parametrize('step, unit', [
    (0.002, 's'), (1, 'ms'), (4, 'ms'), (1000, 'us'), (250, 'us'), (10 ** 6, 'ns')])
def test_the_step_of_the_time_determines_its_unit(step, unit):
    columns = {'time': 1000 * step + step * np.arange(50.0), 'q': ANGLES[1][:50]}
    assert guess(columns).time.unit == unit


def test_a_motor_stated_at_the_link_side_needs_the_ratio():
    columns = {'t': TIME, 'motor_pos_1': ANGLES[1] + 1e-4 * SPEEDS[1] + 7,
               'joint_pos_1': ANGLES[1], 'motor_torque_1': TORQUES[1]}
    document = filled(columns, FILL_IN)
    assert document['each']['ratio'] == FILL_IN
    assert document['each']['motor']['position']['side'] == 'link'
    assert document['each']['motor']['effort']['side'] == 'link'
    with pytest.raises(ValueError, match="joint1.ratio must be a number.*got 'FILL_IN'"):
        read_column_map(document)


def test_a_motor_that_runs_against_the_link_gets_a_sign():
    columns = {'t': TIME, 'theta_m': -RATIO * ANGLES[1], 'theta_l': ANGLES[1]}
    states = imported(columns).joint_states
    np.testing.assert_allclose(states.select(['joint1_motor']).position[:, 0], RATIO * ANGLES[1])


def test_currents_need_their_constant_and_torques_come_first():
    current = {'t': TIME, 'q': ANGLES[1], 'motor_current': TORQUES[1]}
    entry = filled(current)['each']['motor']['effort']
    assert (entry['unit'], entry['torque_constant']) == ('A', 100)
    both = guess({**current, 'motor_torque': TORQUES[1]}).entries['motor.effort']
    assert both.patterns[0].name == 'motor_torque' and both.others == ('motor_current',)


def test_like_sensors_are_averaged_and_commands_are_no_measurements():
    entries = guess({
        't': TIME, 'q_1': ANGLES[1], 'q_des_1': ANGLES[1], 'torque_sensor_a_1': TORQUES[1],
        'torque_sensor_b_1': TORQUES[1], 'tau_cmd_1': TORQUES[1]}).entries
    assert [pattern.name for pattern in entries['reference'].patterns] == [
        'torque_sensor_a_{n}', 'torque_sensor_b_{n}']
    assert entries['motor.effort'].patterns[0].name == 'tau_cmd_{n}'
    assert entries['motor.position'].patterns[0].name == 'q_{n}'
    assert all(entry.others == () for entry in entries.values())


def test_joints_that_count_from_zero_are_named_one_by_one():
    columns = {'t': TIME, 'q_0': ANGLES[1], 'q_1': ANGLES[2], 'motor_pos_1': RATIO * ANGLES[2]}
    states = imported(columns).joint_states
    assert states.names == ('joint1', 'joint2', 'joint2_motor')
    np.testing.assert_array_equal(states.position[:, 1], ANGLES[2])


def test_without_a_time_the_rate_is_to_be_filled_in():
    columns = {'time': np.zeros(1000), 'q': ANGLES[1]}
    assert filled(columns, FILL_IN)['time'] == {'rate': FILL_IN}
    np.testing.assert_array_equal(imported(columns).joint_states.stamps, 10 ** 7 * np.arange(1000))


@pytest.mark.parametrize('late', [0.0, 0.3])
def test_a_column_that_grows_in_even_steps_is_a_time_whatever_its_name(late):
    jitter = late / RATE * np.random.default_rng(3).random(1000)
    columns = {'row': np.arange(1000), 'volume': np.full(1000, 3.0), 'Takt': 5.0 + TIME + jitter,
               'q': ANGLES[1]}
    found = guess(columns).time
    assert found.column == 'Takt' and 'grows in even steps' in found.reason
    assert guess({**columns, 'clock_t': TIME}).time.column == 'clock_t'
    assert guess({'row': np.arange(1000), 'q': ANGLES[1]}).time.column is None


@pytest.mark.parametrize('parts', [('sec', 'nanosec'), ('secs', 'nsecs')])
def test_the_stamps_of_messages_are_whole(parts):
    whole, rest = (f'header.stamp.{part}' for part in parts)
    stamps = 1_700_000_000_990_000_000 + np.rint(1e9 * TIME).astype(np.int64)
    columns = {whole: stamps // 10 ** 9, rest: stamps % 10 ** 9, 'q': ANGLES[1]}
    found = imported(columns).joint_states
    np.testing.assert_allclose(found.stamps, stamps - stamps[0], atol=500)


def test_a_time_that_starts_again_is_split():
    columns = {'t': np.tile(TIME, 2), 'q': np.tile(ANGLES[1], 2), 'phase': np.arange(2000),
               'trial': np.repeat(['b', 'a'], 1000)}
    recordings = convert(read_column_map(filled(columns)), columns)
    assert [recording.label for recording in recordings] == ['b', 'a']


def test_a_table_without_joints_is_refused_in_one_line(tmp_path, capsys):
    with pytest.raises(ColumnMapError, match="no column looks like .* got 'time', 'price'"):
        guess({'time': TIME, 'price': TIME})
    table = tmp_path / 'table.csv'
    table.write_text('time,price\n1,2\n')
    assert main(['import', str(table), '--guess']) == 2
    assert capsys.readouterr().err.count('\n') == 1
    assert main(['import', str(table), '--out', 'bag']) == 2
    assert '--guess for a map to edit' in capsys.readouterr().err


NAMES = st.lists(st.sampled_from([*KINDS, 'motor', 'link', 'deg', 'nm', 'sensor', 'a', 'run', '1',
                                  '2', '[A]', "it's", '\n', '{n}']), max_size=4).map(' '.join)
CONTENTS = {
    'times': TIME, 'long': 1e7 * TIME, 'back': -TIME, 'zeros': np.zeros(1000),
    'texts': TIME.astype(str), 'unknown': np.full(1000, np.nan),
    'whole': np.arange(1000), 'truth': TIME > 1}


@example(chosen={'position': 'back', 'deg': 'back'}, rows=8)         # less than one to one
@given(chosen=st.dictionaries(NAMES, st.sampled_from(sorted(CONTENTS)), max_size=12),
       rows=st.integers(0, 20))
def test_a_guess_is_a_map_of_its_table_or_one_line(chosen: dict[str, str], rows: int) -> None:
    """Whatever the table, the text is YAML and, filled in, a map that its table can be held to."""
    columns = {name: CONTENTS[content][:rows] for name, content in chosen.items()
               if '{n}' not in name}
    try:
        document = filled(columns)
        convert(read_column_map(document), columns)
    except ColumnMapError as refused:
        assert '\n' not in str(refused)


@pytest.mark.parametrize('name, shipped', [
    ('voraus_yucobot/test.parquet', 'voraus_yucobot.yaml'),
    ('kinova_gen3_jointwise/joint_3_trapez.csv.gz', 'kinova_gen3.yaml')])
def test_measured_tables_come_back_as_by_the_shipped_maps(name, shipped, tmp_path, capsys):
    """The printed map of a real table, filled in, gives the angles of the map written by hand."""
    table = MEASURED / name
    if not table.is_file():
        pytest.skip(f'{name} is not at ../shared/data: its licence keeps it out of the project')
    assert main(['import', str(table), '--guess']) == 0
    text = capsys.readouterr().out.replace(FILL_IN, '100')
    (tmp_path / 'map.yaml').write_text(text)
    ours = run_import(table, tmp_path / 'map.yaml', tmp_path / 'guessed')
    theirs = run_import(table, Path(shipped), tmp_path / 'shipped')
    assert len(ours) == len(theirs)
    for one, two in zip(ours, theirs):
        found, expected = (open_recording(bag) for bag in (one, two))
        np.testing.assert_array_equal(found.joint_states().stamps, expected.joint_states().stamps)
        joints = expected.joint_states()
        np.testing.assert_allclose(
            found.joint_states().select(joints.names).position, joints.position)
        if shipped == 'voraus_yucobot.yaml':
            topic = 'reference/joint4/torque'
            np.testing.assert_array_equal(found.wrenches(topic).torque,
                                          expected.wrenches(topic).torque)


def test_every_kind_of_table_can_be_guessed(tmp_path):
    columns = {'t': TIME, 'q_1': ANGLES[1], 'q_2': ANGLES[2]}
    np.savez(tmp_path / 'log.npz', t=TIME, q=np.column_stack([ANGLES[1], ANGLES[2]]))
    assert imported(read_table(tmp_path / 'log.npz')).joint_states.names == ('joint1', 'joint2')
    assert guess(columns).entries == guess(read_table(tmp_path / 'log.npz')).entries


@pytest.mark.parametrize('names', [
    ('Fx', 'Fy', 'Fz', 'Tx', 'Ty', 'Tz'), ('fx [N]', 'fy [N]', 'fz [N]', 'mx', 'my', 'mz'),
    ('ft.force.x', 'ft.force.y', 'ft.force.z', 'ft.torque.x', 'ft.torque.y', 'ft.torque.z')])
def test_six_columns_of_a_wrench_are_shown_as_a_line_to_take_in(names):
    assert wrench_columns(('time', 'exx', *names[::-1], 'max')) == names


@pytest.mark.parametrize('names', [
    ('Fx', 'Fy', 'Fz'), ('tx', 'max', 'matrix'),
    ('Fx', 'Fy', 'Fz', 'Tx', 'Ty', 'Tz', 'fx_filtered')])
def test_what_is_no_wrench_for_certain_is_none(names):
    assert wrench_columns(names) == ()
