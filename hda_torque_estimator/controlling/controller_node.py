"""The `jtf_controller` executable: PD control with joint torque feedback."""

from collections.abc import Mapping
from concurrent.futures import Future
import sys
import time
from typing import Any, ClassVar

from hda_arm_sim.health import Refused, Report, Stopwatch
from hda_arm_sim.ros.arm_node import ArmNode
from hda_arm_sim.ros.listening import Listening
from hda_arm_sim.ros.process import run
from hda_arm_sim.ros.topics import publisher, quality
from hda_msgs_json.topics import JOINT_REFERENCE, JOINT_TORQUES, MOTOR_COMMAND, Topic
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from std_srvs.srv import SetBool
from trajectory_msgs.msg import JointTrajectory

from .controller import ControllerSettings
from .controller_report import controller_report
from .live_controller import LiveController, WatchSettings
from .pairing import MOST_WAITING
from .target_check import Checked, TargetCheck
from ..samples.driver_node import driver_states
from ..samples.driver_states import OPTIONS as DRIVER_OPTIONS

WATCH_PERIOD = 0.004        # with the default timeout the motors are let go within 20 ms [s]
LET_LOOP_IN = 5e-4          # how long a check of a target keeps the loop waiting [s]


class JtfController(ArmNode):
    """
    Answer every joint state with a motor command, while enabled.

    A target begins with the sample after which it is checked, whatever the stamp in its header.
    What moves or stops the arm comes first, words about it afterwards.
    """

    PURPOSE = 'Answer joint_states with motor_command: PD control with joint torque feedback.'
    OPTIONS: ClassVar[Mapping[str, tuple[Any, str]]] = {
        **ArmNode.OPTIONS, **DRIVER_OPTIONS,
        'enabled': (False, 'take over at the first sample'),
        'allow_unstable_gain': (False, 'take torque_feedback with which this arm may swing')}
    GROUPS = (ControllerSettings, WatchSettings)

    def __init__(self) -> None:
        """Prepare for the arm; raises what a wrong parameter or file raises."""
        super().__init__('jtf_controller')
        enabled = self.parameters.flag('enabled', *self.OPTIONS['enabled'])
        self._live = LiveController(
            self.arm, self.parameters.group(ControllerSettings, self._tune,
                                            allowed=lambda new: self._live.check_gain(new)),
            self.parameters.group(WatchSettings, self._watch_for), enabled=enabled,
            allow_unstable_gain=self.parameters.flag(
                'allow_unstable_gain', *self.OPTIONS['allow_unstable_gain']))
        self._states = driver_states(self)
        self._stopwatch = Stopwatch(time.monotonic())
        self._command = publisher(self, MOTOR_COMMAND)
        self.serve(SetBool, 'enable', self._on_enable)
        self._targets = TargetCheck(self.arm)
        self.create_subscription(JointTrajectory, JOINT_REFERENCE.name, self._on_target,
                                 quality(JOINT_REFERENCE), raw=True)
        # Fresh before complete: what has waited longer could not be paired any more.
        self._listening = Listening(self, self._on_heard, depth=MOST_WAITING)
        for topic in (*self._states.topics, JOINT_TORQUES):
            self._listening.add(topic)
        self._unsaid: list[tuple[Topic, Refused]] = []
        sys.setswitchinterval(LET_LOOP_IN)
        # The first line of a process costs more time than there is for a stop.
        awaited = ', '.join(topic.name for topic in self._states.topics)
        self.say_started(f'{awaited}, and '
                         + ('is enabled then' if enabled else 'a call of jtf_controller/enable'))
        self.begin()
        self._timer = self.create_timer(WATCH_PERIOD, self._watch,
                                        clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _on_heard(self, topic: Topic, message: bytes) -> None:
        now = time.monotonic()
        try:
            if topic.name == JOINT_TORQUES.name:
                self._answer(self._live.torque(message, now), now)
            elif (sample := self._states(topic.name, message)) is not None:
                self._answer(self._live.sample(sample, now), now)
        except Refused as refused:
            if self.refusals.add(refused.reason, now):
                self._unsaid.append((topic, refused))   # a line may cost the time for a stop

    def _answer(self, command: bytes | None, began: float) -> None:
        if command is None:
            return
        self._command.publish(self._states.command(command))
        self._stopwatch.add(time.monotonic() - began, time.time() - self._live.stamp * 1e-9)
        if self._live.stopped:
            self._say_stopped()

    def _watch(self) -> None:
        if (command := self._live.watch(time.monotonic())) is not None:
            self._command.publish(self._states.command(command))
            self._say_stopped()
        for checked in self._targets.done():
            self._follow(checked)
        if self._unsaid and not self._live.unsettled:
            unsaid, self._unsaid = self._unsaid, []
            for topic, refused in unsaid:
                self.say_refused(topic, refused)

    def _say_stopped(self) -> None:
        self.get_logger().error(f'stopped, zero torque: {self._live.stopped}; '
                                'call jtf_controller/enable to go on')
        self.diagnostics.publish()

    def _on_target(self, message: bytes) -> None:
        try:
            self._targets.add(message, self._live.present())
        except Refused as refused:
            self.refuse(JOINT_REFERENCE, refused)

    def _follow(self, checked: Future[Checked]) -> None:
        try:
            self._live.follow_checked(checked.result())
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
            self._command.publish(self._states.command(command))

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
        self._targets.close()


def main() -> int:
    """Control until asked to end, and return the exit code."""
    return run('jtf_controller', lambda: [JtfController()], kinds=[JtfController])


if __name__ == '__main__':
    sys.exit(main())
