"""The `torque_estimator` executable: joint torques and tip force from joint states."""

import sys
import time

from hda_arm_sim.health import Refused, Report, Stopwatch
from hda_arm_sim.ros.arm_node import ArmNode
from hda_arm_sim.ros.listening import Listening
from hda_arm_sim.ros.process import run
from hda_arm_sim.ros.topics import publisher, publishers
from hda_msgs_json.topics import ESTIMATOR_STATE, JOINT_STATES, Topic
from std_srvs.srv import Trigger

from .estimate_messages import estimate_topics
from .estimator import EstimatorSettings
from .estimator_report import estimator_report
from .live_estimator import LiveEstimator, StateSettings


class TorqueEstimator(ArmNode):
    """Answer every joint state with the estimates of its stamp."""

    def __init__(self) -> None:
        """Prepare for the arm; raises what a wrong parameter or file raises."""
        super().__init__('torque_estimator')
        self._stopwatch = Stopwatch(time.monotonic())
        self._answer = LiveEstimator(
            self.arm, self.parameters.group(EstimatorSettings, self._tune),
            self.parameters.group(StateSettings, self._tell_state))
        self._estimates = publishers(self, estimate_topics(self.arm))
        self._state = publisher(self, ESTIMATOR_STATE)
        self.create_service(Trigger, 'torque_estimator/tare', self._on_tare)
        self.create_service(Trigger, 'torque_estimator/reset', self._on_reset)
        if self.arm.links is None:
            self.get_logger().info('the model file says "links: none": joint torques only, no '
                                   'external torques and no tip force')
        self.begin()
        self._listening = Listening(self, self._on_sample)
        self._listening.add(JOINT_STATES)

    def _on_sample(self, topic: Topic, message: bytes) -> None:
        began = time.monotonic()
        try:
            stamp, messages, state = self._answer(message)
        except Refused as refused:
            self.refuse(topic, refused)
            return
        for estimates, estimate in zip(self._estimates, messages):
            estimates.publish(estimate)
        if state is not None:
            self._state.publish(state)
        self._stopwatch.add(time.monotonic() - began, time.time() - stamp * 1e-9)

    def _tune(self, settings: EstimatorSettings) -> None:
        self._answer.estimator.tune(settings)

    def _tell_state(self, settings: StateSettings) -> None:
        self._answer.tell_state(settings)

    def _on_tare(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._answer.estimator.tare()
        seconds = self._answer.estimator.settings.tare_time
        response.success = True
        response.message = f'the mean torsion of the next {seconds:g} s becomes zero'
        return response

    def _on_reset(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._answer.reset()
        response.success, response.message = True, 'samples, filters and tare are forgotten'
        return response

    def report(self) -> Report:
        """Return what was answered, how fast, and what was refused."""
        return estimator_report(
            self._answer, self._stopwatch.take(time.monotonic()), self.refusals)


def main() -> int:
    """Estimate until told to end, and return the exit code."""
    return run('torque_estimator', lambda: [TorqueEstimator()])


if __name__ == '__main__':
    sys.exit(main())
