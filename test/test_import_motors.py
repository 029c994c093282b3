"""Logs of small drives: PWM and voltages become torques, host stamps even, MAT 7.3 is read."""

import os

import h5py
from hda_torque_estimator.importing.column_map import ColumnMapError
from hda_torque_estimator.importing.convert import convert
from hda_torque_estimator.importing.map_document import read_column_map
from hda_torque_estimator.importing.tables import read_table, TableError
import numpy as np
import pytest

TIME = 0.01 * np.arange(400)
SPEED = 12.0 * np.cos(2.0 * TIME)                   # [rad/s]
ANGLE = 6.0 * np.sin(2.0 * TIME)                    # [rad]
CURRENT = 0.3 * np.sign(SPEED) + 0.05 * SPEED       # [A]
KT, OHM, SUPPLY = 0.4, 5.0, 12.0
VOLTAGE = OHM * CURRENT + KT * SPEED
MOTOR = {'kt': KT, 'R': OHM}


def torque_of(effort, columns, *quantities):
    """Return the imported torque of a motor, from columns and what is known beside it [N*m]."""
    motor = {name: name for name in quantities} | {'effort': effort}
    found, = convert(read_column_map({'time': 't', 'joints': {'joint1': {'motor': motor}}}),
                     {'t': TIME, 'position': ANGLE, 'velocity': SPEED, **columns})
    return found.joint_states.select(['joint1_motor']).effort[:, 0]


@pytest.mark.parametrize(('entry', 'column'), [
    ({'unit': 'V', **MOTOR}, VOLTAGE),
    ({'unit': 'mV', 'torque_constant': KT, 'resistance': OHM}, 1e3 * VOLTAGE),
    ({'unit': 'pwm', 'full_scale': 885, 'supply': SUPPLY, **MOTOR}, 885 * VOLTAGE / SUPPLY),
    ({'unit': 'pwm', 'full_scale': 1, 'supply': SUPPLY, 'sign': -1, **MOTOR}, -VOLTAGE / SUPPLY),
])
@pytest.mark.parametrize(('quantities', 'error'), [(['velocity'], 1e-12), (['position'], 2e-4)])
def test_a_voltage_less_the_back_emf_is_a_torque(entry, column, quantities, error):
    found = torque_of({'column': 'u', **entry}, {'u': column}, *quantities)
    assert np.abs(found - KT * CURRENT)[1:-1].max() < error


@pytest.mark.parametrize(('entry', 'quantities', 'says'), [
    ({'unit': 'V', 'kt': KT}, ['velocity'], 'needs resistance'),
    ({'unit': 'pwm', **MOTOR, 'supply': 12.0}, ['velocity'], 'needs full_scale'),
    ({'unit': 'pwm', 'kt': KT}, ['velocity'], 'resistance.* and supply.* and full_scale'),
    ({'unit': 'V', **MOTOR, 'supply': 12.0}, ['velocity'], 'supply has no use'),
    ({'unit': 'V', **MOTOR, 'torque_constant': KT}, ['velocity'], 'both kt and torque_constant'),
    ({'unit': 'V', **MOTOR}, [], 'needed for its back EMF'),
    ({'unit': 'V', **MOTOR, 'side': 'link'}, ['velocity'], 'stated at the motor'),
])
def test_a_voltage_that_determines_no_torque_is_refused(entry, quantities, says):
    with pytest.raises(ColumnMapError, match=says):
        torque_of({'column': 'u', **entry}, {'u': VOLTAGE}, *quantities)


def test_bursts_of_a_host_become_even():
    late = np.repeat(TIME[7::8], 8)
    document = {'joints': {'joint1': {'link': {'position': 'q'}}}}
    columns = {'t': late, 'q': ANGLE}
    with pytest.raises(ColumnMapError, match='must grow from row to row'):
        convert(read_column_map({'time': 't', **document}), columns)
    found, = convert(read_column_map({'time': {'column': 't', 'even': True}, **document}), columns)
    assert np.ptp(np.diff(found.joint_states.stamps)) <= 0.01 * 0.01 * 1e9
    with pytest.raises(ColumnMapError, match='time.even must be true or false'):
        read_column_map({'time': {'column': 't', 'even': 'yes'}, **document})


def mat73(path, **others):
    """Write a file as MATLAB does with -v7.3: columns first, structs as groups, own attributes."""
    with h5py.File(path, 'w', userblock_size=512) as file:
        file['t'] = TIME[None, :]
        file['t'].attrs['MATLAB_class'] = np.bytes_('double')
        file['log/q'] = np.stack([ANGLE, 2.0 * ANGLE])          # (400, 2) in MATLAB
        file['log/name'] = np.frombuffer('arm'.encode('utf-16-le'), np.uint16)[:, None]
        file['log/name'].attrs['MATLAB_class'] = np.bytes_('char')
        file['log/no'] = np.zeros(2, np.uint64)
        file['log/no'].attrs['MATLAB_empty'] = np.uint8(1)
        file['#refs#/a'] = np.zeros(3)
        for name, link in others.items():
            file[name] = link
    with path.open('r+b') as head:
        head.write(b'MATLAB 7.3 MAT-file'.ljust(124) + b'\x00\x02IM')
    return path


def test_a_file_of_version_7_3_is_read(tmp_path):
    found = read_table(mat73(tmp_path / 'log.mat'))
    assert sorted(found) == ['log.q_1', 'log.q_2', 't']
    np.testing.assert_array_equal(found['log.q_2'], 2.0 * ANGLE)


def test_a_file_of_version_7_3_leads_nowhere_else(tmp_path):
    with h5py.File(tmp_path / 'secret.h5', 'w') as file:
        file['x'] = np.arange(400.0)
    found = read_table(mat73(tmp_path / 'log.mat', x=h5py.ExternalLink('secret.h5', '/x'),
                             loop=h5py.SoftLink('/')))
    assert sorted(found) == ['log.q_1', 'log.q_2', 't']


def test_a_damaged_file_of_version_7_3_is_one_line(tmp_path):
    whole = mat73(tmp_path / 'log.mat').read_bytes()
    random = np.random.default_rng(1)
    for number in range(12):
        broken = bytearray(whole[:random.integers(700, len(whole))] if number % 2 else whole)
        for place in random.integers(512, len(broken), 20):
            broken[place] = random.integers(256)
        path = tmp_path / f'{number}.mat'
        path.write_bytes(broken)
        try:
            read_table(path)
        except TableError as error:
            assert len(str(error).splitlines()) == 1
    assert os.listdir(tmp_path)
