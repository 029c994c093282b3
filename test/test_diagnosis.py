"""
Hide an effect in data and require its name, joint and size; hide nothing and require silence.

The hidden truth is `truth/`: other formulas, another integrator and step, its own scatter.
"""

from dataclasses import replace
import gc
import json
import warnings

from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import motion
from hda_msgs_json.bag import BagWriter
from hda_msgs_json.samples import JointSamples
from hda_msgs_json.topics import JOINT_STATES
from hda_torque_estimator.cli import main
from hda_torque_estimator.diagnosis.balances.balance import Balancer
from hda_torque_estimator.diagnosis.diagnose import diagnose
from hda_torque_estimator.diagnosis.fitting.derivatives import Derivatives
from hda_torque_estimator.diagnosis.showing import HORIZONS
from hda_torque_estimator.measurements.measurement import Measurement
from hda_torque_estimator.measurements.sample_grid import measurement_from
from hda_torque_estimator.simulating.closed_loop import run
import numpy as np
import pytest
from truth import draw, record, Reference
from truth_samples import published

ARM = read_arm('hda_arm.yaml')
NAMES = ('joint1', 'joint2', 'joint1_motor', 'joint2_motor')


@pytest.fixture
def undisturbed():
    """Collect nothing while a test runs."""
    gc.collect()
    gc.disable()
    yield
    gc.enable()


def kept():
    """Return by identity what holds the most memory of a diagnosis; other tests keep theirs."""
    return {id(one): one for one in gc.get_objects() if isinstance(one, (Balancer, Derivatives))}


def recorded(hidden, seed, name='rich', duration=60.0, noise=1.0):
    """Return what a driver would record of an arm with hidden effects."""
    asked = motion(name, 2, duration, 1e-3, seed)
    return record(hidden, Reference(asked.angle, asked.rate, 1e-3), seed=seed, noise=noise)


def diagnosed(made):
    """Return the diagnosis of a record."""
    reading = np.stack([made.motor_angle, made.link_angle], axis=2)
    return diagnose(Measurement(ARM.labels, 1e-3, reading, made.command), ARM).diagnosis


def named(diagnosis):
    """Return what a diagnosis names: effects and joints."""
    return [(found.effect, found.joint) for found in diagnosis.findings]


@pytest.mark.parametrize(('seed', 'noise'), [
    (900, 1.0), pytest.param(901, 2.0, marks=pytest.mark.study)])
def test_nothing_hidden_nothing_found(seed, noise):
    found = diagnosed(recorded([], seed, noise=noise))
    assert found.verdict == 'no_discrepancy'
    assert named(found) == []


def test_a_diagnosis_leaves_nothing_behind(undisturbed):
    """What only a collection frees piles up: forty records held 8 GB."""
    before = kept()
    diagnosed(recorded([draw('coulomb_friction', np.random.default_rng(3))], 903, duration=12.0))
    assert set(kept()) <= set(before)


def test_a_link_that_is_slammed_is_healthy_still():
    """At the limit of its torque this arm turns round within samples, at 80 N*m."""
    made = published(ARM, [], 121702)
    assert diagnose(measurement_from(ARM.labels, made), ARM).diagnosis.verdict == 'no_discrepancy'


@pytest.mark.study
def test_what_is_certain_but_less_than_noise_is_not_named():
    """In a slow sine a friction that gives way by a count reads like a delay of the command."""
    hidden = draw('torque_saturation', np.random.default_rng([151503, 1]))
    made = published(ARM, [hidden], 151503, name='slow_sine')
    assert named(diagnose(measurement_from(ARM.labels, made), ARM).diagnosis) == []


@pytest.mark.study
def test_noise_that_a_delay_explains_is_no_delay():
    """A loop answers the noise of its encoders, which looks like a delay above 10 Hz."""
    made = published(ARM, [], 4398, name='slow_sine')
    found = diagnose(measurement_from(ARM.labels, made), ARM).diagnosis
    assert (found.verdict, named(found)) == ('no_discrepancy', [])


@pytest.mark.study
@pytest.mark.parametrize(('name', 'seed'), [
    ('command_delay', 4303), ('current_loop_lag', 4301)])
def test_a_slow_motion_cannot_distinguish_a_lag_from_a_delay(name, seed):
    """The command repeats the noise of the encoders; what it moves more than that decides."""
    hidden = draw(name, np.random.default_rng([seed, 1]))
    made = published(ARM, [hidden], seed, name='slow_sine')
    found = diagnose(measurement_from(ARM.labels, made), ARM).diagnosis
    assert (found.verdict, named(found)) == ('ambiguous', [])
    pair, = found.ambiguous
    assert set(pair.effects) == {('current_loop_lag', hidden.joint),
                                 ('command_delay', hidden.joint)}
    held, other = pair.candidates
    assert (held.in_model, other.in_model) == (True, False)
    for one in pair.candidates:
        size, = one.parameters.values()
        assert size.low <= size.value <= size.high
        assert 0.5e-3 < size.value < 2e-2
    assert [note.split()[0] for note in found.notes()] == ['holds', 'as']


def test_a_joint_at_rest_shows_nothing_of_its_motor_and_warns_of_nothing():
    asked = motion('turn', 2, 12.0, 1e-3, 1)
    made = run(ARM, ARM, asked._replace(angle=asked.angle * [1.0, 0.0] + [0.0, 1.2],
                                        rate=asked.rate * [1.0, 0.0]), 1)
    with warnings.catch_warnings():
        warnings.simplefilter('error')
        found = diagnose(Measurement(ARM.labels, 1e-3, np.ascontiguousarray(
            made.reading[:, :, :2]), made.command), ARM, names=('coulomb_friction',)).diagnosis
    assert found.findings == ()
    floor = {(row.site, row.joint): row.floor for row in found.residuals}
    assert np.isnan(floor['motor', 'joint2']) and floor['torsion', 'joint2'] > 0.0


def test_dry_and_viscous_friction_are_no_power_law():
    """An exponent at its bound is another law: both of its parts are named instead."""
    friction = {'coulomb_friction': ('level', 0.02), 'viscous_friction': ('slope', 4e-5)}
    true = ARM
    for name, (number, more) in friction.items():
        usual = ARM.effect(name, 'joint1')
        true = true.with_effect(replace(usual, **{number: getattr(usual, number) + more}),
                                'joint1')
    made = run(true, ARM, motion('rich', 2, 24.0, 1e-3, 3), 3)
    found = diagnose(Measurement(ARM.labels, 1e-3, np.ascontiguousarray(made.reading[:, :, :2]),
                                 made.command), ARM,
                     names=(*friction, 'nonlinear_viscous_friction')).diagnosis
    assert set(named(found)) == {(name, 'joint1') for name in friction}


def test_standstill_shows_nothing():
    found = diagnosed(recorded([], 930, name='standstill', duration=10.0))
    assert found.verdict == 'insufficient_excitation'
    assert named(found) == []


def bag_of(path, made, **changes):
    """Write a record as a bag, with some of its columns changed."""
    count = len(made.stamps)
    angles = np.column_stack([made.link_angle, made.motor_angle]) * changes.get('scale', 1.0)
    effort = np.column_stack([np.full((count, 2), np.nan), made.command])
    rows = slice(0, changes.get('rows', count))
    samples = JointSamples(made.stamps, NAMES, angles, np.full((count, 4), np.nan),
                           effort * changes.get('effort', 1.0)).rows(rows)
    with BagWriter(path, {}) as bag:
        bag.write_joint_states(JOINT_STATES, samples.select(changes.get('names', NAMES)))
    return str(path)


@pytest.fixture(scope='module')
def short():
    """Return ten seconds of a healthy arm."""
    return recorded([], 940, duration=10.0)


@pytest.mark.parametrize(('changes', 'says'), [
    ({'effort': np.nan}, 'no motor torque of joint1'),
    ({'names': NAMES[:3]}, 'no joint2_motor, so the motor side'),
    ({'rows': 1000}, 'too short'),
    ({'scale': 180.0 / np.pi}, '--degrees'),
    ({'scale': np.array([1.0, 1.0, 0.01, 0.01])}, '--motor-at-link'),
    ({'scale': np.array([1.0, 1.0, -1.0, 1.0])}, '--flip joint1_motor'),
    ({'scale': np.array([1.0, 1.0, 1.5, 1.5])}, 'correct "ratio"'),
])
def test_unusable_recording_is_one_line(changes, says, short, tmp_path, capsys):
    bag = bag_of(tmp_path / 'bag', short, **changes)
    out = tmp_path / 'out'
    assert main(['diagnose', bag, '--arm', 'hda_arm.yaml', '--out', str(out)]) == 2
    said = capsys.readouterr()
    assert len(said.err.splitlines()) == 1 and says in said.err
    assert not out.exists()


def test_report_and_extended_model_are_written(short, tmp_path, capsys):
    bag = bag_of(tmp_path / 'bag', short, scale=180.0 / np.pi)
    out = tmp_path / 'out'
    assert main(['diagnose', bag, '--arm', 'hda_arm.yaml', '--out', str(out), '--degrees',
                 '--json']) == 0
    printed = json.loads(capsys.readouterr().out)
    written = json.loads((out / 'report.json').read_text())
    assert printed == written
    assert written['schema'] == 'hda.diagnosis/2'
    assert written['verdict'] == 'no_discrepancy'
    assert [row['horizon'] for row in written['prediction']] == list(HORIZONS)
    assert all(0.0 < row['after'] < 3.0 * row['floor'] for row in written['prediction'])
    assert set(written['excitation'][0]) == {'effect', 'joint', 'smallest_detectable', 'unit',
                                             'parameter'}
    assert read_arm(out / 'model.yaml').labels == ARM.labels
    shown = (out / 'report.html').read_text()
    assert '<svg' in shown
    assert 'Nothing is wrong' in shown
