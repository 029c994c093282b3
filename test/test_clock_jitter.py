"""Stamps that do not say when a sample was taken: simulated, found, sized, and not found."""

from dataclasses import replace

from hda_arm_sim.live import FIRST_STAMP, LiveArm, SimulationSettings
from hda_arm_sim.model.effects import ClockJitter
from hda_arm_sim.model.files import arm_from_text, read_arm
from hda_arm_sim.model.writing import arm_to_text
from hda_arm_sim.motions import motion
from hda_arm_sim.stamping import Stamper
from hda_torque_estimator.diagnosis.diagnose import diagnose
from hda_torque_estimator.diagnosis.fitting.alignment import together
from hda_torque_estimator.diagnosis.readings.late_stamps import (
    clock_jitter, smallest_jitter, stamp_slips)
from hda_torque_estimator.diagnosis.readings.raw_readings import raw_readings
from hda_torque_estimator.measurements.measurement import Measurement
from hda_torque_estimator.measurements.sample_grid import measurement_from
from hda_torque_estimator.simulating.closed_loop import run
from hda_torque_estimator.simulating.recorded import joint_samples
import numpy as np
import pytest
from scipy.signal import detrend
from truth import worlds
from world_samples import arm_of, as_read

ARM = read_arm('hda_arm.yaml')
JITTER = 1e-4
LATE = ARM.with_effect(ClockJitter(jitter=JITTER))
HALF_NORMAL = np.sqrt(1.0 - 2.0 / np.pi)        # deviation of the size of a normal number


def test_samples_wait_for_their_stamps_and_keep_their_order():
    taken = 1_000_000 * np.arange(20_000)
    late = Stamper(LATE, 1)(taken) - taken
    assert late.min() >= 0
    assert late.mean() * 1e-9 == pytest.approx(JITTER, rel=0.03)
    assert late.std() * 1e-9 == pytest.approx(JITTER, rel=0.05)
    crowded = Stamper(LATE, 1)(taken // 50)
    assert (np.diff(crowded) > 0).all()


def test_stamps_are_the_same_one_by_one_and_all_at_once_and_change_with_the_seed():
    taken = 200_000 * np.arange(300)
    one_by_one = Stamper(LATE, 3)
    apart = [int(one_by_one(taken[k:k + 1])[0]) for k in range(len(taken))]
    np.testing.assert_array_equal(apart, Stamper(LATE, 3)(taken))
    assert (Stamper(LATE, 4)(taken) != apart).any()


def test_an_arm_without_jitter_is_stamped_when_it_is_sampled():
    taken = 1_000_000 * np.arange(10)
    assert Stamper(ARM, 1)(taken) is taken
    live = LiveArm(ARM, SimulationSettings(), FIRST_STAMP)
    for k in range(5):
        sample = live.sample()
        assert sample.stamp == sample.taken == FIRST_STAMP + 1_000_000 * k
        live.advance()


def test_the_live_arm_moves_alike_states_the_stamps_of_a_run_and_hears_its_answers():
    asked = motion('rich', 2, 2.0, 1e-3, 1)
    made = run(LATE, LATE, asked, 7)
    live, usual = (LiveArm(arm, SimulationSettings(seed=7), FIRST_STAMP) for arm in (LATE, ARM))
    for k in range(200):
        sample, other = live.sample(), usual.sample()
        assert sample.taken == FIRST_STAMP + 1_000_000 * k
        assert sample.stamp == sample.taken + made.late[k]
        np.testing.assert_array_equal(sample.reading, other.reading)
        live.command(sample.stamp, np.full(2, 0.01))
        usual.command(other.stamp, np.full(2, 0.01))
        live.advance()
        usual.advance()


def test_a_run_without_jitter_is_not_changed_by_a_bit():
    asked = motion('rich', 2, 2.0, 1e-3, 1)
    made = run(ARM, ARM, asked, 7)
    again = run(ARM.with_effect(ClockJitter(jitter=0.0)), ARM, asked, 7)
    assert not made.late.any()
    for field in ('reading', 'command', 'joint_torque', 'estimated_torque', 'state'):
        np.testing.assert_array_equal(getattr(made, field), getattr(again, field))


def test_estimates_suffer_from_stamps_and_encoders_do_not():
    asked = motion('rich', 2, 3.0, 1e-3, 1)
    usual, late = (run(arm, ARM, asked, 7) for arm in (ARM, LATE))
    off = [np.abs(made.estimated_torque - made.joint_torque)[500:].mean()
           for made in (usual, late)]
    assert off[1] > 1.2 * off[0]


def test_an_arm_file_holds_it():
    assert arm_from_text(arm_to_text(LATE), 'text').effect('clock_jitter') == LATE.effect(
        'clock_jitter')


def jittering(world, jitter):
    """Return a world whose host stamps with such a jitter, in periods."""
    return replace(world, logger=world.logger._replace(jitter=jitter / world.rate))


def recorded(world, jitter=0.0):
    """Return the measurement of a world whose host stamps with such a jitter, and its arm."""
    arm, measurement = as_read(jittering(world, jitter))
    return measurement, arm


def stamps_of(world, jitter=0.0):
    """Return the stamps of the log of a world whose host stamps with such a jitter [ns]."""
    return worlds.record(jittering(world, jitter)).stamps


def found(measurement, arm):
    """Return what is found of the jitter of a measurement, and the smallest that would be."""
    seen, slips = np.ones(len(measurement.reading), bool), stamp_slips(measurement)
    return clock_jitter(slips, seen, arm), smallest_jitter(slips, seen, arm)


def more(*values):
    """Return a record that `make study` runs."""
    return pytest.param(*values, marks=pytest.mark.study)


@pytest.mark.parametrize(('seed', 'kind', 'rate'), [
    (710101, 'rich', 1000), (710102, 'rich', 250), more(710103, 'rich', 125),
    more(710104, 'constant', 1000), (710105, 'constant', 250), (710106, 'constant', 125),
    more(710107, 'trapezoid', 500), more(710108, 'sine', 100), more(710109, 'chirp', 2000)])
def test_late_stamps_of_a_host_are_found_with_their_size(seed, kind, rate):
    world = worlds.draw(seed, motion=kind, rate=rate, seconds=20.0)
    measurement, arm = recorded(world, 0.08)
    late = stamps_of(world, 0.08) - stamps_of(world)
    true = float(np.std(detrend(late))) * 1e-9      # the host's clock is a millionth slow
    cause, smallest = found(measurement, arm)
    number = cause.numbers['jitter']
    assert number.value == pytest.approx(true, rel=0.03)
    assert true == pytest.approx(HALF_NORMAL * 0.08 / rate, rel=0.06)
    assert number.low < true < number.high < number.low + 0.2 * true
    assert smallest < true


@pytest.mark.parametrize(('seed', 'kind', 'rate'), [
    (720003, 'sine', 500), more(720004, 'constant', 1000), (720008, 'rich', 250),
    more(720013, 'trapezoid', 125), more(720017, 'rich', 2000)])
def test_an_uneven_sampling_under_even_stamps_is_the_same_cause(seed, kind, rate):
    world = worlds.hide(worlds.draw(seed, motion=kind, rate=rate, seconds=20.0), 'clock_jitter',
                        np.random.default_rng([seed, 12, 0]), form='sampled')
    measurement, arm = recorded(world)
    cause, _ = found(measurement, arm)
    true = world.hidden[0].parameters['jitter']
    assert cause.numbers['jitter'].value == pytest.approx(true, rel=0.08)


@pytest.mark.parametrize(('seed', 'kind', 'rate'), [
    (710201, 'rich', 1000), more(710202, 'rich', 250), (710203, 'rich', 125),
    more(710204, 'constant', 1000), (710205, 'constant', 250), more(710206, 'constant', 125),
    (710207, 'trapezoid', 500), more(710208, 'fourier', 100), more(710209, 'chirp', 2000)])
def test_a_clock_that_is_right_or_tolerable_is_none(seed, kind, rate):
    world = worlds.draw(seed, motion=kind, rate=rate, seconds=20.0)
    measurement, arm = recorded(world)
    assert found(measurement, arm)[0] is None
    assert found(replace(measurement, past=np.zeros(0)), arm)[0] is None
    assert found(recorded(world, 0.01)[0], arm)[0] is None


@pytest.mark.parametrize('name', ['clock_skew', 'motor_encoder_eccentricity', 'base_vibration',
                                  'encoder_interpolation_error', 'command_delay'])
def test_what_other_causes_do_is_no_jitter(name):
    world = worlds.draw(710300, (name,), motion='rich', rate=500, seconds=20.0)
    measurement, arm = recorded(world)
    assert found(measurement, arm)[0] is None
    assert found(replace(measurement, past=np.zeros(0)), arm)[0] is None


def test_stamps_that_know_an_uneven_sampling_are_right():
    random = np.random.default_rng(3)
    time = 1e-3 * np.arange(20_000)
    known = 1e-4 * random.standard_normal(len(time))

    def shown(taken, said):
        link = np.stack([0.8 * np.sin(2.0 * taken), 0.5 * np.sin(3.1 * taken)], axis=1)
        motor = 100.0 * link + 1e-4 * random.standard_normal(link.shape)
        return Measurement(ARM.labels, 1e-3, np.stack([motor, link], axis=2),
                           np.zeros(link.shape), past=said)
    assert found(shown(time + known, known), ARM)[0] is None
    for taken, said in ((time + known, np.zeros(0)), (time, known), (time + known, 0.0 * known)):
        cause = found(shown(taken, said), ARM)[0]
        assert cause.numbers['jitter'].value == pytest.approx(1e-4, rel=0.05)


def test_what_few_samples_have_in_common_by_chance_is_no_jitter():
    time, accused = 1e-3 * np.arange(20_000), 0
    for seed in range(12):
        random = np.random.default_rng(seed)
        link = 0.5 * np.sin(2.0 * time) + 0.2 * np.sin(3.1 * time)
        motor = 100.0 * link + 0.015 * random.standard_normal(len(link))   # clear at its fastest
        link += 2e-5 * random.standard_normal(len(link))
        measurement = Measurement(('joint1',), 1e-3, np.stack([motor, link], axis=1)[:, None],
                                  np.zeros((len(link), 1)))
        (_, _, clear), = stamp_slips(measurement).halves
        assert 100 <= clear.sum() < 0.2 * len(time)
        accused += found(measurement, ARM)[0] is not None
    assert accused == 0


def test_no_more_is_named_than_an_arm_states():
    measurement, arm = recorded(worlds.draw(710102, motion='rich', rate=250, seconds=20.0), 0.08)
    cause, smallest = found(measurement, arm)
    stated = arm.with_effect(cause.effect)
    assert found(measurement, stated)[0] is None
    assert found(measurement, stated)[1] > cause.effect.jitter > smallest


@pytest.mark.parametrize('form', ['', 'bursts'])
def test_lost_samples_are_no_jitter_and_jitter_loses_none(form):
    lost = worlds.draw(710402, ('dropped_samples',), motion='rich', rate=1000, seconds=20.0,
                       form=form)
    lost = replace(lost, logger=lost.logger._replace(every=1))
    named = [[cause.effect.name for cause in raw_readings(measurement, arm).causes]
             for measurement, arm in (recorded(lost), recorded(lost, 0.08),
                                      recorded(replace(lost, hidden=()), 0.08))]
    assert named == [['dropped_samples'], ['dropped_samples', 'clock_jitter'], ['clock_jitter']]


def test_it_is_named_beside_nothing_else_and_the_arm_of_the_report_simulates():
    measurement, arm = recorded(worlds.draw(710102, motion='rich', rate=250, seconds=20.0), 0.08)
    said = diagnose(measurement, arm)
    one, = said.diagnosis.findings
    assert (one.effect, one.joint, one.site) == ('clock_jitter', None, 'timing')
    assert one.gain.removed > 0.9
    assert said.diagnosis.verdict == 'explained'
    model = arm_from_text(arm_to_text(said.extended), 'model')
    assert run(model, model, motion('rich', len(arm.joints), 2.0, 1e-3, 1), 1).late.any()


@pytest.mark.study
def test_of_several_recordings_the_one_that_shows_it_best_is_told():
    world = worlds.draw(710501, motion='rich', rate=500, seconds=10.0)
    parts = [recorded(replace(world, part=part), jitter)[0]
             for part, jitter in enumerate((0.0, 0.08, 0.0))]
    arm = arm_of(world)
    cause, = raw_readings(together(parts), arm).causes
    assert (cause.effect.name, cause.recording) == ('clock_jitter', 1)
    said = diagnose(together(parts), arm).diagnosis
    assert [one.effect for one in said.findings] == ['clock_jitter']


def test_what_a_simulation_stamps_is_found_in_its_recording():
    asked = motion('rich', 2, 12.0, 1e-3, 3)
    made = run(LATE, ARM, asked, 5)
    stamps = FIRST_STAMP + np.round(asked.time * 1e9).astype(np.int64) + made.late
    samples = joint_samples(ARM, stamps, made.reading, made.command)
    cause, _ = found(measurement_from(ARM.labels, samples), ARM)
    assert cause.numbers['jitter'].value == pytest.approx(JITTER, rel=0.05)
