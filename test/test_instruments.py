"""Numbers of a noisy recording are free of the bias that noise gives least squares."""

from hda_arm_sim.model.files import read_arm
from hda_torque_estimator.diagnosis.assumptions import EFFECTIVE
from hda_torque_estimator.diagnosis.balances.balance import Balancer
from hda_torque_estimator.diagnosis.balances.healthy_twin import healthy_twin, noise_of
from hda_torque_estimator.diagnosis.fitting.fit import Fitter
from hda_torque_estimator.diagnosis.fitting.instruments import unbiased
from hda_torque_estimator.diagnosis.fitting.solve import condense, covariance
from hda_torque_estimator.measurements.sample_grid import measurement_from
import numpy as np
from truth_numbers import scattered
from truth_samples import published

ARM = read_arm('hda_arm.yaml')
SEEDS = (910, 911, 912)
NAMES = {'torque_constant_error': 'gain', 'stiffness_error': 'stiffness'}


def fitted(seed):
    """Return the fitter of a healthy arm with doubled noise, its fit, and that freed of bias."""
    samples = published(ARM, [], seed, noise=2.0)
    balancer = Balancer(measurement_from(ARM.labels, samples))
    fitter = Fitter(balancer, ARM, noise_of(balancer, ARM)[0], EFFECTIVE,
                    np.ones(len(balancer.time), bool))
    fit = fitter.fit(())
    twin = Balancer(healthy_twin(balancer, fitter.on(fit.terms), 1))
    return fitter, fit, unbiased(fitter, fit, twin)


def off(fitter, fit, seed):
    """Return by how many deviations torque constants and stiffnesses are estimated too large."""
    spread, errors, place = np.sqrt(np.diag(fitter.covariance(fit))), [], 0
    for term in fit.terms:
        if term.name in NAMES:
            true = scattered(seed)[NAMES[term.name]][ARM.labels.index(term.joint)] - 1.0
            errors.append((term.vector()[0] - true) / spread[place])
        place += term.size
    return errors


def test_instruments_take_the_bias_of_noise_away():
    plain, free = [], []
    for seed in SEEDS:
        fitter, before, after = fitted(seed)
        plain.append(off(fitter, before, seed))
        free.append(off(fitter, after, seed))
        assert (after.variance < 1.01 * before.variance).all()
        assert [(term.name, term.joint) for term in after.terms] == [
            (term.name, term.joint) for term in before.terms]
    assert np.mean(plain) < -1.5
    assert abs(np.mean(free)) < 0.5 * abs(np.mean(plain))
    assert np.sqrt(np.mean(np.square(free))) < 1.5


def test_a_number_that_changes_nothing_any_more_ends_no_fit():
    """A cause at its bound has a column of zeros; what else is fitted is as sure as without it."""
    random = np.random.default_rng(3)
    columns = random.standard_normal((500, 2, 3))
    columns[:, :, 1] = 0.0
    valid, free = np.ones((500, 2), bool), np.full(3, np.inf)
    residual, variance = random.standard_normal((500, 2)), np.ones(2)
    whole = covariance(condense(residual, columns, valid), variance, 1.0, free)
    rest = covariance(condense(residual, columns[:, :, [0, 2]], valid), variance, 1.0, free[:2])
    assert (whole[1] == 0.0).all()
    assert np.allclose(whole[np.ix_([0, 2], [0, 2])], rest, rtol=1e-9)
