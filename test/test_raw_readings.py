"""What raw readings show: found where it is hidden, silent where only noise or counts differ."""

from dataclasses import replace

from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import Motion, motion
from hda_msgs_json.samples import JointSamples
from hda_torque_estimator.diagnosis.balances.balance import Balancer
from hda_torque_estimator.diagnosis.readings.encoder_steps import true_step
from hda_torque_estimator.diagnosis.readings.line_alias import agrees, moves, of_codes
from hda_torque_estimator.diagnosis.readings.line_error import smallest_wave, uneven_lines
from hda_torque_estimator.diagnosis.readings.raw_readings import raw_findings, raw_readings
from hda_torque_estimator.diagnosis.readings.repeats import repeats_of
from hda_torque_estimator.measurements.even_grid import on_grid
from hda_torque_estimator.measurements.measurement import Measurement
from hda_torque_estimator.measurements.sample_grid import measurement_from
from hda_torque_estimator.simulating.closed_loop import run
import numpy as np
import pytest
from truth import Device, draw, record, Reference
from truth_cases import hide as truth_of

ARM = read_arm('hda_arm.yaml')
NAMES = ('joint1', 'joint2', 'joint1_motor', 'joint2_motor')


def measured(hidden, seed, duration=12.0, **how):
    """Return the measurement that a recording of an arm with hidden effects holds."""
    asked = motion('rich', 2, duration, 1e-3, seed)
    made = record(hidden, Reference(asked.angle, asked.rate, 1e-3), seed=seed, **how)
    absent = np.full((len(made.stamps), 2), np.nan)
    return measurement_from(ARM.labels, JointSamples(
        made.stamps, NAMES, np.column_stack([made.link_angle, made.motor_angle]),
        np.full((len(made.stamps), 4), np.nan), np.column_stack([absent, made.command])))


def counting(motor, link):
    """Return the arm with other counts of its encoders."""
    return replace(ARM, joints=tuple(
        replace(joint, motor_encoder=replace(joint.motor_encoder, counts=motor),
                link_encoder=replace(joint.link_encoder, counts=link)) for joint in ARM.joints))


def hide(name, seed):
    """Return a drawn effect."""
    return draw(name, np.random.default_rng([seed, sum(map(ord, name))]))


@pytest.mark.parametrize(('seed', 'noise'), [(900, 1.0), (901, 2.0)])
def test_healthy_readings_show_nothing(seed, noise):
    healthy = measured([], seed, noise=noise)
    raw = raw_readings(healthy, ARM)
    assert raw.causes == ()
    assert raw.arm == ARM
    assert (raw.measurement.reading == on_grid(healthy).reading).all()


def swung(taken, stamped):
    """Return the measurement of a swing whose samples are taken at times, and stamped [s]."""
    link = np.outer(np.sin(3.0 * taken), [0.8, 0.5])
    step = np.array([joint.link_encoder.step for joint in ARM.joints])
    link = np.floor(link / step) * step
    position = np.column_stack([link, 100.0 * link])
    return measurement_from(ARM.labels, JointSamples(
        np.rint(1e9 * stamped).astype(np.int64), NAMES, position,
        np.full(position.shape, np.nan), np.zeros(position.shape)))


@pytest.mark.parametrize(('dt', 'seed'), [(1e-3, 906), (4e-3, 907), (8e-3, 908)])
def test_a_joint_that_stands_and_shakes_by_less_than_a_line_has_no_line_error(dt, seed):
    random, step = np.random.default_rng(seed), 3.7e-7
    angle = step * np.rint(3e-6 * random.standard_normal(5000) / step)
    angle[:1000] += np.linspace(-0.1, 0.0, 1000)            # it comes to rest
    assert list(uneven_lines(of_link(angle, dt), ARM, np.ones(5000, bool))) == []
    assert smallest_wave(angle[1000:], dt, np.ones(4000, bool), step) is None


def of_link(angle, dt):
    """Return a measurement in which only the second link moves."""
    reading = np.zeros((len(angle), 2, 2))
    reading[:, 1, 1] = angle
    return Measurement(ARM.labels, dt, reading, np.zeros((len(angle), 2)))


def test_readings_go_to_the_ticks_of_their_stamps():
    ticks = 1e-3 * np.arange(5000)
    late = 20e-6 * np.random.default_rng(904).standard_normal(5000)
    late[[0, -1]] = 0.0                                     # time begins and is counted there
    even, jittered = (on_grid(swung(taken, taken)).reading for taken in (ticks, ticks + late))
    apart = np.abs(jittered - even)[5:-5]
    assert (apart[:, :, 1] < 5e-6).all()        # a count, and what jitter does to the speed
    assert np.abs(swung(ticks + late, ticks + late).reading - even).max() > 1e-4


def test_stamps_that_do_not_show_when_a_sample_was_taken_are_left_aside():
    ticks = 1e-3 * np.arange(5000)
    reported = swung(ticks, ticks + 50e-6 * np.random.default_rng(905).standard_normal(5000))
    assert reported.past.any()
    assert (on_grid(reported).reading == reported.reading).all()


@pytest.mark.parametrize('counts', [(4096, 1e6), (1024, 2e5)])
def test_coarser_encoders_show_nothing_where_they_are_stated(counts):
    measurement = measured([], 902, device=Device(counts=counts))
    assert raw_readings(measurement, counting(*counts)).causes == ()


def test_finer_encoders_show_nothing():
    assert raw_readings(measured([], 903, device=Device(counts=(65536, 1.6e7))), ARM).causes == ()


@pytest.mark.parametrize('seed', [100, 102])       # a motor encoder, and a link encoder
def test_true_step_is_found_and_counts_from_then_on(seed):
    hidden = hide('coarse_quantisation', seed)
    cause, = raw_readings(measured([hidden], seed), ARM).causes
    side = 'motor_step' if hidden.parameters['motor_side'] else 'link_step'
    assert (cause.effect.name, cause.joint) == ('coarse_quantisation', hidden.joint)
    fitted = cause.numbers[side]
    assert fitted.low <= hidden.parameters['step'] <= fitted.high
    assert fitted.value == pytest.approx(hidden.parameters['step'], rel=1e-9)
    assert set(cause.numbers) == {side}
    assert getattr(cause.on(ARM).effect(cause.effect.name, cause.joint), side) == fitted.value


@pytest.mark.parametrize('least', [1, 2, 3])
def test_step_is_found_where_a_fast_encoder_skips_counts(least):
    counts = np.cumsum(np.random.default_rng(3).integers(least, 40, 500))
    step = true_step(0.01 * counts, np.zeros(500, bool))
    assert step is not None and step.size == pytest.approx(0.01)


def passed(passes, scatter, seed=3):
    """Return angles at a constant speed both ways, with a scatter, in steps of a sample's way."""
    way = np.arange(0.0, 700.0)
    angle = np.concatenate([way + 0.4 * number if number % 2 else way[::-1]
                            for number in range(passes)])
    return 1e-3 * (angle + scatter * np.random.default_rng(seed).standard_normal(len(angle)))


@pytest.mark.parametrize('uneven', [0.1, 0.4])
@pytest.mark.parametrize('step', [0.3e-3, 4.7e-3])      # less than a sample's way, and more
def test_the_step_of_a_scale_that_is_not_even_is_found(uneven, step):
    codes = np.round(passed(8, 0.3) / step)
    angle = step * (codes + uneven * np.sin(2.0 * np.pi * codes / 32.0))
    reported = true_step(angle, np.zeros(len(angle), bool))
    assert reported is not None and reported.size == pytest.approx(step, rel=0.05)


@pytest.mark.parametrize('passes', [1, 2, 3, 8])
@pytest.mark.parametrize('scatter', [0.03, 0.3, 3.0])
def test_what_a_fine_encoder_passes_in_a_sample_is_no_step(passes, scatter):
    angle = passed(passes, scatter)
    assert true_step(angle, np.zeros(len(angle), bool)) is None


def test_readings_without_steps_have_none():
    angle = np.sin(np.linspace(0.0, 1.0, 500) ** 2)
    assert true_step(angle, np.zeros(500, bool)) is None


def test_only_what_is_asked_for_is_looked_for():
    coarse = measured([hide('coarse_quantisation', 100)], 100)
    assert raw_readings(coarse, ARM, names=['clock_skew']).causes == ()


@pytest.mark.parametrize('seed', [100, 101])
def test_slipped_samples_are_counted_and_mended(seed):
    hidden = hide('dropped_samples', seed)
    whole, found = measured([], seed, duration=20.0), measured([hidden], seed, duration=20.0)
    raw = raw_readings(found, ARM)
    cause, = raw.causes
    assert (cause.effect.name, cause.joint) == ('dropped_samples', None)
    fitted, rate = cause.numbers['rate'], hidden.parameters['rate']
    hits = rate * len(found.command)
    assert fitted.low < fitted.value < fitted.high
    assert fitted.value == pytest.approx(rate, rel=3.0 / np.sqrt(hits))
    joint = ARM.joints[0]
    for side, step in enumerate((joint.motor_encoder.step, joint.link_encoder.step)):
        rough, mended, usual = (
            np.square(np.diff(reading[:, :, side], 2, axis=0)).mean()
            for reading in (found.reading, raw.measurement.reading, on_grid(whole).reading))
        assert rough > usual + step ** 2
        assert mended == pytest.approx(usual, rel=0.2)


def test_slips_are_found_behind_coarse_counts():
    hidden = [hide('dropped_samples', 100), hide('coarse_quantisation', 100)]
    raw = raw_readings(measured(hidden, 100, duration=20.0), ARM)
    assert [cause.effect.name for cause in raw.causes] == ['coarse_quantisation',
                                                           'dropped_samples']
    assert raw.arm.effect('dropped_samples').is_neutral()      # the readings are mended


def test_repeated_readings_at_standstill_are_no_slips():
    still = motion('standstill', 2, 12.0, 1e-3, 0)
    made = record([], Reference(still.angle, still.rate, 1e-3), seed=904)
    reading = np.stack([made.motor_angle, made.link_angle], axis=2)
    assert (np.diff(reading[:, :, 0], axis=0) == 0.0).mean() > 0.1
    assert raw_readings(Measurement(ARM.labels, 1e-3, reading, made.command), ARM).causes == ()


def test_a_pause_of_the_recording_is_no_lost_sample():
    healthy = measured([], 905)
    paused = replace(healthy, absent=tuple(range(5000, 5400)))
    assert raw_readings(paused, ARM).causes == ()


@pytest.mark.parametrize('seed', [100, 101, 102])
def test_uneven_lines_are_found_and_taken_out(seed):
    hidden = hide('encoder_interpolation_error', seed)
    whole, found = measured([], seed), measured([hidden], seed)
    raw = raw_readings(found, ARM)
    cause, = raw.causes
    assert (cause.effect.name, cause.joint) == ('encoder_interpolation_error', hidden.joint)
    fitted, true = cause.numbers, hidden.parameters
    assert fitted['amplitude'].value == pytest.approx(true['amplitude'], rel=0.03)
    assert fitted['lines'].value == true['lines']
    assert fitted['lines'].low < true['lines'] < fitted['lines'].high
    zero = 30e-6 * true['lines']                # phases are at readings, not at angles, of zero
    assert np.sin(0.5 * (fitted['phase'].value - true['phase'])) == pytest.approx(0.0, abs=zero)
    column = ARM.labels.index(hidden.joint)
    rough, mended, usual = (
        np.square(np.diff(reading[:, column, 1], 2)).mean()
        for reading in (found.reading, raw.measurement.reading, on_grid(whole).reading))
    assert rough > 2.0 * usual
    assert mended == pytest.approx(usual, rel=0.2)


@pytest.mark.parametrize('name', ['kinematic_error', 'motor_cogging', 'torque_ripple'])
def test_what_the_arm_itself_does_along_a_turn_is_no_error_of_lines(name):
    assert raw_readings(measured([hide(name, 102)], 102, duration=20.0), ARM).causes == ()


def test_numbers_come_from_the_training_stretches_alone():
    hidden = measured([hide('encoder_interpolation_error', 100)], 100)
    healthy = measured([], 100)
    late = hidden.time[:, None, None] >= 6.0
    mixed = replace(healthy, reading=np.where(late, hidden.reading, healthy.reading))
    assert raw_readings(mixed, ARM, training=((0.0, 5.9),)).causes == ()
    assert raw_readings(mixed, ARM, training=((6.1, 12.0),)).causes != ()


def test_each_cause_gains_on_held_out_stretches_beside_the_others():
    hidden = [hide(name, 104) for name in ('dropped_samples', 'coarse_quantisation',
                                           'encoder_interpolation_error')]
    found = measured(hidden, 104, duration=18.0)
    raw = raw_readings(found, ARM, training=((0.0, 4.0), (6.0, 10.0), (12.0, 16.0)))
    findings = raw_findings(raw, found, Balancer(raw.measurement), ARM, raw.arm,
                            ((4.0, 6.0), (10.0, 12.0), (16.0, 18.0)))
    assert {(one.effect, one.joint) for one in findings} == {(one.effect,
                                                              one.joint) for one in hidden}
    for one in findings:
        assert one.site in ('sensing', 'timing')
        assert one.evidence.score > one.evidence.threshold
        assert one.gain.removed > 0.9
        assert one.gain.after < 0.1 * one.gain.before


@pytest.mark.parametrize('ends, gains', [(12.0, True), (6.0, False)])
def test_samples_that_stamps_alone_show_as_lost_gain_where_they_go_on_being_lost(ends, gains):
    """Readings are right, and so are the stamps: some rows are missing until a time [s]."""
    healthy = measured([], 906)
    missing = np.flatnonzero(np.random.default_rng(906).random(len(healthy.command)) < 0.01)
    missing = missing[(missing > 50) & (missing < min(1000.0 * ends, 11950.0))]
    found = replace(healthy, absent=tuple(missing.tolist()))
    raw = raw_readings(found, ARM, training=((0.0, 6.0),))
    cause, = raw.causes
    assert cause.numbers['rate'].low < 0.01 < cause.numbers['rate'].high
    findings = raw_findings(raw, found, Balancer(raw.measurement), ARM, raw.arm,
                            ((6.0, 8.0), (8.0, 10.0), (10.0, 12.0)))
    assert [one.effect for one in findings] == ['dropped_samples'] * gains
    assert all(one.gain.removed > 0.9 for one in findings)


def test_a_wave_gains_at_a_rate_at_which_readings_change_by_more_than_it():
    """Between samples 4 ms apart an acceleration turns a link by thirty times the wave."""
    wave = truth_of('encoder_interpolation_error', 'joint2', amplitude=5.4e-6, lines=9000.0,
                    phase=-1.8)
    fine = measured([wave], 109, duration=30.0)
    slow = Measurement(ARM.labels, 4.0 * fine.dt, np.ascontiguousarray(fine.reading[::4]),
                       np.ascontiguousarray(fine.command[::4]))
    raw = raw_readings(slow, ARM, training=((0.0, 20.0),))
    found, = raw_findings(raw, slow, Balancer(raw.measurement), ARM, raw.arm, ((20.0, 30.0),))
    assert (found.effect, found.joint) == (wave.effect, wave.joint)
    assert found.gain.removed > 0.8


def back_and_forth(arm, speed, rate, duration=20.0):
    """Return the readings of a healthy arm that moves at constant speed both ways."""
    time = np.arange(round(duration * rate)) / rate
    turns = time * speed / 4.0
    away = np.abs((turns[:, None] * [1.0, 1.3][:len(arm.joints)] + 0.25) % 1.0 - 0.5) * 4.0 - 1.0
    made = run(arm, arm, Motion(time, away, np.gradient(away, 1.0 / rate, axis=0),
                                np.zeros((len(time), 2))), 1)
    return Measurement(arm.labels, 1.0 / rate, np.ascontiguousarray(made.reading[:, :, :2]),
                       made.command)


@pytest.mark.parametrize('name', ['hda_arm.yaml', 'paper_single_axis.yaml'])
@pytest.mark.parametrize(('speed', 'rate'), [(0.1, 250.0), (0.1, 500.0), (0.1, 1000.0),
                                             (0.3, 1000.0), (1.0, 1000.0)])
def test_counts_at_constant_speed_are_no_error_of_lines(name, speed, rate):
    """Sampled counts make waves of any number of lines: aliases, which a wave must not be."""
    arm = read_arm(name)
    assert raw_readings(back_and_forth(arm, speed, rate), arm).causes == ()


def test_a_wave_that_samples_do_not_resolve_is_not_looked_for():
    time = 1e-3 * np.arange(8000)
    quick = 12.0 * np.sin(time)                         # 2500 lines pass in 2 samples or fewer
    rows = np.abs(np.cos(time)) > 0.2
    assert smallest_wave(quick, 1e-3, rows, 1e-6) is None


def wave(lines, swing, seed=3):
    """Return angle, speed, the sine and cosine of lines, and noise over a swing."""
    time = 1e-3 * np.arange(8000)
    angle, speed = swing * np.sin(time), swing * np.cos(time)
    noise = np.random.default_rng(seed).standard_normal(len(time))
    return angle, speed, np.stack([np.sin(lines * angle), np.cos(lines * angle)]), noise


def test_a_wave_of_one_phase_agrees_and_one_of_another_phase_each_way_does_not():
    _, speed, columns, noise = wave(3000, 0.5)
    assert agrees(speed, columns, columns[0] + noise)
    assert not agrees(speed, columns, np.where(speed > 0.0, columns[0], columns[1]) + noise)


@pytest.mark.parametrize(('amplitude', 'codes', 'reach', 'is_theirs'), [
    (0.5, 4.0, 1e-6, True), (1.2, 4.0, 1e-6, False),       # of more than a step none is
    (0.5, 4.0001, 1e-6, False), (0.5, 4.0001, 1e-5, True)])
def test_a_wave_over_whole_steps_that_is_less_than_one_is_of_the_codes(amplitude, codes, reach,
                                                                       is_theirs):
    step = 1.5e-4
    lines = 2.0 * np.pi / (codes * step)
    assert of_codes(amplitude * step, lines, reach * lines, step) is is_theirs


def test_codes_that_a_coarse_encoder_skips_are_no_error_of_lines():
    """A step too little at each fourth code makes a wave of half a step over four of them."""
    found = measured([], 941)
    step, angle = 1.5e-4, found.reading[:, 0, 1]
    codes = np.floor(angle / step)
    reading = found.reading.copy()
    reading[:, 0, 1] = step * (codes - (codes % 4.0 == 0.0))
    raw = raw_readings(replace(found, reading=reading), ARM)
    assert [(one.effect.name, one.joint) for one in raw.causes] == [
        ('coarse_quantisation', 'joint1')]


def test_what_the_motor_shows_as_well_is_no_error_of_one_encoder():
    """Jitter of the stamps and true movement are in both."""
    _, _, columns, noise = wave(3000, 0.5)
    assert moves(columns, columns[0], columns[0] + noise)
    assert not moves(columns, columns[0], noise)


@pytest.mark.parametrize('step', [0.0, 2.0 * np.pi / 2 ** 16])
@pytest.mark.parametrize('rate', [0.0, 0.008, 0.02])
def test_repeated_rows_are_counted_where_stamps_jitter(rate, step):
    """Stamps that nothing is known of: each sample slips by a tenth, and is no lost one."""
    random = np.random.default_rng(7)
    taken = 0.01 * (np.arange(6000) + 0.1 * random.standard_normal(6000))
    link = np.stack([0.8 * np.sin(0.9 * taken), 0.5 * np.sin(1.3 * taken)], axis=1)
    again = np.maximum.accumulate(np.where(random.random(6000) < rate, 0, np.arange(6000)))
    motor = 100.0 * link + 1e-4 * random.standard_normal(link.shape)
    reading = np.stack([motor, np.round(link / step) * step if step else link], axis=2)[again]
    raw = raw_readings(Measurement(ARM.labels, 0.01, reading, np.zeros(link.shape)), ARM,
                       names=['dropped_samples'])
    fitted = [cause.numbers['rate'].value for cause in raw.causes]
    true = float((again != np.arange(6000)).mean())
    assert fitted == ([] if rate == 0.0 else [pytest.approx(true, rel=0.15)])


def test_a_noisy_encoder_of_fine_counts_repeats_nothing():
    """Of changes with a noise of ten counts one in thirty is none by chance."""
    random, time = np.random.default_rng(11), np.arange(120000) / 2000.0
    step = np.full((1, 2), 1e-7)
    angle = 0.006 * np.sin(2.0 * time)[:, None, None] + 7e-7 * random.standard_normal(
        (len(time), 1, 2))
    reading = np.round(angle / step) * step
    assert (np.diff(reading, axis=0) == 0.0).mean() > 0.002
    healthy = repeats_of(reading, step)
    assert not healthy.repeated.any()
    places = np.arange(600, len(time) - 600, 997)
    places = places[np.abs(np.cos(2.0 * time[places])) > 0.9]
    reading[places] = reading[places - 1]
    assert (repeats_of(reading, step).repeated[places]).mean() > 0.7
