"""A fleet over time: whose recordings they are, what changed, and what nobody diagnoses twice."""

from dataclasses import replace
import json
from pathlib import Path

from hda_msgs_json.bag import BagWriter
from hda_msgs_json.samples import JointSamples
from hda_msgs_json.topics import JOINT_STATES
from hda_torque_estimator.commands.fleet import date_of, execute
from hda_torque_estimator.commands.fleet_bags import bags_in, fleet_of, FleetError, search
from hda_torque_estimator.commands.fleet_table import alarms
from hda_torque_estimator.commands.outcome import Outcome
from hda_torque_estimator.fleet.fleet_report import fleet_document
from hda_torque_estimator.fleet.history import (
    devices, FIRST, GONE, GROWING, NEW, SHRINKING, STEADY, UNSEEN)
from hda_torque_estimator.fleet.lines import BagLine, line_from, line_of, NamedCause
from hda_torque_estimator.measurements.recording_checks import GateError
import numpy as np
import pytest
from test_fleet import asked

HEALTHY = BagLine('healthy', 'healthy', 'no_discrepancy', severity=1.0)


def line(number, *sizes, verdict='explained', device='arm'):
    """Return a line of one device with plays of these half-widths [rad]."""
    causes = tuple(NamedCause('backlash', f'joint{place}', 1.0, 'half_width', size, 0.9 * size,
                              1.1 * size, 'rad') for place, size in enumerate(sizes, 1))
    return BagLine(f'run{number}', f'run{number}', verdict, causes, device=device,
                   date=f'2026-01-{number:02d}T00:00:00+00:00',
                   severity=3.0 * max(sizes, default=1))


def trends(*lines):
    """Return the trends of the causes of one device."""
    device, = devices(lines)
    return [course.trend for course in device.courses()]


@pytest.mark.parametrize(('lines', 'expected'), [
    ([line(1, 1e-4)], [FIRST]),
    ([line(1, verdict='no_discrepancy'), line(2, 1e-4)], [NEW]),
    ([line(1, 1e-4), line(2, 1.05e-4)], [STEADY]),
    ([line(1, 1e-4), line(2, 2e-4)], [GROWING]),
    ([line(2, 1e-4), line(1, 2e-4)], [SHRINKING]),
    ([line(1, 1e-4), line(2, verdict='no_discrepancy')], [GONE]),
    ([line(1, 1e-4), line(2, verdict='insufficient_excitation')], [UNSEEN]),
    # Three that differ among themselves say how much any two do.
    ([line(1, 1e-4), line(2, 2e-4), line(3, 1.5e-4), line(4, 2.1e-4)], [STEADY]),
    ([line(1, 1e-4, 1e-4), line(2, 1e-4, 3e-4)], [STEADY, GROWING]),
])
def test_a_cause_is_held_against_the_history_of_its_device(lines, expected):
    assert trends(*lines) == expected


def test_the_most_severe_device_comes_first_and_healthy_ones_last():
    lines = [replace(HEALTHY, device='sound'), line(1, 1.0, device='bad'),
             line(1, 2.0, device='worse'),
             BagLine('x', 'x', None, error='it is empty', device='unread')]
    assert [device.name for device in devices(lines)] == ['worse', 'bad', 'unread', 'sound']
    report = fleet_document(lines, 'arm.yaml', '1')
    assert [device['device'] for device in report['devices']] == ['worse', 'bad', 'unread',
                                                                  'sound']
    assert [line_from(each) for each in report['bags']] == lines
    json.dumps(report, allow_nan=False)


def test_an_alarm_is_about_the_latest_recording():
    lines = [line(1, 2.0), replace(line(2, 1.0), severity=1.2)]
    assert alarms(lines, 2.0) == [] and alarms(lines, None) == []
    assert 'errs 6 times as much as noise in run3' in alarms([*lines, line(3, 2.0)], 2.0)[0]
    broken = BagLine('run3', 'run3', None, error='it is empty', device='arm', date='2026-02-01')
    assert alarms([*lines, broken], 2.0) == ['arm: run3 is not diagnosed: it is empty']


def test_a_size_is_the_number_by_which_an_effect_acts():
    number = {'value': 1e-4, 'low': 0.9e-4, 'high': 1.1e-4, 'unit': 'rad'}
    found = line_of('a', 'a', {
        'verdict': 'explained', 'seconds': 1.0, 'gain': {'before': 9.0, 'floor': 1.0},
        'findings': [{'effect': 'kinematic_error', 'joint': 'joint1', 'gain': {'removed': None},
                      'parameters': {'phase_1': number, 'amplitude_1': number}}]})
    assert (found.severity, found.findings[0].parameter) == (3.0, 'amplitude_1')


@pytest.fixture
def tree(tmp_path):
    """Return a folder of two devices, with other things in it."""
    for place in ('left/run1', 'left/run2', 'right/2026/run1'):
        (tmp_path / 'bags' / place).mkdir(parents=True)
        (tmp_path / 'bags' / place / 'metadata.yaml').write_text('no bag')
    (tmp_path / 'bags' / 'right' / 'notes' / 'more').mkdir(parents=True)
    (tmp_path / 'bags' / 'old.bag').touch()
    (tmp_path / 'bags' / '.hidden').mkdir()
    return tmp_path / 'bags'


def test_bags_are_found_at_any_depth_and_what_is_none_is_reported(tree):
    (tree / 'left' / 'back').symlink_to(tree)
    found = search(tree)
    assert [str(bag.relative_to(tree)) for bag in found.bags] == [
        'left/run1', 'left/run2', 'right/2026/run1']
    assert [words.partition(': ')[2].partition(';')[0] for words in found.skipped] == [
        'a bag of ROS 1', 'no recording in it']
    assert bags_in(tree) == found.bags


def test_the_first_folder_names_the_device(tree):
    bags, _ = fleet_of([tree], tree / 'out')
    assert [(bag.device, bag.directory) for bag in bags] == [
        ('left', 'left/run1'), ('left', 'left/run2'), ('right', 'right/2026/run1')]
    bags, _ = fleet_of([tree / 'left'], tree / 'out')
    assert {bag.device for bag in bags} == {'left'}
    bags, _ = fleet_of([tree / 'left' / 'run1'], tree / 'out')
    assert [(bag.device, bag.directory) for bag in bags] == [('left', 'run1')]


def test_two_bags_of_one_name_are_refused(tree):
    with pytest.raises(FleetError, match='would both be written to run1'):
        fleet_of([tree / 'left' / 'run1', tree / 'right' / '2026' / 'run1'], tree / 'out')


def counted(options):
    """Stand for a diagnosis that leaves a mark of every call."""
    with (options.bags[0] / 'calls').open('a') as marks:
        marks.write('x')
    if (options.bags[0] / 'broken').exists():
        raise GateError('it is broken')
    report = {'verdict': 'explained', 'seconds': 1.0, 'findings': [], 'gain': {}, 'arm':
              Path(options.arm).name}
    options.out.mkdir(parents=True, exist_ok=True)
    (options.out / 'report.json').write_text(json.dumps(report))
    return Outcome('', report)


def calls(tree):
    """Return how often each bag was diagnosed, and forget that it changed by it."""
    return [len((bag / 'calls').read_text()) if (bag / 'calls').exists() else 0
            for bag in bags_in(tree)]


def in_this_process(work, items, workers, *, failed, heard, needed):
    """Stand for processes."""
    for item in items:
        heard(work(item))


@pytest.fixture
def quick(monkeypatch):
    """Diagnose here, and hold a bag for unchanged by the marks of the test."""
    monkeypatch.setattr('hda_torque_estimator.commands.fleet.over_processes', in_this_process)
    monkeypatch.setattr(
        'hda_torque_estimator.commands.fleet.state_of', lambda bag, arm, options: str(
            [file.name for file in sorted(bag.iterdir()) if file.name != 'calls']) + arm)


def test_an_update_diagnoses_what_is_new_or_has_changed(tree, tmp_path, quick):
    out = tmp_path / 'out'
    first = execute(counted, asked(tree, out, update=True))
    assert calls(tree) == [1, 1, 1] and len(first.report['bags']) == 3
    (tree / 'left' / 'run2' / 'more').touch()
    (tree / 'right' / 'run9').mkdir()
    (tree / 'right' / 'run9' / 'metadata.yaml').touch()
    second = execute(counted, asked(tree, out, update=True))
    assert calls(tree) == [1, 2, 1, 1] and '2 diagnosed now' in second.text
    assert json.loads((out / 'fleet.json').read_text()) == second.report
    third = execute(counted, asked(tree, out, update=True))
    assert calls(tree) == [1, 2, 1, 1] and third.report == second.report
    for bag in (tree / 'left' / 'run1').iterdir():
        bag.unlink()
    (tree / 'left' / 'run1').rmdir()            # moved to an archive: its history stays
    assert execute(counted, asked(tree, out, update=True)).report['bags'] == third.report['bags']


def test_an_update_takes_no_folder_of_others(tree, tmp_path, quick):
    (tmp_path / 'thesis').mkdir()
    (tmp_path / 'thesis' / 'chapter1.tex').touch()
    with pytest.raises(ValueError, match='holds no fleet.json'):
        execute(counted, asked(tree, tmp_path / 'thesis', update=True))


def test_an_update_that_was_cut_off_goes_on(tree, tmp_path, quick, monkeypatch):
    monkeypatch.setattr('hda_torque_estimator.commands.fleet_out.EVERY', -1.0)

    def cut_off(options):
        if options.bags[0].name == 'run2':
            raise KeyboardInterrupt
        return counted(options)

    with pytest.raises(KeyboardInterrupt):
        execute(cut_off, asked(tree, tmp_path / 'out', update=True))
    execute(counted, asked(tree, tmp_path / 'out', update=True))
    assert calls(tree) == [1, 1, 1]


def test_every_device_has_its_arm(tree, tmp_path, quick):
    arms = tmp_path / 'arms'
    arms.mkdir()
    source = Path(__file__).parents[1] / 'config' / 'hda_arm.yaml'
    (arms / 'left.yaml').write_text(source.read_text())
    with pytest.raises(FleetError, match='no arm file for right: add right.yaml, or default.yaml'):
        execute(counted, asked(tree, tmp_path / 'out', arm=str(arms)))
    (arms / 'default.yaml').write_text(source.read_text())
    report = execute(counted, asked(tree, tmp_path / 'out', arm=str(arms))).report
    assert [Path(each['arm']).name for each in report['bags']] == [
        'left.yaml', 'left.yaml', 'default.yaml']


def test_an_alarm_is_an_exit_code(tree, tmp_path, quick):
    (tree / 'left' / 'run2' / 'broken').touch()
    report = execute(counted, asked(tree, tmp_path / 'out', alarm=2.0))
    assert report.code == 3 and report.report['alarms'] == [
        'left: left/run2 is not diagnosed: it is broken']
    assert execute(counted, asked(tree, tmp_path / 'more')).code == 0


@pytest.mark.parametrize(('stamp', 'date'), [
    (1_000_000_000, None), (1_767_225_600_000_000_000, '2026-01-01T00:00:00+00:00')])
def test_a_date_is_known_from_a_clock_that_was_set(stamp, date, tmp_path):
    angles = np.zeros((2, 1))
    with BagWriter(tmp_path / 'bag', {}) as bag:
        bag.write_joint_states(JOINT_STATES, JointSamples(
            np.array([stamp, stamp + 1]), ('joint1',), angles, angles, angles))
    assert date_of(tmp_path / 'bag') == date
    assert date_of(tmp_path / 'nothing') is None
