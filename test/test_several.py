"""Several recordings of one arm are one diagnosis; one recording is reported as it always was."""

from dataclasses import replace
import json

from hda_arm_sim.model.effects import ExternalContact
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import motion
from hda_msgs_json.bag import BagWriter
from hda_msgs_json.samples import JointSamples
from hda_msgs_json.topics import JOINT_STATES
from hda_torque_estimator.cli import main
from hda_torque_estimator.diagnosis.balances.balance import Balancer
from hda_torque_estimator.diagnosis.balances.predict import prediction_errors
from hda_torque_estimator.diagnosis.diagnose import diagnose
from hda_torque_estimator.diagnosis.fitting.alignment import aligned, together, zeros_of
from hda_torque_estimator.measurements.measurement import Measurement
from hda_torque_estimator.measurements.recording_checks import GateError
from hda_torque_estimator.measurements.running_clock import arm_during, split, within
import numpy as np
import pytest
from truth import draw, record, Reference

ARM = read_arm('hda_arm.yaml')
NAMES = ('joint1', 'joint2', 'joint1_motor', 'joint2_motor')
ZEROS = ((0.0, 0.0), (3e-4, -2e-4), (-1e-4, 5e-4))      # of the link encoders, by recording


def measured(hidden, seed, duration=14.0, zero=(0.0, 0.0)):
    """Return one recording of an arm with hidden effects, its link encoders zeroed anew."""
    asked = motion('rich', 2, duration, 1e-3, seed)
    made = record(hidden, Reference(asked.angle, asked.rate, 1e-3), seed=seed)
    return Measurement(ARM.labels, 1e-3, np.stack([made.motor_angle, made.link_angle + zero],
                                                  axis=2), made.command)


@pytest.fixture(scope='module')
def hidden():
    """Return one drawn effect."""
    return draw('kinematic_error', np.random.default_rng(8))


@pytest.fixture(scope='module')
def three(hidden):
    """Return three recordings of an arm with a hidden effect, each with zeros of its own."""
    return [measured([hidden], 910, zero=zero) for zero in ZEROS]


def test_one_recording_is_itself(three):
    assert together(three[:1]) is three[0]
    assert aligned(three[0], ARM) is three[0]


def test_recordings_come_back_as_they_went_in(three):
    whole = together(three)
    for one, back in zip(three, whole.recordings()):
        count = len(back.command)
        assert 0 <= len(one.command) - count < Balancer(one).every
        np.testing.assert_array_equal(back.reading, one.reading[:count])
        np.testing.assert_array_equal(back.command, one.command[:count])


def test_balances_and_predictions_are_those_of_each_recording(three):
    whole = together(three[:2])
    joint, alone = Balancer(whole), [Balancer(one) for one in whole.recordings()]
    for name in ('residual', 'valid'):
        np.testing.assert_array_equal(getattr(joint(ARM), name), np.concatenate(
            [getattr(balancer(ARM), name) for balancer in alone]))
    spans = split(whole)[1]
    np.testing.assert_allclose(prediction_errors(joint, ARM, spans), np.concatenate(
        [prediction_errors(balancer, ARM, within(spans, piece, 1e-3))
         for balancer, piece in zip(alone, whole.pieces())]))


def test_the_last_of_three_recordings_is_held_out_whole(three):
    two, whole = together(three[:2]), together(three)
    assert {begin >= 14.0 for begin, _ in split(two)[0]} == {False, True}
    training, held_out = split(whole)
    last = whole.pieces()[-1]
    assert within(training, last, 1e-3) == ()
    assert within(held_out, last, 1e-3) == ((0.0, pytest.approx(len(whole.recordings()[-1].command)
                                                                * 1e-3, abs=2e-3)),)


def test_zeros_of_all_recordings_become_those_of_the_first(three):
    parts = aligned(together(three), ARM).recordings()
    for part in parts[1:]:      # the motion of all three is the same
        np.testing.assert_allclose((part.reading - parts[0].reading).mean(axis=0), 0.0, atol=5e-7)
    zeros = zeros_of(Balancer(together(parts)), ARM)
    np.testing.assert_allclose(zeros, np.repeat(zeros[:1], 3, axis=0), atol=5e-7)


def test_a_contact_belongs_to_the_recording_in_which_it_begins():
    touched = ARM.with_effect(ExternalContact(5.0, 0.0, 12.5, 1.0))
    pieces = together([measured([], 900, 10.0), measured([], 900, 10.0)]).pieces()
    first, second = (arm_during(touched, piece, 1e-3) for piece in pieces)
    assert first.effect('external_contact').is_neutral()
    assert second.effect('external_contact').onset == pytest.approx(2.5, abs=0.01)


def test_what_is_hidden_is_found_in_all_recordings_together(three, hidden):
    found = diagnose(together(three), ARM).diagnosis
    assert [(cause.effect, cause.joint) for cause in found.findings] == [
        ('kinematic_error', hidden.joint)]
    fitted = found.findings[0].parameters['amplitude_2'].value
    assert fitted == pytest.approx(hidden.parameters['amplitude_2'], rel=0.03)
    assert found.findings[0].gain.removed > 0.9
    assert found.recording.duration == pytest.approx(42.0, abs=0.1)


def test_nothing_hidden_in_two_recordings_is_nothing_found():
    healthy = together([measured([], 903, zero=ZEROS[1]), measured([], 903, zero=ZEROS[2])])
    found = diagnose(healthy, ARM).diagnosis
    assert (found.verdict, found.findings) == ('no_discrepancy', ())


def test_recordings_of_other_rates_are_refused(three):
    with pytest.raises(GateError, match='second has 500 samples per second where first has 1000'):
        together([three[0], replace(three[1], dt=2e-3)], ('first', 'second'))


@pytest.mark.parametrize('rate', [99.061, 98.0, 100.5])
def test_recordings_of_nearly_one_rate_belong_together(rate):
    """Readings of the second are those at the ticks of the first; torques keep their mean."""
    def swung(rate):
        time = np.arange(3000) / rate
        link = np.stack([0.5 * np.sin(time), 0.3 * np.cos(2.0 * time)], axis=1)
        return Measurement(ARM.labels, 1.0 / rate, np.stack([100.0 * link, link], axis=2),
                           np.stack([np.cos(time), np.sin(3.0 * time)], axis=1))
    first, second = together([swung(98.935), swung(rate)]).recordings()
    assert second.dt == first.dt == 1.0 / 98.935
    shared = slice(0, min(len(first.command), len(second.command)))
    np.testing.assert_allclose(second.reading[shared, :, 1], first.reading[shared, :, 1],
                               atol=1e-6)
    np.testing.assert_allclose(second.command[shared][:-1], first.command[shared][:-1], atol=0.02)


def bag_of(path, recording):
    """Write a measurement as a bag."""
    count = len(recording.command)
    angles = np.column_stack([recording.reading[:, :, 1], recording.reading[:, :, 0]])
    effort = np.column_stack([np.full((count, 2), np.nan), recording.command])
    with BagWriter(path, {}) as bag:
        bag.write_joint_states(JOINT_STATES, JointSamples(
            1 + 1_000_000 * np.arange(count), NAMES, angles, np.full((count, 4), np.nan), effort))
    return str(path)


def test_bags_of_one_arm_make_one_report(three, tmp_path, capsys):
    bags = [bag_of(tmp_path / f'bag{place}', one) for place, one in enumerate(three[:2])]
    out = tmp_path / 'out'
    assert main(['diagnose', *bags, '--arm', 'hda_arm.yaml', '--out', str(out), '--json']) == 0
    report = json.loads(capsys.readouterr().out)
    assert [cause['effect'] for cause in report['findings']] == ['kinematic_error']
    assert [(part['bag'], part['begin']) for part in report['recording']['bags']] == [
        (bags[0], 0.0), (bags[1], pytest.approx(14.0, abs=0.01))]
    assert bags[1] in (out / 'report.html').read_text()
