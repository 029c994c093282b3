"""A fit gains nothing by making a balance smaller: columns of tolerated numbers have no noise."""

from dataclasses import replace

from hda_arm_sim.model.files import read_arm
from hda_torque_estimator.diagnosis.assumptions import EFFECTIVE
from hda_torque_estimator.diagnosis.balances.balance import Balancer
from hda_torque_estimator.diagnosis.balances.healthy_twin import healthy_twin, noise_of
from hda_torque_estimator.diagnosis.fitting.column_noise import ColumnNoise, projection
from hda_torque_estimator.diagnosis.fitting.fit import deviations, Fitter
from hda_torque_estimator.diagnosis.fitting.hypotheses import terms_of
from hda_torque_estimator.diagnosis.fitting.nuisance import nuisances
from hda_torque_estimator.diagnosis.fitting.slopes import has_noise, of_noise
from hda_torque_estimator.measurements.sample_grid import measurement_from
import numpy as np
import pytest
from truth_samples import published

OWN = read_arm('hda_arm.yaml')
ARM = replace(OWN, tolerances=replace(
    OWN.tolerances, stiffness=0.05, link_inertia=0.05, torque_constant=0.02))
SCALING = {'torque_constant_error', 'stiffness_error', 'link_inertia_error'}


@pytest.fixture(scope='module')
def fitter():
    """Return what fits a healthy arm of coarse encoders, known roughly, beside a twin."""
    balancer = Balancer(measurement_from(ARM.labels, published(ARM, [], 910, noise=30.0)))
    twin = balancer.like(healthy_twin(balancer, ARM, 1))
    return Fitter(balancer, ARM, noise_of(balancer, ARM)[0], EFFECTIVE,
                  np.ones(len(balancer.time), bool), twin)


def standing(fitter):
    """Return where a fit leaves the numbers that scale balances, in their tolerances."""
    fit, place, found = fitter.first, 0, []
    away = fitter.away(fit.terms) / deviations(fit.terms)
    for term in fit.terms:
        found += list(away[place:place + term.size]) if term.name in SCALING else []
        place += term.size
    return np.array(found)


def test_numbers_do_not_run_to_the_ends_of_their_tolerances(fitter):
    with_noise, quiet = standing(replace(fitter, twin=None)), standing(fitter)
    assert np.mean(with_noise) < -2.0
    assert abs(np.mean(quiet)) < 0.5 * abs(np.mean(with_noise))
    assert np.abs(quiet).max() < 2.0


def test_what_links_carry_is_as_noisy_by_each_of_its_laws(fitter):
    """A law whose columns kept their noise would fit worse than a point, which it contains."""
    laws = list(terms_of(ARM, 'payload'))
    assert [law.size for law in laws] == [1, 2, 3]
    assert all(has_noise(law, fitter.fit([law]).slopes.noise) for law in laws)


def test_a_smaller_balance_is_as_noisy(fitter):
    """All numbers that scale balances go down together by two tolerances."""
    noise = fitter.first.slopes.noise
    less = [term.at(term.vector() - 2.0 * term.deviations()) if term.name in SCALING else term
            for term in nuisances(ARM)]
    valid = fitter.valid(fitter.balancer(ARM))

    def power(residual):
        fast = np.where(valid, residual - np.roll(residual, 1, axis=0), 0.0)
        return (fast ** 2).sum(axis=0)

    as_given = power(fitter.balancer(ARM).residual)
    smaller = power(fitter.balancer(fitter.on(less)).residual)
    assert (smaller[2:] < 0.9 * as_given[2:]).all()         # a motor's inertia has no tolerance
    assert np.allclose(power(fitter.residual(less, noise)), as_given, rtol=0.05)


@pytest.mark.parametrize('late', [0, 20])
def test_noise_of_columns_is_found_with_a_twin_that_moves_otherwise_too(late):
    """What is left of the noise of columns goes with that of the rest no more."""
    random, time = np.random.default_rng(6), np.arange(6000) / 125.0
    motion = np.sin(time) + np.sin(2.3 * time)
    noise, other, again = 0.01 * random.standard_normal((3, 6000, 2, 1))
    columns = motion[:, None, None] * np.ones((1, 2, 1)) + noise
    twin = np.roll(motion, late)[:, None, None] * np.ones((1, 2, 1)) + other
    term, valid = nuisances(ARM)[0], np.ones((6000, 2), bool)
    known = ColumnNoise.made([term], twin, again, 0.8 * again[:, :, 0], valid,
                             np.array([True, False]))
    rest = 0.8 * noise[:, :, 0]
    found, = known.noise_in([term], columns, rest, valid, np.full((6000, 2), 1.0 / 0.008)).values()
    along = (rest[:, :, None] * (noise - found)).sum(axis=(0, 2))
    assert (np.abs(along) < 0.1 * (rest[:, :, None] * noise).sum(axis=(0, 2))).all()
    assert np.sqrt(np.mean(found ** 2)) < 1.5 * 0.01


def test_what_a_twin_explains_is_the_projection_onto_its_columns():
    random = np.random.default_rng(4)
    twin, columns = random.standard_normal((60, 2, 3)), random.standard_normal((60, 2, 2))
    weight = random.uniform(0.0, 2.0, (60, 2))
    flat = [(some * weight[:, :, None]).reshape(120, -1) for some in (twin, columns)]
    shares = np.linalg.lstsq(*flat, rcond=None)[0]
    assert np.allclose(projection(columns, twin, weight), twin @ shares)
    assert np.allclose(projection(twin[:, :, :2], twin, weight), twin[:, :, :2])


def test_a_column_that_shows_nowhere_determines_nothing():
    twin = np.zeros((20, 2, 2))
    twin[:, 0, 0] = 1.0
    reported = projection(np.ones((20, 2, 1)), twin, np.ones((20, 2)))
    assert np.allclose(reported[:, 0], 1.0) and (reported[:, 1] == 0.0).all()


def test_a_balance_that_no_row_of_a_fit_holds_has_noise_as_well():
    random, valid = np.random.default_rng(8), np.ones((600, 2), bool)
    columns, twin, again = 1.0 + 0.1 * random.standard_normal((3, 600, 2, 1))
    term, weight = nuisances(ARM)[0], np.full((600, 2), 10.0)
    weight[:, 0], columns[:5] = 0.0, np.nan
    valid[:5] = weight[:5] = False
    known = ColumnNoise.made([term], twin, again - 1.0, again[:, :, 0] - 1.0, valid,
                             np.array([True, False]))
    found, = known.noise_in([term], columns, twin[:, :, 0] - 1.0, valid, weight).values()
    assert np.isfinite(found).all() and found.std() > 0.01


def test_only_numbers_with_a_tolerance_have_noise(fitter):
    fit = fitter.first
    known = {term.name for term in fit.terms if has_noise(term, fit.slopes.noise)}
    assert known >= SCALING and 'encoder_zero' not in known
    zero, = (term for term in nuisances(ARM) if term.place == ('encoder_zero', ARM.labels[0]))
    assert of_noise(zero, ARM, fit.slopes.noise) == 0.0
    own = nuisances(ARM)[0]
    assert (of_noise(own, ARM, fit.slopes.noise) == 0.0).all()
