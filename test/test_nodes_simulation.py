"""The simulated arm keeps its schedule, copies nothing it should not, and refuses the rest."""

from dataclasses import replace

from hda_arm_sim.health import Level, Refusals, Refused
from hda_arm_sim.live import (
    FIRST_STAMP, LiveArm, LONGEST_HOLD, MOST_UNANSWERED, SimulationSettings)
from hda_arm_sim.model.arm import ArmError
from hda_arm_sim.model.files import read_arm, read_effects
from hda_arm_sim.sample_messages import SampleEncoder, truth_topics
from hda_arm_sim.schedule import LONGEST_LAG, Patience, Punctuality, Schedule, SHORTEST_TICK
from hda_arm_sim.simulation_report import simulation_report
from hda_msgs_json.cdr import decode_joint_state, decode_wrench
from hypothesis import given, strategies as st
import numpy as np
import pytest

ARM = read_arm('hda_arm.yaml')
PERIOD = 1_000_000


def live(**settings):
    """Return an arm at rest."""
    return LiveArm(ARM, SimulationSettings(**settings), FIRST_STAMP)


def steps(arm, count):
    """Return the readings of some samples."""
    readings = []
    for _ in range(count):
        readings.append(arm.sample().reading.copy())
        arm.advance()
    return np.array(readings)


@given(st.lists(st.integers(0, LONGEST_LAG // 3), min_size=1, max_size=300),
       st.sampled_from([PERIOD, 3_333_333, 100_000]), st.sampled_from([0.5, 1.0, 20.0]))
def test_delays_are_caught_up(delays, period, speed):
    """However late the calls come, the samples are those of the time that has gone by."""
    schedule, now, made = Schedule(period, speed), 0, 0
    for delay in delays:
        made += schedule.due(now)
        assert abs(made - (now * speed / period + 1)) <= 0.5 + 1e-6
        now += delay


def test_time_beyond_the_longest_lag_is_given_up_and_reported():
    schedule = Schedule(PERIOD)
    assert schedule.due(0) == 1
    assert schedule.due(LONGEST_LAG + 3 * PERIOD) == 1
    assert schedule.due(LONGEST_LAG + 4 * PERIOD) == 1
    kept = schedule.take_punctuality(LONGEST_LAG + 4 * PERIOD)
    assert kept.skipped == pytest.approx(0.052)
    assert kept.worst == pytest.approx(0.052)


def test_samples_that_were_not_made_are_due_again():
    schedule = Schedule(PERIOD)
    assert schedule.due(9 * PERIOD) == 1
    assert schedule.due(12 * PERIOD) == 3
    schedule.postpone(2)
    assert schedule.due(13 * PERIOD) == 3


def test_patience_is_for_each_wait_and_has_an_end():
    patience = Patience(0.5)
    assert [patience.waits(True, now) for now in (0, 499_999_999, 500_000_000)] == [
        True, True, False]
    assert not patience.waits(False, 600_000_000)
    assert patience.waits(True, 700_000_000)
    assert not Patience(0.0).waits(True, 0)


def test_an_arm_is_ahead_of_commands_that_came_and_are_late():
    arm = live()
    steps(arm, 20)
    assert not arm.ahead                        # nobody commands it yet
    arm.command(arm.stamp - PERIOD, np.zeros(2))
    steps(arm, MOST_UNANSWERED - 1)
    assert not arm.ahead
    steps(arm, 1)
    assert arm.ahead
    arm.command(arm.stamp - PERIOD, np.zeros(2))
    assert not arm.ahead
    steps(arm, LONGEST_HOLD // PERIOD + 2)
    assert not arm.ahead                        # its commands have ended


def test_punctual_calls_are_not_late():
    schedule = Schedule(PERIOD)
    assert [schedule.due(k * PERIOD + 300_000 * (k % 2)) for k in range(1001)] == [1] * 1001
    kept = schedule.take_punctuality(1000 * PERIOD)
    assert kept.late == 0
    assert kept.rate == pytest.approx(1000.0, rel=2e-3)
    assert schedule.take_punctuality(1001 * PERIOD).worst == 0.0


def test_delay_of_some_samples_is_counted():
    schedule = Schedule(PERIOD)
    schedule.due(0)
    assert schedule.due(5 * PERIOD) == 5
    assert schedule.take_punctuality(5 * PERIOD).late == 4


def test_fast_arm_is_called_with_several_samples_at_once():
    schedule = Schedule(PERIOD, 10.0)
    assert schedule.tick == SHORTEST_TICK
    made = sum(schedule.due(k * schedule.tick) for k in range(2001))
    assert made == pytest.approx(10_000, abs=5)
    assert schedule.take_punctuality(2000 * schedule.tick).late == 0


@pytest.mark.parametrize(('rate', 'period'), [(1000.0, 1_000_000), (300.0, 3_333_333)])
def test_stamps_advance_by_whole_nanoseconds(rate, period):
    arm = live(rate=rate)
    stamps = []
    for _ in range(5):
        stamps.append(arm.sample().stamp)
        arm.advance()
    assert stamps == [FIRST_STAMP + k * period for k in range(5)]


def test_seed_decides_the_noise():
    noisy = read_arm('voraus_yucobot.yaml').joints[0].link_encoder
    joints = tuple(replace(joint, link_encoder=noisy) for joint in ARM.joints)
    arm = type(ARM)(joints, ARM.links)
    one, same, other = (
        steps(LiveArm(arm, SimulationSettings(seed=seed), FIRST_STAMP), 20) for seed in (1, 1, 2))
    np.testing.assert_array_equal(one, same)
    assert (one != other).any()


def test_command_is_in_force_from_the_next_sample():
    arm = live()
    arm.sample()
    arm.advance()
    arm.command(FIRST_STAMP, np.array([0.1, -0.2]))
    assert arm.sample().motor_torque.tolist() == [0.1, -0.2]


def test_command_expires_in_the_time_of_the_arm():
    arm = live()
    arm.command(FIRST_STAMP, np.array([0.1, -0.2]))
    torques = []
    for _ in range(LONGEST_HOLD // PERIOD + 2):
        torques.append(arm.sample().motor_torque.tolist())
        arm.advance()
    assert torques[:-1] == [[0.1, -0.2]] * (LONGEST_HOLD // PERIOD + 1)
    assert torques[-1] == [0.0, 0.0]
    assert arm.expired == 1


def test_command_beyond_the_limit_is_clipped_and_counted():
    arm = live()
    limit = ARM.joints[0].torque_limit
    arm.command(FIRST_STAMP, np.array([9.0, -0.1]))
    assert arm.sample().motor_torque.tolist() == [limit, -0.1]
    assert arm.saturated == 1


@pytest.mark.parametrize(('stamp', 'torque', 'reason'), [
    (FIRST_STAMP, [np.nan, 0.0], 'effort not finite'),
    (FIRST_STAMP + 1, [0.0, 0.0], 'stamp out of time'),
    (FIRST_STAMP - LONGEST_HOLD - 1, [0.0, 0.0], 'stamp out of time'),
])
def test_unusable_command_is_refused(stamp, torque, reason):
    arm = live()
    arm.command(FIRST_STAMP, np.array([0.1, 0.1]))
    with pytest.raises(Refused) as caught:
        arm.command(stamp, np.array(torque))
    assert caught.value.reason == reason
    assert arm.sample().motor_torque.tolist() == [0.1, 0.1]


def test_push_is_held_until_the_next_one():
    arm = live()
    arm.push(np.array([30.0, 40.0]))
    moved = steps(arm, 2000)
    assert (moved[-1, :, 1] != moved[0, :, 1]).any()
    assert arm.sample().tip_force.tolist() == [30.0, 40.0]
    with pytest.raises(Refused, match='must be finite'):
        arm.push(np.array([np.inf, 0.0]))
    assert arm.sample().tip_force.tolist() == [30.0, 40.0]


def test_reset_returns_to_the_start_but_not_in_time():
    arm = live()
    first = steps(arm, 3)
    arm.push(np.array([30.0, 40.0]))
    steps(arm, 500)
    stamp = arm.stamp
    arm.reset()
    np.testing.assert_array_equal(steps(arm, 3), first)
    assert arm.stamp == stamp + 3 * PERIOD


def test_arm_without_links_is_refused():
    with pytest.raises(ArmError, match='cannot be simulated'):
        LiveArm(read_arm('voraus_yucobot.yaml'), SimulationSettings(), FIRST_STAMP)


def test_messages_show_the_sample():
    arm = live()
    arm.command(FIRST_STAMP, np.array([0.1, -0.2]))
    arm.push(np.array([3.0, 4.0]))
    sample, encode = arm.sample(), SampleEncoder(ARM)
    state = decode_joint_state(encode.joint_states(sample))
    assert state.stamp_ns == FIRST_STAMP
    assert state.names == ('joint1', 'joint2', 'joint1_motor', 'joint2_motor')
    assert state.position.tolist() == [*sample.reading[:, 1], *sample.reading[:, 0]]
    assert np.isnan(state.velocity).all()               # a first sample has no difference
    np.testing.assert_array_equal(state.effort, [np.nan, np.nan, 0.1, -0.2])
    truth = [decode_wrench(sent) for sent in encode.truth(sample)]
    assert [topic.name for topic in truth_topics(ARM)] == [
        'truth/joint1/torque', 'truth/joint2/torque', 'truth/tip/wrench']
    assert [wrench.frame_id for wrench in truth] == ['joint1_link', 'joint2_link', 'base']
    assert [wrench.torque[2] for wrench in truth[:2]] == sample.joint_torque.tolist()
    np.testing.assert_array_equal(truth[2].force, [3.0, 4.0, np.nan])


@pytest.mark.parametrize(('truth_rate', 'divisor'), [(1000.0, 1), (5000.0, 1), (100.0, 10)])
def test_truth_may_be_published_less_often(truth_rate, divisor):
    assert SimulationSettings(truth_rate=truth_rate).truth_divisor == divisor


@pytest.mark.parametrize(('kept', 'refused', 'level', 'said'), [
    (Punctuality(1000.0, 0.0, 0, 0.0), [], Level.OK, '1000.0 Hz'),
    (Punctuality(900.0, 0.1, 9, 0.0), [], Level.WARN, 'behind real time: 900.0 Hz instead of'),
    (Punctuality(1000.0, 0.1, 9, 0.2), [], Level.WARN, 'behind real time'),
    (Punctuality(1000.0, 0.0, 0, 0.0), ['wrong names'] * 3, Level.WARN, '3 messages refused'),
])
def test_report_says_what_is_wrong(kept, refused, level, said):
    refusals = Refusals()
    for reason in refused:
        refusals.add(reason, 0.0)
    report = simulation_report(kept, live(), refusals)
    assert report.level is level
    assert said in report.message
    assert simulation_report(Punctuality(1000.0, 0.0, 0, 0.0), live(), refusals).level is Level.OK
    assert report.values.get('refused: wrong names', 0) == len(refused)


def test_effects_are_read_from_a_list_or_under_a_key(tmp_path):
    text = '- {effect: stribeck_friction, joint: joint1, parameters: {excess: 0.02}}\n'
    (tmp_path / 'list.yaml').write_text(text)
    (tmp_path / 'key.yaml').write_text(f'effects:\n{text}')
    listed, keyed = (read_effects(tmp_path / name) for name in ('list.yaml', 'key.yaml'))
    assert listed == keyed
    assert [(placed.effect.name, placed.joint) for placed in listed] == [
        ('stribeck_friction', 'joint1')]


@pytest.mark.parametrize(('text', 'said'), [
    ('3', 'must be a list of effects, or have one under "effects"'),
    ('links: none', 'must be a list of effects'),
    ('[{effect: bad_luck}]', "no effect is named 'bad_luck'"),
    ('[{effect: stribeck_friction, joint: joint1, parameters: {excess: 99}}]', 'must lie in'),
    ('[', 'is not YAML'),
])
def test_unusable_effects_are_reported_with_their_file(tmp_path, text, said):
    path = tmp_path / 'effects.yaml'
    path.write_text(text)
    with pytest.raises(ArmError) as caught:
        read_effects(path)
    assert said in str(caught.value)
    assert str(path) in str(caught.value)


def test_missing_effects_are_reported(tmp_path):
    with pytest.raises(ArmError, match='no file .* to read effects from'):
        read_effects(tmp_path / 'none.yaml')
