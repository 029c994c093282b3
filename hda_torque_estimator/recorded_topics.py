"""The topics that a recording holds: all of the system, or those that a user names."""

from collections.abc import Sequence

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.sample_messages import truth_topics
from hda_msgs_json.topics import (
    CLOCK, DIAGNOSTICS, ESTIMATOR_STATE, EXTERNAL_WRENCH, JOINT_REFERENCE, JOINT_STATES,
    MOTOR_COMMAND, reference_joint_torque, REFERENCE_TIP_WRENCH, Topic)

from .estimate_messages import estimate_topics


class TopicError(ValueError):
    """A topic that cannot be recorded."""


def system_topics(arm: Arm) -> tuple[Topic, ...]:
    """Return every topic of the system."""
    return (JOINT_STATES, MOTOR_COMMAND, JOINT_REFERENCE, EXTERNAL_WRENCH, *estimate_topics(arm),
            ESTIMATOR_STATE, *truth_topics(arm),
            *(reference_joint_torque(label) for label in arm.labels), REFERENCE_TIP_WRENCH,
            DIAGNOSTICS, CLOCK)


def named_topics(arm: Arm, names: Sequence[str]) -> tuple[Topic, ...]:
    """Return the topics of these names, all without any; raises TopicError for another name."""
    known = {topic.name.lstrip('/'): topic for topic in system_topics(arm)}
    wanted = [name.lstrip('/') for name in names] or list(known)
    if unknown := [name for name in wanted if name not in known]:
        raise TopicError(f'no topic of the system is named {", ".join(unknown)}; there are '
                         f'{", ".join(known)}')
    return tuple(known[name] for name in dict.fromkeys(wanted))
