"""
What no effect of the catalogue explains is placed: where it sits, and what it follows.

Rests are made along a motion of two joints, on every site and along every coordinate; nothing may
be placed where there is nothing but noise, or where what is left follows nothing measured.
"""

from dataclasses import replace

from hda_torque_estimator.diagnosis.assumptions import EFFECTIVE
from hda_torque_estimator.diagnosis.balances.balance import Balancer
from hda_torque_estimator.diagnosis.findings.rest import NOTHING, Unexplained
from hda_torque_estimator.diagnosis.fitting.fit import Fitter
from hda_torque_estimator.diagnosis.fitting.hypotheses import terms_of
from hda_torque_estimator.diagnosis.judging.discrepancy_terms import DiscrepancyTerms
from hda_torque_estimator.diagnosis.judging.search import SearchResult
from hda_torque_estimator.diagnosis.judging.site_pattern import is_one_link_torque, misplaced
from hda_torque_estimator.diagnosis.reporting.following import follow
from hda_torque_estimator.diagnosis.reporting.unexplained import (described, Rest, site_of,
                                                                  unexplained)
import numpy as np
import pytest
from truth import draw
from truth.effect import Hidden
from truth_fits import ARM, measured

RATE, RATIO = 125.0, 100.0
LABELS = ('joint1', 'joint2')
NOISE = np.array([0.03, 0.03, 0.006, 0.006])
TIME = np.arange(0.0, 60.0, 1.0 / RATE)


def moved() -> dict[str, np.ndarray]:
    """Return the coordinates of two joints that move by waves of unrelated periods."""
    speeds = np.array([[0.31, 0.83, 1.97], [0.43, 1.13, 2.31]])
    sizes = np.array([[0.6, 0.2, 0.05], [0.7, 0.15, 0.04]])
    phase = speeds[..., None] * 2.0 * TIME + np.arange(3)[:, None]
    angle = (sizes[..., None] * np.sin(phase)).sum(axis=1).T
    rate = (2.0 * sizes * speeds)[..., None] * np.cos(phase)
    torque = -((2.0 * speeds) ** 2 * sizes)[..., None] * np.sin(phase)
    velocity, effort = rate.sum(axis=1).T, torque.sum(axis=1).T
    return {'motor_velocity': RATIO * velocity, 'link_velocity': velocity,
            'motor_angle': RATIO * angle, 'link_angle': angle, 'joint_torque': effort,
            'motor_torque': effort / RATIO + 0.04 * np.sign(velocity),
            'other_link_angle': angle[:, ::-1]}


MOTION = moved()
CURVES = {
    ('time', 4.3): lambda at: np.sin(2.0 * np.pi * 4.3 * TIME + 1.0),
    ('time', None): lambda at: TIME / 30.0 - 1.0,
    ('link_angle', None): lambda at: np.abs(at['link_angle']) - 0.4,
    ('link_angle', 7.0): lambda at: np.sin(7.0 * at['link_angle'] + 0.4),
    ('other_link_angle', None):
        lambda at: np.sin(2.0 * at['other_link_angle']) * np.sign(at['motor_velocity']),
    ('motor_angle', 3.0): lambda at: np.cos(3.0 * at['motor_angle']),
    ('joint_torque', None): lambda at: at['joint_torque'] ** 2 - 2.0,
}
SITES = {'motor': (1.0, 0.0), 'torsion': (0.0, 1.0), 'link': (1.0, 1.0)}


def left_by(site: str, place: int, values: np.ndarray, seed: int = 0) -> Rest:
    """Return the rest that values [N*m] at a site and joint leave, with the noise of sensors."""
    residual = NOISE * np.random.default_rng(seed).standard_normal((len(TIME), 4))
    residual[:, [place, 2 + place]] += np.outer(values, SITES[site])
    valid = np.ones(residual.shape, bool)
    valid[:, :2] = np.abs(MOTION['motor_velocity']) > 5.0     # friction is not known at rest
    return Rest(TIME, LABELS, residual, valid, NOISE, MOTION)


def at(place: int) -> dict[str, np.ndarray]:
    """Return the coordinates of one joint."""
    return {name: values[:, place] for name, values in MOTION.items()}


@pytest.mark.parametrize('place', [0, 1])
@pytest.mark.parametrize('site', SITES)
@pytest.mark.parametrize(('coordinate', 'line'), CURVES)
def test_every_site_and_coordinate_is_identified(coordinate, line, site, place):
    found = described(left_by(site, place, 0.5 * CURVES[coordinate, line](at(place))))
    assert found is not None
    assert (found.site, found.joint, found.depends_on) == (site, LABELS[place], coordinate)
    assert found.line == (None if line is None else pytest.approx(line, abs=0.02))
    assert 0.7 < found.share <= 1.0


@pytest.mark.parametrize('site', SITES)
@pytest.mark.parametrize('size', [0.15, 0.5, 5.0])
def test_the_site_does_not_hang_on_the_size(site, size):
    rest = left_by(site, 1, size * CURVES['link_angle', 7.0](at(1)))
    assert site_of(rest, 1) == site


def test_a_stiffness_along_the_angle_is_described_by_the_angle_that_it_follows():
    values = 0.2 * at(0)['joint_torque'] * np.sin(4.0 * at(0)['link_angle'])
    found = described(left_by('torsion', 0, values))
    assert (found.site, found.depends_on) == ('torsion', 'link_angle')
    first = follow(TIME, values, np.ones(len(TIME), bool), at(0))[0]
    assert first.carrier == 'torque'


def test_a_torsion_that_follows_the_speed_is_a_matter_of_timing():
    values = 0.3 * MOTION['link_velocity'][:, 0]
    assert described(left_by('torsion', 0, values)).site == 'timing'
    assert described(left_by('link', 0, values)).site == 'link'
    assert described(left_by('motor', 0, values)).site == 'motor'


def test_what_loads_every_joint_belongs_to_the_arm():
    wave = CURVES['time', 4.3](None)
    one = left_by('link', 0, wave)
    assert described(one).joint == 'joint1'
    both = one.residual.copy()
    both[:, [1, 3]] += 0.6 * wave[:, None]
    assert described(one._replace(residual=both)).joint is None


@pytest.mark.parametrize('seed', range(5))
def test_noise_is_no_rest(seed):
    assert described(left_by('link', 0, np.zeros(len(TIME)), seed)) is None


@pytest.mark.parametrize('seed', range(5))
def test_a_rest_that_follows_nothing_measured_is_said_to(seed):
    wild = np.random.default_rng(seed + 50).standard_normal(len(TIME))
    found = described(left_by('torsion', 0, wild, seed))
    assert (found.site, found.joint, found.depends_on) == ('torsion', 'joint1', NOTHING)
    assert found.line is None
    assert found.share < 0.1


def test_the_share_counts_what_is_left_elsewhere():
    one = left_by('motor', 0, CURVES['time', 4.3](None))
    two = one.residual.copy()
    two[:, 1] += 0.5 * CURVES['link_angle', 7.0](at(1))
    alone, among = described(one), described(one._replace(residual=two))
    assert (among.joint, among.depends_on) == ('joint1', 'time')
    assert among.share == pytest.approx(0.8 * alone.share, abs=0.03)


@pytest.mark.parametrize('columns', [(0,), (2,), (0, 1)])
def test_columns_that_hold_nowhere_are_left_out(columns):
    rest = left_by('link', 1, CURVES['time', 4.3](None))
    rest.valid[:, list(columns)] = False
    found = described(rest)
    assert (found.joint, found.depends_on) == ('joint2', 'time')


@pytest.mark.parametrize(('rest', 'said'), [
    (Unexplained('torsion', 'joint1', 'link_angle', 7.0, 0.9), '90 % of the rest sits in the '
     'torsion of joint1 and follows the link angle, strongest at 7 per link turn'),
    (Unexplained('motor', 'joint2', 'motor_angle', 3.0, 0.5), '3 per motor turn'),
    (Unexplained('link', None, 'time', 4.25, 1.0), 'the link of the arm and follows time, '
     'strongest at 4.25 Hz'),
    (Unexplained('torsion', 'joint1', NOTHING, None, 0.02), 'follows nothing that was measured')])
def test_the_sentence_says_all_with_its_unit(rest, said):
    assert said in rest.sentence()


@pytest.fixture(scope='module')
def sprung() -> Fitter:
    """Return the fitter of a record with a cubic spring at joint 1, which no catalogue lists."""
    hidden = draw('cubic_spring', np.random.default_rng(5))
    return fitter_of(replace(hidden, parameters={'coefficient': 6.0, 'centre': 0.25}))


def fitter_of(hidden: Hidden) -> Fitter:
    """Return what fits 30 s of an arm with one hidden effect."""
    balancer = Balancer(measured([hidden], 30.0, 120))
    return Fitter(balancer, ARM, NOISE, EFFECTIVE, np.ones(len(balancer.time), bool))


def test_an_unknown_spring_is_placed_with_or_without_a_wrong_cause(sprung):
    first = sprung.fit(())
    wrong = sprung.fit([next(terms_of(ARM, 'link_encoder_eccentricity'))], first.nuisance)
    found = SearchResult(first, wrong, ())
    for fit in (first, found.with_only(sprung, ())):
        rest = unexplained(sprung, fit)
        assert (rest.site, rest.joint, rest.depends_on) == ('link', 'joint1', 'link_angle')
        assert rest.share > 0.7
    assert misplaced(sprung, found) == wrong.accepted


def test_a_right_cause_leaves_nothing_and_stands():
    hidden = draw('link_encoder_eccentricity', np.random.default_rng(5))
    fitter = fitter_of(hidden)
    start = next(term for term in terms_of(ARM, hidden.effect) if term.joint == hidden.joint)
    first = fitter.fit(())
    right = fitter.fit([start], first.nuisance)
    before = unexplained(fitter, first)
    assert (before.site, before.joint) == ('torsion', hidden.joint)
    assert unexplained(fitter, right) is None
    assert misplaced(fitter, SearchResult(first, right, ())) == ()
    skew = next(term for term in terms_of(ARM, 'clock_skew') if term.joint == hidden.joint)
    assert misplaced(fitter, SearchResult(first, fitter.fit([skew], first.nuisance), ())) == ()


def test_a_friction_of_the_link_without_a_name_is_seen_in_both_balances():
    hidden = draw('link_bearing_friction', np.random.default_rng(7))
    fitter = fitter_of(hidden)
    best = DiscrepancyTerms.along(fitter).best(fitter, fitter.first, LABELS)
    assert (best.joint, best.site, best.coordinate) == (hidden.joint, 'link', 'motor_velocity')
    assert best.form == 'sense'


@pytest.mark.parametrize('seed', range(3))
def test_one_torque_at_the_link_is_told_from_what_acts_beside_it(seed):
    of_link = ('cable_spring', 'link_bearing_friction')
    for effect in (*of_link, 'encoder_scale_error', 'coulomb_friction', 'stiffness_error'):
        hidden = draw(effect, np.random.default_rng(seed))
        fitter = fitter_of(hidden)
        nothing = SearchResult(fitter.first, fitter.first, ())
        alike = {label for label in LABELS if is_one_link_torque(fitter, nothing, label)}
        assert alike == ({hidden.joint} if effect in of_link else set())
