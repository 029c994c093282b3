"""The `jtf_controller` executable: PD control with joint torque feedback."""

import sys
import time

from hda_arm_sim.health import Refused, Report, Stopwatch
from hda_arm_sim.ros.arm_node import ArmNode
from hda_arm_sim.ros.listening import Listening
from hda_arm_sim.ros.process import run
from hda_arm_sim.ros.topics import publisher, quality
from hda_msgs_json.topics import (
    JOINT_REFERENCE, JOINT_STATES, JOINT_TORQUES, MOTOR_COMMAND, Topic)
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.serialization import deserialize_message, serialize_message
from std_srvs.srv import SetBool
from trajectory_msgs.msg import JointTrajectory

from .controller import ControllerSettings
from .controller_report import controller_report
from .live_controller import LiveController, Trajectory, WatchSettings
from .pairing import MOST_WAITING

WATCH_PERIOD = 0.004        # with the default timeout the motors are let go within 20 ms [s]


class JtfController(ArmNode):
    """
    Answer every joint state with a motor command, while enabled.

    A target begins with the sample it comes after, whatever the stamp in its header.
    """

    def __init__(self) -> None:
        """Prepare for the arm; raises what a wrong parameter or file raises."""
        super().__init__('jtf_controller')
        enabled = self.parameters.flag('enabled', False, 'take over at the first sample')
        self._live = LiveController(
            self.arm, self.parameters.group(ControllerSettings, self._tune),
            self.parameters.group(WatchSettings, self._watch_for), enabled=enabled)
        self._stopwatch = Stopwatch(time.monotonic())
        self._command = publisher(self, MOTOR_COMMAND)
        self.create_service(SetBool, 'jtf_controller/enable', self._on_enable)
        self.create_subscription(JointTrajectory, JOINT_REFERENCE.name, self._on_target,
                                 quality(JOINT_REFERENCE))
        # Fresh before complete: what has waited longer could not be paired any more.
        self._listening = Listening(self, self._on_heard, depth=MOST_WAITING)
        for topic in (JOINT_STATES, JOINT_TORQUES):
            self._listening.add(topic)
        # The first message of a type loads code for longer than the watchdog waits.
        deserialize_message(serialize_message(JointTrajectory()), JointTrajectory)
        self.begin()
        self._timer = self.create_timer(WATCH_PERIOD, self._watch,
                                        clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _on_heard(self, topic: Topic, message: bytes) -> None:
        now = time.monotonic()
        take = self._live.sample if topic.name == JOINT_STATES.name else self._live.torque
        try:
            self._answer(take(message, now), now)
        except Refused as refused:
            self.refuse(topic, refused)

    def _answer(self, command: bytes | None, began: float) -> None:
        if command is None:
            return
        self._command.publish(command)
        self._stopwatch.add(time.monotonic() - began, time.time() - self._live.stamp * 1e-9)
        if self._live.stopped:
            self._say_stopped()

    def _watch(self) -> None:
        if (command := self._live.watch(time.monotonic())) is not None:
            self._command.publish(command)
            self._say_stopped()

    def _say_stopped(self) -> None:
        self.get_logger().error(f'stopped, zero torque: {self._live.stopped}; '
                                'call jtf_controller/enable to go on')
        self.diagnostics.publish()

    def _on_target(self, message: JointTrajectory) -> None:
        points = message.points
        times = [point.time_from_start.sec + point.time_from_start.nanosec * 1e-9
                 for point in points]
        try:
            self._live.follow(Trajectory(
                message.joint_names, times, [list(point.positions) for point in points],
                [list(point.velocities) for point in points]))
        except Refused as refused:
            self.refuse(JOINT_REFERENCE, refused)

    def _on_enable(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        response.success, response.message = True, 'enabled' if request.data else 'disabled'
        try:
            if request.data:
                self._live.enable(time.monotonic())
            else:
                self._let_go()
        except Refused as refused:
            response.success, response.message = False, str(refused)
        return response

    def _let_go(self) -> None:
        if (command := self._live.disable()) is not None:
            self._command.publish(command)

    def _tune(self, settings: ControllerSettings) -> None:
        self._live.controller.tune(settings)

    def _watch_for(self, settings: WatchSettings) -> None:
        self._live.watch_for(settings)

    def report(self) -> Report:
        """Return whether the controller is enabled, why not, and what it refused."""
        return controller_report(
            self._live, self._stopwatch.take(time.monotonic()), self.refusals)

    def close(self) -> None:
        """Let the motors go."""
        self._let_go()


def main() -> int:
    """Control until told to end, and return the exit code."""
    return run('jtf_controller', lambda: [JtfController()])


if __name__ == '__main__':
    sys.exit(main())
