"""The watch reports what no arm can do, and nothing of what healthy arms do."""

from functools import cache
import math

from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import motion
from hda_torque_estimator.samples.sample_faults import Fault
from hda_torque_estimator.samples.sample_judge import judge, WATCH_MEMORY
from hda_torque_estimator.samples.sample_limits import LATENESS, RATIO, SPEED, STEP, watch_limits
from hda_torque_estimator.samples.sample_watch import SampleWatch
from hda_torque_estimator.simulating.closed_loop import run
from hypothesis import example, given, settings, strategies as st
import numpy as np
import pytest

ARMS = ('hda_arm.yaml', 'paper_single_axis.yaml', 'paper_table1.yaml')
TORSION_ONLY = ('kinova_gen3.yaml', 'voraus_yucobot.yaml')
TURN = 2.0 * math.pi


@cache
def recorded(arm, name, seed):
    """Return readings (k, n, 4) of a healthy arm at 2 kHz."""
    known = read_arm(arm)
    made = run(known, known, motion(name, len(known.joints), 3.0, 5e-4, seed), seed).reading
    made.flags.writeable = False
    return made


@cache
def imagined(arm, seed):
    """Return readings (k, n, 4) at 2 kHz of a torsion-only arm that moves, stops and stands."""
    known, random = read_arm(arm), np.random.default_rng(seed)
    time = 5e-4 * np.arange(6000.0)
    ratio = np.array([joint.ratio for joint in known.joints])
    rate = random.uniform(0.2, 2.5, len(ratio))         # link, rad/s
    fade = np.clip(0.5 + np.sin(TURN * time * random.uniform(0.3, 1.0)), 0.0, 1.0)[:, None]
    link = np.cumsum(rate * fade * 5e-4, axis=0)
    reading = np.stack([link * ratio, link, np.full_like(link, np.nan),
                        np.full_like(link, np.nan)], axis=2)
    for j, joint in enumerate(known.joints):
        for side, encoder in enumerate((joint.motor_encoder, joint.link_encoder)):
            column = reading[:, j, side]
            column += random.standard_normal(len(column)) * encoder.noise
            if encoder.step:
                column[:] = np.floor(column / encoder.step) * encoder.step
    return reading


def stamps_of(count, divisor, jitter, random):
    """Return growing stamps [ns]: each sample is stamped up to `jitter` [s] late by its host."""
    even = 500_000 * divisor * np.arange(1, count + 1) + 10**9
    late = even + (random.uniform(0.0, max(jitter, 1e-12), count) * 1e9).astype(np.int64)
    return np.maximum.accumulate(late) + np.arange(count)


def faults(arm, stamps, reading):
    """Return the faults that are reported, with the numbers of their samples."""
    watch = SampleWatch(read_arm(arm))
    reported = []
    for k, (stamp, each) in enumerate(zip(stamps.tolist(), reading)):
        if fault := watch.look(stamp, np.ascontiguousarray(each)):
            reported.append((k, fault, watch.sentence))
    return reported


@settings(max_examples=60)
@given(st.sampled_from(ARMS + TORSION_ONLY), st.sampled_from(['rich', 'sine', 'push', 'turn']),
       st.integers(0, 2), st.sampled_from([1, 2, 4, 10, 20]),
       st.tuples(st.floats(0.0, 1e-3), st.floats(0.0, 0.5)), st.booleans(),
       st.integers(0, 2 ** 32))
def test_healthy_arms_are_not_accused(arm, name, seed, divisor, late_and_lost, blind, draw):
    """From 100 Hz to 2 kHz, with late stamps, lost samples and without velocities."""
    random, (jitter, loss) = np.random.default_rng(draw), late_and_lost
    whole = imagined(arm, seed) if arm in TORSION_ONLY else recorded(arm, name, seed)
    reading = whole[random.integers(divisor)::divisor].copy()
    if blind:
        reading[:, :, 2:] = np.nan
    kept = random.uniform(size=len(reading)) >= loss
    stamps = stamps_of(len(reading), divisor, jitter, random)
    assert faults(arm, stamps[kept], reading[kept]) == []


@settings(max_examples=20)
@given(st.sampled_from(ARMS + TORSION_ONLY), st.sampled_from([64, 512, 4096]), st.booleans(),
       st.sampled_from([1, 2, 10]), st.floats(0.0, 0.15), st.integers(0, 2 ** 32))
@example('voraus_yucobot.yaml', 64, False, 10, 0.125, 101)     # five in a row are lost
def test_coarse_encoders_and_held_samples_are_not_accused(
        arm, counts, links_too, divisor, share, draw):
    """A driver that repeats the last sample where one was lost; counts that the arm lacks."""
    random = np.random.default_rng(draw)
    whole = imagined(arm, 1) if arm in TORSION_ONLY else recorded(arm, 'rich', 1)
    reading = whole[::divisor].copy()
    reading[:, :, 0] = np.floor(reading[:, :, 0] * counts / TURN) * TURN / counts
    if links_too:
        step = TURN / (64.0 * counts)
        reading[:, :, 1] = np.floor(reading[:, :, 1] / step) * step
    for k in np.flatnonzero(random.uniform(size=len(reading)) < share):
        reading[k] = reading[max(k - 1, 0)]
    assert faults(arm, stamps_of(len(reading), divisor, 0.0, random), reading) == []


@pytest.mark.parametrize(('divisor', 'share', 'within'), [
    (1, 0.0, 19), (1, 0.14, 19), (5, 0.0, 7), (5, 0.14, 10), (10, 0.14, 10)])
def test_readings_that_freeze_are_told_by_what_a_log_loses(divisor, share, within):
    """From 200 Hz to 2 kHz: the more samples a log loses, the longer a streak of them may be."""
    random, reading = np.random.default_rng(4), recorded('hda_arm.yaml', 'sine', 0)
    reading, begin = reading[::divisor].copy(), 3200 // divisor
    for k in np.flatnonzero(random.uniform(size=begin) < share):
        reading[k] = reading[max(k - 1, 0)]
    reading[begin:] = reading[begin - 1]
    sample, fault, _ = faults('hda_arm.yaml', stamps_of(len(reading), divisor, 0.0, random),
                              reading)[0]
    assert fault is Fault.FROZEN
    assert begin + within - 3 <= sample <= begin + within


def test_rest_is_not_frozen():
    reading = np.tile(recorded('hda_arm.yaml', 'sine', 0)[0], (3000, 1, 1))
    assert faults('hda_arm.yaml', stamps_of(3000, 2, 0.0, np.random.default_rng()), reading) == []


BEGIN = 600             # of the disturbance: both joints turn then [samples at 1 kHz]


def disturbed(fault):
    """Return stamps [ns] and readings at 1 kHz that are wrong from BEGIN on."""
    reading = recorded('hda_arm.yaml', 'sine', 0)[2000::2].copy()
    stamps = stamps_of(len(reading), 2, 0.0, np.random.default_rng(0))
    return fault(stamps, reading)


def changed(place, law):
    """Return a disturbance of one reading (joint, side)."""
    def disturb(stamps, reading):
        later = reading[BEGIN:]
        later[(slice(None), *place)] = law(later[(slice(None), *place)])
        return stamps, reading
    return disturb


def other_names(stamps, reading):
    """Change the names of both joints."""
    reading[BEGIN:] = reading[BEGIN:, ::-1]
    return stamps, reading


def other_motors(stamps, reading):
    """Change the names of the motors alone."""
    reading[BEGIN:, :, 0] = reading[BEGIN:, ::-1, 0]
    return stamps, reading


def second(shift, stamp_shift):
    """Return a second publisher, its links elsewhere by `shift` [rad], its stamps by [ns]."""
    def disturb(stamps, reading):
        other = reading[BEGIN:].copy()
        other[:, :, :2] += [100.0 * shift, shift]
        both = np.stack([reading[BEGIN:], other], axis=1).reshape(-1, *reading.shape[1:])
        reported = np.stack([stamps[BEGIN:], stamps[BEGIN:] + stamp_shift], axis=1).ravel()
        return np.concatenate([stamps[:BEGIN], reported]), np.concatenate([reading[:BEGIN], both])
    return disturb


def backwards(stamps, reading):
    """Put the clock back by an hour."""
    stamps[BEGIN:] -= 3600 * 10**9
    return stamps, reading


@pytest.mark.parametrize(('disturb', 'expected', 'within'), [
    (changed((0, 0), lambda x: x * math.nan), Fault.NOT_FINITE, 0),
    (changed((0, 1), lambda x: x + 1e300), Fault.BEYOND_ANGLE, 0),
    (changed((1, 0), lambda x: x + 1e3), Fault.BEYOND_ANGLE, 0),
    (changed((1, 1), lambda x: x + 0.5), Fault.JUMP, 0),
    (changed((0, 0), lambda x: x + TURN), Fault.TURN, 0),
    (changed((0, 0), lambda x: x - TURN), Fault.TURN, 0),
    (changed((0, 1), lambda x: x - TURN), Fault.BEYOND_ANGLE, 0),
    (changed((0, 0), lambda x: (x + math.pi) % TURN - math.pi), Fault.TURN, 0),
    (changed((0, 1), lambda x: x[0] + 0.0 * x), Fault.FROZEN, 20),
    (changed((0, 0), lambda x: x[0] + 0.0 * x), Fault.FROZEN, 20),
    (changed((slice(None), slice(None)), lambda x: x[0] + 0.0 * x), Fault.FROZEN, 20),
    (changed((0, 2), lambda x: 1000.0 * x), Fault.SPEED, 40),
    (changed((0, 3), lambda x: 1e300 + x), Fault.SPEED, 40),
    (changed((0, 0), lambda x: x[0] + 3.0 * (x - x[0])), Fault.APART, 20),
    (changed((0, 0), lambda x: 2.0 * x[0] - x), Fault.APART, 20),
    (other_names, Fault.JUMP, 0), (other_motors, Fault.JUMP, 0),
    (second(0.5, 300_000), Fault.JUMP, 1), (second(0.0, -500_000), Fault.TWO_PUBLISHERS, 6),
    (backwards, Fault.CLOCK_BACK, 0),
])
def test_what_no_arm_can_do_is_reported_in_time(disturb, expected, within):
    """In one sentence; the fault comes within so many samples of the first wrong one."""
    stamps, reading = disturbed(disturb)
    reported = [each for each in faults('hda_arm.yaml', stamps, reading)
                if each[1] is not Fault.NOT_LATER]
    sample, fault, sentence = reported[0]
    assert BEGIN <= sample <= BEGIN + within
    assert fault is expected, sentence
    assert 30 < len(sentence) < 250
    assert fault.reason


def test_two_publishers_are_named_when_both_go_on():
    reported = faults('hda_arm.yaml', *disturbed(second(0.5, 300_000)))
    assert [fault for _, fault, _ in reported[:3]] == [
        Fault.JUMP, Fault.TWO_PUBLISHERS, Fault.TWO_PUBLISHERS]


def test_motors_of_another_joint_are_detected_at_the_first_sample_if_zeros_are_known():
    reading = recorded('hda_arm.yaml', 'sine', 0)[0].copy()
    reading[:, 0] = reading[::-1, 0]
    watch = SampleWatch(read_arm('hda_arm.yaml'), apart=0.05)
    assert watch.look(1, reading) is Fault.APART
    assert SampleWatch(read_arm('hda_arm.yaml')).look(1, reading) is Fault.NONE


def test_a_fault_changes_nothing_and_a_watch_begins_anew():
    reading = recorded('hda_arm.yaml', 'sine', 0)
    watch = SampleWatch(read_arm('hda_arm.yaml'))
    watch.look(500_000, reading[0])
    wrong = reading[1].copy()
    wrong[0, 0] = math.nan
    assert watch.look(1_000_000, wrong) is Fault.NOT_FINITE
    assert watch.look(1_500_000, reading[2]) is Fault.NONE
    assert watch.sentence == ''
    watch.begin()
    assert watch.look(1, reading[2000]) is Fault.NONE


@pytest.mark.parametrize(('share', 'fault'), [(0.99, Fault.NONE), (1.01, Fault.JUMP)])
def test_a_shaft_goes_as_far_as_its_limit_lets_it(share, fault):
    limits, reported, dt = watch_limits(read_arm('hda_arm.yaml')), np.zeros(5), 0.05
    memory, reading = np.zeros((2, WATCH_MEMORY)), recorded('hda_arm.yaml', 'sine', 0)[0].copy()
    assert judge(limits, memory, reading, 0.0, reported) == Fault.NONE
    way = share * (limits[0, SPEED] * (dt + LATENESS) + limits[0, STEP])
    reading[0, :2] += way, way / limits[0, RATIO]
    assert judge(limits, memory, reading, dt, reported) == fault
