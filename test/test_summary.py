"""A page says in words what is wrong, how sure it is, and what to do."""

from collections.abc import Mapping
from dataclasses import replace
from hashlib import sha256
import math
import re
import string
from types import SimpleNamespace

from hda_arm_sim.model.effects import effect_named, EFFECTS
from hda_torque_estimator.calibrate.page import page as calibration_page
from hda_torque_estimator.diagnosis.findings.report import (
    Candidate, Detectable, FittedNumber, Listed, RunnerUp, VERDICTS)
from hda_torque_estimator.diagnosis.reporting import summary
from hda_torque_estimator.diagnosis.reporting.detectability_chart import by_site
from hda_torque_estimator.diagnosis.reporting.effect_words import ELEMENTS, WORDS
from hda_torque_estimator.diagnosis.reporting.page import page
from hda_torque_estimator.pages.badge import badge_of, BADGES
from hda_torque_estimator.pages.render import asset
from hda_torque_estimator.pages.wording import handy, in_unit, spoken, unbroken
from project_files import ROOT
import pytest
from test_page import diagnosis, Reader

KINDS = {effect.name: effect for effect in EFFECTS}


def numbers(**values: float) -> Mapping[str, FittedNumber]:
    """Return fitted numbers with the unit of an angle, each known to a tenth."""
    return {name: FittedNumber(value, 'rad', 0.9 * value, 1.1 * value)
            for name, value in values.items()}


def typical(name: str, sign: float = 1.0) -> dict[str, FittedNumber]:
    """Return all numbers of an effect, as large as they may be, with their units."""
    return {rule.name: FittedNumber(sign * (rule.high if math.isfinite(rule.high) else 1.0),
                                    rule.unit,
                                    0.0, 1.0) for rule in KINDS[name].declarations()}


def test_every_effect_has_words_of_its_own():
    assert WORDS.keys() == KINDS.keys()
    said = [words.said for words in WORDS.values()]
    assert len(set(said)) == len(said)


@pytest.mark.parametrize('name', WORDS)
def test_words_speak_of_numbers_that_the_effect_has(name):
    words, own = WORDS[name], {rule.name for rule in KINDS[name].declarations()}
    used = {field for text in (words.said, words.less)
            for _, field, _, _ in string.Formatter().parse(text) if field}
    assert used - {'size'} <= own
    assert set(words.size) <= own
    assert ('size' in used) == bool(words.size)
    assert words.element in ELEMENTS
    assert words.check.endswith('.')


@pytest.mark.parametrize('sign', [1.0, -1.0])
@pytest.mark.parametrize('name', WORDS)
def test_every_effect_makes_a_sentence(name, sign):
    said = summary.cause_sentence(name, 'joint1', typical(name, sign))
    assert said.startswith('joint 1 ')
    assert '{' not in said and 'unknown' not in said and '_' not in said
    bare = summary.cause_sentence(name, None, {})
    assert bare.startswith('the arm ') and '  ' not in bare and '{' not in bare


def test_the_sentence_names_cause_joint_and_size():
    shown = replace(diagnosis(), findings=(replace(
        diagnosis().findings[0], effect='backlash', parameters=numbers(half_width=1e-4)),))
    assert summary.headline(shown) == 'Joint 1 has 0.2 mrad (0.69 arcmin) of play.'
    assert 'between 0.18 and 0.22 mrad (0.62 and 0.76 arcmin)' in summary.certainty(shown)
    assert '<h1>Joint 1 has 0.2 mrad (0.69 arcmin) of play.</h1>' in page(shown, {})


def test_a_negative_size_is_said_the_other_way_round():
    error = {'error': FittedNumber(-0.12, '', -0.13, -0.11)}
    assert summary.cause_sentence('stiffness_error', 'joint2', error) == (
        'joint 2 has a flexspline that is 12 % softer than stated')
    assert summary.within('stiffness_error', error) == '11 % and 13 %'
    sharp = {'amplitude': FittedNumber(3.01e-3, 'N*m', 2.99e-3, 3.03e-3)}
    assert summary.within('motor_cogging', sharp) == '2.99 and 3.03 mN\N{MIDDLE DOT}m'


def test_every_size_of_the_headline_has_its_interval_and_every_named_gear_is_drawn():
    play = replace(diagnosis().findings[0], effect='backlash',
                   parameters=numbers(half_width=1e-4))
    judged = replace(diagnosis(), ambiguous=(), probability=0.9,
                     findings=tuple(replace(play, joint=f'joint{n}') for n in (2, 1, 3)))
    said = summary.certainty(judged)
    assert said.startswith('90.0 % probable; each with 90 % the backlash of joint 2 is between ')
    assert ', the backlash of joint 1 is between ' in said and 'joint 3' not in said
    shown = Reader(page(judged, {})).text
    for expected in ('gear of joint 2, in section', 'gear of joint 1, in section',
                     'Hatched: flange of joint 2 (backlash), flange of joint 1 (backlash).',
                     'Not drawn: flange of joint 3 (backlash).'):
        assert expected in ' '.join(shown.split())


def test_an_ambiguous_sentence_gives_every_size():
    said = summary.headline(replace(diagnosis('ambiguous'), findings=()))
    assert said == ('Joint 1 has 86 µrad (0.3 arcmin) of play; or joint 1 has a link encoder '
                    'that is read 0.88 ms after its motor encoder: this recording cannot '
                    'decide.')


def test_what_is_listed_has_a_section_with_its_size_and_why_it_is_not_named():
    sized = {'level': FittedNumber(0.05, 'N*m', 0.04, 0.06)}
    one = Listed('coulomb_friction', 'joint1', sized, 0.63, 'unsure',
                 'coulomb_friction at joint1 is not named: it is 63 % sure, and 95 % are needed')
    shown = ' '.join(Reader(page(replace(diagnosis('unknown'), findings=(), listed=(one,)),
                                 {})).text.split())
    assert 'no name for it is sure (63.0 % probable: joint 1 has 50 mN·m' in shown
    listed = shown.partition('Listed, not named')[2]
    assert '63.0 % probable' in listed and 'it is 63 % sure, and 95 % are needed' in listed
    assert 'Listed, not named' not in Reader(page(diagnosis(), {})).text


def test_many_causes_are_counted():
    found = diagnosis().findings[0]
    shown = replace(diagnosis(), findings=(found,) * 5)
    assert summary.headline(shown).endswith('. 3 more causes below.')
    unknown = replace(shown, verdict='unknown', findings=(found,) * 3)
    assert summary.headline(unknown).count('. ') == 3
    assert 'no effect of the catalogue explains. 1 more cause below.' in summary.headline(unknown)


@pytest.mark.parametrize(('verdict', 'said'), [
    ('no_discrepancy', 'Nothing is wrong'), ('insufficient_excitation', 'cannot show whether'),
    ('unknown', 'Something is wrong at the motor side of joint 1')])
def test_verdicts_without_causes_are_sentences_too(verdict, said):
    shown = replace(diagnosis(verdict), findings=(), ambiguous=())
    assert said in summary.headline(shown)
    assert summary.steps(shown)


def test_verdicts_differ_in_word_shape_and_colour():
    badges = [badge_of(verdict) for verdict in VERDICTS]
    assert BADGES.keys() == VERDICTS.keys()
    shapes = {page(replace(diagnosis(verdict)), {}).partition('<svg class="icon"')[2]
              .partition('</svg>')[0] for verdict in VERDICTS}
    colours = {line.strip() for badge in badges for line in asset('style.css').splitlines()
               if line.strip().startswith(f'.{badge.kind} {{ --mark')}
    assert len({badge.word for badge in badges}) == len(shapes) == len(colours) == 5


def contrast(one: str, other: str) -> float:
    """Return the contrast of two colours as WCAG 2 defines it."""
    def light(colour: str) -> float:
        parts = [int(colour[k:k + 2], 16) / 255.0 for k in (1, 3, 5)]
        linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4
                  for part in parts]
        return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]
    low, high = sorted((light(one), light(other)))
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize('theme', [0, 1], ids=['light', 'dark'])
def test_all_text_stands_out_from_its_ground(theme):
    """At least 4.5 to 1, which WCAG 2 asks of text."""
    plain = re.sub(r'/\*.*?\*/', '', asset('style.css'), flags=re.DOTALL)
    block = plain.split(':root {')[1 + theme].partition('}')[0]
    colours = dict(part.strip().split(': ') for part in block.replace('\n', ' ').split(';')
                   if part.strip().startswith('--') and '#' in part)
    for name in ('ink', 'soft', 'before', 'after', 'floor', *(
            badge.kind for badge in BADGES.values()), 'failed', 'done'):
        for ground in ('paper', 'panel'):
            assert contrast(colours[f'--{name}'], colours[f'--{ground}']) >= 4.5, (name, ground)


def test_what_marks_the_arm_is_what_the_causes_say():
    shown = diagnosis('ambiguous')
    assert [(mark.joint, mark.element) for mark in summary.marks(shown)] == [
        ('joint1', 'wave_generator'), (None, 'tip'),
        ('joint1', 'flange'), ('joint1', 'link_encoder')]
    assert 'class="guilty"' in page(shown, {})
    healthy = replace(diagnosis('no_discrepancy'), findings=(), ambiguous=(), unexplained=None)
    assert summary.marks(healthy) == []
    assert 'class="guilty"' not in page(healthy, {})


def test_probabilities_and_next_steps_are_shown_where_they_are_known():
    """Where a diagnosis holds them they stand in the place of odds and general advice."""
    plain = diagnosis('ambiguous')
    assert 'probable' not in Reader(page(plain, {})).text
    judged = replace(plain, probability=0.87, steps=('hang 2 kg on it.',))
    assert summary.certainty(judged).startswith(
        '87.0 % probable; with 90 % the kinematic error of joint 1 is between 0.12 and')
    assert summary.steps(judged)[0] == 'hang 2 kg on it.'
    assert summary.steps(replace(judged, steps=('record at 1 kHz',)))[0] == 'record at 1 kHz.'
    assert not any('decides' in step for step in summary.steps(judged))
    assert summary.probability(SimpleNamespace(probability=0.99999)) == 'more than 99.9 %'


def test_the_next_best_cause_is_reported_with_probability_and_size():
    found, *_ = diagnosis().findings
    play = {'half_width': FittedNumber(1e-4, 'rad', math.nan, math.nan)}

    def rows(sure: float) -> str:
        evidence = replace(found.evidence, runner_up='backlash', odds=250.0,
                           rival=RunnerUp('joint2', play, sure))
        return Reader(page(replace(diagnosis(), findings=(
            replace(found, evidence=evidence),)), {})).text.replace('\N{NO-BREAK SPACE}', ' ')
    assert 'Joint 2 has 0.2 mrad (0.69 arcmin) of play' in rows(0.04)
    assert '4.0 %' in rows(0.04) and '250 to 1' in rows(0.04)
    assert 'less than 0.1 %' in rows(1e-9)


def test_where_the_next_best_cause_is_named_too_any_other_is_the_rival():
    """The runner-up at its time came in as a cause of its own: nothing else came nearer."""
    found, *_ = diagnosis().findings
    first = replace(found, probability=0.97, evidence=replace(
        found.evidence, runner_up='payload', odds=250.0))
    other = replace(found, effect='payload', joint=None, probability=0.9)
    judged = replace(diagnosis(), findings=(first, other))
    text = Reader(page(judged, {})).text.replace('\N{NO-BREAK SPACE}', ' ')
    assert 'any other' in text and 'Payload came nearest, and is named too' in text
    assert summary.rival(first, ['kinematic_error', 'payload'])[2:] == [
        '3.0\N{NO-BREAK SPACE}%', '250 to 1']
    assert summary.rival(first, ['kinematic_error']) == []


def test_what_is_at_the_noise_has_nothing_to_remove():
    """Where nothing was extended, the two errors differ by chance; a share of it says nothing."""
    chance = replace(diagnosis().gain, before=0.74, after=0.75, floor=1.0, removed=-1.0)
    assert summary.removed(chance) == 'nothing to remove'
    assert summary.removed(replace(chance, before=3.1)).startswith('-100.0 %')


@pytest.mark.parametrize(('value', 'scale', 'said'), [
    (2e-4, 'rad', '0.2 mrad (0.69 arcmin)'), (3.2e-6, 'rad', '3.2 µrad (0.011 arcmin)'),
    (0.5, 'rad', '29°'), (0.125, '', '12 %'), (0.004, 'N*m', '4 mN·m'), (12.3, 'N*m', '12 N·m'),
    (0.00088, 's', '0.88 ms'), (0.42, 'kg', '0.42 kg'), (1234.5, 'N*m/rad', '1,234 N·m/rad'),
    (9.999e-5, 'rad', '100 µrad (0.34 arcmin)'),
    (0.0, 'rad', '0 µrad (0 arcmin)'), (math.nan, 's', 'unknown s')])
def test_sizes_are_said_in_units_that_people_use(value, scale, said):
    assert handy(value, scale) == said


def test_a_row_of_numbers_has_one_handy_unit():
    """No row mixes exponents: its largest number chooses the unit of all."""
    assert in_unit([1.001e-4, 9.008e-5, 1.101e-4], 'rad') == (['0.1001', '0.0901', '0.1101'],
                                                              'mrad')
    assert in_unit([-3.1e-3, 2e-4, math.nan], 'N*m') == (['-3.1', '0.2', 'unknown'], 'mN·m')
    assert in_unit([0.0, 0.0], 'rad') == (['0', '0'], 'rad')
    assert in_unit([9757.4, 3.0], 'N*m/rad') == (['9757', '3'], 'N·m/rad')
    assert in_unit([1e-6, 3.252e-4], 'rad') == (['0.001', '0.3252'], 'mrad')
    assert in_unit([5.964e-5], '1/(N*m)') == (['0.00005964'], '1/(N·m)')
    assert in_unit([5.964e-9], '1/(N*m)') == (['5.964e-09'], '1/(N·m)')


def test_no_line_ends_between_a_number_and_its_unit():
    assert unbroken('with 90 % it is 0.2 mrad (0.7 arcmin) [0.1, 0.3]') == (
        'with 90\u00a0% it is 0.2\u00a0mrad (0.7\u00a0arcmin) [0.1, 0.3]')


def test_something_else_is_as_sure_as_it_says_itself():
    """Beside a rest without a name, a cause and the rest each have a probability of their own."""
    plain = diagnosis('unknown')
    first = replace(plain.findings[0], probability=0.97)
    shown = replace(plain, probability=0.9, findings=(first,), unexplained=None)
    assert summary.certainty(shown).startswith(
        'what is named: 97.0 % probable; with 90 % its size')
    assert summary.certainty(shown).endswith('That something else is wrong: 90.0 % probable')
    assert ('Beside what is named so far, something else is wrong that no effect'
            in summary.headline(shown))
    assert not any('what the rest follows' in step for step in summary.steps(shown))
    assert any('what the rest follows' in step for step in summary.steps(plain))


def test_names_are_spoken():
    assert [spoken(name) for name in ('joint1', 'motor_cogging', 'axis_a', 'A6')] == [
        'joint 1', 'motor cogging', 'axis a', 'A6']


def test_the_bundled_library_is_the_one_that_the_docs_name():
    reported = (ROOT / 'docs' / 'dependencies.md').read_text()
    for name in ('uPlot.iife.min.js', 'uPlot.min.css'):
        digest = sha256(asset(f'uplot/{name}').encode()).hexdigest()
        assert name in reported and digest in reported
    assert 'uPlot 1.6.32' in reported and 'v1.6.32' in asset('uplot/uPlot.iife.min.js')
    assert 'MIT License' in asset('uplot/LICENSE')


def test_the_glossary_of_a_page_has_its_terms_and_no_other():
    read = Reader(page(diagnosis(), {}))
    assert 'placebothe columns of a cause' in read.text
    assert 'teleportation' not in read.text
    # Names in code count, and effects have their causes.
    assert 'loaded kinematic error' not in read.text
    judged = replace(diagnosis(), findings=(replace(
        diagnosis().findings[0], effect='loaded_kinematic_error'),))
    assert ('loaded kinematic error' + effect_named('loaded_kinematic_error').cause
            in Reader(page(judged, {})).text)


def test_what_a_recording_could_show_is_one_picture_by_site():
    rows = by_site([Detectable('backlash', 'joint1', 8e-7, 'rad'),
                    Detectable('backlash', 'joint2', 8e-3, 'rad'),
                    Detectable('payload', None, None, 'kg')])
    assert list(rows) == ['torsion', 'link']
    near, far = rows['torsion'][0].dots
    assert near.seen and not far.seen and near.place < 0.5 < far.place
    assert rows['link'][0].dots[0].place is None


def test_every_effect_worth_finding_has_a_place_in_the_picture():
    """A typical size lies in the middle, in the unit in which the smallest is stated."""
    for name, kind in KINDS.items():
        if kind.typical is None:
            continue
        more = {**kind.typical.more, **kind.typical.shape}
        number, value = max(((key, abs(size)) for key, size in more.items()),
                            key=lambda item: item[1])
        unit = {rule.name: rule.unit for rule in kind.declarations()}[number]
        dot = by_site([Detectable(name, 'joint1', value, unit)])[kind.site.value][0].dots[0]
        assert dot.place == pytest.approx(0.5), name


def test_a_candidate_without_numbers_is_named_by_its_cause_alone():
    shown = diagnosis('ambiguous')
    pair = replace(shown.ambiguous[0], candidates=(Candidate('backlash', 'joint1', {}, True),))
    said = summary.headline(replace(shown, ambiguous=(pair,), findings=()))
    assert said.startswith('Joint 1 has backlash; or joint 1 has clock skew: ')


def test_a_calibration_that_changes_nothing_says_so():
    joint = {'joint': 'joint1', 'kept': '', 'before': 0.0141, 'after': 0.0139, 'numbers': [],
             'recordings': []}
    found = SimpleNamespace(report=lambda: {'joints': [joint]})
    blind = {**joint, 'before': 0.0, 'after': 0.0, 'motor': 0.21}
    by_motor = SimpleNamespace(report=lambda: {'joints': [blind]})
    alone, shown = (calibration_page(one, out='a', arm='b', bags=[], version='1').replace(
        '\N{NO-BREAK SPACE}', ' ') for one in (by_motor, found))
    assert 'The torque of joint 1 is off by 0.21 N·m by its motor alone.' in alone
    assert 'The torque of joint 1 is off by 0.014 N·m, as before.' in shown
