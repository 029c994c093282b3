"""A controller that swings its joint is told with what to do, slow or spread commands are not."""

from dataclasses import asdict, replace

from hda_arm_sim.model.files import read_arm
from hda_torque_estimator.diagnosis.detectability.oscillating_loops import oscillating_loops
from hda_torque_estimator.diagnosis.diagnose import diagnose
from hda_torque_estimator.measurements.measurement import Measurement
import numpy as np
import pytest
from truth import worlds
from world_fits import diagnosed
from world_samples import as_read

ARM = read_arm('hda_arm.yaml')
SECONDS, HERTZ = 20.0, 60.0
LIMITS = np.array([joint.torque_limit for joint in ARM.joints])


def commanded(shares, rate=1000.0, begins=(0,)):
    """Return a recording of commands (k, 2), given as shares of the motors' largest torques."""
    reading = np.zeros((len(shares), 2, 2))
    return Measurement(ARM.labels, 1.0 / rate, reading, shares * LIMITS, begins=begins)


def slow(rate=1000.0):
    """Return times [s] and the commands of a motion (k, 2)."""
    time = np.arange(round(SECONDS * rate)) / rate
    return time, np.stack([0.4 * np.sin(time), 0.3 * np.cos(3.0 * time)], axis=1)


@pytest.mark.parametrize('rate', [250.0, 1000.0])
def test_a_line_that_is_more_than_the_motion_is_of_the_loop(rate):
    time, command = slow(rate)
    command[:, 1] += 0.5 * np.sin(2.0 * np.pi * HERTZ * time)
    found, = oscillating_loops(commanded(command, rate), ARM)
    assert found.joint == ARM.labels[1]
    assert found.frequency == pytest.approx(HERTZ, abs=0.5)
    assert found.amplitude == pytest.approx(0.5, rel=0.02)
    whole = 0.5 ** 2 / (0.5 ** 2 + 0.3 ** 2)            # of it, slow motion counts less
    assert whole < found.share < whole + 0.05
    halves = commanded(command, rate, begins=(0, len(command) // 2))
    assert [one.joint for one in oscillating_loops(halves, ARM)] == [found.joint]


def test_motion_noise_and_small_lines_are_not():
    time, command = slow()
    assert oscillating_loops(commanded(command), ARM) == ()
    assert oscillating_loops(commanded(np.zeros_like(command)), ARM) == ()
    noise = 0.3 * np.random.default_rng(5).standard_normal(command.shape)
    assert oscillating_loops(commanded(command + noise), ARM) == ()
    line = np.sin(2.0 * np.pi * HERTZ * time)[:, None]
    assert oscillating_loops(commanded(0.09 * line * np.ones(2)), ARM) == ()
    assert oscillating_loops(commanded(2.0 * command + 0.2 * line), ARM) == ()
    assert oscillating_loops(commanded(0.5 * np.sin(2.0 * np.pi * 5.0 * time)[:, None]
                                       * np.ones(2)), ARM) == ()


def test_a_healthy_loop_is_not_and_one_that_oscillates_is_told_with_what_to_do():
    world = worlds.draw(242177, (), motion='rich', rate=1000, joints=1, seconds=SECONDS)
    healthy = diagnosed(world)
    assert healthy.recording.oscillating == ()
    assert 'oscillating' not in healthy.document()['recording']
    arm, measurement = as_read(world)
    swing = 0.5 * arm.joints[0].torque_limit * np.sin(2.0 * np.pi * HERTZ * measurement.time)
    told = diagnose(replace(measurement, command=measurement.command + swing[:, None]),
                    arm).diagnosis
    loop, = told.recording.oscillating
    assert loop.joint == 'joint1' and round(loop.frequency) == HERTZ
    assert told.document()['recording']['oscillating'] == [asdict(loop)]
    assert told.remarks[0] == loop.sentence() and told.steps[0] == loop.step()


def test_a_loop_that_oscillates_at_standstill_is_told_as_well():
    time, command = slow()
    command[:, 1] += 0.5 * np.sin(2.0 * np.pi * HERTZ * time)
    told = diagnose(commanded(command), ARM).diagnosis
    loop, = told.recording.oscillating
    assert told.verdict == 'insufficient_excitation'
    assert told.remarks[0] == loop.sentence() and told.steps[0] == loop.step()
