"""The node that simulates the arm in real time, or says how far it is from that."""

from collections.abc import Mapping
import time
from typing import Any, ClassVar

from hda_msgs_json.cdr import encode_string
from hda_msgs_json.cdr_fields import LITTLE_ENDIAN, pack_stamp
from hda_msgs_json.topics import (
    CLOCK, EXTERNAL_WRENCH, JOINT_STATES, MOTOR_COMMAND, motor_name, ROBOT_DESCRIPTION)
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from std_srvs.srv import Trigger

from .health import Refused, Report
from .inputs import EffortReader, tip_force
from .live import FIRST_STAMP, LiveArm, SimulationSettings
from .model.description import urdf
from .model.files import read_effects
from .ros.arm_node import ArmNode
from .ros.topics import publisher, publishers, subscribe
from .sample_messages import SampleEncoder, truth_topics
from .schedule import Patience, Schedule
from .simulation_report import simulation_report


class ArmSim(ArmNode):
    """
    Publish samples of a simulated arm on an absolute schedule.

    A motor command is in force from the next sample on, for 50 ms of the arm's time. A wrench on
    the tip is held until the next one comes. With `patience` a late command stops the arm's time:
    then a machine with too much to do makes the arm slow, and not wild.
    """

    PURPOSE = 'Simulate the arm in real time, and publish joint_states.'
    OPTIONS: ClassVar[Mapping[str, tuple[Any, str]]] = {
        **ArmNode.OPTIONS,
        'effects': ('', 'file of effects that the arm has on top of its model file')}
    GROUPS = (SimulationSettings,)

    def __init__(self) -> None:
        """Start the arm at rest; raises what a wrong parameter or file raises."""
        super().__init__('arm_sim')
        effects = self.parameters.text('effects', *self.OPTIONS['effects'])
        settings = self.parameters.group(SimulationSettings)
        arm = self.arm
        for placed in read_effects(effects, arm) if effects else ():
            arm = arm.with_effect(placed.effect, placed.joint)
        _warm_up(LiveArm(arm, settings, FIRST_STAMP))
        self._encode = SampleEncoder(arm)
        self._until_truth = 0
        self._schedule = Schedule(settings.period, settings.speed)
        self._patience = Patience(settings.patience)
        self._clock_time = None if settings.speed == 1.0 else publisher(self, CLOCK)
        self._ticked = False
        self._live = LiveArm(arm, settings, FIRST_STAMP)
        self._connect()
        self.begin()
        self.say_started(f'{MOTOR_COMMAND.name}; no torque until then, '
                         f'{settings.rate:g} samples per second')
        self._timer = self.create_timer(self._schedule.tick * 1e-9, self._tick,
                                        clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _connect(self) -> None:
        self._joint_states = publisher(self, JOINT_STATES)
        self._truth = publishers(self, truth_topics(self.arm))
        self._description = publisher(self, ROBOT_DESCRIPTION)
        self._description.publish(encode_string(urdf(self.arm)))
        self._read_command = EffortReader([motor_name(label) for label in self.arm.labels])
        subscribe(self, MOTOR_COMMAND, self._on_command)
        subscribe(self, EXTERNAL_WRENCH, self._on_wrench)
        self.serve(Trigger, 'reset', self._on_reset)

    def _tick(self) -> None:
        if not self._ticked and self._clock_time is None:
            self._live.begin(time.time_ns())            # the first of an arm in real time
        self._ticked = True
        now = time.monotonic_ns()
        for left in range(self._schedule.due(now), 0, -1):
            if self._patience.waits(self._live.ahead, now):
                self._schedule.postpone(left)
                break
            self._publish_sample()
        if self._clock_time is not None:
            self._clock_time.publish(LITTLE_ENDIAN + pack_stamp(self._live.stamp))

    def _publish_sample(self) -> None:
        sample = self._live.sample()
        self._joint_states.publish(self._encode.joint_states(sample))
        if self._until_truth == 0:
            for topic, message in zip(self._truth, self._encode.truth(sample)):
                topic.publish(message)
            self._until_truth = self._live.settings.truth_divisor
        self._until_truth -= 1
        self._live.advance()

    def _on_command(self, message: bytes) -> None:
        try:
            self._live.command(*self._read_command(message))
        except Refused as refused:
            self.refuse(MOTOR_COMMAND, refused)

    def _on_wrench(self, message: bytes) -> None:
        try:
            self._live.push(tip_force(message, self._live.axes))
        except Refused as refused:
            self.refuse(EXTERNAL_WRENCH, refused)

    def _on_reset(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._live.reset()
        response.success, response.message = True, 'the arm is at rest where it started'
        return response

    def report(self) -> Report:
        """Return how well the arm keeps real time, and what it refused."""
        return simulation_report(
            self._schedule.take_punctuality(time.monotonic_ns()), self._live, self.refusals)


def _warm_up(arm: LiveArm) -> None:
    """Have every compiled function loaded, which may take longer than a sample."""
    arm.sample()
    arm.advance()
