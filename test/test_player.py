"""The player: time, audience, choice of topics, quality of service, and its process."""

from threading import Thread
from typing import NamedTuple

from bag_content import some_messages, write_ours
from hda_arm_sim.ros.offered_quality import strongest
from hda_msgs_json.cdr import encode_joint_state
from hda_msgs_json.cdr_fields import LITTLE_ENDIAN, pack_stamp
from hda_msgs_json.topics import CLOCK, JOINT_STATES, TIP_WRENCH
from hda_torque_estimator.playing.audience import Audience
from hda_torque_estimator.playing.playback import Outlets, Playback
from hda_torque_estimator.playing.timeline import LONGEST_LAG, Timeline
from hda_torque_estimator.recording.topic_choice import chosen, TopicError
from hypothesis import given, strategies as st
from node_processes import running, watching
import pytest
from rclpy.qos import DurabilityPolicy, LivelinessPolicy, ReliabilityPolicy
from std_srvs.srv import Trigger

pytestmark = pytest.mark.xdist_group('nodes')


@given(st.integers(0, 10**18), st.integers(0, 10**12), st.floats(0.01, 100.0),
       st.integers(0, 10**9))
def test_time_and_due_are_inverse_at_any_rate(log_time, now, rate, later):
    line = Timeline(2.0)
    line.jump(log_time, now)
    line.run_at(rate, now)
    assert abs(line.time(line.due(log_time + later)) - log_time - later) <= 0.5 * rate + 0.5
    assert line.time(now) == log_time


def test_time_stands_during_a_pause():
    line = Timeline()
    line.pause(70)
    assert line.time(1000) == 70
    line.resume(1000)
    assert line.due(80) == 1010


def test_only_a_long_lag_is_given_up():
    line = Timeline()
    line.forgive(10, 10 + LONGEST_LAG)
    assert line.due(20) == 20
    line.forgive(10, 11 + LONGEST_LAG)
    assert line.due(20) == 21 + LONGEST_LAG
    assert line.given_up == LONGEST_LAG + 1


class Numbered(NamedTuple):
    """A message with a time and a number."""

    log_time: int
    number: int


def played(times, reported=None, **how):
    """Return a playback of messages at these times, and the list to which they come."""
    messages = [Numbered(time, number) for number, time in enumerate(times)]
    heard = []
    publish = (lambda time: None) if reported is None else reported.append
    return Playback(lambda: iter(messages), Outlets(heard.append, publish, 1000), **how), heard


def test_messages_come_in_their_order_even_at_equal_or_earlier_times():
    reported = []
    playback, heard = played([7, 7, 7, 3, 3, 1_000_000], reported, rate=100.0)
    assert playback.play()
    assert [message.number for message in heard] == list(range(6))
    assert playback.played == 6 and playback.empty
    assert max(reported) <= 1_000_000                   # the clock never runs ahead of a message


def test_steps_need_a_begin_and_a_pause():
    playback, heard = played([0, 10**9, 2 * 10**9], paused=True)
    assert playback.step() is None                  # nobody is there yet
    thread = Thread(target=playback.play)
    thread.start()
    stepped = []
    while len(stepped) < 2:
        stepped += [message for message in [playback.step()] if message]
    assert [message.number for message in stepped] == [0, 1]
    assert heard == stepped
    playback.run_at(100.0)
    playback.resume()
    thread.join()
    assert [message.number for message in heard] == [0, 1, 2]
    assert playback.step() is None


def test_a_loop_begins_again_until_it_is_ended():
    messages = [Numbered(5, 0), Numbered(6, 1), Numbered(7, 2)]
    heard = []

    def hear(message):
        heard.append(message)
        if len(heard) == 7:
            playback.end()

    playback = Playback(
        lambda: iter(messages), Outlets(hear, lambda time: None, 1000), loop=True)
    assert not playback.play()
    assert heard == [*messages, *messages, messages[0]]


def test_an_audience_is_complete_when_no_more_come():
    audience = Audience(('b',), 1.0)
    assert not audience.complete({'a': 1, 'b': 0}, 0.0)
    assert not audience.complete({'a': 1, 'b': 0}, 5.0)
    assert audience.missing() == 'b'
    assert not audience.complete({'a': 1, 'b': 1}, 6.0)
    assert not audience.complete({'a': 2, 'b': 1}, 6.9)
    assert not audience.complete({'a': 2, 'b': 1}, 7.8)
    assert audience.complete({'a': 2, 'b': 1}, 8.0)


def test_without_a_name_anybody_is_an_audience():
    audience = Audience((), 0.0)
    assert not audience.complete({'a': 0, 'b': 0}, 100.0)
    assert audience.complete({'a': 0, 'b': 1}, 101.0)


@pytest.mark.parametrize(('wanted', 'unwanted', 'found'), [
    ([], [], ['/a', '/b/torque', '/c/torque']), (['a'], [], ['/a']),
    (['/*/torque'], [], ['/b/torque', '/c/torque']), (['*'], ['?/torque'], ['/a']),
    (['*/torque', 'a'], ['/b/*'], ['/a', '/c/torque'])])
def test_topics_are_chosen_by_name_and_pattern(wanted, unwanted, found):
    assert chosen(['/a', '/b/torque', '/c/torque'], wanted, unwanted) == found


def test_a_topic_that_is_not_there_is_named():
    with pytest.raises(TopicError, match='no topic is named d; there are /a, /b'):
        chosen(['/a', '/b'], ['a', 'd'])


@pytest.mark.parametrize(('text', 'reliable', 'kept', 'depth'), [
    ('- {reliability: best_effort, durability: volatile, depth: 5}', False, False, 1000),
    ('- {reliability: 1, durability: 1, depth: 7}', True, True, 7),
    ('- {reliability: reliable, depth: 4000}', True, False, 4000),
    ('- {reliability: 2}\n- {reliability: 1}', True, False, 1000),
    ('- {reliability: 2, durability: transient_local}', False, True, 1),
    ('{', True, False, 1000), ('- 5\n- {depth: -3}', True, False, 1000)])
def test_quality_is_the_strongest_that_was_offered(text, reliable, kept, depth):
    found = strongest([text])
    assert (found.reliability == ReliabilityPolicy.RELIABLE) == reliable
    assert (found.durability == DurabilityPolicy.TRANSIENT_LOCAL) == kept
    assert found.depth == depth


def test_deadlines_and_liveliness_are_offered_again():
    found = strongest([
        '- deadline: {sec: 1, nsec: 5}\n  liveliness: 3\n'
        '- deadline: {sec: 0, nsec: 700}\n  liveliness: automatic\n',
        '- deadline: {sec: 9223372036, nsec: 854775807}\n'])
    assert found.deadline.nanoseconds == 700
    assert found.liveliness == LivelinessPolicy.MANUAL_BY_TOPIC
    assert found.liveliness_lease_duration == strongest([]).liveliness_lease_duration


def test_player_publishes_everything_from_the_first_message_on(tmp_path):
    """Nothing is played before a late subscriber has come, and then nothing is left out."""
    messages = some_messages(400)
    write_ours(tmp_path / 'bag', messages)
    with watching() as watcher:
        clock, wrenches = watcher.hear(CLOCK), watcher.hear(TIP_WRENCH)
        with running(tmp_path, bag_player=(
                f'bag:={tmp_path / "bag"}', 'wait_for:=[joint_states]',
                'exclude:=[estimator_*]')) as nodes:
            watcher.until(lambda: watcher.node.count_publishers('joint_states') == 1, 'a topic')
            assert watcher.node.count_publishers('estimator_state') == 0
            heard = watcher.hear(JOINT_STATES)
            assert not wrenches and not clock
            watcher.until(lambda: not nodes['bag_player'].running(), 'the end')
            assert nodes['bag_player'].wait() == 0, nodes['bag_player'].said
        watcher.until(lambda: len(heard) + len(wrenches) == 800, 'all messages')
    for found, topic in ((heard, '/joint_states'), (wrenches, '/tip/wrench')):
        assert found == [content for name, _, content in messages if name == topic]
    assert clock[0] == LITTLE_ENDIAN + pack_stamp(messages[0][1])


def test_paused_player_steps_and_resumes(tmp_path):
    """Two topics of equal stamps, remapped, from an offset on."""
    messages = [('/joint_states', 10**9 * (1 + n // 2), encode_joint_state(n, '', ('a',), (n,)))
                for n in range(8)]
    write_ours(tmp_path / 'bag', messages)
    remapped = JOINT_STATES.__class__('elsewhere', JOINT_STATES.message_type, 100)
    with watching() as watcher, running(tmp_path, bag_player=(
            f'bag:={tmp_path / "bag"}', 'paused:=true', 'start_offset:=1.0', 'settle_time:=0',
            'rate:=100', '/joint_states:=/elsewhere')) as nodes:
        assert not watcher.call(Trigger, 'bag_player/step').success
        heard = watcher.hear(remapped)
        watcher.until(lambda: watcher.call(Trigger, 'bag_player/step').success, 'a step')
        step = watcher.call(Trigger, 'bag_player/step')
        assert step.message == '/joint_states at 2.000000000 s'
        watcher.until(lambda: len(heard) == 2, 'two messages')
        assert watcher.call(Trigger, 'bag_player/pause').message == 'paused'
        assert watcher.call(Trigger, 'bag_player/resume').message == 'playing'
        assert nodes['bag_player'].wait() == 0
        watcher.until(lambda: len(heard) == 6, 'the others')
    assert heard == [content for _, _, content in messages[2:]]


@pytest.mark.parametrize(('parameters', 'said'), [
    ((), 'bag must name a recording'), (('bag:=none',), 'there is no recording at none'),
    (('bag:=none', 'rate:=0',), 'bag_player.rate must lie in [0.01, 100]'),
    (('bag:=BAG', 'topics:=[nowhere]'), 'no topic is named nowhere; there are /estimator_state'),
    (('bag:=BAG', 'start_offset:=9.0'), 'there is no message in what should be played')])
def test_unusable_input_is_one_line(tmp_path, parameters, said):
    write_ours(tmp_path / 'bag', some_messages(3))
    given = [each.replace('BAG', str(tmp_path / 'bag')) for each in parameters]
    with running(tmp_path, bag_player=tuple(given)) as nodes:
        assert nodes['bag_player'].wait() == 2
        assert len(nodes['bag_player'].said.splitlines()) == 1
        assert said in nodes['bag_player'].said
