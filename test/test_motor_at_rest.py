"""A motor at rest keeps the torque that it had, and a ripple that nobody found counts once."""

from dataclasses import replace

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.model.parts import Encoder
from hda_torque_estimator.calibrate.fitting.witness_fit import motor_of
from hda_torque_estimator.calibrate.passages.encoder_noise import with_noise
from hda_torque_estimator.calibrate.passages.joint_recording import Measured
from hda_torque_estimator.calibrate.referenced import calibrate
from hda_torque_estimator.estimating.estimator import Estimator
from hda_torque_estimator.samples.readings import by_motor, MOTOR_READING, READINGS
import numpy as np
import pytest

SECONDS, DT, RATIO, INERTIA, DRY = 24.0, 0.01, 100.0, 5e-5, 0.03
LOAD, NOISE, RIPPLE = 4.0, 1.5e-3, 0.004
Array = np.ndarray


def motor_alone(**parts: float) -> Arm:
    """Return a joint whose motor alone is known."""
    whole = read_arm('hda_arm.yaml')
    joint = replace(whole.joints[0], label='joint1', ratio=RATIO, motor_inertia=INERTIA,
                    dry_friction=DRY, **{'motor_deviation': 0.1, **parts})
    return replace(whole, joints=(joint,), links=None, effects=(),
                   tolerances=replace(whole.tolerances, torque_ripple=0.01))


def stopping(seed: int, *, noise: float = NOISE, ripple: float = 0.0) -> tuple[Measured, Array]:
    """
    Return a motor that lifts and lowers a weight, and stands between: friction holds a part.

    While it stands, its drive relaxes to the weight's middle and beyond. Returns the load as well.
    """
    random = np.random.default_rng(seed)
    time = DT * np.arange(round(SECONDS / DT))
    phase = time % 4.0
    way = np.where(phase < 1.5, np.sin(np.pi * phase / 1.5) ** 2, 0.0)
    way = np.where((time // 4.0) % 2.0 == 0.0, way, -way)
    angle = np.cumsum(60.0 * way) * DT
    rate = 60.0 * way
    slides = np.abs(rate) > 0.05
    load = LOAD * (1.0 + np.sin(3.0 * angle / RATIO + random.uniform(0.0, 6.3)))
    relaxed = random.uniform(-0.8, 0.8, len(time) // 400 + 1)[(time // 4.0).astype(int)]
    held = np.where(slides, np.sign(rate), relaxed)
    given = (load / RATIO + DRY * held + INERTIA * np.gradient(rate, time)
             + ripple * np.sin(2.0 * angle))
    readings = np.full((len(time), 1, READINGS), np.nan)
    readings[:, 0, MOTOR_READING] = angle + noise * random.standard_normal(len(time))
    stamps = 1 + np.round(1e9 * time).astype(np.int64)
    return Measured(f'run{seed}', stamps, readings, given, load, 0.0), slides


def missed(arm: Arm, one: Measured) -> Array:
    """Return what the estimator misses (k,) [N*m]."""
    linked = one.with_link(RATIO)
    estimator = Estimator(by_motor(arm, arm.labels))
    found = estimator.run(linked.stamps, linked.readings, linked.command[:, np.newaxis])
    return np.asarray(found.torque[:, 0] - one.reference)


def rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values ** 2)))


@pytest.mark.parametrize('seed', [1, 2])
def test_a_pose_that_stands_bears_the_load_that_it_had(seed):
    """The middle of what friction allows is off by up to 0.8 of it: 1.3 N*m rms."""
    arm = motor_alone(effort_lag=0.0, motor_encoder=Encoder(noise=NOISE))
    one, slides = stopping(seed)
    middle = RATIO * one.command - one.reference
    stands = ~slides & (one.time > 4.0)
    assert rms(middle[stands]) > 0.9
    assert rms(missed(arm, one)[stands]) < 0.35 * rms(middle[stands])


def test_a_push_beyond_friction_is_followed_at_rest():
    """A hand that lifts by more than friction holds moves the torque at once."""
    arm = motor_alone(effort_lag=0.0, motor_encoder=Encoder(noise=NOISE))
    one, _ = stopping(3)
    last = one.time > SECONDS - 1.0
    pushed = replace(one, command=one.command + np.where(last, 0.12, 0.0),
                     reference=one.reference + np.where(last, 100.0 * 0.12, 0.0))
    assert np.abs(missed(arm, pushed)[last][5:]).max() < 2.2 * RATIO * DRY


def test_noise_at_rest_is_no_motion():
    """Counts of a table that was rounded finely say that a shaft at rest turns to and fro."""
    one, _ = stopping(4)
    arm = motor_alone(effort_lag=0.0, motor_encoder=Encoder(counts=62210.0))
    found = with_noise(arm, [one])
    assert found.joints[0].motor_encoder.noise == pytest.approx(NOISE, rel=0.1)
    assert rms(missed(found, one)) < 0.6 * rms(missed(arm, one))


@pytest.mark.parametrize('noise', [0.0, 1e-6])
def test_an_encoder_as_good_as_its_counts_has_no_noise_of_its_own(noise):
    arm = motor_alone(motor_encoder=Encoder(counts=62210.0))
    assert with_noise(arm, [stopping(5, noise=noise)[0]]) == arm


def test_a_ripple_that_is_left_counts_once():
    """What rows of the fit see of it is in its tolerance, and no longer in the deviation."""
    arm = motor_alone(effort_lag=0.0, motor_encoder=Encoder(noise=NOISE))
    recordings = [stopping(seed, ripple=RIPPLE)[0] for seed in (6, 7, 8)]
    fit = motor_of(arm, recordings)
    assert fit is not None
    assert fit.ripple < arm.tolerances.torque_ripple
    assert 0.0 < fit.deviation < fit.error
    sure = replace(arm, tolerances=replace(arm.tolerances, torque_ripple=0.0))
    alone = motor_of(sure, recordings)
    assert alone is not None
    assert alone.ripple == 0.0
    assert fit.deviation < alone.deviation
    written = calibrate(arm, {'joint1': recordings}).arm
    assert written.tolerances_of('joint1').torque_ripple <= fit.ripple
    assert written.joints[0].motor_deviation > 0.0
