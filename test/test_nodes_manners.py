"""What users of ROS expect of any node: help, namespaces, quality of service, services, times."""

from collections.abc import Callable, Iterator
import math
import signal
import subprocess
import sys
from textwrap import dedent

from bag_content import some_messages, write_ours
from diagnostic_msgs.msg import DiagnosticArray
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.node import ArmSim
from hda_arm_sim.ros.arm_node import ReportingNode
from hda_arm_sim.ros.process import run
from hda_msgs_json.bag import open_recording
from hda_msgs_json.cdr import decode_joint_state, decode_wrench, encode_joint_state
from hda_msgs_json.cdr_arrays import encode_joint_rows, encode_wrench_rows
from hda_msgs_json.samples import JointSamples
from hda_msgs_json.topics import DIAGNOSTICS, JOINT_STATES, Topic
from hda_torque_estimator.controlling.controller_node import JtfController
from hda_torque_estimator.estimating.estimate_messages import estimate_samples, estimate_topics
from hda_torque_estimator.estimating.estimator import Estimator
from hda_torque_estimator.estimating.estimator_node import TorqueEstimator
from hda_torque_estimator.estimating.live_estimator import LiveEstimator
from hda_torque_estimator.playing.player_node import BagPlayer
from hda_torque_estimator.recording.log_clock import LogClock, PATIENCE
from hda_torque_estimator.recording.recorder_node import BagRecorder
from hda_torque_estimator.samples.sample_reader import SampleReader
from moving_arm import moving
from node_processes import diagnostics, running, watching
import numpy as np
from project_files import ROOT
import pytest
import rclpy
from test_recorder import counted, samples

ARM = read_arm('hda_arm.yaml')
KINDS = (ArmSim, TorqueEstimator, JtfController, BagRecorder, BagPlayer)
PARAMETERS = ROOT / 'config' / 'parameters' / 'nodes.yaml'
Make = Callable[..., ReportingNode]
pytestmark = pytest.mark.xdist_group('nodes')


@pytest.fixture
def node(tmp_path) -> Iterator[Make]:
    """Return a function that makes a node with ROS arguments, and what it cannot do without."""
    made: list[ReportingNode] = []
    write_ours(tmp_path / 'played', some_messages(3))
    needed = {BagRecorder: ['-p', f'output:={tmp_path / "bag"}'],
              BagPlayer: ['-p', f'bag:={tmp_path / "played"}', '-p', 'paused:=true']}

    def make(kind: type[ReportingNode], *words: str) -> ReportingNode:
        rclpy.init(args=['node', '--ros-args', *words, *needed.get(kind, [])])
        made.append(kind())
        return made[-1]

    yield make
    for each in made:
        each.close()
        each.destroy_node()
    rclpy.try_shutdown()


@pytest.mark.parametrize('kind', KINDS)
def test_help_lists_every_parameter(kind, node, capsys):
    assert run('name', lambda: [kind()], ['name', '--help'], kinds=[kind]) == 0
    output = capsys.readouterr()
    assert output.err == ''
    assert max(map(len, output.out.splitlines())) <= 80
    names = {line.split()[0] for line in output.out.split('parameters:')[1].splitlines()
             if line.startswith('  ') and line[2] != ' '}
    assert names == set(node(kind).parameters.names())


@pytest.mark.parametrize('kind', KINDS[:4])
def test_the_example_of_parameters_fits_every_node(kind, node):
    made = node(kind, '--params-file', str(PARAMETERS), '-r', '__ns:=/left')
    assert made.parameters.unknown() == []
    assert made.get_parameter('arm').value == 'hda_arm.yaml'


def test_quality_of_service_can_be_overridden(node):
    made = node(TorqueEstimator, '-p', 'qos_overrides./joint_states.subscription.depth:=7',
                '-p', 'qos_overrides./joint_torques.publisher.reliability:=best_effort')
    assert made.parameters.unknown() == []
    (queue,), = ([each.qos_profile.depth for each in made.subscriptions
                  if each.topic_name == '/joint_states'],)
    assert queue == 7
    info, = made.get_publishers_info_by_topic('/joint_torques')
    assert info.qos_profile.reliability.name == 'BEST_EFFORT'


def test_unknown_quality_of_service_is_one_line(signals, capsys):
    words = ['-p', 'qos_overrides./joint_states.publisher.reliability:=perhaps']
    assert run('name', lambda: [ArmSim()], ['name', '--ros-args', *words]) == 2
    said = capsys.readouterr().err
    assert len(said.splitlines()) == 1
    assert 'the parameters qos_overrides of joint_states cannot be used' in said


@pytest.mark.parametrize(('kind', 'usual', 'service'), [
    (ArmSim, 'arm_sim', 'reset'), (TorqueEstimator, 'torque_estimator', 'tare'),
    (JtfController, 'jtf_controller', 'enable'), (BagRecorder, 'bag_recorder', 'pause'),
    (BagPlayer, 'bag_player', 'step')])
def test_services_have_the_usual_name_and_that_of_the_node(kind, usual, service, node):
    made = node(kind, '-r', '__node:=renamed', '-r', '__ns:=/left')
    names = {name for name, _ in made.get_service_names_and_types_by_node('renamed', '/left')}
    assert {f'/left/{usual}/{service}', f'/left/renamed/{service}'} <= names


@pytest.mark.parametrize(('kind', 'waits'), [
    (ArmSim, 'motor_command'), (TorqueEstimator, 'joint_states'),
    (JtfController, 'joint_states, and a call of jtf_controller/enable'),
    (BagPlayer, 'a subscriber of any')])
def test_a_node_says_in_one_line_that_it_started(kind, waits, node, capfd):
    node(kind)
    said, = (line for line in capfd.readouterr().err.splitlines() if 'started: ' in line)
    assert f'waits for {waits}' in said
    assert 'hda_arm.yaml (joint1, joint2)' in said or kind is BagPlayer


def test_a_middleware_that_does_not_let_go_cannot_keep_a_process():
    """Stand in for Fast DDS: it spins in compiled code that holds the interpreter."""
    ended = subprocess.run([sys.executable, '-c', dedent("""
        import ctypes
        from hda_arm_sim.ros import process

        class Held:
            def destroy_node(self):
                ctypes.PyDLL(None).sleep(60)

        process.LONGEST_END = 0.2
        process._end([Held()])
        """)], timeout=30.0, check=False)
    assert ended.returncode == -signal.SIGALRM


def test_diagnostics_name_the_arm(tmp_path):
    with watching() as watcher, running(tmp_path, torque_estimator=('arm:=paper_table1.yaml',)):
        heard = watcher.hear(DIAGNOSTICS)
        watcher.until(lambda: heard, 'a report')
        status = diagnostics(heard, DiagnosticArray)['torque_estimator']
    assert status.hardware_id == 'paper_table1.yaml'


def test_topics_in_a_namespace_keep_it_in_the_bag(tmp_path):
    bag, sent = tmp_path / 'bag', samples(5)
    with watching() as watcher, running(tmp_path, bag_recorder=(
            f'output:={bag}', '__ns:=/left', 'topics:=[joint_states, extra]')) as nodes:
        send = watcher.send(Topic('/left/joint_states', JOINT_STATES.message_type, 100), 1)
        late = watcher.send(Topic('/left/extra', JOINT_STATES.message_type, 100), 1)
        for message in sent:
            send(message)
            late(message)
        watcher.until(lambda: counted(bag) == 2 * len(sent), 'all messages')
        nodes['bag_recorder'].send(signal.SIGINT)
        assert nodes['bag_recorder'].wait() == 0
    recording = open_recording(bag)
    assert set(recording.topics) == {'/left/joint_states', '/left/extra'}
    assert recording.raw('joint_states')[1] == sent     # by the name that the commands use


def test_without_a_clock_messages_get_the_time_of_this_machine(tmp_path):
    bag, sent = tmp_path / 'bag', samples(5)
    with watching() as watcher, running(tmp_path, bag_recorder=(
            f'output:={bag}', 'topics:=[joint_states]', 'use_sim_time:=true')) as nodes:
        send = watcher.send(JOINT_STATES, 1)
        for message in sent:
            send(message)
        watcher.until(lambda: counted(bag) == len(sent), 'all messages')
        nodes['bag_recorder'].send(signal.SIGINT)
        assert nodes['bag_recorder'].wait() == 0
        assert 'nobody publishes /clock' in nodes['bag_recorder'].said
    times, found = open_recording(bag).raw('joint_states')
    assert found == sent
    assert times.min() > 10**18                         # of this century, not of 1970


def test_a_recording_has_one_clock():
    reported = LogClock(simulated=True)
    assert [reported.time(0, 100), reported.time(0, 200), reported.time(7, 300)] == [None, None, 7]
    silent = LogClock(simulated=True)
    assert [silent.time(0, 100), silent.time(0, 100 + PATIENCE), silent.time(7, 10**10)] == [
        None, 100 + PATIENCE, 10**10]
    assert silent.gave_up
    assert not reported.gave_up
    ending = LogClock(simulated=True)
    ending.hurry()
    assert ending.time(0, 5) == 5
    assert LogClock(simulated=False).time(7, 9) == 9


def test_publishers_that_offer_less_are_heard_without_a_warning(tmp_path):
    hurried = Topic('joint_states', JOINT_STATES.message_type, 100, 'best_effort')
    bag, sent = tmp_path / 'bag', samples(3)
    with watching() as watcher, running(tmp_path, bag_recorder=(
            f'output:={bag}', 'topics:=[joint_states]')) as nodes:
        send = watcher.send(hurried, 1)
        for message in sent:
            send(message)
        watcher.until(lambda: counted(bag) == len(sent), 'all messages')
        assert 'QoS' not in nodes['bag_recorder'].said


@pytest.fixture(scope='module')
def sent() -> list[bytes]:
    """Return the messages of 0.6 s of an arm that moves, and one of a stretched arm."""
    return [*moving(ARM), encode_joint_state(
        10**10, '', ('joint1', 'joint2', 'joint1_motor', 'joint2_motor'), (0.3, 0.0, 30.0, 0.0))]


@pytest.mark.parametrize('unobserved', ['nan', 'zero'])
def test_wrenches_are_as_tools_want_them(sent, unobserved):
    """The node and the command give the same bytes; zeros stand where NaN would, nowhere else."""
    live, usual = LiveEstimator(ARM, unobserved=unobserved), LiveEstimator(ARM)
    answers = [live(message).messages for message in sent]
    expected = [usual(message).messages for message in sent]
    topics = estimate_topics(ARM)
    for made, known in zip(answers, expected):
        for topic, one, other in zip(topics, made, known):
            if topic.message_type != JOINT_STATES.message_type:
                numbers, usual_ones = ([*decode_wrench(each).force, *decode_wrench(each).torque]
                                       for each in (one, other))
                assert any(map(math.isnan, usual_ones))
                assert not (unobserved == 'zero' and any(map(math.isnan, numbers)))
                assert np.array_equal(numbers, np.where(
                    np.isnan(usual_ones) & (unobserved == 'zero'), 0.0, usual_ones),
                    equal_nan=True)
    stamps, reading, command = recorded(sent)
    estimates = Estimator(ARM).run(stamps, reading, command)
    for column, part in enumerate(estimate_samples(ARM, estimates, unobserved).values()):
        encode = encode_joint_rows if isinstance(part, JointSamples) else encode_wrench_rows
        assert [row.tobytes() for row in encode(part)] == [each[column] for each in answers]


def recorded(messages: list[bytes]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return stamps, readings and commands of messages."""
    read, rows = SampleReader(ARM), []
    for message in messages:
        stamp, reading = read(message)
        rows.append((stamp, reading.copy(), read.command.copy()))
    stamps, readings, commands = zip(*rows)
    return np.array(stamps), np.array(readings), np.array(commands)


def test_joint_torques_have_no_numbers_that_nobody_knows(sent):
    topics = estimate_topics(ARM)
    column, = (at for at, topic in enumerate(topics) if topic.name == 'joint_torques')
    state = decode_joint_state(LiveEstimator(ARM)(sent[0]).messages[column])
    assert [len(values) for values in state.numbers] == [0, 0, 2]


@pytest.mark.parametrize('word', ['nan', 'zero'])
def test_unobserved_is_a_word(node, word):
    """YAML takes one of the words for a number."""
    made = node(TorqueEstimator, '-p', f'unobserved:={word}')
    assert made.get_parameter('unobserved').value == word


def test_unobserved_is_nan_or_zero(signals, capsys):
    words = ['--ros-args', '-p', 'unobserved:=none']
    assert run('name', lambda: [TorqueEstimator()], ['name', *words]) == 2
    said = capsys.readouterr().err
    assert len(said.splitlines()) == 1
    assert 'unobserved must be one of nan, zero' in said
