"""Other forms of a law, what chance buys, and how noisy a balance is."""

from dataclasses import replace

from hda_arm_sim.model.files import read_arm
from hda_torque_estimator.diagnosis.balances.balance import Balancer
from hda_torque_estimator.diagnosis.balances.healthy import (
    healthy_twin, noise_of, torque_noise_of)
from hda_torque_estimator.diagnosis.diagnose import EFFECTIVE
from hda_torque_estimator.diagnosis.fitting.alignment import aligned
from hda_torque_estimator.diagnosis.fitting.fit import Fitter
from hda_torque_estimator.diagnosis.fitting.hypotheses import terms_of
from hda_torque_estimator.diagnosis.judging.chance import by_chance
from hda_torque_estimator.diagnosis.judging.forms import evidence, reformed
from hda_torque_estimator.measurements.finer import finer
from hda_torque_estimator.measurements.measurement import measurement_from
import numpy as np
import pytest
from truth import TruthError, worlds
from truth.logs import Logger
from world_samples import arm_of, logged


def fitter_of(world):
    """Return what fits the record of a world, with a twin that is as noisy."""
    arm = arm_of(world)
    balancer = Balancer(aligned(finer(measurement_from(arm.labels, logged(world, arm))), arm))
    noise, plain = noise_of(balancer, arm)
    twin = healthy_twin(balancer, arm, 2, torque_noise_of(noise, plain, balancer, arm))
    return Fitter(balancer, arm, noise, EFFECTIVE, np.ones(len(balancer.time), bool),
                  Balancer(twin))


def fitted(fitter, name):
    """Return the best fit with an effect at the first joint."""
    trials = [fitter.refit(fitter.first, term) for term in terms_of(fitter.arm, name)
              if term.joint in (None, fitter.arm.labels[0])]
    return fitter.refined(min(trials, key=lambda trial: trial.score))


@pytest.mark.parametrize(('seed', 'motion', 'rate'), [
    (721001, 'rich', 200), (721002, 'fourier', 1000), (721003, 'sine', 125),
    (721004, 'rich', 500), (721005, 'chirp', 250)])
def test_a_healthy_arm_leaves_the_noise_that_its_readings_tell(seed, motion, rate):
    world = worlds.draw(seed, motion=motion, rate=rate, seconds=20.0)
    world = replace(world, logger=world.logger._replace(jitter=0.0))
    fitter = fitter_of(world)
    fit = fitter.first
    left = np.array([np.sqrt(np.mean(column[valid] ** 2)) for column, valid in
                     zip(fit.balance.residual.T, fit.balance.valid.T)])
    assert (0.6 * fitter.noise < left).all() and (left < 1.7 * fitter.noise).all()


def clear(effect, form):
    """Return a fitter and the fit of the first world in which a law of one form is not enough."""
    for seed in range(722001, 722012):
        try:
            world = worlds.draw(seed, (effect,), form=form, motion='rich', rate=1000, joints=1,
                                seconds=20.0)
        except TruthError:
            continue
        fitter = fitter_of(replace(world, controller=1000, logger=Logger()))
        fit = fitted(fitter, effect)
        if rest(fitter, fit) > 1.0:
            return fitter, fit
    raise AssertionError(f'{effect} {form} is one form with the library in every world')


def rest(fitter, fit):
    """Return the power left beyond noise, in powers of noise, where most is left."""
    return max(float((fit.variance / fitter.noise ** 2).max()) - 1.0, 0.0)


@pytest.mark.parametrize(('effect', 'form', 'other'), [
    ('link_bearing_friction', 'wide', 'torque_constant_error'),
    ('stribeck_friction', 'one_way', 'load_dependent_friction')])
def test_another_form_of_a_law_leaves_less_and_another_law_does_not(effect, form, other):
    fitter, right = clear(effect, form)
    wrong = fitted(fitter, other)
    better = rest(fitter, reformed(fitter, right))
    assert better < 0.5 * rest(fitter, right)
    assert better < 0.5 * rest(fitter, reformed(fitter, wrong))
    assert evidence(fitter, right) < evidence(fitter, wrong)


def test_a_law_that_follows_noise_gains_as_much_on_a_healthy_twin():
    """A recorded command with noise that the motor never felt makes a lag look right."""
    world = worlds.draw(400015, ('stribeck_friction',), motion='rich', rate=1000)
    fitter = fitter_of(world)
    lag = next(term for term in terms_of(fitter.arm, 'current_loop_lag')
               if term.joint == fitter.arm.labels[1])
    assert by_chance(fitter, lag) > 300.0
    silent = replace(fitter, twin=Balancer(healthy_twin(fitter.balancer, fitter.arm, 2)))
    assert by_chance(silent, lag) < 60.0


def test_without_a_twin_nothing_is_chance():
    arm = read_arm('hda_arm.yaml')
    world = worlds.draw(722003, motion='rich', rate=1000, joints=1, seconds=6.0)
    fitter = replace(fitter_of(world), twin=None)
    assert by_chance(fitter, next(iter(terms_of(arm, 'current_loop_lag')))) == 0.0
