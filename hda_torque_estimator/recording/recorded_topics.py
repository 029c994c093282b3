"""The topics that a recording holds: all of the system, or those that a user describes."""

from collections.abc import Sequence

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.sample_messages import truth_topics
from hda_msgs_json.topics import (
    CLOCK, DIAGNOSTICS, ESTIMATOR_STATE, EXTERNAL_WRENCH, JOINT_REFERENCE, JOINT_STATES,
    MOTOR_COMMAND, reference_joint_torque, REFERENCE_TIP_WRENCH, Topic)

from .topic_choice import matches
from ..estimating.estimate_messages import estimate_topics
from ..estimating.number_messages import number_topics


def system_topics(arm: Arm) -> tuple[Topic, ...]:
    """Return every topic of the system."""
    return (JOINT_STATES, MOTOR_COMMAND, JOINT_REFERENCE, EXTERNAL_WRENCH, *estimate_topics(arm),
            ESTIMATOR_STATE, *number_topics(arm), *truth_topics(arm),
            *(reference_joint_torque(label) for label in arm.labels), REFERENCE_TIP_WRENCH,
            DIAGNOSTICS, CLOCK)


def chosen_topics(arm: Arm, wanted: Sequence[str], unwanted: Sequence[str]) -> list[Topic]:
    """Return the topics of the system that have these names or patterns, all without any."""
    return [topic for topic in system_topics(arm)
            if (not wanted or matches(topic.name, wanted)) and not matches(topic.name, unwanted)]


def awaited(topics: Sequence[Topic], wanted: Sequence[str]) -> list[str]:
    """Return the names, without those that are patterns, that none of the topics has."""
    return [name for name in wanted if not set(name) & set('*?[')
            and not any(matches(topic.name, [name]) for topic in topics)]
