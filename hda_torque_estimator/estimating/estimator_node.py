"""The `torque_estimator` executable: joint torques and tip force from joint states."""

from collections.abc import Mapping
import sys
import time
from typing import Any, ClassVar

from hda_arm_sim.health import Refused, Report, Stopwatch
from hda_arm_sim.ros.arm_node import ArmNode
from hda_arm_sim.ros.listening import Listening
from hda_arm_sim.ros.process import run
from hda_arm_sim.ros.topics import publisher, publishers
from hda_msgs_json.topics import ESTIMATOR_STATE, Topic
from std_srvs.srv import Trigger

from .estimate_messages import estimate_topics
from .estimator import EstimatorSettings
from .estimator_report import estimator_report
from .live_estimator import LiveEstimator, StateSettings
from .number_messages import number_topics
from .recorded_settings import checked_unobserved
from ..samples.driver_node import driver_states
from ..samples.driver_states import OPTIONS as DRIVER_OPTIONS


class TorqueEstimator(ArmNode):
    """Answer every joint state with the estimates of its stamp."""

    PURPOSE = 'Publish joint torques and tip force, estimated from joint_states.'
    OPTIONS: ClassVar[Mapping[str, tuple[Any, str]]] = {
        **ArmNode.OPTIONS, **DRIVER_OPTIONS,
        'unobserved': ('nan', 'what stands in a wrench where nothing is known: nan, or zero for '
                              'tools that refuse nan; estimator_state has the covariance')}
    GROUPS = (EstimatorSettings, StateSettings)

    def __init__(self) -> None:
        """Prepare for the arm; raises what a wrong parameter or file raises."""
        super().__init__('torque_estimator')
        self._stopwatch = Stopwatch(time.monotonic())
        self._answer = LiveEstimator(
            self.arm, self.parameters.group(EstimatorSettings, self._tune),
            self.parameters.group(StateSettings, self._set_state),
            checked_unobserved(self.parameters.word('unobserved', *self.OPTIONS['unobserved'])))
        self._states = driver_states(self)
        self._estimates = publishers(self, estimate_topics(self.arm))
        self._state = publisher(self, ESTIMATOR_STATE)
        self._numbers = publishers(self, number_topics(self.arm))
        self.serve(Trigger, 'tare', self._on_tare)
        self.serve(Trigger, 'reset', self._on_reset)
        if self.arm.links is None:
            self.get_logger().info('joint torques only: external torques and the tip force need '
                                   'links in the model file')
        self.begin()
        self._listening = Listening(self, self._on_sample)
        for topic in self._states.topics:
            self._listening.add(topic)
        self.say_started(' and '.join(topic.name for topic in self._states.topics))

    def _on_sample(self, topic: Topic, message: bytes) -> None:
        began = time.monotonic()
        try:
            sample = self._states(topic.name, message)
            if sample is None:
                return
            stamp, messages, state, numbers = self._answer(sample)
        except Refused as refused:
            self.refuse(topic, refused)
            return
        for estimates, estimate in zip(self._estimates, messages):
            estimates.publish(estimate)
        if state is not None:
            self._state.publish(state)
        for plotted, number in zip(self._numbers, numbers):
            if plotted.get_subscription_count():
                plotted.publish(number)
        self._stopwatch.add(time.monotonic() - began, time.time() - stamp * 1e-9)

    def _tune(self, settings: EstimatorSettings) -> None:
        self._answer.estimator.tune(settings)

    def _set_state(self, settings: StateSettings) -> None:
        self._answer.set_state(settings)

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
    """Estimate until asked to end, and return the exit code."""
    return run('torque_estimator', lambda: [TorqueEstimator()], kinds=[TorqueEstimator])


if __name__ == '__main__':
    sys.exit(main())
