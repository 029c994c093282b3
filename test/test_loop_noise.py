"""A loop repeats the noise of its readings in its commands, and its log says by how much."""

from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import motion
from hda_torque_estimator.diagnosis.balances.balance import Balancer
from hda_torque_estimator.diagnosis.balances.loop_noise import noisier_commands
from hda_torque_estimator.measurements.measurement import Measurement
from hda_torque_estimator.simulating.closed_loop import run
import numpy as np
import pytest

SECONDS, NOISE = 20.0, 2e-3         # of motor readings, of a coarse encoder [rad]
STIFFNESS, DAMPING, LATE = 0.8, 0.02, 1     # of a loop at the motor [N*m/rad, N*m*s/rad, samples]


def repeated(reading: np.ndarray, dt: float) -> np.ndarray:
    """Return what a loop makes of motor readings (k,), a sample late [N*m]."""
    rate = np.diff(reading, prepend=reading[:1]) / dt
    return -np.roll(STIFFNESS * reading + DAMPING * rate, LATE)


def measured(parts: int) -> Measurement:
    """Return readings of two joints that a loop follows, held for so many parts of a sample."""
    dt = 1e-3 * parts
    time = dt * np.arange(round(SECONDS / dt))
    motors = np.stack([np.sin(5.0 * time), np.cos(3.0 * time)], axis=1) + NOISE * (
        np.random.default_rng(1).standard_normal((len(time), 2)))
    command = np.stack([2.0 * np.sin(5.0 * time) + repeated(column, dt)
                        for column in motors.T], axis=1)
    reading = np.stack([motors, 0.01 * motors + 1e-6 * np.random.default_rng(2).standard_normal(
        motors.shape)], axis=2)
    held = [np.repeat(each, parts, axis=0) for each in (reading, command)]
    return Measurement(('joint1', 'joint2'), 1e-3, *held, parts=parts)


@pytest.mark.parametrize('parts', [1, 4])
def test_a_loop_makes_of_more_noise_what_it_made_of_its_readings(parts):
    balancer = Balancer(measured(parts))
    more = (balancer.noisier.measurement.reading - balancer.measurement.reading)[::parts, :, 0]
    added = (noisier_commands(balancer) - balancer.measurement.command)[::parts]
    for joint in (0, 1):
        right = repeated(more[:, joint], 1e-3 * parts)
        assert np.std((added[:, joint] - right)[8:]) < 0.02 * np.std(right)


def test_commands_are_held_as_they_were():
    balancer = Balancer(measured(4))
    added = noisier_commands(balancer) - balancer.measurement.command
    np.testing.assert_array_equal(added.reshape(-1, 4, 2), added[::4, None].repeat(4, axis=1))


def test_gains_of_two_recordings_are_found_within_each():
    """Where one begins a command does not follow the readings of the other."""
    one = measured(1)
    half = len(one.command) // 2
    jump = np.where(np.arange(len(one.command)) < half, 0.0, 50.0)[:, None]
    both = Measurement(one.labels, one.dt, one.reading, one.command + jump, begins=(0, half))
    alone = noisier_commands(Balancer(one)) - one.command
    np.testing.assert_allclose(noisier_commands(Balancer(both)) - both.command, alone,
                               atol=0.02 * alone.std())


def test_a_loop_of_the_simulator_repeats_its_noise():
    """Its command is linear in what it read, so the log explains what is quick in it."""
    arm = read_arm('hda_arm.yaml')
    made = run(arm, arm, motion('rich', 2, SECONDS, 1e-3, 4), 4, estimator=None)
    balancer = Balancer(Measurement(arm.labels, 1e-3, made.reading[:, :, :2], made.command))
    added = noisier_commands(balancer) - balancer.measurement.command
    quick = np.diff(made.command, 4, axis=0).std(axis=0)
    assert (np.abs(np.diff(added, 4, axis=0).std(axis=0) / quick - 1.0) < 0.2).all()
