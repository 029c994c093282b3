"""
Joint states as a robot's driver gives them: its own names, and perhaps a topic for each side.

They become what this package works with, one message of both sides with one stamp. The node and
the command take this way alike, so that both get the same bits.
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.health import Refused
from hda_arm_sim.inputs import refusal, UNREADABLE
from hda_msgs_json.cdr import encode_joint_state, JointState, JointStateDecoder
from hda_msgs_json.columns import ColumnFinder
from hda_msgs_json.errors import HdaError
from hda_msgs_json.topics import JOINT_STATES, motor_name, Topic
import numpy as np
from numpy.typing import NDArray

from .sample_reader import seconds

OPTIONS: Mapping[str, tuple[Any, str]] = {
    'link': ([''], 'names of the link sides in joint_states, in the order of the joints of the '
                   'arm; those of the arm without any'),
    'motor': ([''], 'names of the motor shafts in joint_states, in the order of the joints of the '
                    'arm; those of the arm with _motor without any'),
    'link_topic': ('', 'topic of the link sides alone, instead of joint_states'),
    'motor_topic': ('', 'topic of the motor shafts alone, instead of joint_states')}
MOST_WAITING = 50


class DriverError(HdaError):
    """Names or topics of a driver that do not fit the arm."""


class Driver(NamedTuple):
    """Say how a driver names both sides of all joints, and where each side is published."""

    link: tuple[str, ...] = ()
    motor: tuple[str, ...] = ()
    link_topic: str = ''
    motor_topic: str = ''


class DriverStates:
    """Make joint states of this package of those of a driver; stamps must be equal to pair."""

    def __init__(self, labels: Sequence[str], driver: Driver = Driver()) -> None:
        """Prepare for the joints of an arm with these labels; raises DriverError."""
        motors = tuple(map(motor_name, labels))
        link, motor = driver.link or tuple(labels), driver.motor or motors
        _check(labels, link, motor, driver)
        self._plain = not any(driver)
        self._names, self._motor = (*labels, *motors), motor
        sides = (driver.link_topic, driver.motor_topic) if driver.link_topic else ()
        self.topics = tuple(map(_like, sides)) or (JOINT_STATES,)
        self._finders = {topic.name: ColumnFinder(names) for topic, names in zip(
            self.topics, (link, motor) if sides else ((*link, *motor),))}
        self._decoders = {topic.name: JointStateDecoder() for topic in self.topics}
        self._waiting: dict[str, dict[int, Array]] = {topic.name: {} for topic in self.topics}
        self._decode_command = JointStateDecoder()

    def __call__(self, topic: str, message: bytes) -> bytes | None:
        """Return a message of both sides, None until the other side has come; raises Refused."""
        if self._plain:
            return message
        try:
            state = self._decoders[topic](message)
            rows = _rows(state, self._finders[topic](state))
        except UNREADABLE as error:
            raise refusal(error) from None
        return self._paired(topic, state.stamp_ns, rows)

    def command(self, message: bytes) -> bytes:
        """Return a motor command with the names that the driver has for the motors."""
        if self._plain:
            return message
        state = self._decode_command(message)
        return encode_joint_state(state.stamp_ns, '', self._motor, (), (), state.effort)

    def _paired(self, topic: str, stamp: int, rows: Array) -> bytes | None:
        self._waiting[topic][stamp] = rows
        if not all(stamp in waiting for waiting in self._waiting.values()):
            self._drop(topic)
            return None
        both = np.hstack([waiting[stamp] for waiting in self._waiting.values()])
        for waiting in self._waiting.values():
            for old in [known for known in waiting if known <= stamp]:
                del waiting[old]
        return encode_joint_state(stamp, '', self._names, *both)

    def _drop(self, topic: str) -> None:
        """Refuse the oldest that waits on a topic, if too many do."""
        waiting = self._waiting[topic]
        if len(waiting) > MOST_WAITING:
            stamp = next(iter(waiting))
            del waiting[stamp]
            other, = (name for name in self._waiting if name != topic)
            raise Refused('without its other side', f'the stamps of {topic} and {other} must be '
                          f'equal to pair them, {other} has none at {seconds(stamp)}')


def _like(name: str) -> Topic:
    """Return a topic of joint states with another name."""
    return Topic(name, JOINT_STATES.message_type, JOINT_STATES.depth, reason=JOINT_STATES.reason)


def _rows(state: JointState, columns: NDArray[np.intp]) -> Array:
    """Return position, velocity and effort (3, k), NaN where a message has none."""
    nothing = np.full(len(columns), np.nan)
    return np.array([values[columns] if len(values) else nothing for values in state.numbers])


def _check(labels: Sequence[str], link: Sequence[str], motor: Sequence[str],
           driver: Driver) -> None:
    for side, names in (('link', link), ('motor', motor)):
        if len(names) != len(labels) or len(set(names)) != len(names):
            raise DriverError(f'{side} must name each of {", ".join(labels)} once, in this order, '
                              f'got {", ".join(names)}')
    if bool(driver.link_topic) != bool(driver.motor_topic):
        raise DriverError('link_topic and motor_topic must be given together, got '
                          f'{driver.link_topic!r} and {driver.motor_topic!r}')
    if driver.link_topic and driver.link_topic == driver.motor_topic:
        raise DriverError(f'link_topic and motor_topic must differ, got {driver.link_topic!r} '
                          'twice; without both, one topic has both sides')
    if not driver.link_topic and (both := set(link) & set(motor)):
        raise DriverError(f'the sides of a joint must have different names on one topic, got '
                          f'{", ".join(sorted(both))} for both; or give link_topic and '
                          'motor_topic')
