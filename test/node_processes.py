"""Start the nodes as processes of their own, watch them, and leave none behind."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
import signal
import subprocess
import sys
import time

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.ros.topics import publisher, subscribe
from hda_msgs_json.bag import open_recording
from hda_msgs_json.cdr_arrays import encode_joint_rows, encode_wrench_rows
from hda_msgs_json.samples import JointSamples
from hda_msgs_json.topics import Topic
from hda_torque_estimator.estimating.estimate_messages import estimate_samples
from hda_torque_estimator.estimating.estimator import Estimator
from hda_torque_estimator.estimating.state_messages import state_samples
from hda_torque_estimator.samples.readings import motor_commands, readings
import rclpy
from rclpy.node import Node
from rclpy.serialization import deserialize_message

MODULES = {
    'arm_sim': 'hda_arm_sim.main',
    'torque_estimator': 'hda_torque_estimator.estimating.estimator_node',
    'jtf_controller': 'hda_torque_estimator.controlling.controller_node',
    'bag_recorder': 'hda_torque_estimator.recording.recorder_node',
    'bag_player': 'hda_torque_estimator.playing.player_node',
}
PATIENCE = 120.0        # until something must have happened: nothing is measured by it [s]
SETTLE = 1.0            # a reader learns of a writer later than the writer of it [s]


class Process:
    """A node that runs as a process."""

    def __init__(self, name: str, folder: Path, *parameters: str) -> None:
        """Start it with parameters like `rate:=200`, and names changed like `/from:=/to`."""
        words = [word for each in parameters
                 for word in ('-r' if each.startswith(('/', '__')) else '-p', each)]
        self.name, self._log = name, folder / f'{name}.log'
        with self._log.open('wb') as log:
            self._process = subprocess.Popen(
                [sys.executable, '-m', MODULES[name], '--ros-args', *words],
                stdout=log, stderr=subprocess.STDOUT)

    @property
    def said(self) -> str:
        """Return everything that it has said."""
        return self._log.read_text(errors='replace')

    @property
    def pid(self) -> int:
        """Return its number."""
        return self._process.pid

    def send(self, *numbers: int) -> None:
        """Send signals, one right after the other."""
        for number in numbers:
            self._process.send_signal(number)

    def wait(self) -> int:
        """Wait for its end and return its exit code."""
        return self._process.wait(PATIENCE)

    def running(self) -> bool:
        """Return whether it runs."""
        return self._process.poll() is None

    def interrupt(self) -> None:
        """Ask it to end."""
        if self.running():
            self.send(signal.SIGCONT, signal.SIGINT)

    def end(self) -> None:
        """End it, however it takes it."""
        if self.running():
            self.interrupt()
            try:
                self._process.wait(10.0)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()


class Watcher:
    """A node of the test: it hears topics, sends bytes, calls services."""

    def __init__(self) -> None:
        """Join the ROS domain of this run."""
        rclpy.init(args=['watcher'])
        self.node = Node('watcher')

    def hear(self, topic: Topic) -> list[bytes]:
        """Return a list to which the bytes of every message of a topic come."""
        heard: list[bytes] = []
        subscribe(self.node, topic, heard.append, depth=5000)
        return heard

    def send(self, topic: Topic, readers: int) -> Callable[[bytes], None]:
        """Return what publishes bytes on a topic, when so many readers are connected."""
        made = publisher(self.node, topic)
        self.until(lambda: made.get_subscription_count() >= readers, f'readers of {topic.name}')
        self.spin(SETTLE)
        return made.publish

    def until_read(self, readers: Mapping[Topic, int]) -> None:
        """Wait until topics have so many readers each, and until their writers know of them."""
        self.until(lambda: all(self.node.count_subscribers(topic.name) >= count
                               for topic, count in readers.items()), 'readers')
        self.spin(SETTLE)

    def call(self, kind: type, name: str, **request: object) -> object:
        """Call a service and return its response."""
        client = self.node.create_client(kind, name)
        self.until(client.service_is_ready, f'the service {name}')
        future = client.call_async(kind.Request(**request))
        self.until(future.done, f'an answer of {name}')
        return future.result()

    def spin(self, seconds: float) -> None:
        """Let time go by."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            rclpy.spin_once(self.node, timeout_sec=0.05)

    def until(self, done: Callable[[], bool], what: str) -> None:
        """Spin until something has happened, and fail if it never does."""
        end = time.monotonic() + PATIENCE
        while not done():
            assert time.monotonic() < end, f'waited in vain for {what}'
            rclpy.spin_once(self.node, timeout_sec=0.05)

    def close(self) -> None:
        """Leave the domain."""
        self.node.destroy_node()
        rclpy.try_shutdown()


@contextmanager
def watching() -> Iterator[Watcher]:
    """Have a watcher for a while."""
    watcher = Watcher()
    try:
        yield watcher
    finally:
        watcher.close()


@contextmanager
def running(folder: Path, **nodes: tuple[str, ...]) -> Iterator[dict[str, Process]]:
    """Have nodes run for a while, each with its parameters."""
    started: dict[str, Process] = {}
    try:
        for name, parameters in nodes.items():
            started[name] = Process(name, folder, *parameters)
        yield started
    finally:
        for process in started.values():        # all are asked first: each may take a second
            process.interrupt()
        for process in started.values():
            process.end()


def diagnostics(heard: list[bytes], kind: type) -> dict[str, object]:
    """Return the last status of every node that was heard on /diagnostics."""
    return {status.name: status for message in heard
            for status in deserialize_message(message, kind).status}


def holds_the_live_run(bag: Path, arm: Arm, sent: list[bytes]) -> None:
    """Check that a bag has all that was sent, and that estimates of it are those it recorded."""
    recording = open_recording(bag)
    assert recording.raw('/joint_states')[1] == sent
    samples = recording.joint_states()
    estimates = Estimator(arm).run(samples.stamps, readings(arm.labels, samples),
                                   motor_commands(arm.labels, samples))
    for topic, part in estimate_samples(arm, estimates).items():
        encode = encode_joint_rows if isinstance(part, JointSamples) else encode_wrench_rows
        assert recording.raw(topic.name)[1] == [row.tobytes() for row in encode(part)]
    assert recording.texts('/estimator_state').texts == state_samples(arm, estimates).texts
