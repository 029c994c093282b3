"""The node behind the live page: it hears what the arm and the other nodes say."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
import sys
import time
from typing import Any, ClassVar
import webbrowser

from diagnostic_msgs.msg import DiagnosticArray
from hda_arm_sim.foundation.parameter import Declared, parameter
from hda_arm_sim.health import Level, Report
from hda_arm_sim.ros.arm_node import ArmNode
from hda_arm_sim.ros.listening import Listening
from hda_arm_sim.ros.process import run
from hda_msgs_json.topics import DIAGNOSTICS, ESTIMATOR_STATE, JOINT_STATES, TIP_WRENCH, Topic
from rclpy.client import Client
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.serialization import deserialize_message
from std_srvs.srv import Trigger

from .recorder import Recorder
from .requests import Action, Done, Request, Requests
from .scene import NodeHealth, Scene
from .server import Server

TURN = 0.05             # between two looks at what the page has asked for [s]


@dataclass(frozen=True)
class LiveSettings(Declared):
    """Where the page is served."""

    name: ClassVar[str] = 'live_view'
    port: float = parameter(0.0, '', 0.0, 65535.0, 'port on this machine, 0 for any free one')


class LiveView(ArmNode):
    """Show the arm on a page of this machine, and do what its buttons ask for."""

    PURPOSE = 'Serve a page on this machine that shows the arm, its torques and its health.'
    OPTIONS: ClassVar[Mapping[str, tuple[Any, str]]] = {
        **ArmNode.OPTIONS,
        'folder': ('recordings', 'directory in which the button of the page makes bags'),
        'open': (False, 'open the page in the browser')}
    GROUPS = (LiveSettings,)

    def __init__(self) -> None:
        """Serve the page; raises what a wrong parameter, file or port raises."""
        super().__init__('live_view')
        settings = self.parameters.group(LiveSettings)
        folder = self.parameters.text('folder', *self.OPTIONS['folder'])
        opened = self.parameters.flag('open', *self.OPTIONS['open'])
        self._scene, self._requests = Scene(self.arm), Requests()
        self._recorder = Recorder(Path(folder), self.hardware)
        self._reaching: dict[Action, Client] = {
            action: self.create_client(Trigger, f'torque_estimator/{action.value}')
            for action in (Action.TARE, Action.RESET)}
        self._server = Server(round(settings.port), self._picture, self._requests)
        self.begin()
        self._timer = self.create_timer(
            TURN, self._turn, clock=Clock(clock_type=ClockType.STEADY_TIME))
        self._listening = Listening(self, self._on_message)
        for topic in (JOINT_STATES, ESTIMATOR_STATE, TIP_WRENCH, DIAGNOSTICS):
            self._listening.add(topic)
        self.url = self._server.start()
        sys.stdout.write(f'the arm is shown at {self.url}\n')
        sys.stdout.flush()
        if opened:
            webbrowser.open(self.url)

    def _on_message(self, topic: Topic, message: bytes) -> None:
        now = time.monotonic()
        if topic is not DIAGNOSTICS:
            self._scene.hear(topic, message, now)
            return
        for status in deserialize_message(message, DiagnosticArray).status:
            self._scene.hear_health(
                NodeHealth(status.name, status.level[0], status.message, now))

    def _picture(self) -> dict[str, Any]:
        """Return what is shown now; the thread of the server asks."""
        return {**self._scene.picture(time.monotonic()), 'recording': self._recorder.state()}

    def _turn(self) -> None:
        for request in self._requests.take():
            if request.action is Action.RECORD:
                request.answer.set_result(self._recorder.start())
            elif request.action is Action.STOP:
                request.answer.set_result(self._recorder.stop())
            else:
                self._call(request)

    def _call(self, request: Request) -> None:
        """Call a service of the estimator; its answer becomes that of the request."""
        service = self._reaching[request.action]
        if not service.service_is_ready():
            request.answer.set_result(Done(False, 'no estimator is running'))
            return
        service.call_async(Trigger.Request()).add_done_callback(partial(_answer, request))

    def report(self) -> Report:
        """Return where the page is, without its token."""
        return Report(Level.OK, 'the page is served', {
            'address': self.url.partition('?')[0]})

    def close(self) -> None:
        """End the recording, if one runs, and the page."""
        if self._recorder.state():
            self._recorder.stop()
        self._server.stop()


def _answer(request: Request, future: Any) -> None:
    """Hand over what a service said."""
    response = future.result()
    request.answer.set_result(Done(response.success, response.message))


def main(arguments: list[str] | None = None) -> int:
    """Serve until asked to end, and return the exit code."""
    return run('live_view', lambda: [LiveView()], arguments, kinds=[LiveView])


if __name__ == '__main__':
    sys.exit(main())
