"""A motor that goes from one limit to the other moves itself first: the gear's torque stays."""

from dataclasses import replace

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.model.parts import Encoder
from hda_torque_estimator.estimating.estimator import Estimator
from hda_torque_estimator.estimating.laws.fusion_memory import MEMORY
from hda_torque_estimator.estimating.laws.torque_jumps import jump_of
from hda_torque_estimator.samples.readings import by_motor, READINGS
import numpy as np
import pytest

DT, SECONDS, RATIO, INERTIA = 0.01, 8.0, 100.0, 1e-3
SMALL, LARGE, PERIOD = 0.01, 0.3, 0.5   # torques of the motor [N*m], time between jumps [s]
Array = np.ndarray


def motor_alone(lag: float) -> Arm:
    """Return a joint whose motor alone is known, without friction."""
    whole = read_arm('hda_arm.yaml')
    joint = replace(whole.joints[0], label='joint1', ratio=RATIO, motor_inertia=INERTIA,
                    dry_friction=0.0, viscous_friction=0.0, motor_deviation=0.5, effort_lag=lag,
                    motor_encoder=Encoder())
    return replace(whole, joints=(joint,), links=None, effects=())


def missed(lag: float, inertia: float = INERTIA) -> tuple[Array, Array]:
    """Return what is missed of a gear's torque (k,) [N*m], and the samples after jumps."""
    time = DT * np.arange(round(SECONDS / DT))
    fine = np.arange(0.0, SECONDS, 0.1 * DT)
    load = 5.0 + 2.0 * np.sin(3.0 * fine)
    jumps = np.where(fine > 2.0, np.sign(np.sin(2.0 * np.pi * fine / PERIOD + 0.3)), 0.0)
    given = load / RATIO + SMALL * np.sin(9.0 * fine) + LARGE * jumps
    speed = 300.0 + np.cumsum(given - load / RATIO) * 0.1 * DT / INERTIA
    angle = np.cumsum(speed) * 0.1 * DT
    held = given.reshape(-1, 10).mean(axis=1)
    command = held if lag > 0.0 else np.interp(time, fine, given)
    readings = np.full((len(time), 1, READINGS), np.nan)
    readings[:, 0, 0] = angle[::10]
    readings[:, 0, 1] = angle[::10] / RATIO
    stamps = 1 + np.round(1e9 * time).astype(np.int64)
    arm = motor_alone(lag)
    arm = replace(arm, joints=(replace(arm.joints[0], motor_inertia=inertia),))
    found = Estimator(by_motor(arm, arm.labels)).run(stamps, readings, command[:, np.newaxis])
    step = np.abs(np.diff(command, prepend=command[0])) > 0.5 * LARGE
    near = np.convolve(step & (time > 1.0), np.ones(12), 'full')[:len(time)] > 0.0
    return found.torque[:, 0] - load[::10], near


@pytest.mark.parametrize('lag', [0.5, 0.0])
def test_a_jump_of_the_motor_is_none_of_the_gear(lag):
    """By angles alone it is 19 N*m rms, as the shaft is late; the motor jumps by 60."""
    error, near = missed(lag)
    assert 200 < near.sum() < 400
    assert np.sqrt(np.mean(error[near] ** 2)) < 0.03 * RATIO * 2.0 * LARGE


def test_an_inertia_that_is_off_costs_as_much_as_it_is_off():
    error, near = missed(0.5, 1.2 * INERTIA)
    assert np.sqrt(np.mean(error[near] ** 2)) < 0.2 * RATIO * LARGE


def test_usual_steps_are_no_jumps():
    """Of a motor's noise one step in thousands is beyond four deviations."""
    memory, random = np.zeros(MEMORY), np.random.default_rng(5)
    jumps = [jump_of(memory, step, 1e-3) for step in 0.02 * random.standard_normal(20_000)]
    assert np.mean(np.abs(jumps) > 0.0) < 1e-3
    assert jump_of(memory, 1.0, 1e-3) == pytest.approx(1.0 - 4.0 * 0.02, abs=0.01)
    assert jump_of(memory, -1.0, 1e-3) == pytest.approx(-1.0 + 4.0 * 0.02, abs=0.01)


def test_nothing_is_unusual_at_first():
    assert jump_of(np.zeros(MEMORY), 1.0, 1e-3) == 0.0
