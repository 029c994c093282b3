"""A command is held until the next sample, a current is measured at its own (eq:effort-lag)."""

from dataclasses import replace

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.files import arm_from_text, read_arm
from hda_arm_sim.model.writing import arm_to_text
from hda_torque_estimator.calibrate.passages.joint_recording import Measured
from hda_torque_estimator.calibrate.referenced import calibrate, JointCalibration
from hda_torque_estimator.estimating.estimator import Estimator
from hda_torque_estimator.measurements.effort import acting, as_held, HELD, MEASURED
from hda_torque_estimator.measurements.measurement import Measurement
from hda_torque_estimator.samples.readings import by_motor, MOTOR_READING, READINGS
import numpy as np
import pytest

SECONDS, FAST, EVERY = 12.0, 1e-3, 10       # a drive at 1 kHz, logged at 100 Hz
RATIO, INERTIA, DRY = 100.0, 5e-5, 0.02
Array = np.ndarray


def motor_alone(lag: float) -> Arm:
    """Return a joint whose motor alone is known, and when its torque acts."""
    whole = read_arm('hda_arm.yaml')
    joint = replace(whole.joints[0], label='joint1', ratio=RATIO, motor_inertia=INERTIA,
                    dry_friction=DRY, motor_deviation=0.2, effort_lag=lag)
    return replace(whole, joints=(joint,), links=None, effects=())


def recorded(seed: int, *, held: bool) -> tuple[Measured, Array]:
    """Return a motor that works against a quick load, and the true torque at its samples."""
    random = np.random.default_rng(seed)
    time = FAST * np.arange(round(SECONDS / FAST))
    load = np.sum([3.0 * np.sin(6.28 * random.uniform(4.0, 8.0) * time + random.uniform(0.0, 6.3))
                   for _ in range(4)], axis=0)
    angle = RATIO * 0.8 * np.sin(1.3 * time + random.uniform(0.0, 6.3))
    rate = np.gradient(angle, time)
    given = load / RATIO + DRY * np.sign(rate) + INERTIA * np.gradient(rate, time)
    rows = slice(None, None, EVERY)
    mean = given.reshape(-1, EVERY).mean(axis=1)    # what acts from a sample to the next
    readings = np.full((len(mean), 1, READINGS), np.nan)
    readings[:, 0, MOTOR_READING] = angle[rows]
    stamps = 1 + np.round(1e9 * time[rows]).astype(np.int64)
    return Measured(f'run{seed}', stamps, readings, mean if held else given[rows],
                    load[rows]), load[rows]


def error(arm: Arm, one: Measured, true: Array) -> float:
    """Return what the estimator misses where the shaft turns [N*m rms]."""
    linked = one.with_link(RATIO)
    estimator = Estimator(by_motor(arm, arm.labels))
    found = estimator.run(linked.stamps, linked.readings, linked.command[:, np.newaxis])
    turns = np.abs(linked.turning().rate) > 10.0
    return float(np.sqrt(np.mean((found.torque[turns, 0] - true[turns]) ** 2)))


def test_a_torque_acts_by_its_lag_after_its_stamp():
    effort = np.array([1.0, 2.0, 4.0, np.nan, 8.0])
    np.testing.assert_array_equal(acting(effort, HELD), [1.0, 1.5, 3.0, np.nan, np.nan])
    np.testing.assert_array_equal(acting(effort, MEASURED), effort)
    np.testing.assert_array_equal(acting(effort, -0.5), [1.5, 3.0, np.nan, np.nan, 8.0])
    np.testing.assert_array_equal(acting(effort[:1], HELD), [1.0])


def test_a_held_command_is_the_mean_of_both_to_the_last_bit():
    effort = np.random.default_rng(1).standard_normal(1000)
    np.testing.assert_array_equal(acting(effort, HELD)[1:], 0.5 * (effort[1:] + effort[:-1]))


@pytest.mark.parametrize('held', [True, False])
def test_the_convention_that_holds_errs_less(held):
    """The other one is half a sample off."""
    one, true = recorded(3, held=held)
    right, other = (error(motor_alone(lag), one, true) for lag in (
        (HELD, MEASURED) if held else (MEASURED, HELD)))
    assert right < 0.7 * other


@pytest.mark.parametrize(('held', 'given'), [(True, HELD), (False, HELD), (True, MEASURED)])
def test_a_calibration_finds_which_it_is(held, given):
    recordings = [recorded(seed, held=held)[0] for seed in (5, 6, 7)]
    found = calibrate(motor_alone(given), {'joint1': recordings})
    right = HELD if held else MEASURED
    assert found.arm.joints[0].effort_lag == right
    report = found.joints[0]
    assert isinstance(report, JointCalibration)
    assert ('motor torque acts' in found.text()) == (right != given)
    one, true = recorded(8, held=held)
    assert error(found.arm, one, true) < 0.7 * error(motor_alone(given), one, true) or (
        right == given)


def test_a_diagnosis_sees_what_acted_until_the_next_sample():
    """A current at its stamp is the mean of the commands about it; smooth ones come back."""
    time = 0.001 * np.arange(600)
    held = np.sin(40.0 * time)[:, None]
    measured = np.concatenate([held[:1], 0.5 * (held[1:] + held[:-1])])
    one = Measurement(('joint1',), 0.001, np.zeros((600, 1, 2)), measured, begins=(0, 300))
    assert as_held(one, motor_alone(HELD)) is one
    found = as_held(one, motor_alone(MEASURED))
    assert found.held
    inside = np.setdiff1d(np.arange(1, 599), [299, 300])
    assert np.abs(found.command - held)[inside].max() < 0.02 * np.abs(measured - held).max()
    assert found.command[299] == measured[299]          # no way from one recording to another


def test_the_lag_is_a_number_of_the_arm_file():
    arm = motor_alone(MEASURED)
    assert arm_from_text(arm_to_text(arm), 'it').joints[0].effort_lag == MEASURED
    assert read_arm('hda_arm.yaml').joints[0].effort_lag == HELD
