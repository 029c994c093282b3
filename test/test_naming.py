"""Bags of others in every command: their topics, their names, both sides apart, host stamps."""

from dataclasses import replace
import json

from hda_msgs_json.bag import BagWriter, open_recording
from hda_msgs_json.samples import JointSamples
from hda_msgs_json.topics import JOINT_STATES, JOINT_TORQUES
from hda_torque_estimator.cli import main
from hda_torque_estimator.measurements.even_stamps import evened
from hda_torque_estimator.measurements.renamed_recording import (
    Naming, naming_of, NamingError, open_named)
import numpy as np
import pytest

ARM = ['--arm', 'hda_arm.yaml']
SIDES = ['--link-topic', '/left/load', '--motor-topic', '/left/drive']
NAMES = ['--name', 'q*=joint*', '--name', 'drive_*_motor=joint*_motor']


def topic(name):
    """Return a topic of joint states with another name."""
    return replace(JOINT_STATES, name=name)


@pytest.fixture(scope='module')
def ours(tmp_path_factory):
    """Return a bag as this package writes it."""
    path = tmp_path_factory.mktemp('ours') / 'bag'
    assert main(['simulate', *ARM, '--motion', 'rich', '--duration', '14', '--seed', '3',
                 '--out', str(path)]) == 0
    return path


@pytest.fixture(scope='module')
def theirs(ours):
    """Return the same as a driver might have recorded it: two topics, their names, own stamps."""
    samples = open_recording(ours).joint_states()
    link, motor = samples.select(['joint1', 'joint2']), samples.select(
        ['joint1_motor', 'joint2_motor'])
    with BagWriter(ours.with_name('theirs'), {}) as bag:
        bag.write_joint_states(topic('left/load'), replace(link, names=('q1', 'q2')))
        bag.write_joint_states(topic('left/drive'), replace(
            motor, names=('drive_1', 'drive_2'), stamps=motor.stamps + 200_000).rows(
                np.flatnonzero(np.arange(len(motor)) != 4000)))
    return ours.with_name('theirs')


def naming(*names, **others):
    """Return a naming of names as they are typed."""
    return replace(naming_of(None, (None, None), names, even=False), **others)


def test_two_topics_are_paired_by_stamp(ours, theirs):
    found = open_named(theirs, naming(
        'q*=joint*', 'drive_*_motor=joint*_motor', link_topic='left/load',
        motor_topic='/left/drive')).joint_states()
    expected = open_recording(ours).joint_states()
    rows = np.flatnonzero(np.arange(len(expected)) != 4000)     # its motor sample never came
    assert found.names == ('joint1', 'joint2', 'joint1_motor', 'joint2_motor')
    np.testing.assert_array_equal(found.stamps, expected.stamps[rows])
    np.testing.assert_array_equal(found.position, expected.select(found.names).position[rows])
    np.testing.assert_array_equal(found.effort[:, 2:], expected.select(
        found.names[2:]).effort[rows])


def test_the_name_with_most_letters_of_its_own_counts():
    names = 'q*=joint*', 'q*_drive=joint*_motor', 'q1=elbow'
    seen = JointSamples(np.zeros(0, np.int64), ('q1', 'q2', 'q1_drive', 'other'),
                        *[np.zeros((0, 4))] * 3)
    for order in (names, names[::-1]):
        assert naming(*order).named(seen).names == ('elbow', 'joint2', 'joint1_motor', 'other')


@pytest.mark.parametrize('command', ['estimate', 'diagnose', 'calibrate', 'info', 'compare'])
def test_every_command_reads_them(command, theirs, tmp_path, capsys):
    words = {'compare': [str(theirs), str(theirs)], 'info': [str(theirs)]}.get(
        command, [str(theirs), *ARM])
    out = [] if command == 'info' else ['--out', str(tmp_path / 'out.yaml')]
    assert main([command, *words, *SIDES, *NAMES, *out, '--json']) == 0, capsys.readouterr().err
    output = capsys.readouterr().out
    assert 'joint1' in output and 'drive_1' not in output


def test_estimates_are_those_of_the_same_numbers(ours, theirs, tmp_path, capsys):
    for bag, words in ((ours, []), (theirs, [*SIDES, *NAMES])):
        assert main(['estimate', str(bag), *ARM, *words, '--default-settings', '--out',
                     str(tmp_path / bag.name)]) == 0
    one, two = (open_recording(tmp_path / bag.name).joint_states(JOINT_TORQUES.name).effort
                for bag in (ours, theirs))
    np.testing.assert_array_equal(one[:3000], two[:3000])       # before the one that never came


@pytest.mark.parametrize(('words', 'says'), [
    (['--link-topic', 'a'], 'given together'),
    (['--topic', 'c', *SIDES], '--topic has both sides'),
    (['--name', 'q1'], '--name needs THEIRS=OURS'),
    (['--name', 'q=joint*'], '--name needs THEIRS=OURS'),
    (['--topic', '/left/lod'], 'no topic /left/lod'),
    ([*SIDES, '--name', 'q1=joint1', '--name', 'q2=joint1'], 'two names become joint1'),
    ([*SIDES, '--name', 'q1=joint1'], 'drive_1_motor'),
])
def test_a_naming_that_does_not_fit_is_one_line(words, says, theirs, tmp_path, capsys):
    assert main(['estimate', str(theirs), *ARM, *words, '--out', str(tmp_path / 'out')]) == 2
    output = capsys.readouterr().err
    assert says in output and len(output.splitlines()) == 1
    assert list(tmp_path.iterdir()) == []


def test_a_namespace_is_chosen_by_its_topic(tmp_path):
    angles = np.zeros((3, 1))
    with BagWriter(tmp_path / 'bag', {}) as bag:
        for side, first in (('left', 1), ('right', 11)):
            bag.write_joint_states(topic(f'{side}/joint_states'), JointSamples(
                first + np.arange(3), (side,), angles, angles, angles))
    assert open_named(tmp_path / 'bag', Naming(topic='right/joint_states')
                      ).joint_states().names == ('right',)


def test_no_words_are_no_naming(ours):
    assert naming_of(None, (None, None), [], even=False) == Naming()
    with pytest.raises(NamingError, match='needs THEIRS=OURS'):
        naming('a*b*=c*')


def host_stamps(count, period, *, seed, lost=(), burst=1, jitter=0.0):
    """Return even stamps [ns] and those of a host that gets them late, in bursts."""
    random = np.random.default_rng(seed)
    kept = np.setdiff1d(np.arange(count), lost)
    true = 10**9 + np.rint(kept * period).astype(np.int64)
    late = true[np.minimum((np.arange(len(kept)) // burst + 1) * burst, len(kept)) - 1]
    late = late + np.rint(random.exponential(jitter * period, len(kept))).astype(np.int64)
    return true, np.maximum.accumulate(late)


@pytest.mark.parametrize(('burst', 'jitter', 'lost'), [
    (1, 0.3, ()), (1, 0.3, (500,)), (1, 0.1, (200, 201, 202, 900)), (8, 0.0, ()), (8, 0.2, ())])
def test_stamps_of_a_host_become_even(burst, jitter, lost):
    true, host = host_stamps(2000, 10e6, seed=1, lost=lost, burst=burst, jitter=jitter)
    found = evened(host)
    late = float(np.mean(host - true))
    assert np.abs(found - true - late).max() < 0.05 * 10e6 * max(1.0, burst * 0.5)
    assert np.abs(np.diff(found) - np.diff(true)).max() < 0.01 * 10e6


def test_even_stamps_and_those_that_go_back_stay():
    even = 10**9 + 1_000_000 * np.arange(100)
    np.testing.assert_array_equal(evened(even), even)
    back = np.array([5, 3, 9])
    np.testing.assert_array_equal(evened(back), back)


def test_a_command_evens_stamps(ours, tmp_path, capsys):
    samples = open_recording(ours).joint_states()
    _, host = host_stamps(len(samples), 1e6, seed=2, jitter=0.4)
    with BagWriter(tmp_path / 'host', {}) as bag:
        bag.write_joint_states(JOINT_STATES, replace(samples, stamps=host))
    assert main(['info', str(tmp_path / 'host'), '--even-stamps', '--json']) == 0
    report = json.loads(capsys.readouterr().out)['joint_states']
    assert report['gaps'] == report['not_later'] == 0 and abs(report['rate'] - 1000.0) < 1e-2
