"""Noise of balances is made white, slow motion passes as it is, and what is filtered is marked."""

from hda_arm_sim.model.effects import Backlash
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import motion
from hda_torque_estimator.diagnosis.balances.balance import Balancer, BANDWIDTH, RATE
from hda_torque_estimator.diagnosis.balances.whitening import whitening_of
from hda_torque_estimator.diagnosis.diagnose import diagnose
from hda_torque_estimator.diagnosis.fitting.hypotheses import terms_of
from hda_torque_estimator.measurements.sample_grid import measurement_from
from hda_torque_estimator.measurements.upsampling import finer
from hda_torque_estimator.simulating.closed_loop import run
from hda_torque_estimator.simulating.recorded import joint_samples
import numpy as np
import pytest
from scipy.signal import welch
from truth import worlds
from world_samples import as_read

SAMPLES = 20_000
TIME = np.arange(SAMPLES) / RATE
NONE = np.zeros(1)


def coloured(seed: int, corner: float) -> np.ndarray:
    """Return noise (m, 1) that rises as second differences do above a corner [Hz]."""
    spectrum = np.fft.rfft(np.random.default_rng(seed).standard_normal(SAMPLES))
    frequency = np.fft.rfftfreq(SAMPLES, 1.0 / RATE)
    return np.fft.irfft(spectrum * (1.0 + (frequency / corner) ** 2), SAMPLES)[:, None]


def levels(noise, bands):
    """Return the density of noise (m, 1) within bands of frequency [Hz]."""
    frequency, power = welch(noise[:, 0], RATE, nperseg=256)
    return np.array([np.sqrt(power[(frequency >= low) & (frequency < high)].mean())
                     for low, high in bands])


@pytest.mark.parametrize('seed', range(920100, 920104))
def test_white_noise_needs_no_filter(seed):
    white = np.random.default_rng(seed).standard_normal((SAMPLES, 2))
    assert whitening_of(white, np.zeros(2), RATE, BANDWIDTH) is None
    assert whitening_of(white[:100], np.zeros(2), RATE, BANDWIDTH) is None   # too short


@pytest.mark.parametrize('corner', [5.0, 10.0, 20.0])
def test_what_is_quick_and_loud_becomes_as_loud_as_what_is_slow(corner):
    noise = coloured(920110, corner)
    whitening = whitening_of(noise, NONE, RATE, BANDWIDTH)
    bands = [(0.0, 5.0), (10.0, 20.0), (25.0, 40.0)]
    before, after = levels(noise, bands), levels(whitening.of(noise, 0), bands)
    assert before[2] > 2.0 * before[0]
    assert after / before[0] == pytest.approx(1.0, abs=0.25)


def test_what_is_loud_at_rest_alone_has_the_longest_filter():
    """A frequency of zero has no period, so the cap of the filter's length is all that counts."""
    slow = 100.0 * np.sin(2.0 * np.pi * 0.2 * np.arange(SAMPLES) / RATE)[:, None]
    noise = slow + np.random.default_rng(920113).standard_normal((SAMPLES, 1))
    with np.errstate(all='raise'):
        whitening = whitening_of(noise, NONE, RATE, BANDWIDTH)
    assert whitening.reach == round(0.1 * RATE)


def test_noise_that_is_white_beside_what_rises_is_left_alone():
    """White noise of a torque hides what readings make: nothing is to be gained."""
    noise = coloured(920115, 10.0)
    loudest = levels(noise, [(35.0, 40.0)])[0]
    assert whitening_of(noise, np.array([4.0 * loudest ** 2]), RATE, BANDWIDTH) is None
    assert whitening_of(noise, NONE, RATE, BANDWIDTH) is not None


def test_slow_motion_passes_as_it_is_and_without_delay():
    whitening = whitening_of(coloured(920120, 5.0), NONE, RATE, BANDWIDTH)
    inside = slice(whitening.reach, -whitening.reach)
    for frequency in (0.0, 0.5, 2.0):
        wave = np.cos(2.0 * np.pi * frequency * TIME)[:, None]
        assert whitening.of(wave, 0)[inside] == pytest.approx(wave[inside], abs=0.05)


def test_what_a_filter_saw_of_invalid_samples_is_invalid():
    whitening = whitening_of(coloured(920130, 5.0), NONE, RATE, BANDWIDTH)
    valid = np.ones((200, 1), bool)
    valid[100] = False
    holds = whitening.holds(valid)[:, 0]
    assert np.flatnonzero(~holds).tolist() == list(range(100 - whitening.reach,
                                                         101 + whitening.reach))


@pytest.fixture(scope='module')
def slow():
    """Return an arm and its balances at 200 Hz, as they are and whitened."""
    world = worlds.draw(920140, motion='rich', rate=200, joints=2, seconds=30.0)
    arm, measurement = as_read(world)
    plain = Balancer(finer(measurement))
    return arm, plain, plain.whitened(arm, np.zeros(2 * len(arm.joints)))


def test_a_slow_log_is_left_with_less_noise_and_the_same_effects(slow):
    """A friction that is slow keeps its size beside noise that shrinks."""
    arm, plain, white = slow
    assert white is not plain
    friction = next(iter(terms_of(arm, 'coulomb_friction')))
    stronger = friction.at(friction.vector() + friction.all_steps()).on(arm)
    sizes = []
    for balancer in (plain, white):
        balance = balancer(arm)
        valid = white(arm).valid[:, 0]
        noise = balancer.noisier(arm).residual - balance.residual
        effect = balancer(stronger).residual - balance.residual
        sizes.append((np.std(noise[valid, 0]), np.std(effect[valid, 0])))
    assert sizes[1][0] < 0.6 * sizes[0][0]
    assert sizes[1][1] > 0.9 * sizes[0][1]


def test_a_curve_is_filtered_as_the_balance_that_it_stands_beside(slow):
    arm, plain, white = slow
    low_passed, expected = plain(arm).residual, white(arm).residual
    assert expected != pytest.approx(low_passed)
    for channel in range(4):
        curve = low_passed[:, [channel]]
        assert white.in_balance(curve, channel) == pytest.approx(expected[:, [channel]])
        assert plain.in_balance(curve, channel) is curve


@pytest.mark.parametrize(('seconds', 'effects', 'verdict'), [
    (60.0, [], 'no_discrepancy'), (30.0, [('joint1', Backlash(half_width=1e-4))], 'explained')])
def test_what_only_a_filter_shows_is_nothing_wrong(seconds, effects, verdict):
    """The simulator's own arm, healthy and with the play of the README's example."""
    arm = read_arm('hda_arm.yaml')
    true = arm
    for joint, effect in effects:
        true = true.with_effect(effect, joint)
    made = run(true, arm, motion('rich', 2, seconds, 1e-3, 4), 4)
    stamps = 1 + np.rint(1e9 * made.time).astype(np.int64)
    samples = joint_samples(arm, stamps, made.reading, made.command)
    found = diagnose(measurement_from(arm.labels, samples), arm).diagnosis
    assert found.verdict == verdict
    assert [(one.joint, one.effect) for one in found.findings] == [
        (joint, effect.name) for joint, effect in effects]
