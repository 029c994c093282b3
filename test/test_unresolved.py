"""Motion that the samples of a slow log do not resolve: found, and not judged there."""

from dataclasses import replace

from hda_torque_estimator.diagnosis.assumptions import AsRecorded
from hda_torque_estimator.diagnosis.readings.raw_readings import raw_readings
import numpy as np
import pytest
from truth import worlds
from world_fits import diagnosed
from world_samples import as_read


def recorded(seed, rate, effects=(), motion='rich'):
    """Return an arm and a log of it that moves smoothly."""
    world = worlds.draw(seed, effects, motion=motion, rate=rate, seconds=30.0)
    world = replace(world, logger=world.logger._replace(jitter=0.0))
    return as_read(world)


def shaken(measurement, begin, end, frequency, share):
    """Return readings of shafts that shake from time to time by a share of how they move."""
    time = measurement.time
    shakes = np.where((time > begin) & (time < end), np.sin(2.0 * np.pi * frequency * time), 0.0)
    reading = measurement.reading.copy()
    reading[:, :, 0] += share * reading[:, :, 0].std(axis=0) * shakes[:, None]
    return replace(measurement, reading=reading)


def judged(arm, measurement):
    """Return the balances of a measurement, which is blind where nothing is judged."""
    return AsRecorded.of(raw_readings(measurement, arm), ((0.0, 30.0),)).balancer


@pytest.mark.parametrize('rate', [100, 250, 500, 1000])
@pytest.mark.parametrize('motion', ['rich', 'trapezoid'])
def test_a_smooth_motion_is_resolved_at_any_rate(motion, rate):
    arm, measurement = recorded(770011, rate, motion=motion)
    assert not judged(arm, measurement).measurement.blind


def test_where_shafts_shake_at_a_fifth_of_the_rate_balances_hold_nothing():
    arm, measurement = recorded(770011, 250)
    balancer = judged(arm, shaken(measurement, 10.0, 15.0, 53.0, 1e-3))
    made = balancer.measurement
    found = made.is_blind[[round((second + 0.5) / made.dt) for second in range(30)]]
    assert found[11:14].all()
    assert not found[:9].any() and not found[17:].any()
    rows = made.is_blind[::balancer.every]
    assert not balancer(arm).valid[rows].any()
    assert balancer(arm).valid[~rows].any()


@pytest.mark.parametrize('effects', [
    (), pytest.param(('drive_offset',), marks=pytest.mark.study)])
def test_a_loop_that_shakes_its_arm_hides_no_cause_and_makes_none(effects):
    """At 250 Hz its shakes of 50 Hz left 2.7 times the noise of a healthy torsion."""
    world = worlds.draw(770066, effects, motion='rich', rate=250)
    said = diagnosed(world)
    assert not said.findings
    if effects:
        assert [pair.effects for pair in said.ambiguous] == [
            (('drive_offset', 'joint2'), ('asymmetric_friction', 'joint2'))]
    else:
        assert said.verdict == 'no_discrepancy'
    assert any('samples every 4 ms do not show' in remark for remark in said.remarks)
