"""Topics: one definition each, types and depths as the interface promises."""

import re

from hda_msgs_json import topics
from hda_msgs_json.topics import Topic
import pytest

ALL = [value for value in vars(topics).values() if isinstance(value, Topic)] + [
    make('joint1') for make in (
        topics.joint_torque, topics.truth_joint_torque, topics.reference_joint_torque)] + [
    topics.state_of_joints('torsion'), topics.state_number('payload')]
PROMISED = {
    'joint_states': 'sensor_msgs/msg/JointState',
    'motor_command': 'sensor_msgs/msg/JointState',
    'joint_reference': 'trajectory_msgs/msg/JointTrajectory',
    'external_wrench': 'geometry_msgs/msg/WrenchStamped',
    'joint1/torque': 'geometry_msgs/msg/WrenchStamped',
    'tip/wrench': 'geometry_msgs/msg/WrenchStamped',
    'tip/wrench_tool': 'geometry_msgs/msg/WrenchStamped',
    'joint_torques': 'sensor_msgs/msg/JointState',
    'estimator_state': 'std_msgs/msg/String',
    'estimator_state/torsion': 'sensor_msgs/msg/JointState',
    'estimator_state/payload': 'std_msgs/msg/Float64',
    'truth/joint1/torque': 'geometry_msgs/msg/WrenchStamped',
    'truth/tip/wrench': 'geometry_msgs/msg/WrenchStamped',
    'reference/joint1/torque': 'geometry_msgs/msg/WrenchStamped',
    'reference/tip/wrench': 'geometry_msgs/msg/WrenchStamped',
    '/diagnostics': 'diagnostic_msgs/msg/DiagnosticArray',
    '/clock': 'rosgraph_msgs/msg/Clock',
    'robot_description': 'std_msgs/msg/String',
}


def test_topics_are_those_of_the_interface() -> None:
    """Names and types are exactly the promised ones, each defined once."""
    assert sorted((topic.name, topic.message_type) for topic in ALL) == sorted(PROMISED.items())


@pytest.mark.parametrize('topic', ALL, ids=lambda topic: topic.name)
def test_quality_of_service_has_a_reason(topic: Topic) -> None:
    """Policies are those of ROS, names are legal, and the choice is explained."""
    assert topic.reliability in ('reliable', 'best_effort')
    assert topic.durability in ('volatile', 'transient_local')
    assert re.fullmatch(r'/?[a-z][a-z0-9_]*(/[a-z][a-z0-9_]*)*', topic.name)
    assert topic.depth > 0 and len(topic.reason) > 20


@pytest.mark.parametrize('topic', ALL, ids=lambda topic: topic.name)
def test_sampled_topics_survive_a_busy_second(topic: Topic) -> None:
    """What comes with every sample at 1 kHz has room for a second of it."""
    if topic.name not in ('joint_reference', 'external_wrench', '/diagnostics', '/clock',
                          'robot_description'):
        assert topic.depth >= 1000


def test_names_of_motors_and_frames() -> None:
    """The motor side of a joint and its frame are named after it."""
    assert topics.motor_name('joint1') == 'joint1_motor'
    assert topics.link_frame('joint2') == 'joint2_link'
    assert (topics.BASE_FRAME, topics.TOOL_FRAME) == ('base', 'tool')
