"""How sure a diagnosis says it is, and what it says to do next."""

from dataclasses import replace
import math

from hda_arm_sim.model.files import read_arm
from hda_torque_estimator.diagnosis.findings.certainty import (
    margin_of, margin_of_rest, margin_of_share, probability, unsure, verdict_probability)
from hda_torque_estimator.diagnosis.findings.choice import ChoiceError, chosen
from hda_torque_estimator.diagnosis.findings.origin import RecordingFacts
from hda_torque_estimator.diagnosis.findings.report import (Alike, Candidate, Detectable,
                                                            Diagnosis, Evidence, Finding,
                                                            FittedNumber, Gain, TotalGain)
from hda_torque_estimator.diagnosis.findings.rest import Unexplained
from hda_torque_estimator.diagnosis.judging.listed_causes import told
from hda_torque_estimator.diagnosis.reporting.next_steps import next_steps
from hda_torque_estimator.diagnosis.reporting.summary import headline
import pytest

GAIN = Gain(2.0, 1.0, 1.0, 0.99, 0.98, 1.0)
SIZE = {'level': FittedNumber(0.05, 'N*m', 0.04, 0.06)}


def cause(sure):
    """Return a finding of this probability."""
    return Finding('coulomb_friction', 'joint1', 'motor', 'friction', SIZE,
                   Evidence(500.0, 60.0, None, 1e6), GAIN, sure)


def report(verdict, rate=1000.0, rest=None, pairs=(), limited_by=None, hidden=()):
    """Return a diagnosis with this verdict, of a recording of this rate [samples/s]."""
    return Diagnosis(
        verdict, (), tuple(pairs), rest, tuple(Detectable(name, 'joint1', None, '')
                                               for name in hidden),
        TotalGain(2.0, 1.0, 1.0, 0.99, 0.98, 1.0, 'error', '1'), (),
        RecordingFacts(60.0, round(60.0 * rate), rate, (), ()), 'arm.yaml', '0', 1.0,
        limited_by=limited_by, probability=0.9)


def test_a_cause_that_is_not_sure_says_why_it_is_not_named():
    assert unsure(cause(0.96)) is None and unsure(cause(math.nan)) is None
    assert unsure(cause(0.63)) == (
        'coulomb_friction at joint1 is not named: it is 63 % sure, and 95 % are needed')
    assert 'it is 94 % sure, and 95 %' in unsure(cause(0.9499))


def test_what_is_not_sure_or_at_a_bound_is_listed_with_its_size():
    edge = replace(cause(0.99), effect='asymmetric_friction', parameters={
        'asymmetry': FittedNumber(0.95, '', 0.94, 0.96)})
    named, others = told([cause(0.96), cause(0.63), edge])
    assert named == (cause(0.96),)
    assert [(one.effect, one.kind) for one in others] == [
        ('coulomb_friction', 'unsure'), ('asymmetric_friction', 'at_bound')]
    shown = replace(report('unknown'), listed=others)
    first = shown.document()['listed'][0]
    assert first['probability'] == 0.63 and first['parameters']['level']['value'] == 0.05
    said = ' '.join(shown.sentences())
    assert 'is not named: it is 63 % sure' in said and 'it would be level = 0.05' in said
    assert '63.0 % probable' in headline(shown) and 'asymmetr' not in headline(shown)


def test_a_cause_that_leaves_hardly_anything_of_what_it_explains_is_no_stand_in():
    assert margin_of_share(0.02) == 0.0
    assert margin_of_share(0.002) == pytest.approx(1.0)
    assert margin_of_share(0.0) > 2.0


def test_a_bar_is_95_percent_either_way_and_nothing_overflows():
    assert probability(0.0) == 0.5
    assert probability(1.0) == pytest.approx(0.95)
    assert probability(-1.0) == pytest.approx(0.05)
    assert 0.0 < probability(-1e9) < probability(1e9) <= 1.0
    assert probability(math.inf) == 1.0


def test_a_rest_is_even_at_its_bar_and_never_surer_than_two_bars():
    assert [margin_of_rest(share) for share in (-3.0, 0.0, 0.5, 1.0, 1.5)] == [2, 2, 1, 0, -1]
    assert margin_of(Evidence(120.0, 60.0, None, 1.0)) == 2.0


def test_a_verdict_is_as_sure_as_all_of_it():
    reported = [cause(0.9), cause(0.8)]
    assert verdict_probability('explained', reported, (), 0.5) == pytest.approx(0.36)
    assert verdict_probability('ambiguous', (), (0.9,), 1.0) == pytest.approx(0.9)
    assert verdict_probability('no_discrepancy', (), (), 0.97) == 0.97
    assert verdict_probability('unknown', reported, (), 0.03) == 0.97


def test_what_looks_alike_shares_its_probability_and_states_its_sizes():
    places = ('coulomb_friction', 'joint1'), ('drive_offset', 'joint1')
    pair = Alike(places, 'a dwell', probability=0.9, lead=0.75)
    assert [pair.share(place) for place in places] == pytest.approx([0.675, 0.225])
    pair = Alike(places, 'a dwell', tuple(Candidate(*place, SIZE, place == places[0],
                                                    pair.share(place)) for place in places), 0.9)
    written = report('ambiguous', pairs=[pair]).document()['ambiguous'][0]
    assert written['probability'] == 0.9
    assert [one['effect'] for one in written['sizes']] == ['coulomb_friction', 'drive_offset']
    assert written['sizes'][0]['parameters']['level'] == {
        'value': 0.05, 'unit': 'N*m', 'low': 0.04, 'high': 0.06}
    assert written['effects'] == [list(place) for place in places]      # as schema 1 has them


def test_what_to_do_is_stated_under_next():
    asked = replace(report('unknown'), steps=('record at 1 kHz',))
    assert asked.document()['next'] == ['record at 1 kHz']
    assert asked.sentences()[-1] == '  next: record at 1 kHz'


def test_what_to_do_next_is_stated_where_a_question_is_left():
    assert next_steps(report('no_discrepancy')) == ()
    rest = Unexplained('motor', 'joint1', 'motor_velocity', None, 0.9)
    unknown = next_steps(report('unknown', rate=250.0, rest=rest))
    assert 'constant speeds' in unknown[0] and unknown[1] == 'record at 1 kHz'
    assert next_steps(report('unknown', rest=rest)) == unknown[:1]
    assert next_steps(report('insufficient_excitation', 100.0, limited_by='rate')) == (
        'record at 1 kHz',)
    planned, = next_steps(report('insufficient_excitation', limited_by='motion',
                                 hidden=('dropped_samples', 'backlash')))
    assert planned.endswith(' --show backlash --out motion.csv')
    pair = Alike((('payload', None), ('cable_spring', 'joint1')), 'hang a known mass')
    assert next_steps(report('ambiguous', pairs=[pair])) == (
        'to decide between payload and cable_spring: hang a known mass',)


def test_another_candidate_takes_the_place_of_the_one_that_the_arm_holds():
    arm = read_arm('hda_arm.yaml')
    places = ('coulomb_friction', 'joint1'), ('drive_offset', 'joint1')
    offset = {'offset': FittedNumber(0.01, 'N*m', 0.009, 0.011)}
    pair = Alike(places, 'a dwell', (Candidate(*places[0], SIZE, True),
                                     Candidate(*places[1], offset, False)), 0.9)
    coulomb = replace(arm.effect(*places[0]), level=0.05)
    held, reported = arm.with_effect(coulomb, 'joint1'), report('ambiguous', pairs=[pair])
    same, other = chosen(reported, held, arm, 1), chosen(reported, held, arm, 2)
    assert same == (reported, held)
    assert other[1].effect(*places[0]) == arm.effect(*places[0])
    assert other[1].effect(*places[1]).offset == 0.01
    assert other[0].notes()[0].startswith('holds drive_offset at joint1: offset = 0.01')
    assert chosen(report('explained'), held, arm, 2)[1] == held     # nothing to choose from
    for number in (0, 3):
        with pytest.raises(ChoiceError, match=f'--candidate {number} is none of the 2 causes'):
            chosen(reported, held, arm, number)
