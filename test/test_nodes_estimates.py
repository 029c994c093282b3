"""The messages of a live estimator are those of the offline one, bit for bit."""

from typing import get_type_hints

from hda_arm_sim.health import Refused
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import motion
from hda_msgs_json.cdr import (
    decode_joint_state, decode_number, decode_string, decode_wrench, encode_joint_state,
    encode_number, JointStateDecoder)
from hda_msgs_json.cdr_arrays import encode_joint_rows, encode_wrench_rows
from hda_msgs_json.messages import EstimatorState, from_json
from hda_msgs_json.samples import JointSamples, NumberSamples
from hda_msgs_json.topics import NUMBER
from hda_torque_estimator.estimating.estimate_messages import (estimate_samples, estimate_topics,
                                                               EstimateEncoder)
from hda_torque_estimator.estimating.estimator import Estimator
from hda_torque_estimator.estimating.laws.layout import RESULTS, TIP_RESULTS
from hda_torque_estimator.estimating.live_estimator import LiveEstimator, StateSettings
from hda_torque_estimator.estimating.number_messages import number_samples, number_topics
from hda_torque_estimator.estimating.state_messages import due_rows, Pacer, state_samples
from hda_torque_estimator.samples.gaps import Gaps
from hda_torque_estimator.samples.readings import reading_names
from hda_torque_estimator.simulating.closed_loop import run
from hda_torque_estimator.simulating.recorded import joint_samples
from hypothesis import given, strategies as st
import numpy as np
import pytest

ARM = read_arm('hda_arm.yaml')
WITHOUT_LINKS = read_arm('voraus_yucobot.yaml')
PERIOD = 1_000_000


@pytest.fixture(scope='module')
def pushed():
    """Return the joint states of an arm that moves and is pushed, as samples."""
    made = run(ARM, ARM, motion('push', 2, 4.0, 1e-3, 0), 1)
    stamps = 10**9 + np.arange(len(made.time)) * PERIOD
    return joint_samples(ARM, stamps, made.reading, made.command)


def messages_of(samples: JointSamples) -> list[bytes]:
    """Return the messages of samples."""
    return [row.tobytes() for row in encode_joint_rows(samples)]


def rows_of(part) -> list[bytes]:
    """Return the messages of estimates."""
    if isinstance(part, NumberSamples):
        return [encode_number(value) for value in part.values.tolist()]
    encode = encode_joint_rows if isinstance(part, JointSamples) else encode_wrench_rows
    return [row.tobytes() for row in encode(part)]


@pytest.mark.parametrize('arm', [ARM, WITHOUT_LINKS], ids=['two links', 'no links'])
def test_live_messages_are_the_offline_ones(arm):
    random = np.random.default_rng(0)
    readings = random.normal(size=(400, len(arm.joints), 4)) * 1e-3
    readings[:, :, 0] *= [joint.ratio for joint in arm.joints]
    readings[100:200, -1, 1] += 0.5                             # in and out of the singular pose
    stamps = np.cumsum(random.integers(1, 3 * PERIOD, len(readings))) + 10**9
    effort = random.normal(size=readings.shape[:2]) * 0.1
    live = LiveEstimator(arm)
    answers = [live(sent) for sent in messages_of(joint_samples(arm, stamps, readings, effort))]
    estimates = Estimator(arm).run(stamps, readings, effort)
    parts = estimate_samples(arm, estimates)
    assert tuple(parts) == estimate_topics(arm)
    for place, part in enumerate(parts.values()):
        assert [answer.messages[place] for answer in answers] == rows_of(part)
    reported = [decode_string(answer.state) for answer in answers if answer.state is not None]
    assert reported == list(state_samples(arm, estimates).texts)
    numbers = number_samples(arm, estimates)
    assert tuple(numbers) == number_topics(arm)
    due = [answer for answer in answers if answer.state is not None]
    for place, part in enumerate(numbers.values()):
        assert [answer.numbers[place] for answer in due] == rows_of(part)


def test_numbers_of_the_state_are_plain_topics(pushed):
    """Each number of the JSON that has no topic of its own is a plain one, with the same value."""
    live = LiveEstimator(ARM)
    answers = [answer for sent in messages_of(pushed)[:1500]
               if (answer := live(sent)).state is not None]
    state = from_json(EstimatorState, decode_string(answers[-1].state))
    reported = {}
    for topic, message in zip(number_topics(ARM), answers[-1].numbers):
        quantity = topic.name.removeprefix('estimator_state/')
        reported[quantity] = decode_number(message) if topic.message_type == NUMBER else [
            *decode_joint_state(message).position, *decode_joint_state(message).effort]
    x, y = (reported.pop(f'tip_force_std/{axis}') for axis in 'xy')
    np.testing.assert_allclose([x * x, y * y], np.array(state.tip_force_covariance)[[0, 3]])
    reported['motor_share'] = [reported.pop(f'motor_share/{label}') for label in ARM.labels]
    for quantity, numbers in reported.items():
        np.testing.assert_array_equal(numbers, getattr(state, quantity), quantity)
    kinds = get_type_hints(EstimatorState)
    of_numbers = {name for name, kind in kinds.items() if 'float' in str(kind)}
    assert reported.keys() == of_numbers - {'torque', 'tip_force', 'tip_force_covariance'}


def test_without_links_there_is_no_tip():
    names = [topic.name for topic in estimate_topics(WITHOUT_LINKS)]
    plain = [topic.name for topic in number_topics(WITHOUT_LINKS)]
    assert plain[:4] == [f'estimator_state/{name}' for name in (
        'torsion', 'kinematic_torsion', 'torsion_zero', 'torque_std')]
    assert all('/motor_share/' in name for name in plain[4:])
    assert names == [*(f'joint{k}/torque' for k in range(1, 7)), 'joint_torques']


def test_what_cannot_be_observed_is_nan(pushed):
    answer = LiveEstimator(ARM)(messages_of(pushed)[0])
    joint, _, torques, base, tool = answer.messages
    wrench = decode_wrench(joint)
    assert wrench.frame_id == 'joint1_link'
    np.testing.assert_array_equal(np.isnan(wrench.torque), [True, True, False])
    assert np.isnan(wrench.force).all()
    for sent, frame in ((base, 'base'), (tool, 'tool')):
        wrench = decode_wrench(sent)
        assert wrench.frame_id == frame
        np.testing.assert_array_equal(np.isnan(wrench.force), [False, False, True])
        assert np.isnan(wrench.torque).all()
    assert decode_joint_state(torques).names == ARM.labels


def test_stamps_are_copied(pushed):
    live = LiveEstimator(ARM)
    for sent in messages_of(pushed)[:5]:
        stamp = JointStateDecoder()(sent).stamp_ns
        answer = live(sent)
        assert {decode_joint_state(answer.messages[2]).stamp_ns, answer.stamp} == {stamp}
        assert {decode_wrench(answer.messages[k]).stamp_ns for k in (0, 1, 3, 4)} == {stamp}


def spoilt(sample: bytes) -> list[tuple[bytes, str, str]]:
    """Return what a driver may send instead of a sample, the reason and part of the sentence."""
    state = decode_joint_state(sample)
    names, stamp = state.names, state.stamp_ns
    bad = state.position.copy()
    bad[0] = np.nan
    return [
        (sample[:40], 'malformed message', 'needs'),
        (encode_joint_state(stamp, '', names[:3], bad[:3]), 'wrong names', 'joint2_motor'),
        (encode_joint_state(stamp, '', names, bad[:3]), 'wrong lengths', 'got 3'),
        (encode_joint_state(stamp, '', names, bad), 'angle not finite', 'nan for joint1 at 1.5'),
        (encode_joint_state(1, '', names, state.position), 'stamp not later', '0.000000001 s'),
    ]


def test_a_refused_sample_changes_nothing(pushed):
    sent = messages_of(pushed)[:1000]
    clean, disturbed = LiveEstimator(ARM), LiveEstimator(ARM)
    for sample in sent[:500]:
        clean(sample)
        disturbed(sample)
    for wrong, reason, sentence in spoilt(sent[500]):
        with pytest.raises(Refused, match=sentence) as caught:
            disturbed(wrong)
        assert caught.value.reason == reason
    assert [disturbed(sample) for sample in sent[500:]] == [clean(sample) for sample in sent[500:]]


def test_reset_accepts_a_jump_back_in_time(pushed):
    sent = messages_of(pushed)
    live = LiveEstimator(ARM)
    first = [live(sample) for sample in sent[:50]]
    with pytest.raises(Refused, match='call torque_estimator/reset'):
        live(sent[0])
    live.reset()
    assert [live(sample) for sample in sent[:50]] == first


def test_state_shows_a_tare(pushed):
    live = LiveEstimator(ARM)
    live.estimator.tare()
    state = from_json(EstimatorState, decode_string(live(messages_of(pushed)[0]).state))
    assert 'a tare is under way' in state.flags


def test_state_shows_validity_and_posture():
    live = LiveEstimator(ARM)
    names = reading_names(ARM.labels)
    far = [0.0, 0.1, 50.0, 0.5]                 # joint1 wound up by 0.1 rad, the elbow bent
    sent = encode_joint_state(10**9, '', names, far)
    state = from_json(EstimatorState, decode_string(live(sent).state))
    assert state.valid == (False, True)
    assert any(flag.startswith('joint1') for flag in state.flags)
    assert not state.singular
    straight = encode_joint_state(2 * 10**9, '', names, [0.0] * 4)
    state = from_json(EstimatorState, decode_string(live(straight).state))
    assert state.singular
    assert state.conditioning == 0.0


@given(st.lists(st.integers(1, 10**8), min_size=1, max_size=200), st.floats(0.5, 2000.0))
def test_both_ways_choose_the_same_samples(steps, rate):
    stamps = np.cumsum(steps)
    pacer = Pacer(rate)
    assert [row for row, stamp in enumerate(stamps.tolist()) if pacer.due(stamp)] == (
        due_rows(stamps, rate).tolist())


def test_states_come_at_their_rate():
    stamps = 10**9 + np.arange(10_000) * PERIOD
    assert len(due_rows(stamps, 50.0)) == 500
    assert len(due_rows(stamps, 5000.0)) == 10_000              # never more than samples


def test_rate_of_states_can_change(pushed):
    live = LiveEstimator(ARM, state=StateSettings(state_rate=100.0))
    sent = messages_of(pushed)
    assert sum(live(sample).state is not None for sample in sent[:1000]) == 100
    live.set_state(StateSettings(state_rate=1000.0))
    assert all(live(sample).state is not None for sample in sent[1000:1100])


def test_encoder_keeps_every_bit_of_a_nan():
    """A NaN of the other sign is published as it is, by both encoders."""
    joints, tip = np.zeros((2, RESULTS)), np.full(TIP_RESULTS, -np.nan)
    live = EstimateEncoder(ARM)(5, joints, tip)
    estimates = Estimator(ARM).run(np.zeros(0, np.int64), np.zeros((0, 2, 4)))._replace(
        stamps=np.array([5]), joints=joints[None], tip=tip[None])
    assert live == [rows_of(part)[0] for part in estimate_samples(ARM, estimates).values()]


@pytest.mark.parametrize(('missing', 'lost'), [([], 0), ([50], 1), ([50, 51, 52, 70], 4)])
def test_lost_samples_are_counted(missing, lost):
    gaps = Gaps()
    jitter = np.random.default_rng(0).integers(-200_000, 200_000, 100)
    for k in sorted(set(range(100)) - set(missing)):
        gaps.add(k * PERIOD + int(jitter[k]))
    assert gaps.lost == lost


def test_another_rate_is_not_a_loss_for_ever():
    gaps = Gaps()
    for k in range(100):
        gaps.add(k * PERIOD)
    for k in range(1000):
        gaps.add((100 + 3 * k) * PERIOD)
    assert gaps.lost <= 2 * 10
