"""Arms are compared as if all made as much noise: of readings, of commands and of torques."""

from dataclasses import replace

from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import motion
from hda_torque_estimator.diagnosis.balances.balance import Balancer
from hda_torque_estimator.diagnosis.balances.healthy_twin import torque_response, TorqueNoise
from hda_torque_estimator.diagnosis.fitting.hypotheses import terms_of
from hda_torque_estimator.diagnosis.judging.equal_noise import (
    _less_noise, equal_noise_score, noise_in, NoisePower)
from hda_torque_estimator.measurements.measurement import Measurement
from hda_torque_estimator.simulating.closed_loop import run
import numpy as np
import pytest
from truth import worlds
from world_fits import fitter_of

ARM = read_arm('hda_arm.yaml')
LABEL = ARM.labels[0]
SIGMA = 0.01            # of the first motor's torque, each sample [N*m]


def test_torque_noise_is_in_the_balances_of_an_arm_as_it_was_given():
    balancer = _balancer()
    more, rows = balancer.beside_torque_noise, balancer(ARM).valid.all(axis=1)
    left = (more(ARM).residual - balancer(ARM).residual)[rows]
    given = balancer.filtered(_drawn(balancer, 3))[rows, 0] * ARM.joints[0].ratio
    assert np.corrcoef(left[:, 0], given)[0, 1] > 0.97
    assert left[:, 0].std() == pytest.approx(given.std(), rel=0.05)
    assert (left[:, 1:].std(axis=0) < 0.2 * given.std()).all()


@pytest.mark.parametrize(('name', 'error', 'least', 'most'), [
    ('motor_inertia_error', 0.3, 1.1, 1.69),
    ('torque_constant_error', -0.3, 0.49, 0.95)])
def test_it_is_as_loud_as_what_answers_it(name, error, least, most):
    """Inertia answers torques that are quick, commands of the loop answer those that are slow."""
    balancer = _balancer()
    other = ARM.with_effect(replace(ARM.effect(name, LABEL), error=error), LABEL)
    made = [np.var((balancer.beside_torque_noise(arm).residual - balancer(arm).residual)[
        balancer(ARM).valid[:, 0], 0]) for arm in (ARM, other)]
    assert least < made[1] / made[0] < most


def test_without_torque_noise_nothing_answers():
    balancer = _balancer()
    assert torque_response(balancer, ARM, 3, TorqueNoise.none(2)) is None
    assert balancer.knowing(None).beside_torque_noise is None


def test_a_torque_constant_is_not_a_payload_because_that_makes_more_noise():
    """
    By its readings it makes 27 % more. They are a third of the noise of that motor's torque.

    27 % of all of it were taken off what it leaves, of more noise than there was in the end.
    """
    fitter = fitter_of(worlds.draw(810409, ('torque_constant_error',), motion='rich', rate=1000,
                                   form=''))
    usual = noise_in(fitter, fitter.first)
    right, wrong = (fitter.refined(min(
        (fitter.refit(fitter.first, term) for term in terms_of(fitter.arm, name)),
        key=lambda fit: fit.score)) for name in ('torque_constant_error', 'payload'))
    assert right.accepted[0].joint == 'joint2'
    lead = equal_noise_score(fitter, wrong, usual) - equal_noise_score(fitter, right, usual)
    assert lead > 0.9 * (wrong.score - right.score)     # 0.72 of it were left


def test_noise_of_torques_is_no_more_than_what_is_left():
    """However loud it was thought to be, none of that makes an arm with more of it the better."""
    thought = NoisePower(np.array([0.3]), np.array([0.7]))
    more = NoisePower(np.array([0.3]), np.array([1.4 * 0.7]))
    assert _less_noise(more, thought, np.array([2.0])) == pytest.approx(-0.4 * 0.7)
    assert _less_noise(more, thought, np.array([0.5])) == pytest.approx(-0.2 * 0.4 / 1.4)
    assert _less_noise(more, thought, np.array([0.2])) == pytest.approx(0.0)


def test_noise_of_readings_is_known_however_little_is_left():
    """A link of a third of its mass made a seventh of the noise of coarse readings (810504)."""
    usual = NoisePower(np.array([0.59]), np.array([0.37]))
    light = NoisePower(np.array([0.093]), np.array([0.245]))
    left, before = 0.153, 0.672
    assert left + _less_noise(light, usual, np.array([left])) == pytest.approx(before, abs=0.02)


def _balancer() -> Balancer:
    """Return balances of a healthy arm, and what noise of its first motor makes of them."""
    asked = motion('rich', 2, 10.0, 1e-3, 7)
    made = run(ARM, ARM, asked, 7, estimator=None)
    balancer = Balancer(Measurement(ARM.labels, 1e-3, made.reading[:, :, :2].copy(),
                                    made.command))
    return balancer.knowing(torque_response(
        balancer, ARM, 3, TorqueNoise(np.array([SIGMA, 0.0]), np.zeros(2))))


def _drawn(balancer: Balancer, seed: int) -> np.ndarray:
    """Return the noise (k, 2) of the motors as `torque_response` draws it."""
    drawn = np.random.default_rng(seed).standard_normal(balancer.measurement.command.shape)
    return drawn * np.array([SIGMA, 0.0])
