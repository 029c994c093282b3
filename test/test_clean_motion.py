"""A twin follows the motion of a recording and none of its noise."""

from hda_torque_estimator.diagnosis.balances.clean_motion import CleanMotion
from hda_torque_estimator.diagnosis.fitting.hypotheses import terms_of
import numpy as np
import pytest
from truth import worlds
from world_fits import fitter_of

RATE = 250.0            # of the readings here [Hz]
NOISE = 1e-5            # of their angles [rad]
QUIET = np.array([NOISE])


def read(time, shake=0.0):
    """Return angles of a slow motion that may shake at 30 Hz, as they are and as they are read."""
    angle = np.sin(2.0 * np.pi * 0.7 * time) + 0.3 * np.sin(2.0 * np.pi * 1.9 * time)
    angle += shake * np.sin(2.0 * np.pi * 30.0 * time)
    random = np.random.default_rng(5)
    return angle[:, None], (angle + NOISE * random.standard_normal(len(time)))[:, None]


def acceleration(angle):
    """Return the second differences of angles over time, away from the ends [rad/s^2]."""
    return np.diff(angle[:, 0], 2)[200:-200] * RATE ** 2


def test_a_slow_motion_is_as_it_was_without_its_noise():
    angle, reading = read(np.arange(5000) / RATE)
    clean = CleanMotion(reading, QUIET, 1.0 / RATE, 1.0 / RATE).angles(reading)
    left, noise = (acceleration(each) - acceleration(angle) for each in (clean, reading))
    assert left.std() < 0.02 * noise.std()
    assert np.abs(clean - angle).max() < 5e-4


def test_a_shaking_that_is_far_above_noise_is_followed():
    angle, reading = read(np.arange(5000) / RATE, shake=100.0 * NOISE)
    clean = CleanMotion(reading, QUIET, 1.0 / RATE, 1.0 / RATE).angles(reading)
    left, noise = (acceleration(each) - acceleration(angle) for each in (clean, reading))
    assert left.std() < 0.1 * noise.std()


def test_an_arm_that_shakes_at_all_high_frequencies_is_followed():
    """Of a log of 100 Hz, half of whose frequencies are those of an arm on a soft gear."""
    angle, reading = read(np.arange(5000) / RATE)
    shaking = 100.0 * NOISE * np.random.default_rng(3).standard_normal(angle.shape)
    clean = CleanMotion(reading + shaking, QUIET, 1.0 / RATE, 1.0 / RATE).angles(angle + shaking)
    left, noise = (acceleration(each) - acceleration(angle) for each in (clean, angle + shaking))
    assert left.std() > 0.9 * noise.std()


def test_between_readings_rates_are_those_of_the_angles():
    time = np.arange(20000) / (4.0 * RATE)
    angle, _ = read(time)
    clean = CleanMotion(read(time[::4])[1], QUIET, 1.0 / RATE, 0.25 / RATE)
    rate = np.gradient(angle, time, axis=0)
    made = np.gradient(clean.angles(angle), time, axis=0)
    assert np.abs(clean.rates(rate) - made)[4:-4].max() < 1e-3 * np.abs(rate).max()


def test_any_time_between_readings_will_do():
    for dt in np.random.default_rng(7).uniform(0.9e-3, 1.1e-3, 200):
        angle = read(np.arange(1500) * dt)[1]
        assert np.isfinite(CleanMotion(angle, QUIET, dt, dt).angles(angle)).all()


@pytest.mark.parametrize('readings', [1, 3, 100])
def test_of_a_short_recording_all_is_followed(readings):
    angle = read(np.arange(readings) / RATE)[1]
    clean = CleanMotion(angle, QUIET, 1.0 / RATE, 1.0 / RATE)
    np.testing.assert_array_equal(clean.angles(angle), angle)
    np.testing.assert_array_equal(clean.rates(angle), angle)


def test_a_payload_in_a_slow_log_is_not_read_too_small():
    """Beside a twin that followed the noise it was read as 0.49 of 0.62 kg."""
    world = worlds.draw(799637, ('payload',), motion='rich', rate=250, form='')
    fitter = fitter_of(world)
    term = next(iter(terms_of(fitter.arm, 'payload')))
    fit = fitter.refined(fitter.refit(fitter.first, term))
    mass, true = fit.accepted[0].effect.mass, world.hidden[0].parameters['mass']
    assert abs(mass / true - 1.0) < 0.06
