"""Recordings with one encoder: friction and lines are found where they are, and nothing else."""

from dataclasses import replace
import json
from pathlib import Path

from hda_arm_sim.model.files import read_arm
from hda_msgs_json.bag import BagWriter
from hda_msgs_json.samples import JointSamples
from hda_msgs_json.topics import JOINT_STATES
from hda_torque_estimator.cli import main
from hda_torque_estimator.diagnosis.motors_alone.motor_fit import explained, gain_without, MOST
from hda_torque_estimator.diagnosis.motors_alone.motor_record import is_motor_side, sweeps_of
from hda_torque_estimator.diagnosis.motors_alone.motor_side import diagnose_motors
from hda_torque_estimator.importing.run import run_import
from hda_torque_estimator.measurements.recording_checks import GateError
import numpy as np
import pytest

ARM = read_arm('kinova_gen3.yaml')
KINOVA = Path(__file__).parents[2] / 'shared' / 'data' / 'kinova_gen3_jointwise'
RATIO, LEVEL, SLOPE = 100.0, 0.05, 4e-4


def turned(both_ways, lines=(), duration=12.0, seed=1, noise=2e-3):
    """Return a recording of one motor under a load, with friction and cogging (size, order)."""
    time = 1e-3 * np.arange(round(duration * 1e3))
    speed = 40.0 * np.sin(2.0 * np.pi * time / 6.0) if both_ways else 40.0 * np.minimum(
        1.0, np.minimum(time, time[-1] - time) / 0.3)
    angle = np.cumsum(speed) * 1e-3
    link = angle / RATIO
    torque = (1.3e-4 * np.gradient(speed, 1e-3) + 0.03 * np.cos(link) - 0.06 * np.sin(link)
              + LEVEL * np.sign(speed) + SLOPE * speed)
    for size, order in lines:
        torque -= size * np.sin(order * angle + 0.7)
    torque += noise * np.random.default_rng(seed).standard_normal(len(time))
    return recorded(angle, torque)


def recorded(angle, torque, names=('joint3_motor',)):
    """Return joint states of one motor."""
    absent = np.full((len(angle), 1), np.nan)
    return JointSamples(1 + 1_000_000 * np.arange(len(angle)), names, angle[:, None], absent,
                        torque[:, None])


def diagnosed(samples):
    """Return the conclusion on a recording."""
    return diagnose_motors(sweeps_of(samples, ARM, 'bag'), ARM)


def test_friction_and_lines_are_found_with_their_sizes():
    found = diagnosed(turned(True, ((4e-3, 12.0), (2e-3, 24.0))))
    reported = {(cause.effect,
                 round(cause.parameters['order'].value) if 'order' in cause.parameters
                 else None): cause for cause in found.diagnosis.findings}
    assert set(reported) == {('coulomb_friction', None), ('viscous_friction', None),
                             ('motor_cogging', 12), ('motor_cogging', 24)}
    assert found.diagnosis.verdict == 'explained'
    level = reported['coulomb_friction', None].parameters['level']
    assert level.value == pytest.approx(LEVEL, rel=0.03)
    wave = reported['motor_cogging', 12].parameters
    assert wave['amplitude'].value == pytest.approx(4e-3, rel=0.05)
    assert wave['phase'].value == pytest.approx(0.7, abs=0.05)
    assert all(cause.gain.low > 0.0 for cause in found.diagnosis.findings)


@pytest.mark.parametrize(('lag', 'off'), [(0.5, 0.0), (0.0, 12.0 * 40.0 * 0.5e-3)])
def test_a_held_command_acts_half_a_sample_later(lag, off):
    """Half a sample at 40 rad/s is a quarter of a radian of twelve waves per turn."""
    samples = turned(False, ((4e-3, 12.0),), noise=1e-4)
    effort = samples.effort[:, 0]
    later = np.append(0.5 * (effort[1:] + effort[:-1]), effort[-1])
    held = recorded(samples.position[:, 0], later)
    arm = replace(ARM, joints=tuple(replace(joint, effort_lag=lag) for joint in ARM.joints))
    found = diagnose_motors(sweeps_of(held, arm, 'bag'), arm).diagnosis
    wave, = (cause.parameters for cause in found.findings if cause.effect == 'motor_cogging')
    assert abs(wave['phase'].value - 0.7) == pytest.approx(off, abs=0.02)


def test_what_explains_a_torque_gains_line_by_line():
    lines = [(4e-3 / order, float(order)) for order in range(1, MOST + 3)]
    sweep, = sweeps_of(turned(True, lines, noise=1e-4), ARM, 'bag')
    part = explained(sweep, ARM)
    assert 1 < len(part.lines) <= MOST
    first = part.columns.shape[1] - 2 * len(part.lines)
    assert all(gain_without(part, [first + 2 * k, first + 2 * k + 1]).removed() > 0.0
               for k in range(len(part.lines)))


def test_the_extended_arm_has_friction_and_the_strongest_line():
    extended = diagnosed(turned(True, ((4e-3, 12.0), (2e-3, 24.0)))).extended
    assert extended.effect('coulomb_friction', 'joint3').level == pytest.approx(LEVEL, rel=0.03)
    assert extended.effect('viscous_friction', 'joint3').slope == pytest.approx(SLOPE, rel=0.05)
    assert extended.effect('motor_cogging', 'joint3').order == 12.0


@pytest.mark.parametrize('seed', range(8))
def test_a_torque_without_lines_shows_none(seed):
    slow = np.cumsum(np.random.default_rng(seed).standard_normal(12000)) * 2e-4
    samples = turned(False, seed=seed)
    found = diagnosed(recorded(samples.position[:, 0], samples.effort[:, 0] + slow))
    assert found.diagnosis.findings == ()


def test_friction_of_a_sweep_one_way_is_ambiguous():
    found = diagnosed(turned(False)).diagnosis
    assert found.verdict == 'ambiguous'
    assert found.ambiguous[0].effects == (('coulomb_friction', 'joint3'),
                                          ('drive_offset', 'joint3'))
    resists = f'{LEVEL + 40.0 * SLOPE:.2g} N*m at the shaft'
    assert any('one way' in remark for remark in found.remarks), resists


def test_what_one_encoder_cannot_see_is_said():
    found = diagnosed(turned(True)).diagnosis
    unseen = {row.effect for row in found.excitation}
    assert {'stiffness_error', 'clock_skew', 'kinematic_error'} <= unseen
    assert not {'coulomb_friction', 'motor_cogging'} & unseen
    assert all(row.smallest_detectable is None for row in found.excitation)
    assert 'One encoder' in found.remarks[0]


def test_a_motor_held_still_shows_nothing():
    still = recorded(np.zeros(5000), np.full(5000, 0.1))
    assert is_motor_side(still, ARM)
    assert diagnosed(still).diagnosis.verdict == 'insufficient_excitation'


def test_unusable_motors_are_refused():
    samples = turned(True)
    with pytest.raises(GateError, match='no motor torque of joint3'):
        sweeps_of(recorded(samples.position[:, 0], np.full(12000, np.nan)), ARM, 'bag')
    with pytest.raises(GateError, match='too short'):
        sweeps_of(turned(False, duration=1.0), ARM, 'bag')


def test_a_bag_of_motors_makes_a_report(tmp_path, capsys):
    with BagWriter(tmp_path / 'bag', {}) as bag:
        bag.write_joint_states(JOINT_STATES, turned(True, ((4e-3, 12.0),)))
    out = tmp_path / 'out'
    assert main(['diagnose', str(tmp_path / 'bag'), '--arm', 'kinova_gen3.yaml', '--out', str(out),
                 '--json']) == 0
    report = json.loads(capsys.readouterr().out)
    assert report == json.loads((out / 'report.json').read_text())
    assert report['verdict'] == 'explained'
    assert '<svg' in (out / 'report.html').read_text()
    assert read_arm(out / 'model.yaml').effect('motor_cogging', 'joint3').order == 12.0


def test_other_conventions_are_mended(tmp_path, capsys):
    """Degrees, the other sign and an angle at the link, as the options say, give the same."""
    plain = turned(True, ((4e-3, 12.0),))
    ratio = next(joint.ratio for joint in ARM.joints if joint.label == 'joint3')
    written = {'plain': plain, 'other': replace(
        plain, position=-np.degrees(plain.position) / ratio, effort=-plain.effort)}
    options = {'plain': [], 'other': ['--degrees', '--motor-at-link', '--flip', 'joint3_motor']}
    report = []
    for name, samples in written.items():
        with BagWriter(tmp_path / name, {}) as bag:
            bag.write_joint_states(JOINT_STATES, samples)
        assert main(['diagnose', str(tmp_path / name), '--arm', 'kinova_gen3.yaml', '--out',
                     str(tmp_path / f'{name}_out'), '--json', *options[name]]) == 0
        report.append(json.loads(capsys.readouterr().out))
    for first, second in zip(*(one['findings'] for one in report), strict=True):
        assert (first['effect'], first['joint']) == (second['effect'], second['joint'])
        for name, number in first['parameters'].items():
            assert number['value'] == pytest.approx(second['parameters'][name]['value'], rel=1e-6)


def test_a_name_to_flip_that_is_not_there_is_one_line(tmp_path, capsys):
    with BagWriter(tmp_path / 'bag', {}) as bag:
        bag.write_joint_states(JOINT_STATES, turned(True))
    assert main(['diagnose', str(tmp_path / 'bag'), '--arm', 'kinova_gen3.yaml', '--out',
                 str(tmp_path / 'out'), '--flip', 'joint3']) == 2
    assert capsys.readouterr().err == (
        f'hda diagnose: {tmp_path / "bag"}: --flip joint3 names nothing here; it names '
        'joint3_motor\n')
    assert not (tmp_path / 'out').exists()


def resting(samples, rest=60.0):
    """Return a recording in which the same motion is followed by a long rest."""
    still = round(rest * 1e3)
    return recorded(np.append(samples.position[:, 0], np.full(still, samples.position[-1, 0])),
                    np.append(samples.effort[:, 0], np.full(still, 0.01)))


def test_a_joint_that_moves_in_a_small_part_is_diagnosed_from_that(tmp_path):
    """All stretches have as much of its motion: none that is held out is empty."""
    with BagWriter(tmp_path / 'bag', {}) as bag:
        bag.write_joint_states(JOINT_STATES, resting(turned(True, duration=12.0)))
    out = tmp_path / 'out'
    assert main(['diagnose', str(tmp_path / 'bag'), '--arm', 'kinova_gen3.yaml', '--out',
                 str(out)]) == 0
    report = json.loads((out / 'report.json').read_text())
    assert {cause['effect'] for cause in report['findings']} == {'coulomb_friction',
                                                                 'viscous_friction'}


def test_a_joint_that_hardly_moves_shows_nothing():
    samples = turned(False, duration=12.0)
    angle = np.minimum(samples.position[:, 0], 2.5)
    assert diagnosed(recorded(angle, samples.effort[:, 0])).diagnosis.verdict == (
        'insufficient_excitation')


def test_what_loses_on_held_out_stretches_is_not_named():
    sweep, = sweeps_of(turned(True, ((4e-3, 12.0),)), ARM, 'bag')
    turned_over = np.where(sweep.held_out, -2.0 * sweep.torque, sweep.torque)
    found = diagnose_motors([sweep._replace(torque=turned_over)], ARM)
    assert found.diagnosis.findings == ()
    assert found.extended == ARM


def test_the_same_sweep_back_in_another_recording_decides(tmp_path, capsys):
    """Several bags of motors are one diagnosis; rates of two days differ by a little."""
    there = turned(False)
    back = recorded(there.position[::-1, 0].copy(), there.effort[:, 0] * -1.0 + 0.06 * np.cos(
        there.position[:, 0] / RATIO) - 0.12 * np.sin(there.position[:, 0] / RATIO))
    back = replace(back, effort=back.effort[:], stamps=np.rint(
        back.stamps * (99.061 / 98.935)).astype(np.int64))
    bags = []
    for name, samples in (('there', there), ('back', back)):
        with BagWriter(tmp_path / name, {}) as bag:
            bag.write_joint_states(JOINT_STATES, samples)
        bags.append(str(tmp_path / name))
    assert main(['diagnose', *bags, '--arm', 'kinova_gen3.yaml', '--out', str(tmp_path / 'out'),
                 '--json']) == 0
    report = json.loads(capsys.readouterr().out)
    assert report['ambiguous'] == []
    assert [part['bag'] for part in report['recording']['bags']] == bags
    assert report['recording']['duration'] == pytest.approx(24.0, rel=0.01)


def test_a_sweep_one_way_shows_how_large_each_would_be(tmp_path):
    with BagWriter(tmp_path / 'bag', {}) as bag:
        bag.write_joint_states(JOINT_STATES, turned(False))
    out = tmp_path / 'out'
    assert main(['diagnose', str(tmp_path / 'bag'), '--arm', 'kinova_gen3.yaml', '--out',
                 str(out)]) == 0
    pair, = json.loads((out / 'report.json').read_text())['ambiguous']
    friction, offset = pair['candidates']
    assert not friction['in_model'] and not offset['in_model']
    assert offset['parameters']['offset']['value'] == -friction['parameters']['level']['value']
    first, *_ = (out / 'model.yaml').read_text().splitlines()
    assert first == '# holds none of these'


# Joint of the sweep, and waves per output turn that its motor torque must show.
LINES = {1: {2400}, 4: {100, 2400}, 5: {1200, 1400, 2800}, 6: {1200, 1400, 2400, 2800},
         7: {700, 1200, 2800}}


@pytest.mark.parametrize('joint', LINES)
def test_the_lines_of_a_real_arm_are_found(joint, tmp_path):
    table = KINOVA / f'joint_{joint}_trapez.csv.gz'
    if not table.exists():
        pytest.skip('the public recordings are not here')
    bag, = run_import(table, Path('kinova_gen3.yaml'), tmp_path / 'bag')
    assert main(['diagnose', str(bag), '--arm', 'kinova_gen3.yaml', '--out',
                 str(tmp_path / 'out')]) == 0
    report = json.loads((tmp_path / 'out' / 'report.json').read_text())
    orders = {round(RATIO * cause['parameters']['order']['value']) for cause in report['findings']}
    assert LINES[joint] <= orders
    assert {cause['joint'] for cause in report['findings']} == {f'joint{joint}'}
