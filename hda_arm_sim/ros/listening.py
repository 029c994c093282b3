"""Subscriptions that suit the publishers: to topics known before, and to those that come late."""

from collections.abc import Callable, Sequence
from functools import partial

from hda_msgs_json.schemas import schema, SchemaError
from hda_msgs_json.topics import SAMPLED_DEPTH, Topic
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.exceptions import InvalidTopicNameException
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, ReliabilityPolicy
from rclpy.subscription import Subscription
from rclpy.topic_endpoint_info import TopicEndpointInfo

from .topics import subscribe

PERIOD = 0.25           # between two looks at which publishers are there [s]


class Listening:
    """Have the bytes of topics handed to `heard`, of late ones too if they are `wanted`."""

    def __init__(self, node: Node, heard: Callable[[Topic, bytes], None], *,
                 wanted: Callable[[str], bool] | None = None, depth: int | None = None) -> None:
        """Look at the publishers now and then; queues have this depth, else the topic's own."""
        self._node, self._heard, self._wanted, self._depth = node, heard, wanted, depth
        self._queues: dict[str, tuple[Topic, Subscription]] = {}
        self._names: dict[Topic, str] = {}
        self._refused: set[str] = set()
        self._timer = node.create_timer(
            PERIOD, self.look, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def add(self, topic: Topic) -> None:
        """Listen to a topic, whether somebody publishes it yet or not."""
        self._add(topic, adaptable=True)

    def _add(self, topic: Topic, *, adaptable: bool) -> None:
        queue = subscribe(self._node, topic, partial(self._take, topic), depth=self._depth,
                          adaptable=adaptable)
        self._names[topic] = queue.topic_name
        self._queues[queue.topic_name] = topic, queue

    def look(self) -> None:
        """Find publishers of new topics, and of known ones that offer less than is asked for."""
        for name in self._present():
            known = self._queues.get(name)
            infos = self._node.get_publishers_info_by_topic(name)
            if infos and known is None:
                self._add_late(offered(name, infos))
            elif infos and known is not None:
                self._suit(known[0], offered(known[0].name, infos))

    def _present(self) -> list[str]:
        """Return the names of topics that are listened to, or shall be."""
        names = list(self._queues)
        if self._wanted is None:
            return names
        return names + [name for name, _ in self._node.get_topic_names_and_types()
                        if name not in self._queues and name not in self._refused
                        and self._wanted(name)]

    def drain(self) -> None:
        """Hand over what waits in the queues."""
        for topic, queue in self._queues.values():
            for _ in range(self._depth or topic.depth):
                with queue.handle:
                    taken = queue.handle.take_message(queue.msg_type, True)
                if taken is None:
                    break
                self._heard(topic, taken[0])

    def _add_late(self, topic: Topic) -> None:
        try:
            schema(topic.message_type)
            self._add(topic, adaptable=False)
            self._node.get_logger().info(f'{topic.name} has come')
        except (SchemaError, ImportError, AttributeError, ValueError,
                InvalidTopicNameException) as error:
            self._refused.add(topic.name)
            self._node.get_logger().warning(f'{topic.name} cannot be heard: {error}')

    def _suit(self, topic: Topic, found: Topic) -> None:
        """
        Ask for less where a publisher offers less.

        The first subscription is left alone: executors stumble over one that is destroyed while
        something of it waits for them.
        """
        if ((topic.reliability == 'reliable' and found.reliability == 'best_effort')
                or (topic.durability == 'transient_local' and found.durability == 'volatile')):
            self._add(found, adaptable=False)

    def _take(self, topic: Topic, message: bytes) -> None:
        """Hand over what comes, unless another subscription gets it too."""
        if self._queues[self._names[topic]][0] is topic:
            self._heard(topic, message)


def offered(name: str, infos: Sequence[TopicEndpointInfo]) -> Topic:
    """Return a topic with the quality that suits all of its publishers."""
    profiles = [info.qos_profile for info in infos]
    hurried = any(each.reliability == ReliabilityPolicy.BEST_EFFORT for each in profiles)
    kept = all(each.durability == DurabilityPolicy.TRANSIENT_LOCAL for each in profiles)
    return Topic(name, infos[0].topic_type, SAMPLED_DEPTH,
                 'best_effort' if hurried else 'reliable',
                 'transient_local' if kept else 'volatile')
