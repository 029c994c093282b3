"""Every topic of the system, once: its name, type, quality of service and the reason for it."""

from dataclasses import dataclass

JOINT_STATE = 'sensor_msgs/msg/JointState'
WRENCH_STAMPED = 'geometry_msgs/msg/WrenchStamped'
JOINT_TRAJECTORY = 'trajectory_msgs/msg/JointTrajectory'
STRING = 'std_msgs/msg/String'
NUMBER = 'std_msgs/msg/Float64'
DIAGNOSTIC_ARRAY = 'diagnostic_msgs/msg/DiagnosticArray'
CLOCK_TYPE = 'rosgraph_msgs/msg/Clock'

SAMPLED_DEPTH = 1000
SAMPLED_REASON = (
    'every sample counts: reliable delivery still overwrites its history, so only a deep queue '
    'survives a busy second'
)


@dataclass(frozen=True)
class Topic:
    """Name one topic, what it carries, and the quality of service that it needs."""

    name: str
    message_type: str
    depth: int
    reliability: str = 'reliable'
    durability: str = 'volatile'
    reason: str = ''


def _sampled(name: str, message_type: str) -> Topic:
    return Topic(name, message_type, SAMPLED_DEPTH, reason=SAMPLED_REASON)


JOINT_STATES = _sampled('joint_states', JOINT_STATE)
MOTOR_COMMAND = _sampled('motor_command', JOINT_STATE)
JOINT_TORQUES = _sampled('joint_torques', JOINT_STATE)
TIP_WRENCH = _sampled('tip/wrench', WRENCH_STAMPED)
TIP_WRENCH_TOOL = _sampled('tip/wrench_tool', WRENCH_STAMPED)
TRUTH_TIP_WRENCH = _sampled('truth/tip/wrench', WRENCH_STAMPED)
REFERENCE_TIP_WRENCH = _sampled('reference/tip/wrench', WRENCH_STAMPED)
ESTIMATOR_STATE = _sampled('estimator_state', STRING)
EXTERNAL_WRENCH = Topic(
    'external_wrench', WRENCH_STAMPED, 100, reason='a push may be streamed at a high rate')
JOINT_REFERENCE = Topic(
    'joint_reference', JOINT_TRAJECTORY, 10, reason='a target is sent once and must arrive')
DIAGNOSTICS = Topic(
    '/diagnostics', DIAGNOSTIC_ARRAY, 10, reason='the depth that ROS tools use for diagnostics')
CLOCK = Topic(
    '/clock', CLOCK_TYPE, 10, reason='only the latest time matters, yet a step must arrive')
ROBOT_DESCRIPTION = Topic(
    'robot_description', STRING, 1, durability='transient_local',
    reason='it is said once, and who comes late must hear it too')

MOTOR_SUFFIX = '_motor'
BASE_FRAME = 'base'
TOOL_FRAME = 'tool'


def joint_torque(joint: str) -> Topic:
    """Return the topic of the estimated torque through the gear of a joint."""
    return _sampled(f'{joint}/torque', WRENCH_STAMPED)


def truth_joint_torque(joint: str) -> Topic:
    """Return the topic of the torque through the gear of a joint that the simulator knows."""
    return _sampled(f'truth/{joint}/torque', WRENCH_STAMPED)


def truth_link_wrench(joint: str) -> Topic:
    """Return the topic of what the simulator lets act on a joint's link, at the link's end."""
    return _sampled(f'truth/{joint}/wrench', WRENCH_STAMPED)


def reference_joint_torque(joint: str) -> Topic:
    """Return the topic of the torque of a joint that a sensor of its own measured."""
    return _sampled(f'reference/{joint}/torque', WRENCH_STAMPED)


def state_of_joints(quantity: str) -> Topic:
    """Return the topic of a quantity of `estimator_state` that every joint has."""
    return _sampled(f'estimator_state/{quantity}', JOINT_STATE)


def state_number(quantity: str) -> Topic:
    """Return the topic of a single number of `estimator_state`."""
    return _sampled(f'estimator_state/{quantity}', NUMBER)


def motor_name(joint: str) -> str:
    """Return the name that the motor shaft of a joint has in a JointState."""
    return joint + MOTOR_SUFFIX


def link_frame(joint: str) -> str:
    """Return the frame in which the torque of a joint is given."""
    return f'{joint}_link'
