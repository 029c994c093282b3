"""`hda new` writes arms that every command reads, from facts with a source and nothing else."""

import io
import json
import logging

from command_line import complaint_of
from hda_arm_sim.model import files
from hda_arm_sim.model.files import arm_from_text, read_arm
from hda_arm_sim.model.gear_catalogue import gear, gear_names, GearError
from hda_arm_sim.model.gear_defaults import defaults_sentence
from hda_arm_sim.model.torsion import torsion_of_torque
from hda_arm_sim.model.writing import arm_to_text
from hda_torque_estimator.calibrate.fitting.arm_numbers import number, with_numbers
from hda_torque_estimator.cli import main
from hda_torque_estimator.commands.new_arm_text import yaml_number
from hda_torque_estimator.diagnosis.fitting.nuisance import nuisances
import numpy as np
import pytest
import yaml

MOTOR = ['--motor-inertia', '1.21e-4', '--motor-torque', '0.5', '--motor-counts', '16384',
         '--link-counts', '4e6']
RATED = ['--peak-torque', '50', '--motor-speed', '500']     # that no table of CSF was found for
LINKS = ['--lengths', '0.3', '0.25', '--masses', '4', '2']

DEFAULTS = ('structural_damping.coefficient', 'coulomb_friction.level', 'viscous_friction.slope',
            'torsional_hysteresis.width')

# Torsions at T1 and T2 that the manufacturer's tables print beside their stiffnesses [1e-4 rad].
PRINTED = {
    'CSF-14-30': (10.5, 31.0), 'CSF-17-30': (11.5, 30.0), 'CSF-20-30': (12.3, 38.0),
    'CSF-25-30': (14.0, 40.0), 'CSF-32-30': (12.1, 38.0),
    'CSG-14-50': (5.8, 16.0), 'CSG-14-100': (4.1, 12.0), 'CSG-17-50': (4.9, None),
    'CSG-20-50': (5.2, None), 'CSG-25-50': (5.5, None), 'CSG-32-50': (5.5, None),
    'CSG-40-50': (5.2, None)}


def made(tmp_path, capsys, *words, name='arm.yaml'):
    """Return the file that `hda new` writes, and its report."""
    out = tmp_path / name
    assert main(['new', *words, '--out', str(out), '--json']) == 0
    return out, json.loads(capsys.readouterr().out.splitlines()[-1])


def complaint(capsys, tmp_path, *words):
    """Return the one line of a mistake, which leaves nothing behind."""
    said = complaint_of(capsys, 'new', *words, '--out', str(tmp_path / 'arm.yaml'))
    assert list(tmp_path.iterdir()) == []
    return said


@pytest.mark.parametrize('name', PRINTED)
def test_stiffnesses_give_the_torsions_that_are_printed_beside_them(name):
    known = gear(name)
    first = known.knees[0] / known.stiffness[0]
    second = first + (known.knees[1] - known.knees[0]) / known.stiffness[1]
    for torsion, printed in zip((first, second), PRINTED[name]):
        assert printed is None or torsion == pytest.approx(1e-4 * printed, rel=0.04)


@pytest.mark.parametrize('name', gear_names())
def test_every_gear_stiffens_and_its_peak_is_beyond_its_knees(name):
    known = gear(name.lower())
    assert known.name == name
    assert 0.0 < known.stiffness[0] < known.stiffness[1] < known.stiffness[2]
    assert 0.0 < known.knees[0] < known.knees[1]
    if known.peak_torque is not None:
        assert known.peak_torque > known.knees[1]


@pytest.mark.parametrize('name', gear_names())
def test_every_gear_becomes_an_arm_that_states_all(name, tmp_path, capsys, caplog):
    files._say.cache_clear()
    caplog.set_level(logging.WARNING)
    path, report = made(tmp_path, capsys, '--gear', name, *MOTOR, *RATED)
    arm, known = read_arm(path), gear(name)
    joint, = arm.joints
    assert arm_from_text(arm_to_text(arm), 'again') == arm
    assert joint.motor_inertia == pytest.approx(1.21e-4 + (known.inertia or 0.0))
    end = known.knees[1]
    torsion = torsion_of_torque(joint.torsion.record(joint.ratio), joint.ratio, end)
    assert torsion == pytest.approx(known.knees[0] / known.stiffness[0] + (
        end - known.knees[0]) / known.stiffness[1], rel=1e-9)
    loop = arm.effect('torsional_hysteresis', 'joint1')
    assert 2.0 * loop.level / known.stiffness[0] == pytest.approx(known.hysteresis_loss)
    line, = caplog.messages
    assert line == f'{path}: class defaults stand for ' + ', '.join(
        f'{default} (joint1)' for default in DEFAULTS) + ', until hda calibrate'
    assert report['class_defaults'] == sorted(DEFAULTS)


def test_what_a_calibration_has_found_is_no_class_default_any_more(tmp_path, capsys):
    path, _ = made(tmp_path, capsys, '--gear', 'CSG-17-100', *MOTOR)
    arm = read_arm(path)
    assert defaults_sentence(dict(arm.provenance))
    found = [number(name, 1e-4, 1e-6) for name in DEFAULTS]
    calibrated = with_numbers(arm, 'joint1', found, 'a recording')
    assert defaults_sentence(dict(calibrated.provenance)) == ''


def test_every_number_has_a_comment(tmp_path, capsys):
    path, _ = made(tmp_path, capsys, '--gear', 'CSG-17-100', *MOTOR, *LINKS)
    head, _, rest = path.read_text().partition('\njoints:\n')
    assert all(line.startswith('#') for line in head.splitlines())
    assert 'catalogue' in head
    joints = rest.partition('\nlinks:')[0].splitlines()
    assert [line for line in joints if '#' not in line] == [
        '  - name: joint1', '    torsion:', '  - name: joint2', '    torsion:']


def test_uniform_rods_have_their_inertia(tmp_path, capsys):
    path, _ = made(tmp_path, capsys, '--gear', 'CSG-17-100', *MOTOR, *LINKS)
    links = read_arm(path).links
    points = [np.linspace(0.0, length, 20001) for length in (0.3, 0.25)]
    own = [mass * np.mean(place ** 2) for mass, place in zip((4.0, 2.0), points)]
    assert links.p2 == pytest.approx(own[1], rel=1e-3)
    assert links.p1 == pytest.approx(sum(own) + 2.0 * 0.3 ** 2, rel=1e-3)
    assert links.p3 == pytest.approx(2.0 * 0.3 * 0.125)
    assert (links.first, links.second) == (pytest.approx(4 * 0.15 + 2 * 0.3), pytest.approx(0.25))


def test_an_arm_is_simulated_and_estimated(tmp_path, capsys):
    path, _ = made(tmp_path, capsys, '--joints', 'shoulder', 'on', '--gear', 'CSG-20-100',
                   'CSG-14-80', *MOTOR, *LINKS, '--starting-torque', '0.05', '0.02')
    assert [joint.dry_friction for joint in read_arm(path).joints] == [0.05, 0.02]
    bag = tmp_path / 'run'
    assert main(['simulate', '--arm', str(path), '--motion', 'sine', '--duration', '2', '--out',
                 str(bag)]) == 0
    capsys.readouterr()
    assert main(['estimate', str(bag), '--arm', str(path), '--fusion', 'off', '--out',
                 str(tmp_path / 'out'), '--json']) == 0
    errors = json.loads(capsys.readouterr().out.splitlines()[-1])['errors']
    assert errors['truth/shoulder/torque']['rms'] < 0.2


def test_what_is_stated_counts_more_than_the_catalogue(tmp_path, capsys):
    path, report = made(
        tmp_path, capsys, '--gear', 'CSG-17-100', '--motor-inertia', '1e-4', '--torque-constant',
        '0.05', '--motor-current', '8', '--motor-counts', '0', '--link-counts', '0',
        '--hysteresis-loss', '0', *RATED, '--starting-torque', '0.037', '--viscous-friction',
        '6e-5')
    arm = read_arm(path)
    joint, = arm.joints
    assert (joint.torque_limit, joint.velocity_limit) == (pytest.approx(0.4), 500.0)
    assert (joint.torsion.valid_torque, joint.viscous_friction) == (50.0, 6e-5)
    assert arm.effects == ()
    assert arm.links is None
    assert report['class_defaults'] == ['structural_damping.coefficient']


def test_a_measured_current_is_stated_of_each_joint_or_of_all(tmp_path, capsys):
    path, _ = made(tmp_path, capsys, '--gear', 'CSG-17-100', *MOTOR, '--joints', 'a', 'b',
                   '--effort-lag', '0', '-0.5')
    assert [joint.effort_lag for joint in read_arm(path).joints] == [0.0, -0.5]
    path, _ = made(tmp_path, capsys, '--gear', 'CSG-17-100', *MOTOR, name='held.yaml')
    assert read_arm(path).joints[0].effort_lag == 0.5
    assert 'effort_lag' not in path.read_text()


@pytest.mark.parametrize(('words', 'says'), [
    ([], 'needs --gear, --motor-torque [N*m], --motor-counts [1/turn], --link-counts'),
    (['--gear', 'CSG-17-100', '--motor-inertia', '1e-4'], 'needs --motor-torque [N*m], '),
    (['--gear', 'SHD-17-100', *MOTOR], 'its series are CSF, CSG'),
    (['--gear', '', *MOTOR], 'its series are CSF, CSG'),
    (['--gear', 'CSG-17-100\n', '--joints', 'a\nb', *MOTOR], 'must be a name like joint1'),
    (['--gear', 'CSG-18-100', *MOTOR], 'sizes 14, 17, 20'),
    (['--gear', 'CSG', *MOTOR], 'sizes 14, 17, 20'),
    (['--gear', 'CSG-17-30', *MOTOR], 'ratios 50, 80, 100, 120'),
    (['--gear', 'CSG-17-99999999999999999999', *MOTOR], 'ratios 50'),
    (['--gear', 'CSF-17-100', *MOTOR], '--motor-speed'),
    (['--gear', 'CSF-17-100', *MOTOR, '--motor-speed', '500'], '--peak-torque'),
    (['--gear', *['CSG-17-100'] * 3, '--joints', 'a', 'b', *MOTOR], 'all joints or 2, got 3'),
    (['--gear', 'CSG-17-100', '--joints', 'a', 'a', *MOTOR], 'must differ'),
    (['--gear', 'CSG-17-100', *MOTOR, '--viscous-friction', 'nan'], 'a number >= 0'),
    (['--gear', 'CSG-17-100', *MOTOR, '--viscous-friction', '1e300'], 'must lie in [0, 1]'),
    (['--gear', 'CSG-17-100', *MOTOR, '--effort-lag', '2'], 'a number from -1 to 1, got'),
    (['--gear', 'CSG-17-100', *MOTOR, '--torque-constant', '1'], 'together'),
    (['--gear', 'CSG-17-100', *MOTOR, '--torque-constant', '1', '--motor-current', '1'], 'twice'),
    (['--gear', 'CSG-17-100', *MOTOR, '--lengths', '1'], 'for each link, got 1 and 0'),
    (['--gear', 'CSG-17-100', *MOTOR, '--lengths', '1', '--masses', '0'], 'above 0'),
    (['--gear', 'CSG-17-100', *MOTOR, '--lengths', *'111', '--masses', *'111'], 'one or two'),
])
def test_a_mistake_is_one_line(words, says, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr('sys.stdin', io.StringIO('CSG-17-100\n'))
    assert says in complaint(capsys, tmp_path, *words)


def test_a_file_that_exists_is_kept_unless_forced(tmp_path, capsys):
    words = ['--gear', 'CSG-17-100', *MOTOR]
    path, _ = made(tmp_path, capsys, *words)
    path.write_text('mine')
    assert main(['new', *words, '--out', str(path)]) == 2
    assert 'exists' in capsys.readouterr().err
    assert path.read_text() == 'mine'
    made(tmp_path, capsys, *words, '--force')
    assert read_arm(path).labels == ('joint1',)


class Terminal(io.StringIO):
    """Somebody who types."""

    def isatty(self):
        """Say that there is a terminal."""
        return True


def test_a_terminal_is_asked_for_what_is_missing(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr('sys.stdin', Terminal(
        'nonsense\n\nCSG-17-100 csg-14-80\n1e-4, 2e-5\nmuch\n0.5\n16384\n4e6\n'))
    path, report = made(tmp_path, capsys)
    assert report['gears'] == {'joint1': 'CSG-17-100', 'joint2': 'CSG-14-80'}
    assert read_arm(path).joints[1].motor_inertia == pytest.approx(2e-5 + 3.3e-6)


def test_an_inertia_that_nobody_knows_is_that_of_an_actuator_of_the_size(tmp_path, capsys, caplog):
    """It is a class default that every command names, and known to a half only."""
    files._say.cache_clear()
    caplog.set_level(logging.WARNING)
    path, report = made(tmp_path, capsys, '--gear', 'CSG-25-100', 'CSG-17-100', *MOTOR[2:])
    arm = read_arm(path)
    assert [joint.motor_inertia for joint in arm.joints] == pytest.approx([3.4e-4, 7.0e-5])
    assert {arm.tolerances_of(label).motor_inertia for label in arm.labels} == {0.5}
    assert 'motor_inertia_error.error' in report['class_defaults']
    assert any('motor_inertia_error.error (joint1, joint2)' in line for line in caplog.messages)
    assert [term.joint for term in nuisances(arm) if term.name == 'motor_inertia_error'] == [
        *arm.labels]
    stated = read_arm('hda_arm.yaml')
    assert [term for term in nuisances(stated) if term.name == 'motor_inertia_error'] == []


@pytest.mark.parametrize(('size', 'least', 'most'), [(14, 2e-5, 4e-5), (20, 8.9e-5, 1.6e-4)])
def test_other_sizes_lie_between_actuators(size, least, most):
    """An SHA20A has 8.9e-5 kg*m^2 at its motor: 0.91 at its output, ratio 101."""
    assert least < gear(f'CSG-{size}-100').usual_inertia < most


def test_an_empty_line_leaves_an_inertia_to_its_class(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr('sys.stdin', Terminal('CSG-17-100\n\n0.5\n16384\n4e6\n'))
    path, _ = made(tmp_path, capsys)
    assert read_arm(path).joints[0].motor_inertia == pytest.approx(7.0e-5)


def test_a_gear_that_no_catalogue_has_is_refused_before_anything_is_asked(
        tmp_path, capsys, monkeypatch):
    monkeypatch.setattr('sys.stdin', Terminal(''))
    assert main(['new', '--gear', 'CSG-17-101', '--out', str(tmp_path / 'arm.yaml')]) == 2
    assert 'CSG-17 is made with ratios' in capsys.readouterr().err


def test_a_question_ends_with_the_option_and_its_unit(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr('sys.stdin', Terminal('CSG-17-100\n\n0.5\n16384\n4e6\n'))
    assert main(['new', '--out', str(tmp_path / 'arm.yaml')]) == 0
    assert '\n  --motor-torque [N*m]: ' in capsys.readouterr().err


def test_somebody_who_leaves_gets_one_line(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr('sys.stdin', Terminal('CSG-17-100\n'))
    assert main(['new', '--out', str(tmp_path / 'arm.yaml')]) == 2
    assert capsys.readouterr().err.endswith('hda new: no answer for --motor-inertia\n')
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize('value', [1e-5, 1e-10, 1.0, 4e6, 1e10, 0.1, 2.5e-7])
def test_numbers_are_numbers_to_yaml(value):
    assert yaml.safe_load(yaml_number(value)) == value


def test_a_name_of_no_gear_raises():
    with pytest.raises(GearError, match='no gear'):
        gear('-')


def test_a_weak_motor_has_tolerances_of_its_own(tmp_path, capsys):
    """A fiftieth of the strongest motor's torque would be most of what a wrist can give."""
    path = tmp_path / 'arm.yaml'
    assert main(['new', '--gear', 'CSG-32-100', 'CSG-14-100', '--motor-inertia', '1e-4',
                 '--motor-torque', '3', '0.2', '--motor-counts', '0', '--link-counts', '0',
                 '--out', str(path)]) == 0
    arm = read_arm(path)
    for label, largest in (('joint1', 3.0), ('joint2', 0.2)):
        known = arm.tolerances_of(label)
        assert known.torque_ripple == known.drive_offset == pytest.approx(0.02 * largest)
        assert known.stiffness == arm.tolerances.stiffness
