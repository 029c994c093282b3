"""Slow recordings: every so many samples of a faster loop, or of a loop that is as slow."""

from dataclasses import replace

from hda_arm_sim.model.files import read_arm
from hda_torque_estimator.diagnosis.balances.balance import Balancer
from hda_torque_estimator.diagnosis.balances.healthy_twin import healthy_twin, noise_of
from hda_torque_estimator.diagnosis.diagnose import diagnose
from hda_torque_estimator.diagnosis.fitting.derivatives import Derivatives
from hda_torque_estimator.diagnosis.fitting.nuisance import is_of_log
from hda_torque_estimator.diagnosis.fitting.solve import REACH
from hda_torque_estimator.measurements.even_grid import on_grid
from hda_torque_estimator.measurements.measurement import Measurement
from hda_torque_estimator.measurements.sample_grid import measurement_from
from hda_torque_estimator.measurements.upsampling import between, finer, is_held, parts_of
import numpy as np
import pytest
from truth import draw, worlds
from truth_samples import published
from world_fits import diagnosed
from world_samples import as_read

ARM = read_arm('hda_arm.yaml')
SEED = 940000


def recorded(name, seed, *, period=1e-3, every=1, seconds=60.0):
    """Return what is hidden, and every so many samples of a loop with this period [s]."""
    hidden = [draw(name, np.random.default_rng([seed, 1]))] if name else []
    samples = published(ARM, hidden, seed, seconds=seconds, period=period)
    return hidden, measurement_from(ARM.labels, samples.rows(slice(None, None, every)))


@pytest.mark.parametrize(('period', 'every', 'held'), [
    (1e-3, 4, False), (1e-3, 5, False), (1e-3, 8, False), (2e-3, 1, True), (4e-3, 1, True)])
def test_who_held_a_command_is_known_from_the_noise_that_it_answers(period, every, held):
    _, measurement = recorded(None, SEED, period=period, every=every, seconds=20.0)
    assert is_held(measurement) == held
    parts = parts_of(measurement.dt)
    between_samples = finer(measurement).command[20 * parts:21 * parts]
    assert (np.ptp(between_samples, axis=0) == 0.0).all() == held
    asked = finer(measurement).as_recorded()
    assert asked.held == is_held(replace(asked, command=-asked.command)) == held    # once


@pytest.mark.parametrize('late', [0, 1])
@pytest.mark.parametrize('share', [0.0, 0.036])
def test_a_few_percent_of_quick_commands_that_readings_lack_are_of_a_faster_loop(share, late):
    """Of an arm from point to point, at 250 Hz. In a log of 1 kHz a hidden clock may do it."""
    random = np.random.default_rng(SEED)
    link = np.cumsum(random.standard_normal((2000, 2)), axis=0)
    answered, other = -0.01 * np.roll(link, late, axis=0), random.standard_normal((2000, 2))
    size = np.diff(answered, 3, axis=0).std() / np.diff(other, 3, axis=0).std()
    log = Measurement(ARM.labels, 4e-3, np.stack([100.0 * link, link], axis=2),
                      answered + np.sqrt(share) * size * other)
    assert is_held(log) == (share == 0.0)
    assert is_held(replace(log, dt=1e-3))


def slow_world(seed, effects=(), *, rate, controller=None, jitter=0.0):
    """Return the arm and half a minute of a world whose log has this rate [Hz]."""
    world = worlds.draw(seed, effects, rate=rate, seconds=30.0)
    controller = controller or world.controller
    world = replace(world, controller=controller, logger=world.logger._replace(
        every=controller // rate, jitter=jitter))
    return as_read(world)


# At constant speed most of a quick command is of the motion, which is smooth and shows itself, so
# that only a few per cent are not known, and with good encoders less than 1e-3 (the last three).
# Beside samples in which a controller answered nothing, half was not known.
@pytest.mark.parametrize(('seed', 'effects', 'rate', 'controller', 'held'), [
    (660010, (), 125, 2000, False), (661001, ('dropped_samples',), 250, 250, True),
    (800113, ('kinematic_error',), 125, 250, False),
    (800133, ('motor_inertia_error',), 125, 250, False),
    (1110041, ('position_dependent_friction',), 250, 500, False)])
def test_clocks_that_jitter_and_lost_samples_hide_not_who_held_a_command(
        seed, effects, rate, controller, held):
    _, measurement = slow_world(seed, effects, rate=rate, controller=controller)
    assert is_held(on_grid(measurement)) == held


@pytest.mark.parametrize(('dt', 'parts'), [
    (5e-4, 1), (1.000002e-3, 1), (1.5e-3, 2), (1 / 300, 4), (5e-3, 5), (8e-3, 8)])
def test_a_finer_grid_is_at_most_a_millisecond(dt, parts):
    assert parts_of(dt) == parts


def test_what_was_recorded_stays_and_a_motion_goes_on_between():
    time = 5e-3 * np.arange(400)
    fine = between(np.stack([np.sin(2.0 * np.pi * 3.0 * time), time], axis=1), 5)
    there = 1e-3 * np.arange(2000)
    assert fine[::5] == pytest.approx(np.stack([np.sin(2.0 * np.pi * 3.0 * time), time], axis=1))
    assert np.abs(fine[20:-20, 0] - np.sin(2.0 * np.pi * 3.0 * there)[20:-20]).max() < 1e-5
    assert fine[:, 1] == pytest.approx(there)


def test_the_samples_that_were_recorded_can_be_had_again():
    _, measurement = recorded(None, SEED, every=5, seconds=5.0)
    again = finer(measurement).as_recorded()
    assert again.dt == measurement.dt
    assert again.reading == pytest.approx(measurement.reading, abs=1e-12)
    assert again.reading_noise() == pytest.approx(finer(measurement).reading_noise())


@pytest.mark.parametrize('every', [4, 5, 8])
def test_a_slow_healthy_recording_leaves_hardly_more_than_a_quick_one(every):
    """Half a sample of delay, as held commands would have, leaves three times as much."""
    left = []
    for part in (1, every):
        balancer = Balancer(finer(recorded(None, SEED, every=part, seconds=20.0)[1]))
        balance = balancer(ARM)
        left.append([column[good].std() for column, good in
                     zip(balance.residual.T, balance.valid.T)])
    assert (np.array(left[1]) < 1.6 * np.array(left[0]) + 0.05).all()


def test_the_twin_is_read_as_often_and_its_noise_is_that_of_the_samples():
    _, measurement = recorded(None, SEED, every=5, seconds=20.0)
    balancer = Balancer(finer(measurement))
    twin = healthy_twin(balancer, ARM, 1)
    assert twin.parts == 5
    assert twin.reading == pytest.approx(between(twin.reading[::5], 5))
    balance, noise = balancer(ARM), noise_of(balancer, ARM)[0]
    healthy = [column[good].std() for column, good in zip(balance.residual.T, balance.valid.T)]
    assert (noise < healthy).all()          # which has tolerances beside the noise
    assert (noise[:2] < 0.1).all()


@pytest.mark.parametrize('held', [False, True])
def test_only_commands_of_a_faster_loop_have_noise_that_never_acted(held):
    time, random = 8e-3 * np.arange(1000), np.random.default_rng(SEED)
    link = np.stack([np.sin(2.0 * time), np.cos(time)], axis=1)
    noise = 1e-3 * random.standard_normal((1000, 2))
    slow = Measurement(ARM.labels, 8e-3, np.stack([100.0 * link, link], axis=2), link + noise)
    command = np.repeat(slow.command, 8, axis=0) if held else between(slow.command, 8)
    fine = replace(slow, dt=1e-3, parts=8, reading=between(slow.reading, 8), command=command)
    assert fine.command_noise() == pytest.approx(0.0 if held else 1e-3, rel=0.4)
    assert slow.command_noise() == pytest.approx(0.0)


# Of a slow sine most of the commands' noise is where an arm moves, below that of readings. Of
# trapezoids no half second moves throughout, so those that do in parts show the noise.
@pytest.mark.parametrize(('seed', 'motion', 'every'), [
    (610287, 'sine', 16), (650041, 'trapezoid', 4)])
def test_commands_of_a_fast_loop_in_a_slow_log_accuse_no_healthy_arm(seed, motion, every):
    world = worlds.draw(seed, ())
    assert (world.motion, world.controller, world.logger.every) == (motion, 2000, every)
    said = diagnosed(world)
    assert said.verdict == 'no_discrepancy'


def test_commands_of_a_slow_loop_beside_late_stamps_accuse_no_healthy_arm():
    """What jitter of the clock adds to commands is in no stamp, so the motor shows it."""
    arm, measurement = slow_world(650008, rate=250, controller=250, jitter=6e-4)
    assert not is_held(on_grid(measurement))
    said = diagnose(measurement, arm).diagnosis
    assert [one.effect for one in said.findings] == ['clock_jitter'] and not said.ambiguous
    assert said.verdict == 'explained'


@pytest.mark.parametrize(('period', 'every'), [(1e-3, 5), (4e-3, 2), (4e-3, 1), (1e-3, 1)])
def test_when_commands_acted_is_not_known_where_a_log_lacks_some(period, every):
    _, measurement = recorded(None, SEED, period=period, every=every, seconds=20.0)
    balancer = Balancer(finer(measurement))
    for one in (balancer, balancer.noisier, balancer.like(healthy_twin(balancer, ARM, 1))):
        late = [term for term in Derivatives(one, ARM).tolerated
                if is_of_log(term) and term.name != 'encoder_zero']
        assert [term.place for term in late] == [
            ('command_delay', label) for label in ARM.labels if every > 1]
        assert [REACH * float(term.deviations()[0]) for term in late] == pytest.approx(
            len(late) * [0.5 * period * every], rel=1e-3)


@pytest.mark.parametrize(('name', 'seed', 'late', 'controller', 'every'), [
    ('command_delay', 992320, {'delay': 0.002}, 250, 2),
    ('current_loop_lag', 992303, {'time_constant': 0.012}, 1000, 4)])
def test_a_delay_is_told_beyond_what_a_log_does_not_know(name, seed, late, controller, every):
    """Samples are 8 and 4 ms apart. A loop of 250 Hz holds commands as late as such a delay."""
    world = worlds.draw(seed, (name,), motion='rich', rate=1000, seconds=30.0, form='')
    hidden, = world.hidden
    world = replace(world, controller=controller, hidden=(replace(hidden, parameters=late),),
                    logger=world.logger._replace(every=every, jitter=0.0))
    arm, measurement = as_read(world)
    said = diagnose(measurement, arm)
    is_long = every == 4
    assert [(one.effect, one.joint) for one in said.diagnosis.findings] == [
        (name, hidden.joint)] * is_long
    assert not said.diagnosis.ambiguous
    assert any(f'recorded every {1e3 * every / controller:g} ms' in remark
               for remark in said.diagnosis.remarks)
    assert said.extended.effect('command_delay', hidden.joint).delay == 0.0
    assert said.extended.effect('current_loop_lag', hidden.joint).time_constant == pytest.approx(
        0.012 * is_long, rel=0.05)


@pytest.mark.parametrize(('name', 'seed', 'period', 'every'), [
    (None, 930001, 1e-3, 5), ('stribeck_friction', 930003, 1e-3, 5),
    pytest.param('clock_skew', 930014, 1e-3, 5, marks=pytest.mark.study),
    ('coulomb_friction', 931002, 4e-3, 1)])
def test_a_slow_recording_is_diagnosed_as_a_quick_one(name, seed, period, every):
    hidden, measurement = recorded(name, seed, period=period, every=every)
    found = diagnose(measurement, ARM).diagnosis
    assert [(one.effect, one.joint) for one in found.findings] == [
        (one.effect, one.joint) for one in hidden]
    assert found.verdict == ('explained' if name else 'no_discrepancy')


def test_what_looks_alike_at_a_quick_rate_does_so_at_a_slow_one():
    hidden, measurement = recorded('drive_offset', 931014, every=8)
    found = diagnose(measurement, ARM).diagnosis
    pair, = found.ambiguous
    assert set(pair.effects) == {('asymmetric_friction', hidden[0].joint),
                                 ('drive_offset', hidden[0].joint)}
    assert found.findings == () and found.verdict == 'ambiguous'
    assert [one.probability for one in pair.candidates] == pytest.approx(
        2 * [0.5 * pair.probability])
    assert found.probability > 0.9
