"""A page shows all that a diagnosis holds, and a residual shows the coordinate it follows."""

from collections.abc import Callable
from dataclasses import replace
from html.parser import HTMLParser
import math
import re
from xml.etree import ElementTree

from hda_arm_sim.foundation.arrays import Array
from hda_torque_estimator.diagnosis.balances.strongest_wave import strongest_wave
from hda_torque_estimator.diagnosis.findings.origin import RecordingFacts
from hda_torque_estimator.diagnosis.findings.report import (Alike, Candidate, Detectable,
                                                            Diagnosis, Evidence, Finding,
                                                            FittedNumber, Gain, Prediction,
                                                            Residual, TotalGain, VERDICTS)
from hda_torque_estimator.diagnosis.findings.rest import Unexplained
from hda_torque_estimator.diagnosis.reporting.dependence import against
from hda_torque_estimator.diagnosis.reporting.exhibits import Exhibits
from hda_torque_estimator.diagnosis.reporting.following import Following
from hda_torque_estimator.diagnosis.reporting.page import page
from hda_torque_estimator.diagnosis.reporting.plots import figures
from hda_torque_estimator.pages.drawing import inline_svg
import numpy as np
import pytest

RATE, RATIO, NOISE = 125.0, 100.0, 0.3
FREE_TEXT = '<b>"R&D"</b> $5'


def coordinates(seed: int) -> dict[str, Array]:
    """Return the coordinates of a joint that moves in many ways for 60 s."""
    random = np.random.default_rng(seed)
    time = np.arange(7500) / RATE
    angle = 0.2 * np.arcsin(np.sin(0.3 * time))
    for frequency in random.uniform(0.1, 1.5, 8):
        angle += random.uniform(0.05, 0.25) * np.sin(
            2.0 * np.pi * (frequency * time + random.random()))
    velocity = np.gradient(angle, time)
    torque = 10.0 * np.cos(angle + 0.3) + 1.5 * np.gradient(velocity, time)
    return {'motor_velocity': RATIO * velocity,
            'link_velocity': velocity + 0.003 * random.normal(size=len(time)),
            'link_angle': angle, 'motor_angle': RATIO * angle + 40.0,
            'joint_torque': torque + 0.05 * random.normal(size=len(time)),
            'motor_torque': torque / RATIO + 0.02 * np.sign(velocity)}


def exhibits_of(residual: Array, moved: dict[str, Array], seed: int = 0) -> Exhibits:
    """Return exhibits of one joint; the residual, made of unit size and noisy, is in B."""
    random = np.random.default_rng(seed)
    noise = NOISE * random.normal(size=(len(residual), 2))
    before = noise + np.outer(residual / residual.std(), (0.0, 1.0))
    valid = np.stack([np.abs(moved['motor_velocity']) > NOISE, np.ones(len(residual), bool)], 1)
    horizons = np.array([0.01, 0.05, 0.2])
    return Exhibits(np.arange(len(residual)) / RATE, ('joint1',), before, noise, valid,
                    np.full(2, NOISE), {name: values[:, None] for name, values in moved.items()},
                    horizons, 1e-3 * horizons, 1e-4 * horizons, 9e-5 * horizons)


def followed(exhibits: Exhibits, column: int) -> list[Following]:
    """Return what a column follows before anything is extended, as text and figures state it."""
    return exhibits.missed().followed(column)


Law = Callable[[dict[str, Array]], Array]
LAWS: dict[str, tuple[Law, str, bool]] = {
    'dry friction': (lambda c: np.sign(c['link_velocity']), 'link_velocity', False),
    'boundary lubrication': (
        lambda c: np.sign(c['link_velocity']) * np.exp(-(c['motor_velocity'] / 5.0) ** 2),
        'link_velocity', False),
    'friction along the turn': (
        lambda c: np.sign(c['motor_velocity']) * np.cos(3.0 * c['link_angle'] + 1.0),
        'link_angle', True),
    'mesh loss': (lambda c: np.sign(c['motor_velocity']) * np.abs(c['joint_torque'] - 4.0),
                  'joint_torque', True),
    'cable': (lambda c: c['link_angle'], 'link_angle', False),
    'stiffness': (lambda c: c['joint_torque'] ** 3, 'joint_torque', False),
    'torque constant': (lambda c: c['motor_torque'], 'motor_torque', False),
    'ripple': (lambda c: np.cos(2.0 * c['motor_angle'] + 1.0), 'motor_angle', False),
    'cogging': (lambda c: np.cos(42.0 * c['motor_angle']), 'motor_angle', False),
}


@pytest.mark.parametrize('seed', range(4))
@pytest.mark.parametrize('cause', LAWS)
def test_residual_shows_the_coordinate_it_follows(cause, seed):
    law, coordinate, by_direction = LAWS[cause]
    moved = coordinates(seed)
    best = followed(exhibits_of(law(moved), moved, seed), 1)[0]
    assert (best.coordinate, best.carrier) == (coordinate, 'direction' if by_direction else '')
    assert 0.5 < best.share <= 1.0


@pytest.mark.parametrize('disturbance', [
    lambda time: np.sin(2.0 * np.pi * 7.51 * time),
    lambda time: ((time > 25.0) & (time < 33.0)).astype(float)], ids=['line', 'push'])
def test_what_nothing_that_moves_explains_follows_time(disturbance):
    moved = coordinates(3)
    shown = exhibits_of(disturbance(np.arange(7500) / RATE), moved)
    best = followed(shown, 1)[0]
    assert best.coordinate == 'time'
    assert best.share > 0.8


def test_lines_are_stated_in_hertz_or_by_motor_turn():
    moved = coordinates(3)
    hum = followed(exhibits_of(np.sin(47.0 * np.arange(7500) / RATE), moved), 1)[0]
    cogging = followed(exhibits_of(np.cos(14.0 * moved['motor_angle']), moved), 1)[0]
    push = followed(exhibits_of((np.arange(7500) > 4000).astype(float), moved), 1)[0]
    assert hum.line == pytest.approx(47.0 / (2.0 * np.pi), abs=1e-3)
    assert cogging.line == 14.0
    assert push.line is None


@pytest.mark.parametrize('seed', range(4))
def test_noise_follows_nothing(seed):
    moved = coordinates(seed)
    shown = exhibits_of(moved['link_angle'], moved, seed)
    assert max(reported.share for reported in followed(shown, 0)) < 0.03


def test_slow_noise_follows_nothing_that_moves():
    moved = coordinates(1)
    random = np.random.default_rng(2)
    slow = np.convolve(random.normal(size=8499), np.hanning(1000), 'valid')
    assert followed(exhibits_of(slow, moved), 1)[0].coordinate == 'time'


def test_the_share_is_what_is_not_noise():
    moved = coordinates(0)
    best = followed(exhibits_of(moved['link_angle'], moved), 1)[0]
    assert best.share == pytest.approx(1.0 / (1.0 + NOISE ** 2), abs=0.02)


def test_part_of_a_motor_turn_is_described_by_the_link():
    moved = coordinates(0)
    moved['motor_angle'] = 2.0 * moved['link_angle']
    names = [reported.coordinate for reported in followed(exhibits_of(moved['link_angle'],
                                                                      moved), 1)]
    assert names[0] == 'link_angle'
    assert 'motor_angle' not in names


def test_standstill_follows_only_time():
    still = dict.fromkeys(coordinates(0), np.zeros(1000))
    shown = exhibits_of(np.random.default_rng(0).normal(size=1000), still)
    assert followed(shown, 0) == [Following('time', '', 0.0)]       # nowhere valid
    assert [reported.coordinate for reported in followed(shown, 1)] == ['time']


@pytest.mark.parametrize('frequency', [0.7, 7.51, 33.0])
def test_strongest_line_is_found_beside_a_drift(frequency):
    time = np.arange(7500) / RATE
    values = np.sin(2.0 * np.pi * frequency * time) + 0.001 * time
    line = strongest_wave(time, values - values.mean(), np.ones(len(time), bool))
    assert line.frequency == pytest.approx(frequency, abs=0.05 / 60.0)
    assert line.share > 0.99


def test_nothing_has_no_line():
    line = strongest_wave(np.arange(100) / RATE, np.zeros(100), np.ones(100, bool))
    assert line.share == 0.0


def test_bins_hold_quartiles_of_equally_many_values():
    random = np.random.default_rng(0)
    place = random.random(7500) ** 2
    shown = exhibits_of(place, coordinates(0) | {'link_angle': place})
    shown = replace(shown, before=np.outer(2.0 * place + random.normal(size=7500), (0.0, 1.0)))
    plot = against(Following('link_angle', '', 1.0), 1, (('median', shown.missed(), 'before'),))
    count, (line,) = len(plot.x), plot.lines
    np.testing.assert_allclose(plot.x, ((np.arange(count) + 0.5) / count) ** 2, atol=0.02)
    np.testing.assert_allclose(line.values, 2.0 * plot.x, atol=0.25)
    np.testing.assert_allclose(np.mean(line.high - line.low), 2.0 * 0.6745, rtol=0.1)


def test_what_a_carrier_multiplies_is_drawn_apart_for_both_of_its_signs():
    moved = coordinates(0)
    shown = exhibits_of(np.sign(moved['motor_velocity']) * (moved['link_angle'] + 3.0), moved)
    plot = against(Following('link_angle', 'direction', 1.0), 1,
                   (('rest', shown.missed(), 'before'),))
    positive, negative = plot.lines
    assert (positive.name, negative.name) == ('rest, direction positive',
                                              'rest, direction negative')
    assert np.nanmin(positive.values) > 0.0 > np.nanmax(negative.values)


def test_column_is_where_the_most_goes_at_the_site_of_a_cause():
    moved = coordinates(0)
    one = exhibits_of(moved['link_angle'], moved)
    two = replace(one, labels=('joint1', 'joint2'), before=np.tile(one.before, 2),
                  after=np.tile(one.after, 2), valid=np.tile(one.valid, 2),
                  noise=np.tile(one.noise, 2))
    # Columns are now A1, A2, B1, B2, and the excess sits in A2 and B2.
    assert two.column('motor', None) == 1
    assert two.column('torsion', None) == 3
    assert two.column('torsion', 'joint1') == 2
    assert two.column('timing', 'joint2') in (1, 3)


def test_one_cause_is_shown_without_the_others():
    moved = coordinates(0)
    shown = exhibits_of(moved['link_angle'], moved)
    alone = shown.after + 1.0
    both = replace(shown, lacking={('payload', None): alone})
    assert both.of('payload', None).before is alone
    assert both.of('payload', 'joint1').before is shown.before
    assert both.rest().residual is shown.after


def diagnosis(verdict: str = 'explained') -> Diagnosis:
    """Return a diagnosis that holds some of everything, and text that a page must not obey."""
    gain = Gain(3.1, 1.02, 1.0, 0.987, 0.981, 0.992).beside(0.0123)
    finding = Finding(
        'kinematic_error', 'joint1', 'torsion', f'transmission error {FREE_TEXT}',
        {'amplitude_2': FittedNumber(1.2345e-4, 'rad', 1.2e-4, 1.3e-4)},
        Evidence(812.5, 60.0, 'link_encoder_eccentricity', math.inf), gain)
    return Diagnosis(
        verdict, (finding, replace(finding, effect='payload', joint=None, site='link')),
        (Alike((('backlash', 'joint1'), ('clock_skew', 'joint1')), 'slow torque loops',
               (Candidate('backlash', 'joint1', {
                   'half_width': FittedNumber(4.321e-5, 'rad', 4.2e-5, 4.4e-5)}, False),
                Candidate('clock_skew', 'joint1', {
                    'skew': FittedNumber(8.765e-4, 's', 8.1e-4, 9.2e-4)}, True))),),
        Unexplained('motor', 'joint1', 'link_angle', 7.53, 0.12),
        (Detectable('payload', None, 0.0421, 'kg'), Detectable('backlash', 'joint1', None, 'rad')),
        TotalGain(3.1, 1.02, 1.0, 0.987, 0.981, 0.992, 'mean squared error', '1'),
        (Residual('motor', 'joint1', 1.04, 0.31, 0.3, 'N*m'),
         Residual('torsion', 'joint1', 1.04, 0.31, math.nan, 'N*m')),
        RecordingFacts(60.0, 60001, 1000.0, ((0.0, 2.0), (2.0, 4.0)), ((4.0, 6.0),)),
        f'arm {FREE_TEXT}.yaml', '0.1.0', 7.25, (f'38 of 39 effects {FREE_TEXT}',),
        (Prediction(0.05, 2.25e-4, 1.03e-4, 1e-4, 'rad'),))


class Reader(HTMLParser):
    """Collects text, attributes and elements that are left open."""

    VOID = ('meta', 'br', 'wbr')

    def __init__(self, text: str) -> None:
        """Read a whole page."""
        super().__init__()
        self.text, self.open, self.names = '', [], []
        self.attributes: list[tuple[str, str | None]] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        """Note an element."""
        self.names.append(tag)
        self.attributes += attrs
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        """Note an element without content."""
        self.names.append(tag)
        self.attributes += attrs

    def handle_endtag(self, tag):
        """Check that what closes was opened last."""
        assert self.open.pop() == tag

    def handle_data(self, data):
        """Note text."""
        self.text += data


@pytest.fixture(scope='module')
def drawn() -> dict[str, str]:
    """Return every figure of the diagnosis as SVG."""
    moved = coordinates(0)
    shown = exhibits_of(np.cos(2.0 * moved['motor_angle']), moved)
    shown = replace(shown, labels=(FREE_TEXT,))
    plain = diagnosis()
    here = replace(plain, findings=tuple(
        replace(found, joint=found.joint and FREE_TEXT) for found in plain.findings),
        unexplained=replace(plain.unexplained, joint=FREE_TEXT))
    return {name: inline_svg(figure, name) for name, figure in figures(here, shown).items()}


def test_every_part_of_a_diagnosis_is_drawn(drawn):
    assert list(drawn) == ['residuals', 'finding_1', 'finding_2', 'unexplained', 'prediction']


def test_figures_of_a_page_are_whole_and_share_no_names(drawn):
    names = [element.get('id') for svg in drawn.values()
             for element in ElementTree.fromstring(svg).iter() if element.get('id')]
    assert len(names) == len(set(names))
    for svg in drawn.values():
        used = re.findall(r'(?:href="#|url\(#)([^")]+)', svg)
        assert used
        assert set(used) <= set(names)


def test_figures_are_drawn_alike_every_time(drawn):
    moved = coordinates(0)
    shown = exhibits_of(moved['link_angle'], moved)
    first, second = ({name: inline_svg(figure, name)
                      for name, figure in figures(diagnosis(), shown).items()} for _ in range(2))
    assert first == second


@pytest.mark.parametrize('verdict', VERDICTS)
def test_page_says_all_that_a_diagnosis_holds(verdict):
    read = Reader(page(diagnosis(verdict), {}))
    assert read.open == []
    for said in (VERDICTS[verdict], 'kinematic_error', 'payload', 'the arm',
                 f'Transmission error {FREE_TEXT}. Site: torsion', f'arm {FREE_TEXT}.yaml',
                 '0.1234', '0.12 to 0.13', 'mrad', 'twice per motor turn',
                 'more than 1,000,000 to 1', 'link_encoder_eccentricity',
                 '98.7 % [98.1, 99.2]', 'slow torque loops',
                 'clock_skew', 'follows the link angle, strongest at 7.53 per link turn',
                 '0.0421 kg', 'cannot be shown by this motion', '60,001', '4 s: 0 to 4 s', '0.1.0',
                 f'38 of 39 effects {FREE_TEXT}', '0.05 s', '0.225', '0.103',
                 'a placebo of equal freedom 1.2 %', 'unknown'):
        assert said in read.text, said


def loaded(read: Reader) -> list[str | None]:
    """Return what a page would fetch from elsewhere."""
    return [value for name, value in read.attributes
            if name in ('src', 'href', 'xlink:href') and not str(value).startswith('#')]


def test_page_without_plots_needs_no_script(drawn):
    text = page(diagnosis(), drawn)
    read = Reader(text)
    assert read.open == []
    assert {'script', 'link', 'iframe', 'img', 'object'}.isdisjoint(read.names)
    assert loaded(read) == []
    assert not re.search(r'@import|url\((?!#)', text)
    assert read.names.count('figcaption') == 1 + len(drawn)         # the arm, and every figure


def test_page_shows_orders_that_were_chosen_with_every_other_number():
    cogging = replace(diagnosis().findings[0], effect='motor_cogging', parameters={
        'order': FittedNumber(14.0, '1/turn', 14.0, 14.0),
        'amplitude': FittedNumber(5.1e-3, 'N*m', 5.0e-3, 5.2e-3)})
    judged = replace(diagnosis(), findings=(cogging,))
    text = ' '.join(Reader(page(judged, {})).text.split())
    assert 'orderwaves per motor turn 14 chosen, not fitted 1/turn' in text
    assert '5.1 5 to 5.2 mN·m' in text
    assert 'order = 14 1/turn, amplitude = 0.0051 [0.005, 0.0052] N*m' in judged.sentences()[1]


def test_page_shows_sizes_of_all_that_look_alike_and_which_one_the_model_holds():
    read = Reader(page(diagnosis('ambiguous'), {}))
    for said in ('43.21', '42 to 44', 'µrad', '0.8765', '0.81 to 0.92', 'ms',
                 'clock_skew at joint1, which model.yaml holds'):
        assert said in read.text, said
    assert 'backlash at joint1, which' not in read.text


def test_page_of_a_healthy_arm_names_nothing():
    healthy = replace(diagnosis('no_discrepancy'), findings=(), ambiguous=(), unexplained=None)
    text = Reader(page(healthy, {})).text
    assert 'No cause is named' in text
    assert 'Causes' not in text
    assert 'cannot distinguish' not in text
    assert 'unexplained rest' not in text


def test_colours_of_ink_follow_the_page(drawn):
    for svg in drawn.values():
        assert 'currentColor' in svg
        assert '#000000' not in svg
