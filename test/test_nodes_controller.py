"""Commands answer one sample each, and the motors are let go when something stops coming."""

from hda_arm_sim.health import Refused
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import HOME
from hda_msgs_json.cdr import decode_joint_state, encode_joint_state
from hda_msgs_json.topics import motor_name
from hda_torque_estimator.controlling.controller import Controller, ControllerSettings
from hda_torque_estimator.controlling.controller_node import WATCH_PERIOD
from hda_torque_estimator.controlling.live_controller import (LiveController, TargetPoints,
                                                              WatchSettings)
from hda_torque_estimator.controlling.pairing import MOST_WAITING, Pairing
from hda_torque_estimator.controlling.reference import hold
from hda_torque_estimator.controlling.watchdog import Watchdog
from hypothesis import given, strategies as st
import numpy as np
import pytest

ARM = read_arm('hda_arm.yaml')
PERIOD = 1_000_000
FEEDBACK = ControllerSettings(torque_feedback=-1.0)
MOTORS = [motor_name(label) for label in ARM.labels]
NAMES = [*ARM.labels, *MOTORS]


def sample(k, offset=0.0):
    """Return the joint state of sample k, its shafts turned a little by the offset [rad]."""
    return encode_joint_state(k * PERIOD, '', NAMES,
                              [*HOME, 100.0 * HOME[0] + offset, 100.0 * HOME[1] - offset])


def torque(k, value=2.0):
    """Return the estimated torques of sample k."""
    return encode_joint_state(k * PERIOD, '', ARM.labels, [], [], [value, -value])


def enabled(settings=ControllerSettings(), **options):
    """Return a controller that has just been enabled at sample 1, time 0.001 s."""
    live = LiveController(ARM, settings, **options)
    live.sample(sample(1), 0.001)
    live.torque(torque(1), 0.001)
    live.enable(0.001)
    return live


def effort(command):
    """Return the efforts of a command."""
    return decode_joint_state(command).effort.tolist()


@given(st.permutations('a' * 5 + 't' * 5))
def test_pairs_belong_to_one_stamp(arrivals):
    """Each stream keeps its own order, and either may be ahead of the other."""
    pairing, pairs, last = Pairing(), [], {'a': 0, 't': 0}
    for stream in arrivals:
        last[stream] += 1
        add = pairing.add_angle if stream == 'a' else pairing.add_torque
        if pair := add(last[stream], np.array([float(last[stream])])):
            pairs.append(pair)
    assert [pair.stamp for pair in pairs] == [1, 2, 3, 4, 5]
    assert all(pair.motor_angle[0] == pair.joint_torque[0] == pair.stamp for pair in pairs)


def test_what_waits_in_vain_is_forgotten():
    pairing = Pairing()
    for stamp in range(MOST_WAITING + 1):
        assert pairing.add_angle(stamp, np.zeros(1)) is None
    assert pairing.add_torque(0, np.zeros(1)) is None
    assert pairing.add_torque(1, np.zeros(1)) is not None


@given(st.permutations('a' * 5 + 't' * 5))
def test_order_of_arrival_does_not_matter(arrivals):
    """A command depends on the sample and on the torque of its stamp only."""
    in_turn, mixed = enabled(FEEDBACK), enabled(FEEDBACK)
    expected, commands, last = [], [], {'a': 1, 't': 1}
    for k in range(2, 7):
        in_turn.sample(sample(k, 0.01 * k), k * 1e-3)
        expected.append(in_turn.torque(torque(k, k), k * 1e-3))
    for stream in arrivals:
        last[stream] = k = last[stream] + 1
        commands.append(mixed.sample(sample(k, 0.01 * k), 0.002) if stream == 'a' else
                        mixed.torque(torque(k, k), 0.002))
    assert [command for command in commands if command is not None] == expected


def test_command_is_that_of_the_pure_controller():
    """It holds the arm where it was when it took over."""
    live, pure = enabled(FEEDBACK), Controller(ARM, FEEDBACK)
    pure.enable()
    pure.follow(hold(decode_joint_state(sample(1)).position[2:] / 100.0), PERIOD)
    for k in range(2, 100):
        assert live.sample(sample(k, 0.01 * k), k * 1e-3) is None
        command = live.torque(torque(k, 0.1 * k), k * 1e-3)
        shafts = decode_joint_state(sample(k, 0.01 * k)).position[2:]
        expected = pure.update(k * PERIOD, shafts, np.array([0.1 * k, -0.1 * k]))
        assert effort(command) == expected.tolist()


def test_stamps_are_copied():
    live = enabled()
    command = decode_joint_state(live.sample(sample(2), 0.002))
    assert command.stamp_ns == 2 * PERIOD
    assert list(command.names) == MOTORS
    assert len(command.position) == len(command.velocity) == 0


def test_without_feedback_torques_are_not_needed():
    live = LiveController(ARM)
    live.sample(sample(1), 0.001)
    live.enable(0.001)
    assert live.sample(sample(2), 0.002) is not None
    assert live.torque(torque(2), 0.002) is None


def test_disabled_controller_is_silent():
    live = LiveController(ARM)
    assert live.sample(sample(1), 0.001) is None
    assert live.disable() is None


def test_enabling_and_disabling_make_no_torque():
    live = enabled()
    assert effort(live.sample(sample(2, 0.3), 0.002)) == [0.0, 0.0]
    for k in range(3, 50):
        command = live.sample(sample(k, 0.3), k * 1e-3)
    assert min(np.abs(effort(command))) > 0.0
    assert effort(live.disable()) == [0.0, 0.0]
    assert not live.enabled
    assert live.stopped == ''


def test_enabled_parameter_takes_over_at_the_first_sample():
    live = LiveController(ARM, enabled=True)
    assert not live.enabled
    assert effort(live.sample(sample(1), 0.001)) == [0.0, 0.0]
    assert live.enabled


@pytest.mark.parametrize(('settings', 'fed', 'missing'), [
    (ControllerSettings(), False, 'no joint_states that can be used'),
    (FEEDBACK, True, 'no joint_torques of the samples'),
])
def test_nothing_is_enabled_without_what_it_needs(settings, fed, missing):
    live = LiveController(ARM, settings)
    if fed:
        live.sample(sample(1), 0.001)
    with pytest.raises(Refused, match=missing):
        live.enable(0.001)
    assert not live.enabled


def test_old_samples_do_not_enable():
    live = LiveController(ARM)
    live.sample(sample(1), 0.001)
    with pytest.raises(Refused, match='not enabled: no joint_states'):
        live.enable(0.1)


def test_watchdog_expires_exactly_after_its_time():
    watchdog = Watchdog(0.5)
    assert not watchdog.expired(1e9)                    # nothing has come yet that could stop
    assert not watchdog.alive(0.0)
    watchdog.feed(8.0)
    assert watchdog.alive(8.5)
    assert not watchdog.expired(8.5)
    assert watchdog.expired(8.500001)
    assert not watchdog.alive(8.500001)
    watchdog.feed(9.0)
    assert not watchdog.expired(9.5)


def test_motors_are_let_go_within_20_ms():
    """The last good sample may be as old as the timeout when the timer has just looked."""
    assert WatchSettings().sample_timeout + WATCH_PERIOD <= 0.8 * 0.020


def stopped_at(live, begin, disturb):
    """Return when the watchdog let go [s], looking every millisecond while disturbed."""
    for millisecond in range(1, 100):
        now = begin + millisecond * 1e-3
        disturb(now, round(now * 1e3))
        if (command := live.watch(now)) is not None:
            assert effort(command) == [0.0, 0.0]
            assert not live.enabled
            return now
    return None


def silence(live):
    """Return a disturbance in which nothing comes any more."""
    return lambda now, k: None


def invalid(live):
    """Return a disturbance in which one angle of every sample is NaN."""
    def disturb(now, k):
        state = decode_joint_state(sample(k))
        with pytest.raises(Refused, match='finite'):
            live.sample(encode_joint_state(
                k * PERIOD, '', NAMES, [np.nan, *state.position[1:]]), now)
    return disturb


def repeated(live):
    """Return a disturbance in which the same sample comes again and again."""
    def disturb(now, k):
        with pytest.raises(Refused, match='later'):
            live.sample(sample(1), now)
    return disturb


def without_torque(live):
    """Return a disturbance in which samples come, but no torques."""
    return lambda now, k: live.sample(sample(k), now)


@pytest.mark.parametrize(('disturbance', 'settings', 'said'), [
    (silence, ControllerSettings(), 'no joint_states that can be used for 0.012 s'),
    (invalid, ControllerSettings(), 'the last one was refused: every angle must be finite'),
    (repeated, ControllerSettings(), 'the last one was refused: a stamp must be later'),
    (without_torque, FEEDBACK, 'no joint_torques of the samples for 0.012 s'),
])
def test_motors_are_let_go_when_something_stops(disturbance, settings, said):
    live = enabled(settings)
    for k in range(2, 100):
        live.sample(sample(k, 0.3), k * 1e-3)
        live.torque(torque(k), k * 1e-3)
        assert live.watch(k * 1e-3) is None
    assert 0.099 + 0.012 <= stopped_at(live, 0.099, disturbance(live)) <= 0.099 + 0.014
    assert said in live.stopped
    assert live.watch(1.0) is None                      # reported once


def test_gap_between_stamps_stops_at_the_sample_behind_it():
    """After a gap in the arm's time the law would jump, whatever the time of arrival."""
    live = enabled()
    live.sample(sample(2, 0.3), 0.002)
    assert effort(live.sample(sample(20, 0.3), 0.003)) == [0.0, 0.0]
    assert live.stopped == '0.018 s lie between two stamps of joint_states'


def test_after_a_stop_it_can_be_enabled_again():
    live = enabled()
    assert live.watch(1.0) is not None
    live.sample(sample(1), 2.0)                         # the arm started anew: earlier stamps
    live.enable(2.0)
    assert live.stopped == ''
    assert live.sample(sample(2), 2.001) is not None


def test_trajectory_begins_with_the_last_sample():
    live = enabled()
    live.sample(sample(2), 0.002)
    live.follow(TargetPoints(['joint2', 'joint1'], [1.0], [[1.0, 0.5]], [[]]))
    assert live.controller.present_reference(2 * PERIOD)[:, 0] == pytest.approx(HOME)
    end = live.controller.present_reference(2 * PERIOD + 10**9)
    assert end[:, 0].tolist() == [0.5, 1.0]


@pytest.mark.parametrize(('trajectory', 'said'), [
    (TargetPoints(['joint1'], [1.0], [[0.5]], [[]]), 'joint_names must be'),
    (TargetPoints(['joint1', 'joint2'], [], [], []), 'at least one point'),
    (TargetPoints(['joint1', 'joint2'], [1.0], [[9.0, 0.0]], [[]]), 'joint1 must stay within'),
])
def test_bad_trajectory_is_refused_and_the_old_one_followed(trajectory, said):
    live = enabled()
    before = live.controller.present_reference(10**9).tolist()
    with pytest.raises(Refused, match=said):
        live.follow(trajectory)
    assert live.controller.present_reference(10**9).tolist() == before
    assert live.enabled


def test_target_needs_an_enabled_controller():
    with pytest.raises(Refused, match='call jtf_controller/enable before'):
        LiveController(ARM).follow(TargetPoints(ARM.labels, [1.0], [[0.0, 0.0]], [[]]))


def test_gains_change_without_a_jump():
    live = enabled()
    for k in range(2, 200):
        before = effort(live.sample(sample(k, 0.2), k * 1e-3))
    live.controller.tune(ControllerSettings(position_gain=0.9))
    after = effort(live.sample(sample(200, 0.2), 0.2))
    limit = live.controller.settings.rate_limit * 1e-3
    assert np.abs(np.subtract(after, before)).max() <= limit + 1e-12
