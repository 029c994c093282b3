"""The nodes as their users run them: each a process, connected by ROS, ended by signals."""

from functools import partial
from itertools import islice
import json
from pathlib import Path
import signal

from bag_content import some_messages, write_ours
from diagnostic_msgs.msg import DiagnosticArray
from hda_arm_sim.model.files import arm_from_text, read_arm
from hda_msgs_json.bag import open_recording
from hda_msgs_json.cdr import decode_joint_state, encode_joint_state
from hda_msgs_json.mcap_records import BagError
from hda_msgs_json.topics import (
    DIAGNOSTICS, ESTIMATOR_STATE, JOINT_REFERENCE, JOINT_STATES, JOINT_TORQUES, MOTOR_COMMAND,
    Topic)
from hda_torque_estimator.estimating.estimate_messages import estimate_topics
from moving_arm import moving
from node_processes import diagnostics, holds_the_live_run, MODULES, running, SETTLE, watching
import numpy as np
import pytest
from rclpy.serialization import serialize_message
from std_srvs.srv import SetBool, Trigger
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

ARM = read_arm('hda_arm.yaml')
pytestmark = pytest.mark.xdist_group('nodes')


@pytest.fixture(scope='module')
def sent():
    """Return the messages of 0.6 s of an arm that moves."""
    return moving(ARM)


@pytest.mark.parametrize('numbers', [(signal.SIGINT, signal.SIGINT), (signal.SIGTERM,)])
def test_nodes_end_cleanly_when_interrupted(numbers, tmp_path):
    """The terminal and `ros2 launch` both send SIGINT: every node takes it twice."""
    write_ours(tmp_path / 'played', some_messages(3))
    parameters = {'bag_recorder': (f'output:={tmp_path / "bag"}',),
                  'bag_player': (f'bag:={tmp_path / "played"}', 'paused:=true')}
    with watching() as watcher, running(
            tmp_path, **{name: parameters.get(name, ()) for name in MODULES}) as nodes:
        heard = watcher.hear(DIAGNOSTICS)
        watcher.until(lambda: len(diagnostics(heard, DiagnosticArray)) == len(nodes), 'all nodes')
        watcher.until(lambda: JOINT_STATES.name in recorded_topics(heard), 'samples in the bag')
        for process in nodes.values():
            process.send(*numbers)
        assert {name: process.wait() for name, process in nodes.items()} == dict.fromkeys(nodes, 0)
        assert {name: 'Traceback' in process.said for name, process in nodes.items()} == (
            dict.fromkeys(nodes, False))
    assert open_recording(tmp_path / 'bag').topics['/joint_states'].count > 0


def recorded_topics(heard: list[bytes]) -> set[str]:
    """Return the keys of all that the nodes have said of themselves."""
    return {each.key for status in diagnostics(heard, DiagnosticArray).values()
            for each in status.values}


def at_least(heard: list[bytes], count: int) -> bool:
    """Return whether so many messages have come."""
    return len(heard) >= count


def test_estimates_of_a_recording_are_those_of_the_live_run(sent, tmp_path):
    """The recorder loses nothing, and the same samples give the same bits again."""
    bag = tmp_path / 'bag'
    with watching() as watcher, running(tmp_path, torque_estimator=(), bag_recorder=(
            f'output:={bag}',)) as nodes:
        torques, states = watcher.hear(JOINT_TORQUES), watcher.hear(ESTIMATOR_STATE)
        send = watcher.send(JOINT_STATES, 2)
        watcher.until_read({**dict.fromkeys(estimate_topics(ARM), 1), JOINT_TORQUES: 2,
                            ESTIMATOR_STATE: 2})
        for first in range(0, len(sent), 100):          # never more on their way than queues hold
            watcher.until(partial(at_least, torques, first - 100), 'estimates')
            for message in sent[first:first + 100]:
                send(message)
        watcher.until(lambda: len(torques) == len(sent) and len(states) >= 30, 'all estimates')
        for name in ('torque_estimator', 'bag_recorder'):
            nodes[name].send(signal.SIGINT)
            assert nodes[name].wait() == 0
    holds_the_live_run(bag, ARM, sent)


def test_what_a_node_sent_arrives_though_it_ends(sent, tmp_path):
    """A recorder that got no time at all still gets what an estimator said before its end."""
    bag = tmp_path / 'bag'
    with watching() as watcher, running(tmp_path, torque_estimator=(), bag_recorder=(
            f'output:={bag}',)) as nodes:
        torques = watcher.hear(JOINT_TORQUES)
        send, left = watcher.send(JOINT_STATES, 2), iter(sent)
        watcher.until_read({JOINT_TORQUES: 2})

        def records():
            send(next(left))
            watcher.spin(0.2)
            return recorded(bag) > 0

        watcher.until(records, 'a first estimate in the bag')
        watcher.spin(SETTLE)
        before, heard = recorded(bag), len(torques)
        nodes['bag_recorder'].send(signal.SIGSTOP)
        for message in islice(left, 60):
            send(message)
        watcher.until(lambda: len(torques) == heard + 60, 'all estimates')
        nodes['torque_estimator'].send(signal.SIGINT)
        watcher.spin(0.5)
        nodes['bag_recorder'].send(signal.SIGCONT)
        assert nodes['torque_estimator'].wait() == 0
        nodes['bag_recorder'].send(signal.SIGINT)
        assert nodes['bag_recorder'].wait() == 0
    assert recorded(bag) == before + 60


def recorded(bag: Path) -> int:
    """Return how many estimates a bag holds so far, 0 before there is one."""
    try:
        return open_recording(bag).topics[f'/{JOINT_TORQUES.name}'].count
    except (BagError, KeyError):
        return 0


def test_recording_states_how_it_was_made(tmp_path):
    with watching() as watcher, running(
            tmp_path, arm_sim=('seed:=7', 'rate:=100'),
            bag_recorder=(f'output:={tmp_path / "bag"}',)) as nodes:
        heard = watcher.hear(DIAGNOSTICS)
        watcher.until(lambda: len(diagnostics(heard, DiagnosticArray)) == 2, 'both nodes')
        watcher.until(lambda: 'seed' in open_recording(tmp_path / 'bag').metadata, 'the seed')
        nodes['bag_recorder'].send(signal.SIGTERM)
        assert nodes['bag_recorder'].wait() == 0
    about = open_recording(tmp_path / 'bag').metadata
    assert arm_from_text(about['arm'], 'bag') == ARM
    assert about['seed'] == '7'
    assert json.loads(about['parameters'])['arm_sim']['rate'] == 100.0
    assert about['version']


def test_estimator_counts_what_is_wrong_and_goes_on(sent, tmp_path):
    state = decode_joint_state(sent[0])
    wrong = [b'\x00\x01\x00\x00 no message', sent[0], *(
        encode_joint_state(state.stamp_ns + 1, '', names, position) for names, position in (
            (state.names[:3], state.position[:3]), (state.names, state.position[:3]),
            (state.names, [np.nan] * 4)))]
    with watching() as watcher, running(tmp_path, torque_estimator=()) as nodes:
        torques, heard = watcher.hear(JOINT_TORQUES), watcher.hear(DIAGNOSTICS)
        send = watcher.send(JOINT_STATES, 1)
        watcher.until(lambda: watcher.node.count_publishers(JOINT_TORQUES.name) == 1, 'torques')
        for message in (sent[0], *wrong, *wrong, sent[1]):
            send(message)
        watcher.until(lambda: len(torques) == 2, 'the sample after the wrong ones')

        def counted():
            status = diagnostics(heard, DiagnosticArray).get('torque_estimator')
            return {value.key: value.value for value in status.values
                    if value.key.startswith('refused')} if status else {}

        watcher.until(lambda: sum(map(int, counted().values())) == 10, 'all refusals')
        assert set(counted().values()) == {'2'}
        assert len(counted()) == 5
        said = [line for line in nodes['torque_estimator'].said.splitlines() if 'WARN' in line]
    assert len(said) == 5
    assert all('joint_states: ' in line for line in said)
    assert any('joint2_motor not found in joint1, joint2, joint1_motor' in line for line in said)


def test_loop_is_closed_and_opens_when_samples_stop(tmp_path):
    """Enable, follow a target, lose the samples: zero torque, disabled, and why."""
    with watching() as watcher, running(
            tmp_path, arm_sim=('rate:=200',), torque_estimator=(),
            jtf_controller=('torque_feedback:=0.5', 'sample_timeout:=0.5')) as nodes:
        states, commands = watcher.hear(JOINT_STATES), watcher.hear(MOTOR_COMMAND)
        heard = watcher.hear(DIAGNOSTICS)
        target = watcher.send(JOINT_REFERENCE, 1)
        watcher.until(lambda: states, 'states')         # from here on it hears all of them
        watcher.until(lambda: watcher.call(SetBool, 'jtf_controller/enable', data=True).success,
                      'samples and torques')
        point = JointTrajectoryPoint(positions=[0.35, 1.15])
        point.time_from_start.sec = 1
        target(serialize_message(
            JointTrajectory(joint_names=list(ARM.labels), points=[point])))

        def last_angles():
            return decode_joint_state(states[-1]).position[:2] if states else np.zeros(2)

        watcher.until(lambda: np.allclose(last_angles(), [0.35, 1.15], atol=0.02), 'the target')
        nodes['arm_sim'].send(signal.SIGSTOP)
        watcher.until(lambda: 'stopped, zero torque' in nodes['jtf_controller'].said, 'the stop')
        watcher.until(lambda: not np.any(decode_joint_state(commands[-1]).effort), 'zero torque')
        watcher.until(lambda: diagnostics(heard, DiagnosticArray)['jtf_controller'].message ==
                      'stopped: no joint_states that can be used for 0.5 s', 'why')
        assert not watcher.call(SetBool, 'jtf_controller/enable', data=True).success
    stamps = {decode_joint_state(state).stamp_ns for state in states}
    answered = [decode_joint_state(command).stamp_ns for command in commands]
    assert set(answered[:-1]) <= stamps
    assert answered[:-1] == sorted(set(answered[:-1]))


def test_a_driver_that_does_its_best_only_is_heard(sent, tmp_path):
    hurried = Topic('joint_states', JOINT_STATES.message_type, 100, 'best_effort')
    with watching() as watcher, running(tmp_path, torque_estimator=(), jtf_controller=(
            'enabled:=true', 'torque_feedback:=0.0')):
        torques, commands = watcher.hear(JOINT_TORQUES), watcher.hear(MOTOR_COMMAND)
        send, left = watcher.send(hurried, 2), iter(sent)

        def answered():
            send(next(left))
            watcher.spin(0.05)
            return torques and commands

        watcher.until(answered, 'estimates and commands')
        stamps = {decode_joint_state(message).stamp_ns for message in sent}
        for message in (*torques, *commands):
            assert decode_joint_state(message).stamp_ns in stamps


def test_time_of_a_patient_arm_stands_while_a_command_is_late(tmp_path):
    """After one command no other comes: its samples stop for the patience, and then go on."""
    with watching() as watcher, running(tmp_path, arm_sim=('patience:=3.0',)):
        samples = watcher.hear(JOINT_STATES)
        command = watcher.send(MOTOR_COMMAND, 1)
        watcher.until(partial(at_least, samples, 1), 'samples')
        stamp = decode_joint_state(samples[-1]).stamp_ns
        motors, none = [f'{label}_motor' for label in ARM.labels], []
        command(encode_joint_state(stamp, '', motors, none, none, [0.0] * len(motors)))
        watcher.spin(SETTLE)
        stands = len(samples)
        watcher.spin(0.5)
        assert len(samples) == stands
        watcher.until(partial(at_least, samples, stands + 100), 'samples after the patience')
    stamps = [decode_joint_state(each).stamp_ns for each in samples]
    assert set(np.diff(stamps)) == {1_000_000}      # no time of the arm is left out


def test_services_answer(tmp_path):
    with watching() as watcher, running(
            tmp_path, arm_sim=('rate:=100',), torque_estimator=('tare_time:=0.1',)):
        for service in ('arm_sim/reset', 'torque_estimator/tare', 'torque_estimator/reset'):
            assert watcher.call(Trigger, service).success


def test_recorder_that_cannot_write_says_so_and_ends(tmp_path):
    (tmp_path / 'taken').mkdir()
    (tmp_path / 'taken' / 'file').touch()
    with running(tmp_path, bag_recorder=(f'output:={tmp_path / "taken"}',)) as nodes:
        assert nodes['bag_recorder'].wait() == 2
        assert len(nodes['bag_recorder'].said.splitlines()) == 1
