"""The first bad sample stops the motors before a word is said, seen over DDS."""

from functools import partial

from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import HOME
from hda_arm_sim.ros.topics import message_class, quality
from hda_msgs_json.cdr import decode_joint_state, encode_joint_state
from hda_msgs_json.topics import DIAGNOSTICS, JOINT_STATES, MOTOR_COMMAND, Topic
from node_processes import running, watching
import numpy as np
import pytest
from rclpy.serialization import deserialize_message

pytestmark = pytest.mark.xdist_group('nodes')
ARM = read_arm('hda_arm.yaml')
NAMES = [*ARM.labels, 'joint1_motor', 'joint2_motor']
ROSOUT = Topic('/rosout', 'rcl_interfaces/msg/Log', 1000, 'reliable', 'transient_local')
GOOD, BAD = 20, 20


def sample(k, offset=0.0):
    """Return the joint state of sample k, the first shaft off by so much [rad]."""
    return encode_joint_state(10**9 + k * 10**6, '', NAMES,
                              [*HOME, 100.0 * HOME[0] + offset, 100.0 * HOME[1]])


def timed(watcher, topic):
    """Return a list to which every message of a topic comes, with when it was published [ns]."""
    heard = []
    watcher.node.create_subscription(
        message_class(topic), topic.name,
        lambda message, about: heard.append((about['source_timestamp'], message)),
        quality(topic), raw=True)
    return heard


def reached(heard, count):
    """Return whether so many messages were heard."""
    return len(heard) >= count


def when_reported(watcher, log, reports):
    """Return when the log and when the diagnostics first reported the stop [ns]."""
    def reported():
        lines = [(at, deserialize_message(each, message_class(ROSOUT)).msg) for at, each in log]
        states = [(at, status.message) for at, each in reports
                  for status in deserialize_message(each, message_class(DIAGNOSTICS)).status]
        return [[at for at, text in reported if 'stopped' in text] for reported in (lines, states)]

    watcher.until(lambda: all(reported()), 'the log and the diagnostics')
    return [min(times) for times in reported()]


def test_zero_torque_comes_before_the_words_and_nothing_after_it(tmp_path):
    with watching() as watcher, running(
            tmp_path, jtf_controller=('enabled:=true', 'sample_timeout:=1.0')):
        commands, log, reports = (timed(watcher, topic)
                                  for topic in (MOTOR_COMMAND, ROSOUT, DIAGNOSTICS))
        send = watcher.send(JOINT_STATES, 1)
        for k in range(GOOD):
            send(sample(k))
            watcher.until(partial(reached, commands, k + 1), f'an answer to sample {k}')
        for k in range(BAD):                        # the shaft a turn away, from now on
            send(sample(GOOD + k, 2.0 * np.pi))
        reported = when_reported(watcher, log, reports)
        watcher.spin(0.5)                           # what else may come
    assert len(commands) == GOOD + 1
    zero_at, last = commands[-1][0], decode_joint_state(commands[-1][1])
    assert last.effort.tolist() == [0.0, 0.0]
    assert last.stamp_ns == 10**9 + (GOOD - 1) * 10**6
    assert all(zero_at <= when for when in reported)
