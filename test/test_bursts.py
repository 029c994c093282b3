"""Mishaps of samples that come in bursts: found, mended, and left aside where nothing is known."""

from dataclasses import replace

from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import motion
from hda_torque_estimator.diagnosis.balances.balance import Balancer
from hda_torque_estimator.diagnosis.readings.lost_samples import slips_of
from hda_torque_estimator.diagnosis.readings.repeats import repeats_of
from hda_torque_estimator.measurements.joined_recordings import joined
from hda_torque_estimator.measurements.measurement import Measurement
from hda_torque_estimator.measurements.upsampling import finer
import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from truth import record, Reference, worlds
from world_fits import diagnosed

ARM = read_arm('hda_arm.yaml')


def healthy_one(seed):
    """Return the measurement of an arm with nothing hidden in it."""
    asked = motion('rich', 2, 12.0, 1e-3, seed)
    made = record([], Reference(asked.angle, asked.rate, 1e-3), seed=seed)
    reading = np.stack([made.motor_angle, made.link_angle], axis=2)
    return Measurement(ARM.labels, 1e-3, reading, made.command)


def spoiled(healthy, wrong, seed):
    """Return a measurement in which samples are lost, stale or late by turns of chance."""
    random, places = np.random.default_rng(seed), np.flatnonzero(wrong)
    kind = random.integers(3, size=len(places))
    count = np.arange(len(wrong))
    reading = healthy.reading.copy()
    late = places[kind == 2]
    reading[late] = CubicSpline(count, healthy.reading)(late + random.uniform(0.3, 0.9, len(late)))
    lost = places[kind == 0]
    came = np.setdiff1d(count, lost)
    for place in places[kind == 1]:                         # the last one that was fresh, or late
        reading[place] = reading[came[np.searchsorted(came, place) - 1]]
    for column in reading.reshape(len(wrong), -1).T:
        column[lost] = np.interp(lost, came, column[came])
    return replace(healthy, reading=reading, absent=tuple(lost.tolist()))


def begun(count, apart, length, seed):
    """Return where so many samples (k,) in a row are wrong, every so often."""
    first = np.arange(300, count - 300, apart)
    first += np.random.default_rng(seed).integers(apart // 2, size=len(first))
    wrong = np.zeros(count, bool)
    wrong[first[:, None] + np.arange(length)] = True
    return wrong


@pytest.mark.parametrize('seed', [910, 911])
def test_all_of_a_burst_is_found_and_nothing_else(seed):
    healthy = healthy_one(seed)
    wrong = begun(len(healthy.command), 200, 8, seed)
    burst = spoiled(healthy, wrong, seed)
    slips = slips_of(burst, ARM)
    found = slips.slipped | burst.put_in
    assert (found & ~wrong).sum() == 0
    assert (wrong & ~found & slips.watched).sum() <= 0.01 * wrong.sum()
    rough, mended = (np.abs(reading - healthy.reading).max(axis=(0))
                     for reading in (burst.reading, slips.reading))
    assert (mended < 0.2 * rough).all()
    blind = np.zeros(len(wrong), bool)
    blind[list(slips.blind)] = True
    assert (blind & ~wrong).sum() == 0


def test_the_motion_in_a_long_gap_is_not_known_and_in_a_short_one_is():
    healthy = healthy_one(912)
    count = len(healthy.command)
    single, burst = (slips_of(spoiled(healthy, begun(count, 100, length, 1), 1), ARM)
                     for length in (1, 8))
    assert single.blind == ()
    assert len(burst.blind) > 0.9 * begun(count, 100, 8, 1).sum()


def test_a_streak_of_repeats_is_judged_by_the_reading_after_it():
    time, step = np.arange(4000) / 1000.0, np.full((1, 2), 1e-6)
    angle = np.sin(2.0 * time)[:, None, None] * [[100.0, 1.0]]
    places = np.arange(400, 3600, 400)
    stale, stopped = angle.copy(), angle.copy()
    for late in (1, 2, 3):
        stale[places + late] = stale[places]
    stopped[2000:] = angle[np.maximum(np.arange(2000, 4000) - 3, 2000)]
    again = repeats_of(stale, step).repeated
    assert (np.flatnonzero(again) == (places[:, None] + [1, 2, 3]).ravel()).all()
    assert not repeats_of(stopped, step).repeated.any()


def test_nothing_is_judged_where_nobody_knows_the_motion():
    healthy = healthy_one(913)
    blind = replace(healthy, blind=(5000, 5001))
    known, unknown = (Balancer(one)(ARM).valid.any(axis=1) for one in (healthy, blind))
    lacking = Balancer(blind).time[known & ~unknown]
    assert lacking.min() < 5.0 < lacking.max()
    assert np.ptp(lacking) < 0.1
    count = len(healthy.command)
    assert joined([healthy, blind]).blind == (count + 5000, count + 5001)
    assert joined([healthy, blind]).recordings()[1].blind == blind.blind
    slow = replace(blind, dt=4.0 * blind.dt)
    assert finer(slow).blind == tuple(range(20000, 20008))
    assert finer(slow).as_recorded().blind == blind.blind


@pytest.mark.study
@pytest.mark.parametrize(('seed', 'motion', 'rate'), [
    (760001, 'rich', 1000), (760006, 'sine', 1000), (760008, 'rich', 250)])
def test_bursts_are_named_and_leave_nothing_else(seed, motion, rate):
    world = worlds.draw(seed, ('dropped_samples',), motion=motion, rate=rate, form='bursts')
    said = diagnosed(world)
    assert said.verdict == 'explained'
    assert [one.effect for one in said.findings] == ['dropped_samples']
