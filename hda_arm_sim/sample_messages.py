"""The messages that describe a sample of the simulated arm."""

from hda_msgs_json.cdr import JointStateEncoder, WrenchEncoder
from hda_msgs_json.topics import (
    BASE_FRAME, link_frame, motor_name, Topic, truth_joint_torque, TRUTH_TIP_WRENCH)
import numpy as np

from .live import DriverSample
from .model.arm import Arm
from .sensors import LINK, MOTOR, SIDES

UNKNOWN = (np.nan, np.nan, np.nan)


def truth_topics(arm: Arm) -> tuple[Topic, ...]:
    """Return the topics of what is true."""
    return (*(truth_joint_torque(label) for label in arm.labels), TRUTH_TIP_WRENCH)


class SampleEncoder:
    """Encode one sample after another; what does not exist in the plane is NaN."""

    def __init__(self, arm: Arm) -> None:
        """Prepare the bytes: links first, then motor shafts."""
        motors = tuple(motor_name(label) for label in arm.labels)
        self._joint_states = JointStateEncoder((*arm.labels, *motors))
        self._no_effort = [np.nan] * len(arm.labels)
        self._torques = [WrenchEncoder(link_frame(label)) for label in arm.labels]
        self._tip = WrenchEncoder(BASE_FRAME)

    def joint_states(self, sample: DriverSample) -> bytes:
        """Return the JointState of both sides of every joint."""
        reading = sample.reading.T.tolist()
        return self._joint_states(
            sample.stamp, reading[LINK] + reading[MOTOR],
            reading[SIDES + LINK] + reading[SIDES + MOTOR],
            self._no_effort + sample.motor_torque.tolist())

    def truth(self, sample: DriverSample) -> list[bytes]:
        """Return the messages of `truth_topics` in their order."""
        messages = [encode(sample.taken, UNKNOWN, (np.nan, np.nan, torque))
                    for encode, torque in zip(self._torques, sample.joint_torque.tolist())]
        on_tip = (sample.tip_force.tolist() + [np.nan] * 4)[:6]     # in a plane there are two
        return [*messages, self._tip(sample.taken, tuple(on_tip[:3]), tuple(on_tip[3:]))]
