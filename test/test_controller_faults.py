"""What no arm can do stops the motors at once; what an arm cannot follow is refused whole."""

from dataclasses import replace
from functools import cache
import math

from hda_arm_sim.foundation.parameter import ParameterError
from hda_arm_sim.health import Refused
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import HOME
from hda_msgs_json.cdr import CdrError, decode_joint_state, encode_joint_state
from hda_msgs_json.cdr_fields import FieldWriter
from hda_msgs_json.cdr_trajectory import count_points, decode_trajectory
from hda_torque_estimator.controlling.controller import ControllerSettings
from hda_torque_estimator.controlling.followable import motor_torques
from hda_torque_estimator.controlling.live_controller import LiveController
from hda_torque_estimator.controlling.loop_stability import stable_range
from hda_torque_estimator.controlling.reference import MOST_POINTS, reference_from, TrajectoryError
from hda_torque_estimator.controlling.target_check import TargetCheck
from hypothesis import given, settings, strategies as st
from moving_arm import moving
import numpy as np
import pytest

ARM = read_arm('hda_arm.yaml')
NAMES = [*ARM.labels, 'joint1_motor', 'joint2_motor']
TURN = 2.0 * math.pi
BEGIN = 200             # of the fault [samples]
REST = np.stack([HOME, (0.0, 0.0)], axis=1)


@cache
def samples():
    """Return stamps, names and angles of a moving arm at 1 kHz."""
    return [decode_joint_state(each) for each in moving(ARM)]


def wrong(column, law):
    """Return a stream in which one angle is wrong from BEGIN on."""
    states = samples()
    held = states[BEGIN].position[column]
    for k, state in enumerate(states):
        angles = np.array(state.position)
        if k >= BEGIN:
            angles[column] = law(angles[column], held)
        yield encode_joint_state(state.stamp_ns, '', state.names, angles)


def swapped():
    """Yield a stream in which both joints change their names."""
    for k, state in enumerate(samples()):
        names = list(state.names)
        if k >= BEGIN:
            names = [name.translate(str.maketrans('12', '21')) for name in names]
        yield encode_joint_state(state.stamp_ns, '', names, state.position)


def second():
    """Yield a stream to which a second publisher adds the arm as it was, a little late."""
    for k, state in enumerate(samples()):
        yield encode_joint_state(state.stamp_ns, '', state.names, state.position)
        if k >= BEGIN:
            yield encode_joint_state(state.stamp_ns - 500_000, '', state.names, state.position)


def answers(live, messages):
    """Return the efforts that answer messages, 1 ms each, None where there are none."""
    made = []
    for k, message in enumerate(messages):
        try:
            command = live.sample(message, k * 1e-3) or live.watch(k * 1e-3)
        except Refused:
            command = live.watch(k * 1e-3)
        made.append(None if command is None else decode_joint_state(command).effort)
    return made


LINK, MOTOR = samples()[0].names.index('joint1'), samples()[0].names.index('joint1_motor')
STREAMS = {
    'bit flipped': lambda: wrong(MOTOR, lambda x, held: 5.39e307),
    'huge': lambda: wrong(LINK, lambda x, held: -1e300),
    'beyond the limit': lambda: wrong(LINK, lambda x, held: 3.3),
    'turn of the motor': lambda: wrong(MOTOR, lambda x, held: x - TURN),
    'turn of the link': lambda: wrong(LINK, lambda x, held: x + TURN),
    'wrap': lambda: wrong(MOTOR, lambda x, held: math.remainder(x, TURN)),
    'motor frozen': lambda: wrong(MOTOR, lambda x, held: held),
    'link frozen': lambda: wrong(LINK, lambda x, held: held),
    'speed': lambda: wrong(MOTOR, lambda x, held: held + 20.0 * (x - held)),
    'swapped': swapped,
    'second publisher': second,
}


@pytest.mark.parametrize('stream', STREAMS.values(), ids=STREAMS)
def test_what_no_arm_can_do_stops_within_20_ms_until_enabled_anew(stream):
    live = LiveController(ARM, enabled=True)
    made = answers(live, stream())
    assert all(effort is not None for effort in made[:BEGIN])
    given = [k for k, effort in enumerate(made) if effort is not None]
    assert BEGIN <= given[-1] <= BEGIN + 20
    assert (made[given[-1]] == 0.0).all()
    assert not live.enabled
    assert len(live.stopped) > 30
    assert np.isfinite([made[k] for k in given]).all()


def test_healthy_motion_is_answered_to_the_end():
    live = LiveController(ARM, enabled=True)
    assert all(effort is not None for effort in answers(live, wrong(LINK, lambda x, held: x)))


def test_after_an_impossible_sample_it_waits_for_good_ones():
    live = LiveController(ARM, enabled=True)
    messages = list(wrong(MOTOR, lambda x, held: x))
    answers(live, [*messages[:50], *STREAMS['turn of the motor']()][:50])
    bad = list(wrong(MOTOR, lambda x, held: x + 1e5))[BEGIN]
    with pytest.raises(Refused, match='must stay within'):
        live.disable()
        live.sample(bad, 0.05)
    with pytest.raises(Refused, match='not enabled: joint1_motor must stay within'):
        live.enable(0.05)
    live.sample(messages[60], 0.08)
    live.enable(0.08)
    assert live.enabled


@pytest.mark.parametrize('torque', [1e308, -1e9])
def test_impossible_torque_stops(torque):
    live = LiveController(ARM, ControllerSettings(torque_feedback=-1.0))
    messages = list(wrong(LINK, lambda x, held: x))[:3]
    for k, message in enumerate(messages):
        stamp = decode_joint_state(message).stamp_ns
        live.sample(message, k * 1e-3)
        if k == 1:
            live.enable(k * 1e-3)
        reported = [2.0, torque if k == 2 else 2.0]
        made = live.torque(encode_joint_state(stamp, '', ARM.labels, [], [], reported), k * 1e-3)
    assert decode_joint_state(made).effort.tolist() == [0.0, 0.0]
    assert 'the torque of joint2 must lie within' in live.stopped


def refused(times, angles, rates=()):
    """Return why a trajectory from HOME is refused."""
    with pytest.raises(TrajectoryError) as caught:
        reference_from(ARM, ARM.labels, times, angles, rates, REST)
    return str(caught.value)


@pytest.mark.parametrize(('times', 'angles', 'rates', 'said'), [
    ([1e-9], [[3.0, -3.0]], (), 'the rate must stay within'),
    ([1.0, 2.0], [[0.5, 1.3]] * 2, [[1e6, 0.0], [0.0, 0.0]], 'the angle must stay within'),
    ([1.0, 2.0], [[0.5, 1.3]] * 2, [[1e308, 0.0], [0.0, 0.0]], 'must stay within'),
    ([1.0, 2.0], [[0.5, 1.3]] * 2, [[20.0, 0.0], [0.0, 0.0]], 'must stay within'),
    ([1.0, 2.0], [[3.1, 1.3]] * 2, [[2.5, 0.0], [0.0, 0.0]], 'must stay within'),
    ([0.25], [[0.6, 1.2]], (), 'the motor torque must stay within'),
    ([1.0], [[0.5, 1.3]], [[0.5, 0.0]], 'velocities of 0'),
    ([math.inf], [[0.5, 1.3]], (), 'grow from point to point'),
    ([math.nan], [[0.5, 1.3]], (), 'grow from point to point'),
    ([5e-324, 1e308], [[0.3, 1.3]] * 2, (), 'grow from point to point'),
    ([1e-9, 2e-9, 2e9], [[0.3, 1.2]] * 2 + [[0.3, 1.3]], [[1e308] * 2, [-1e308] * 2, [0.0] * 2],
     'must stay within'),
    ([1e-9, 2e-9, 2e9], [[0.3, 1.3]] * 3, (), 'the rate must stay within'),
    (np.linspace(0.01, 100.0, 10**6), [[0.3, 1.2]] * 10**6, (), 'may have 100000 points, got 10'),
])
def test_what_cannot_be_followed_between_points_is_refused(times, angles, rates, said):
    assert said in refused(times, angles, rates)


@settings(max_examples=60)
@given(st.lists(st.tuples(st.floats(0.02, 1.0), st.floats(-3.2, 3.2), st.floats(-3.2, 3.2)),
                min_size=1, max_size=4))
def test_what_is_accepted_keeps_its_limits_everywhere(points):
    """Sampled 2000 times a second, angle, speed and motor torque are within their limits."""
    table = np.array(points)
    times = np.cumsum(table[:, 0] * 3.0)
    try:
        made = reference_from(ARM, ARM.labels, times, table[:, 1:], [], REST)
    except TrajectoryError:
        return
    time = np.linspace(0.0, times[-1] * (1.0 - 1e-12), int(2000 * times[-1]) + 2)
    angle, rate, speeding = (made.curve(time, order) for order in range(3))
    assert np.abs(angle).max() <= 3.2 * (1.0 + 1e-12)
    assert np.abs(rate).max() <= 4.45 * (1.0 + 1e-9)
    assert np.abs(motor_torques(ARM, angle, rate, speeding)).max() <= 0.3 * 1.02


def trajectory(points, names=ARM.labels):
    """Return the bytes of a trajectory; points are (seconds, angles, rates)."""
    made = FieldWriter()
    made.stamp(0)
    made.string('', 'frame_id')
    made.uint32(len(names))
    for name in names:
        made.string(name, 'name')
    made.uint32(len(points))
    for moment, angles, rates in points:
        for each in (angles, rates, (), ()):
            made.uint32(len(each))
            made.doubles(np.array(each, float))
        made.stamp(round(moment * 1e9))
    return bytes(made)


def test_trajectories_are_read_from_their_bytes():
    read = decode_trajectory(trajectory([(0.5, (0.1, 0.2), ()), (1.25, (0.3, 0.4), (1.0, 2.0))]))
    assert read.names == ARM.labels
    assert read.times == [0.5, 1.25]
    assert [list(row) for row in read.angles] == [[0.1, 0.2], [0.3, 0.4]]
    assert [list(row) for row in read.rates] == [[], [1.0, 2.0]]
    with pytest.raises(CdrError):
        decode_trajectory(trajectory([(0.5, (0.1, 0.2), ())])[:-6])
    lying = bytearray(trajectory([(0.5, (0.1, 0.2), ())]))
    place = bytes(lying).index(b'\x01\x00\x00\x00\x02\x00\x00\x00')
    lying[place:place + 4] = b'\xff\xff\xff\x7f'
    with pytest.raises(CdrError, match='more than the message has room for'):
        count_points(bytes(lying))


def test_trajectories_are_checked_beside_the_loop_and_join_it():
    live, check = LiveController(ARM, enabled=True), TargetCheck(ARM)
    angles = [*HOME, *(100.0 * np.array(HOME))]
    live.sample(encode_joint_state(10**6, '', NAMES, angles), 0.001)
    check.add(trajectory([(1.0, (0.5, 1.1), ()), (2.0, (0.4, 1.0), ())]), live.present())
    check.add(trajectory([(1e-9, (0.5, 1.1), ())]), live.present())
    check.close_after_all()
    good, bad = list(check.done())
    live.follow_checked(good.result())
    live.sample(encode_joint_state(2 * 10**6, '', NAMES, angles), 0.002)
    live.follow_checked(good.result())                  # the reference moves meanwhile
    assert live.controller.present_reference(3 * 10**9)[:, 0].tolist() == [0.4, 1.0]
    with pytest.raises(Refused, match='the rate must stay within'):
        bad.result()


@pytest.mark.parametrize(('message', 'said'), [
    (trajectory([(1e-3 * (k + 1), (), ()) for k in range(MOST_POINTS + 1)]), 'may have 100000'),
    (b'', 'CDR message'),
])
def test_what_is_too_long_to_be_checked_is_refused_unread(message, said):
    check = TargetCheck(ARM)
    with pytest.raises(Refused, match=said):
        check.add(message, REST)
    check.close()


def stiff():
    """Return the shipped arm without damping in its gears."""
    joints = tuple(replace(joint, torsion=replace(joint.torsion, damping=0.0,
                                                  flexspline_stiffness=1e6))
                   for joint in ARM.joints)
    return replace(ARM, joints=joints)


def test_torque_feedback_that_the_arm_does_not_bear_is_refused_unless_asked_for():
    low, high = stable_range(stiff(), ControllerSettings(), 1e-3)
    assert -2.0 < low < 0.0 < high
    asked = ControllerSettings(torque_feedback=-2.0)
    with pytest.raises(ParameterError) as caught:
        LiveController(stiff(), asked)
    assert f'between {low:.2g} and {high:.2g} for this arm at 1000 Hz' in str(caught.value)
    assert 'allow_unstable_gain' in str(caught.value)
    LiveController(stiff(), asked, allow_unstable_gain=True)
    LiveController(ARM, asked)
    LiveController(stiff(), ControllerSettings(torque_feedback=0.5 * low))


def test_stable_range_shrinks_with_the_period():
    widths = [high - low for low, high in (
        stable_range(ARM, ControllerSettings(), period) for period in (1e-3, 4e-3, 5e-3))]
    assert widths[0] > widths[1] > widths[2] > 0.0
    assert 'no value' in str(stable_range(ARM, ControllerSettings(), 0.02))


def test_a_gain_is_judged_again_at_the_rate_of_the_samples():
    live = LiveController(ARM, ControllerSettings(torque_feedback=-1.0))
    for k in range(1, 100):
        live.sample(encode_joint_state(k * 5_000_000, '', NAMES, [*HOME, 30.0, 120.0]), k * 5e-3)
        live.torque(encode_joint_state(k * 5_000_000, '', ARM.labels, [], [], [0.0, 0.0]),
                    k * 5e-3)
    with pytest.raises(Refused, match='at 200 Hz with these gains, got -1'):
        live.enable(0.495)
