"""
The operator of the demo: enables the controller, sends a motion, pushes the tip.

It goes by the stamps of the samples: where a busy machine simulates the arm slower than real time,
the pushes wait for it.

Beside simulator, estimator, controller and recorder it runs by itself as well:

    demo_operator.py [--duration SECONDS]
"""

from argparse import ArgumentParser
from collections.abc import Callable
import sys
import time

from builtin_interfaces.msg import Duration
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import WrenchStamped
from hda_arm_sim.motions import Motion, motion
from hda_arm_sim.ros.topics import publisher, subscribe
from hda_msgs_json.cdr import JointStateDecoder
from hda_msgs_json.topics import (
    BASE_FRAME, DIAGNOSTICS, EXTERNAL_WRENCH, JOINT_REFERENCE, JOINT_STATES, JOINT_TORQUES,
    MOTOR_COMMAND)
import rclpy
from rclpy.node import Node
from std_srvs.srv import SetBool
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

LABELS = ('joint1', 'joint2')
POINTS = 5              # one point of the trajectory for so many of the motion
STEP = 0.01             # between points of the motion, and between pushes [s]
REST = 0.5              # before and after the motion [s]
PATIENCE = 90.0         # until all nodes have found each other, or for a sample [s]
GLANCE = 0.003          # between two looks at what came [s]
READERS = {JOINT_STATES: 3, JOINT_TORQUES: 2, MOTOR_COMMAND: 2, EXTERNAL_WRENCH: 2,
           JOINT_REFERENCE: 2}
RECORDED = (JOINT_STATES, JOINT_TORQUES, MOTOR_COMMAND)     # from before the motion on


class OperatorError(RuntimeError):
    """What the operator waited for in vain, or what stopped the motion."""


def operate(duration: float, check: Callable[[], None]) -> None:
    """
    Let the arm make its motion under pushes.

    `check` is called all the time and may raise. Raises OperatorError if something does not come
    or the controller lets the motors go.
    """
    rclpy.init()
    node = Node('operator')
    try:
        operator = _Operator(node, check)
        operator.wait_for_readers()
        operator.take_over()
        operator.spin(REST)
        operator.move(motion('push', len(LABELS), duration, STEP, 0))
        operator.spin(REST)
        operator.disable()
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


class _Operator:

    def __init__(self, node: Node, check: Callable[[], None]) -> None:
        self._node, self._check = node, check
        self._enable = node.create_client(SetBool, 'jtf_controller/enable')
        self._target = publisher(node, JOINT_REFERENCE)
        self._push = publisher(node, EXTERNAL_WRENCH)
        self._decode, self._stamp = JointStateDecoder(), 0
        self._samples = subscribe(node, JOINT_STATES, self._on_sample, depth=1)
        self._in_bag: set[str] = set()
        self._stopped = ''
        self._reports = node.create_subscription(
            DiagnosticArray, DIAGNOSTICS.name, self._on_report, 10)

    def spin(self, seconds: float) -> None:
        """Let time of the arm go by."""
        self.spin_until(self._stamp + round(seconds * 1e9))

    def spin_until(self, stamp: int) -> None:
        """Let the arm's time go by until a sample has this stamp [ns]."""
        self._until(lambda: self._stamp >= stamp, lambda: f'no {JOINT_STATES.name} come')

    def _glance(self) -> None:
        """Take what came; of the samples the last one only, which costs least."""
        self._check()
        time.sleep(GLANCE)
        rclpy.spin_once(self._node, timeout_sec=0.0)

    def _on_sample(self, message: bytes) -> None:
        self._stamp = self._decode(message).stamp_ns

    def wait_for_readers(self) -> None:
        """Wait until every topic has all of its readers."""
        self._until(lambda: not self._missing(),
                    lambda: f'no reader yet for {", ".join(self._missing())}')

    def _missing(self) -> list[str]:
        return [topic.name for topic, count in READERS.items()
                if self._node.count_subscribers(topic.name) < count]

    def take_over(self) -> None:
        """Enable the controller, again if it stops, until the recorder has its commands."""
        self._enable_now()
        wanted = {topic.name for topic in RECORDED}

        def recorded() -> bool:
            if self._stopped:
                self._stopped = ''
                self._enable_now()
            return wanted <= self._in_bag

        self._until(recorded, lambda: 'nothing recorded yet of '
                    f'{", ".join(sorted(wanted - self._in_bag))}')

    def _enable_now(self) -> None:
        """Enable the controller as soon as samples and torques come."""
        self._until(lambda: self._enable.service_is_ready(),
                    lambda: 'the controller offers no service to enable it')
        said = ['']

        def enabled() -> bool:
            response = self._call(True)
            said[0] = response.message
            return response.success

        self._until(enabled, lambda: said[0])

    def _on_report(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name == 'bag_recorder':
                self._in_bag.update(value.key for value in status.values)
            if status.name == 'jtf_controller' and status.level == DiagnosticStatus.ERROR:
                self._stopped = status.message

    def disable(self) -> None:
        """Let the motors go."""
        self._call(False)

    def move(self, made: Motion) -> None:
        """Send the motion at once, and its pushes as time goes by."""
        self._target.publish(_trajectory(made))
        start = self._stamp
        message = WrenchStamped()
        message.header.frame_id = BASE_FRAME
        for moment, (x, y) in zip(made.time, made.force):
            self.spin_until(start + round(moment * 1e9))
            if self._stopped:
                raise OperatorError(f'the controller has {self._stopped}')
            message.wrench.force.x, message.wrench.force.y = float(x), float(y)
            self._push.publish(message)

    def _call(self, enable: bool) -> SetBool.Response:
        future = self._enable.call_async(SetBool.Request(data=enable))
        self._until(future.done, lambda: 'the controller does not answer')
        return future.result()

    def _until(self, done: Callable[[], bool], missing: Callable[[], str]) -> None:
        end = time.monotonic() + PATIENCE
        while not done():
            if time.monotonic() > end:
                raise OperatorError(f'{missing()}, after {PATIENCE:g} s')
            self._glance()


def _trajectory(made: Motion) -> JointTrajectory:
    """Return points of a motion without the first, at which the arm is already."""
    message = JointTrajectory(joint_names=list(LABELS))
    chosen = slice(POINTS, None, POINTS)
    for moment, angle, rate in zip(made.time[chosen], made.angle[chosen], made.rate[chosen]):
        nanoseconds = round(moment * 1e9)
        message.points.append(JointTrajectoryPoint(
            positions=angle.tolist(), velocities=rate.tolist(),
            time_from_start=Duration(sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9)))
    return message


def main() -> int:
    """Operate the nodes that run already, and return the exit code."""
    parser = ArgumentParser(description='Enable the controller, move the arm, push its tip.')
    parser.add_argument('--duration', type=float, default=10.0, help='of the motion [s]')
    try:
        operate(parser.parse_args().duration, lambda: None)
    except OperatorError as error:
        sys.stderr.write(f'demo_operator: {error}\n')
        return 1
    return 0


if __name__ == '__main__':
    sys.exit(main())
