"""
The readings of a recording: all at once, or as the live estimator reads them, one by one.

Where a message is broken, recordings are refused as a whole by their bulk reader. The estimator of
a live arm refuses that message only, and so does this.
"""

from typing import NamedTuple

from hda_arm_sim.health import Refused
from hda_arm_sim.model.arm import Arm
from hda_msgs_json.bag import BagError, Recording
from hda_msgs_json.columns import NamesError
from hda_msgs_json.topics import JOINT_STATE, JOINT_STATES
import numpy as np
from numpy.typing import NDArray

from .renamed_recording import RenamedRecording
from ..samples.driver_states import Driver, DriverStates
from ..samples.readings import motor_commands, readings, with_links_of
from ..samples.sample_reader import SampleReader


class RecordedReadings(NamedTuple):
    """
    Stamps [ns] (k,), readings (k, n, READINGS), motor torques in force since (k, n) [N*m].

    Beside them how many messages could not be read, and the joints without a link angle. Theirs is
    that of a rigid gear.
    """

    stamps: NDArray[np.int64]
    reading: NDArray[np.float64]
    command: NDArray[np.float64]
    unreadable: int = 0
    by_motor: tuple[str, ...] = ()


def recorded_readings(arm: Arm, recording: Recording,
                      driver: Driver = Driver()) -> RecordedReadings:
    """
    Return what the joint states hold; raise BagError or NamesError if that is nothing.

    Those of a driver with names and topics of its own go the way that they go in a node.
    """
    if any(driver):
        return _of_driver(arm, recording, driver)
    try:
        samples, alone = with_links_of(arm, recording.joint_states())
        return RecordedReadings(samples.stamps, readings(arm.labels, samples),
                                motor_commands(arm.labels, samples), by_motor=alone)
    except (BagError, NamesError):
        if isinstance(recording, RenamedRecording):     # its messages have other names
            raise
        found = _one_by_one(arm, recording.raw(JOINT_STATES.name, JOINT_STATE)[1])
        if not len(found.stamps):
            raise
        return found


def _of_driver(arm: Arm, recording: Recording, driver: Driver) -> RecordedReadings:
    states = DriverStates(arm.labels, driver)
    arrived = [(time, topic.name, message) for topic in states.topics
               for time, message in zip(*recording.raw(topic.name))]
    messages, refused = [], 0
    for _, topic, message in sorted(arrived, key=lambda each: int(each[0])):
        try:
            sample = states(topic, message)
        except Refused:
            refused += 1
        else:
            messages += [sample] if sample is not None else []
    found = _one_by_one(arm, messages)
    if not len(found.stamps):
        topics = ' and '.join(topic.name for topic in states.topics)
        raise BagError(f'{recording.path}: no sample of both sides in {topics} can be read')
    return found._replace(unreadable=found.unreadable + refused)


def _one_by_one(arm: Arm, messages: list[bytes]) -> RecordedReadings:
    read = SampleReader(arm)
    stamps, found, commands = [], [], []
    for message in messages:
        try:
            stamp, reading = read(message)
        except Refused:
            continue
        stamps.append(stamp)
        found.append(reading.copy())
        commands.append(read.command.copy())
    return RecordedReadings(np.array(stamps, np.int64), np.array(found), np.array(commands),
                            len(messages) - len(stamps))
