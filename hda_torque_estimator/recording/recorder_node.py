"""The `bag_recorder` executable: every topic of the system to a bag that survives a crash."""

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
import json
import sys
import time
from typing import Any, ClassVar

from hda_arm_sim.foundation.parameter import ParameterError
from hda_arm_sim.health import Level, Report
from hda_arm_sim.model.writing import arm_to_text
from hda_arm_sim.ros.arm_node import ArmNode
from hda_arm_sim.ros.listening import Listening
from hda_arm_sim.ros.process import run
from hda_arm_sim.ros.remote_parameters import RemoteParameters
from hda_msgs_json.bag import BagError, BagWriter
from hda_msgs_json.bag_writer import Files
from hda_msgs_json.topics import Topic
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.expand_topic_name import expand_topic_name
from std_srvs.srv import Trigger

from .held_messages import Held, HeldMessages
from .log_clock import LogClock
from .recorded_topics import awaited, chosen_topics
from .recorder_settings import RecorderSettings
from .topic_choice import matches
from ..version import version

DEPTH = 5000            # of every queue: seconds of samples, should the disk take its time
FLUSH_PERIOD = 0.05     # what a crash may cost [s]
MEGABYTE = 1_000_000
NODES = ('arm_sim', 'torque_estimator', 'jtf_controller')


class BagRecorder(ArmNode):
    """Write the bytes of every message to a bag, at the time of their arrival."""

    PURPOSE = 'Record topics to a bag that a crash or a kill leaves readable.'
    OPTIONS: ClassVar[Mapping[str, tuple[Any, str]]] = {
        **ArmNode.OPTIONS,
        'output': ('', 'directory of the bag, which must be new'),
        'topics': ([''], 'names or patterns of topics to record, also of late ones; those of the '
                         'system without any'),
        'exclude': ([''], 'names or patterns of topics not to record'),
        'compression': ('zstd', 'zstd, lz4 or none'),
        'paused': (False, 'pause before the first message')}
    GROUPS = (RecorderSettings,)
    LINGER = 0.2        # what was sent before the end still comes in [s]

    def __init__(self) -> None:
        """Open the bag; raises what a wrong parameter or file raises."""
        super().__init__('bag_recorder')
        output = self.parameters.text('output', *self.OPTIONS['output'])
        self._wanted, self._unwanted = self.names('topics'), self.names('exclude')
        compression = self.parameters.text('compression', *self.OPTIONS['compression'])
        self._paused = self.parameters.flag('paused', *self.OPTIONS['paused'])
        settings = self.parameters.group(RecorderSettings)
        if not output:
            raise ParameterError('output must name the directory of the bag, got nothing')
        self._held = HeldMessages[Topic](round(settings.snapshot_time * 1e9)
                                         ) if settings.snapshot_time else None
        self._log_clock = LogClock(simulated=self.get_parameter('use_sim_time').value)
        self._early: list[tuple[Topic, bytes]] = []         # whose time is not known yet
        self._gave_up = False
        self._counts: Counter[str] = Counter()
        self._parameters_of: dict[str, Any] = {self.get_name(): self.parameters.values()}
        files = Files(compression, round(settings.split_size * MEGABYTE),
                      round(settings.split_time * 1e9))
        self._bag = BagWriter(output, self._about(), files=files, whole=False)
        self._serve()
        self._remote = RemoteParameters(self, NODES, self._on_parameters)
        self.begin()
        self._timer = self.create_timer(FLUSH_PERIOD, partial(self._try, self._flush),
                                        clock=Clock(clock_type=ClockType.STEADY_TIME))
        self._listen()              # last: what comes before the node spins, a kill would take

    def _listen(self) -> None:
        topics = chosen_topics(self.arm, self._wanted, self._unwanted)
        if late := awaited(topics, self._wanted):
            self.get_logger().warning(f'no topic of the system is named {", ".join(late)}; '
                                      'what others publish there is recorded')
        self._listening = Listening(self, self._on_message, wanted=self._is_wanted, depth=DEPTH)
        for topic in topics:
            self._listening.add(self._named(topic))
        self.get_logger().info(f'recording {len(topics)} topics to {self._bag.path}')

    def _serve(self) -> None:
        for name, answer in (('pause', self._pause), ('resume', self._resume),
                             ('snapshot', self._snapshot)):
            self.serve(Trigger, name, answer)

    def _is_wanted(self, name: str) -> bool:
        """Return whether a topic that is not of the system shall be recorded."""
        names = {name, name.removeprefix(self.get_namespace())}
        return (any(matches(each, self._wanted) for each in names)
                and not any(matches(each, self._unwanted) for each in names))

    def _named(self, topic: Topic) -> Topic:
        """Return a topic with its name in the namespace of this node, if it is in one."""
        space = self.get_namespace()
        return topic if space == '/' else replace(
            topic, name=expand_topic_name(topic.name, self.get_name(), space))

    def _about(self) -> dict[str, str]:
        """Return what the bag says of itself."""
        about = {'arm': arm_to_text(self.arm), 'version': version(),
                 'parameters': json.dumps(self._parameters_of)}
        seed = self._parameters_of.get('arm_sim', {}).get('seed')
        return about if seed is None else {**about, 'seed': f'{seed:.0f}'}

    def _on_message(self, topic: Topic, message: bytes) -> None:
        if self._paused:
            return
        self._early.append((topic, message))
        self._stamp()

    def _stamp(self) -> None:
        """Give what has come its time, as soon as that is known."""
        if not self._early:
            return
        now = self._log_clock.time(self.get_clock().now().nanoseconds, time.time_ns())
        if now is None:
            return
        if self._log_clock.gave_up and not self._gave_up:
            self._gave_up = True
            self.get_logger().warning('use_sim_time is true, but nobody publishes /clock: '
                                      'messages are recorded at the time of this machine')
        early, self._early = self._early, []
        for topic, message in early:
            held = Held(topic, now, message)
            if self._held is None:
                self._write(held)
            else:
                self._held.add(held)

    def _flush(self) -> None:
        self._stamp()
        self._bag.flush()

    def _write(self, held: Held[Topic]) -> None:
        self._counts[held.topic.name] += 1
        self._try(partial(self._bag.write, *held))

    def _on_parameters(self, name: str, values: dict[str, Any]) -> None:
        self._parameters_of[name] = values
        self._try(partial(self._bag.add_metadata, self._about()))

    def _try(self, write: Callable[[], None]) -> None:
        """Write, or end the process with what the disk says."""
        if self.failure:
            return
        try:
            write()
        except BagError as error:
            self.failure = f'{error}; the bag keeps what came before'

    def _pause(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._paused, response.success, response.message = True, True, 'paused'
        return response

    def _resume(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._paused, response.success, response.message = False, True, 'recording'
        return response

    def _snapshot(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        """Write what is held."""
        if self._held is None:
            response.message = 'every message is written; snapshot_time holds them back'
            return response
        taken = self._held.take()
        for held in taken:
            self._write(held)
        self._try(self._bag.flush)
        response.success = not self.failure
        response.message = self.failure or f'{len(taken)} messages written'
        return response

    def report(self) -> Report:
        """Return how many messages the bag holds."""
        count = self._counts.total()
        level = Level.OK if count else Level.WARN
        held = {} if self._held is None else {'messages held': len(self._held)}
        return Report(level, 'paused' if self._paused else f'{count} messages recorded', {
            'bag': self._bag.path, **held, **self._counts})

    def close(self) -> None:
        """Write what still waits in the queues, index and summary."""
        self._listening.drain()
        self._log_clock.hurry()
        self._stamp()
        self._bag.close()


def main() -> int:
    """Record until asked to end, and return the exit code."""
    return run('bag_recorder', lambda: [BagRecorder()], kinds=[BagRecorder])


if __name__ == '__main__':
    sys.exit(main())
