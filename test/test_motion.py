"""The motion behind readings: without delay, at the stamp, and whole in the balances' band."""

from dataclasses import replace

from hda_arm_sim.model.effects import ClockSkew
from hda_arm_sim.model.files import read_arm
from hda_torque_estimator.measurements.measurement import Measurement
from hda_torque_estimator.measurements.motion import jolts, motion_of, SHORT
import numpy as np
import pytest

ARM = read_arm('hda_arm.yaml')
DT, INNER = 1e-3, slice(50, -50)
TIME = DT * np.arange(2000)


def measured(frequency, late=0.0):
    """Return readings of links that swing at a frequency [Hz], the link encoders late [s]."""
    motor, link = (0.3 * np.sin(2.0 * np.pi * frequency * (TIME + shift))
                   for shift in (0.0, late))
    reading = np.stack([100.0 * motor, link], axis=1)
    return Measurement(ARM.labels, DT, np.repeat(reading[:, None], 2, axis=1),
                       np.zeros((len(TIME), 2)))


def swinging(frequency, order):
    """Return a derivative of the links' swing at the ticks."""
    pace = 2.0 * np.pi * frequency
    return 0.3 * pace ** order * np.sin(pace * TIME + 0.5 * np.pi * order)[INNER]


def of_link(motion):
    """Return angle, velocity and acceleration of the first link."""
    return *motion.state[INNER, 0, 2:4].T, motion.acceleration[INNER, 0, 1]


@pytest.mark.parametrize(('window', 'least'), [({}, 0.95), ({'window': SHORT}, 0.998)])
def test_accelerations_pass_a_window(window, least):
    reported = motion_of(measured(40.0), ARM, **window).acceleration[INNER, 0, 1]
    true = swinging(40.0, 2)
    assert least < (reported @ true) / (true @ true) < 1.0


@pytest.mark.parametrize('skew', [3e-4, -2e-4])
def test_everything_is_taken_at_the_stamp(skew):
    late = measured(3.0, late=skew)
    taken, unmoved = (motion_of(late, arm, SHORT) for arm in (
        ARM.with_effect(ClockSkew(skew=skew), 'joint1'), ARM))
    for order, (reported, off) in enumerate(zip(of_link(taken), of_link(unmoved))):
        true = swinging(3.0, order)
        assert np.abs(reported - true).max() < 1e-4 * np.abs(true).max()
        assert np.abs(off - true).max() > 1e-3 * np.abs(true).max()


@pytest.mark.parametrize(('size', 'marked'), [(0.0, False), (0.01, False), (1.0, True)])
def test_only_a_jolt_is_taken_for_one(size, marked):
    """A link is stopped within two samples; `size` is how fast it was [rad/s]."""
    made = measured(2.0)
    noise = 4e-7 * np.random.default_rng(1).standard_normal(made.reading.shape)
    stopped = size * np.minimum(TIME - TIME[1000], 0.0)
    jolted = jolts(replace(made, reading=made.reading + noise + stopped[:, None, None]))
    assert jolted[990:1010].any() == marked
    assert not jolted[20:950].any() and not jolted[1050:-20].any()
