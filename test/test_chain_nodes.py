"""The nodes of an arm of seven joints, each a process: what they say, and that they stop."""

import signal

from diagnostic_msgs.msg import DiagnosticArray
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import home_of, motion_of
from hda_msgs_json.cdr import decode_joint_state
from hda_msgs_json.cdr_arrays import encode_joint_rows
from hda_msgs_json.topics import (DIAGNOSTICS, ESTIMATOR_STATE, JOINT_REFERENCE, JOINT_STATES,
                                  JOINT_TORQUES, MOTOR_COMMAND, ROBOT_DESCRIPTION)
from hda_torque_estimator.estimating.estimate_messages import estimate_topics
from hda_torque_estimator.simulating.closed_loop import run
from hda_torque_estimator.simulating.recorded import joint_samples
from node_processes import diagnostics, holds_the_live_run, running, watching
import numpy as np
import pytest
from rclpy.serialization import serialize_message
from std_srvs.srv import SetBool
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

COBOT = read_arm('cobot7.yaml')
ARM = 'arm:=cobot7.yaml'
pytestmark = pytest.mark.xdist_group('nodes')


def test_three_nodes_move_seven_joints_and_stop_without_samples(tmp_path):
    with watching() as watcher, running(
            tmp_path, arm_sim=(ARM, 'rate:=100'), torque_estimator=(ARM,),
            jtf_controller=(ARM, 'torque_feedback:=0.0', 'sample_timeout:=1.0')) as nodes:
        states, commands = watcher.hear(JOINT_STATES), watcher.hear(MOTOR_COMMAND)
        torques, heard = watcher.hear(JOINT_TORQUES), watcher.hear(DIAGNOSTICS)
        described = watcher.hear(ROBOT_DESCRIPTION)
        target = watcher.send(JOINT_REFERENCE, 1)
        watcher.until(lambda: states and described and torques, 'what the nodes say')
        watcher.until(lambda: watcher.call(SetBool, 'jtf_controller/enable', data=True).success,
                      'samples and torques')
        wanted = np.array(home_of(COBOT)) + 0.1
        point = JointTrajectoryPoint(positions=list(wanted))
        point.time_from_start.sec = 1
        target(serialize_message(JointTrajectory(joint_names=list(COBOT.labels),
                                                 points=[point])))
        watcher.until(lambda: np.allclose(decode_joint_state(states[-1]).position[:7], wanted,
                                          atol=0.02), 'the target')
        assert list(decode_joint_state(torques[-1]).names) == list(COBOT.labels)
        assert np.isfinite(decode_joint_state(torques[-1]).effort).all()
        nodes['arm_sim'].interrupt()
        watcher.until(lambda: 'stopped, zero torque' in nodes['jtf_controller'].said, 'the stop')
        watcher.until(lambda: not np.any(decode_joint_state(commands[-1]).effort), 'zero torque')
        watcher.until(lambda: 'stopped' in diagnostics(heard, DiagnosticArray)[
            'jtf_controller'].message, 'why')
    assert b'name="tool"' in described[0] and b'joint7' in described[0]


def test_a_recording_of_seven_joints_gives_the_bits_of_the_live_run(tmp_path):
    made = run(COBOT, COBOT, motion_of(COBOT, 'sine', 2.0, 1e-3, 0), 1)
    stamps = 10**9 + np.arange(len(made.time)) * 1_000_000
    samples = joint_samples(COBOT, stamps, made.reading, made.command)
    sent = [row.tobytes() for row in encode_joint_rows(samples)][1000:1300]
    bag = tmp_path / 'bag'
    with watching() as watcher, running(tmp_path, torque_estimator=(ARM,), bag_recorder=(
            ARM, f'output:={bag}')) as nodes:
        torques = watcher.hear(JOINT_TORQUES)
        send = watcher.send(JOINT_STATES, 2)
        watcher.until_read({**dict.fromkeys(estimate_topics(COBOT), 1), JOINT_TORQUES: 2,
                            ESTIMATOR_STATE: 1})
        for message in sent:                            # fewer than the queues hold
            send(message)
        watcher.until(lambda: len(torques) == len(sent), 'all estimates')
        for name in ('torque_estimator', 'bag_recorder'):
            nodes[name].send(signal.SIGINT)
            assert nodes[name].wait() == 0
    holds_the_live_run(bag, COBOT, sent)
