"""Commands between the samples of a log: held, or on their way, as the motor shows."""

from dataclasses import replace

from hda_arm_sim.model.effects import BaseVibration
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import motion
from hda_torque_estimator.diagnosis.assumptions import EFFECTIVE
from hda_torque_estimator.diagnosis.balances.balance import Balancer
from hda_torque_estimator.diagnosis.balances.commands import on_its_way, way_between
from hda_torque_estimator.diagnosis.balances.healthy_twin import noise_of
from hda_torque_estimator.diagnosis.fitting.fit import Fitter
from hda_torque_estimator.diagnosis.judging import equal_noise
from hda_torque_estimator.measurements.measurement import Measurement
from hda_torque_estimator.measurements.upsampling import finer
import numpy as np
import pytest
from truth import record, Reference, worlds
from truth_cases import hide
from world_samples import as_read


def balances(seed, motion='constant', every=1, effects=(), seconds=30.0):
    """Return an arm, balances of a log of every so many samples, and their noise."""
    world = worlds.draw(seed, effects, motion=motion, rate=1000, joints=1, seconds=seconds)
    world = replace(world, controller=1000, logger=world.logger._replace(every=every, jitter=0.0))
    arm, measurement = as_read(world)
    balancer = Balancer(finer(measurement))
    return arm, balancer, noise_of(balancer, arm)[0]


@pytest.mark.parametrize('every', [
    2, *(pytest.param(every, marks=pytest.mark.study) for every in (4, 8))])
def test_how_far_commands_went_between_samples_is_estimated_where_they_change_at_once(every):
    ways = []
    for seed in range(720000, 720006):
        arm, balancer, noise = balances(seed, every=every)
        ways.append(way_between(balancer, arm, noise))
    reported = [way for way in ways if way is not None]
    assert len(reported) >= 2
    assert reported == pytest.approx([(every - 1) / every] * len(reported), abs=0.15)


def test_commands_that_were_held_are_left_as_they_are():
    for seed in range(720000, 720006):
        arm, balancer, noise = balances(seed)
        assert on_its_way(balancer, arm, noise) is balancer


def test_a_way_that_is_not_known_is_none():
    """What follows quick sweeps at 2 kHz looks like 1.4 of the way, give or take 0.9."""
    world = worlds.draw(1020217, ())
    arm, measurement = as_read(world)
    balancer = Balancer(finer(measurement))
    noise = noise_of(balancer, arm)[0]
    assert (world.motion, world.logger.every) == ('chirp', 1)
    assert way_between(balancer, arm, noise) is None
    assert on_its_way(balancer, arm, noise) is balancer


def test_a_delay_of_commands_is_no_way_to_the_next_one():
    arm, balancer, noise = balances(720000, effects=('command_delay',))
    assert on_its_way(balancer, arm, noise) is balancer


def test_motor_balances_hold_nothing_where_what_a_command_did_is_unknown():
    arm, balancer, noise = balances(720000, every=8)
    known = on_its_way(balancer, arm, noise)
    assert known is not balancer
    held = np.repeat(balancer.measurement.command[::8], 8, axis=0)[:len(balancer.time) * 8]
    as_held = Balancer(replace(balancer.measurement, command=held))
    before, after = as_held(arm), known(arm)
    assert 0.0 < after.valid[:, 0].sum() < before.valid[:, 0].sum()
    assert (after.valid[:, 1] == before.valid[:, 1]).all()
    left = [np.sqrt(np.mean(one.residual[one.valid[:, 0], 0] ** 2)) for one in (before, after)]
    assert left[1] < 0.9 * left[0]


def test_what_a_base_does_at_once_is_no_way_of_commands_known_or_not():
    """It looks like 1.6 of the way, give or take 1; no command goes farther than the next one."""
    swings = {'frequency': 10.0, 'damping': 1.4, 'amplitude': 0.03, 'direction': 2.0}
    arm = read_arm('hda_arm.yaml')
    asked = motion('rich', 2, 30.0, 1e-3, 105)
    made = record([hide('base_vibration', None, **swings)],
                  Reference(asked.angle, asked.rate, 1e-3), seed=105)
    recorded = Measurement(arm.labels, 1e-3, np.stack([made.motor_angle, made.link_angle], axis=2),
                           made.command)
    plain = Balancer(recorded)
    noise = noise_of(plain, arm)[0]
    assert way_between(plain, arm, noise) is None
    assert not way_between(plain, arm.with_effect(BaseVibration(**swings), None), noise)


@pytest.mark.parametrize(('every', 'least', 'most'), [(5, 0.64, 0.9), (1, 0.999, 1.001)])
def test_a_motor_that_gives_less_makes_less_of_commands_not_recorded(every, least, most):
    """A torque constant won by that over a drive offset. Readings are as noisy as ever."""
    arm, balancer, noise = balances(790101, 'rich', every, seconds=20.0)
    fitter = Fitter(balancer, arm, noise, EFFECTIVE, np.ones(len(balancer.time), bool))
    label, valid = arm.labels[0], fitter.valid(balancer(arm))
    weaker = replace(arm.effect('torque_constant_error', label), error=-0.2)
    made = [equal_noise._noise_of(fitter, each, valid).whole[0]
            for each in (arm, arm.with_effect(weaker, label))]
    assert least < made[1] / made[0] < most
