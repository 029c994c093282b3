"""Run nodes for a benchmark, in a ROS domain of its own, and read what they say of themselves."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager, ExitStack
import os
import signal
import socket
import subprocess
import sys
import tempfile
import time

from diagnostic_msgs.msg import DiagnosticArray
import rclpy
from rclpy.node import Node

PATIENCE = 120.0        # until nodes have started [s]
Values = dict[str, str]


@contextmanager
def own_domain() -> Iterator[None]:
    """Use a ROS domain that no other run on this machine has, and stay on this machine."""
    with socket.socket(socket.AF_UNIX) as claim, tempfile.TemporaryDirectory() as log:
        for domain in range(1, 102):
            try:
                claim.bind(f'\0hda_torque_estimator/ros_domain/{domain}')
                break
            except OSError:
                continue
        os.environ.update(ROS_DOMAIN_ID=str(domain), ROS_AUTOMATIC_DISCOVERY_RANGE='LOCALHOST',
                          ROS_LOG_DIR=log)
        yield


@contextmanager
def process(*words: str) -> Iterator[subprocess.Popen[str]]:
    """Run python with these words, its output to be read, and end it cleanly."""
    started = subprocess.Popen([sys.executable, *words], stdout=subprocess.PIPE, text=True)
    try:
        yield started
    finally:
        started.send_signal(signal.SIGINT)
        started.wait(30.0)


@contextmanager
def nodes(*parts: tuple[str, ...]) -> Iterator[list[subprocess.Popen[str]]]:
    """Run several modules as nodes, each with its parameters like `rate:=200`."""
    with ExitStack() as running:
        started = []
        for module, *parameters in parts:
            words = [word for parameter in parameters for word in ('-p', parameter)]
            started.append(running.enter_context(process('-m', module, '--ros-args', *words)))
        yield started
        for one in started:             # all are asked first: each may take a second
            one.send_signal(signal.SIGINT)


class Listener:
    """Hear the diagnostics of all nodes."""

    def __init__(self) -> None:
        """Join the domain."""
        rclpy.init(args=['listener'])
        self.node = Node('listener')
        self.last: dict[str, Values] = {}
        self.node.create_subscription(DiagnosticArray, '/diagnostics', self._hear, 100)

    def _hear(self, message: DiagnosticArray) -> None:
        for status in message.status:
            self.last[status.name] = {value.key: value.value for value in status.values}

    def spin(self, seconds: float) -> None:
        """Listen for a while."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0.0:
            rclpy.spin_once(self.node, timeout_sec=left)

    def until(self, done: Callable[[], bool], what: str) -> None:
        """Listen until something has happened."""
        end = time.monotonic() + PATIENCE
        while not done():
            if time.monotonic() > end:
                sys.exit(f'waited in vain for {what}')
            self.spin(0.1)

    def close(self) -> None:
        """Leave the domain."""
        self.node.destroy_node()
        rclpy.try_shutdown()
