"""Messages for tests of bags, and the writers that put them there."""

from pathlib import Path

from hda_msgs_json.bag import BagWriter, Recording
from hda_msgs_json.cdr import encode_joint_state, encode_string, encode_wrench
from hda_msgs_json.samples import JointSamples, WrenchSamples
from hda_msgs_json.schemas import schema_text
from hda_msgs_json.topics import ESTIMATOR_STATE, JOINT_STATES, TIP_WRENCH, Topic
from mcap.writer import Writer
import numpy as np

START = 1_700_000_000_000_000_000
NAMES = ('joint1', 'joint1_motor')
Message = tuple[str, int, bytes]


def joint_samples(count: int, *, step: int = 1_000_000) -> JointSamples:
    """Return samples with distinct numbers and some NaN."""
    rng = np.random.default_rng(count)
    position, velocity, effort = rng.normal(size=(3, count, len(NAMES)))
    velocity[:, 1] = np.nan
    stamps = START + step * np.arange(count)
    return JointSamples(stamps, NAMES, position, velocity, effort, 'base')


def wrench_samples(count: int, *, offset: int = 0, step: int = 1_000_000) -> WrenchSamples:
    """Return samples with distinct numbers."""
    force, torque = np.random.default_rng(count).normal(size=(2, count, 3))
    return WrenchSamples(START + offset + step * np.arange(count), 'base', force, torque)


def assert_same(found: JointSamples | WrenchSamples, expected: object) -> None:
    """Compare all fields of samples, NaN equal to NaN."""
    for name, value in vars(expected).items():
        np.testing.assert_array_equal(getattr(found, name), value)


def some_messages(count: int) -> list[Message]:
    """Return messages of three topics in log time order, the last one of varying size."""
    messages: list[Message] = []
    for n in range(count):
        time = START + 1000 * n
        messages.append(('/joint_states', time, encode_joint_state(
            time, 'base', NAMES, (n, -n), (np.nan, 0.5), (1.0, 2.0))))
        messages.append(('/tip/wrench', time + 1, encode_wrench(
            time, 'base', (n, 0, 1), (0, 0, n))))
        if n % 3 == 0:
            messages.append(('/estimator_state', time + 2, encode_string('x' * (n % 7))))
    return messages


TYPES = {'/joint_states': JOINT_STATES.message_type, '/tip/wrench': TIP_WRENCH.message_type,
         '/estimator_state': ESTIMATOR_STATE.message_type}


def write_mcap(path: Path, messages: list[Message], **options: object) -> None:
    """Write a loose file with the writer of the mcap project."""
    with path.open('wb') as stream:
        writer = Writer(stream, **options)
        writer.start('ros2', 'test')
        channels = {}
        for topic, message_type in TYPES.items():
            number = writer.register_schema(
                message_type, 'ros2msg', schema_text(message_type).encode())
            channels[topic] = writer.register_channel(topic, 'cdr', number)
        for topic, time, message in messages:
            writer.add_message(channels[topic], time, message, time)
        writer.finish()


def write_ours(path: Path, messages: list[Message], **options: object) -> Path:
    """Write a bag message by message, and return its file."""
    with BagWriter(path, {'seed': '7'}, **options) as bag:
        for topic, time, message in messages:
            bag.write(Topic(topic, TYPES[topic], 10), time, message)
    return path / f'{path.name}_0.mcap'


def contents(recording: Recording) -> list[Message]:
    """Return all messages by log time, as they went in."""
    found = [(name, int(time), message) for name in recording.topics
             for time, message in zip(*recording.raw(name))]
    return sorted(found, key=lambda message: message[1])
