"""The `bag_recorder` executable: every topic of the system to a bag that survives a crash."""

from collections.abc import Callable
from functools import partial
import json
import sys
from typing import Any

from hda_arm_sim.health import Level, Report
from hda_arm_sim.model.files import arm_to_text
from hda_arm_sim.model.parameter import ParameterError
from hda_arm_sim.ros.arm_node import ArmNode
from hda_arm_sim.ros.process import run
from hda_arm_sim.ros.remote_parameters import RemoteParameters
from hda_arm_sim.ros.topics import subscribe
from hda_msgs_json.bag import BagError, BagWriter
from hda_msgs_json.topics import Topic
from rclpy.clock import Clock
from rclpy.clock_type import ClockType

from .recorded_topics import named_topics
from .version import version

DEPTH = 5000            # of every queue: seconds of samples, should the disk take its time
FLUSH_PERIOD = 0.05     # what a crash may cost [s]
NODES = ('arm_sim', 'torque_estimator', 'jtf_controller')


class BagRecorder(ArmNode):
    """Write the bytes of every message to a bag, at the time of their arrival."""

    LINGER = 0.2        # what was sent before the end still comes in [s]

    def __init__(self) -> None:
        """Open the bag; raises what a wrong parameter or file raises."""
        super().__init__('bag_recorder')
        output = self.parameters.text('output', '', 'directory of the bag, which must be new')
        names = self.parameters.texts('topics', [''], 'topics to record, all if there is none')
        if not output:
            raise ParameterError('output must name the directory of the bag, got nothing')
        topics = named_topics(self.arm, [name for name in names if name])
        self._counts = dict.fromkeys((topic.name for topic in topics), 0)
        self._parameters_of: dict[str, Any] = {self.get_name(): self.parameters.values()}
        self._bag = BagWriter(output, self._about(), whole=False)
        self._queues = [(topic, subscribe(self, topic, partial(self._on_message, topic),
                                          depth=DEPTH)) for topic in topics]
        self._remote = RemoteParameters(self, NODES, self._on_parameters)
        self.begin()
        self._timer = self.create_timer(FLUSH_PERIOD, partial(self._try, self._bag.flush),
                                        clock=Clock(clock_type=ClockType.STEADY_TIME))
        self.get_logger().info(f'recording {len(topics)} topics to {self._bag.path}')

    def _about(self) -> dict[str, str]:
        """Return what the bag says of itself."""
        about = {'arm': arm_to_text(self.arm), 'version': version(),
                 'parameters': json.dumps(self._parameters_of)}
        seed = self._parameters_of.get('arm_sim', {}).get('seed')
        return about if seed is None else {**about, 'seed': f'{seed:.0f}'}

    def _on_message(self, topic: Topic, message: bytes) -> None:
        self._counts[topic.name] += 1
        self._try(partial(self._bag.write, topic, self.get_clock().now().nanoseconds, message))

    def _on_parameters(self, name: str, values: dict[str, Any]) -> None:
        self._parameters_of[name] = values
        self._try(partial(self._bag.add_metadata, self._about()))

    def _try(self, write: Callable[[], None]) -> None:
        """Write, or end the process with what the disk says."""
        try:
            write()
        except BagError as error:
            self.failure = str(error)

    def report(self) -> Report:
        """Return how many messages the bag holds."""
        count = sum(self._counts.values())
        level = Level.OK if count else Level.WARN
        return Report(level, f'{count} messages recorded', {
            'bag': self._bag.path, **self._counts})

    def close(self) -> None:
        """Write what still waits in the queues, index and summary."""
        for topic, queue in self._queues:
            for _ in range(DEPTH):
                with queue.handle:
                    taken = queue.handle.take_message(queue.msg_type, True)
                if taken is None:
                    break
                self._on_message(topic, taken[0])
        self._bag.close()


def main() -> int:
    """Record until told to end, and return the exit code."""
    return run('bag_recorder', lambda: [BagRecorder()])


if __name__ == '__main__':
    sys.exit(main())
