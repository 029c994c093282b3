"""Publishers and subscriptions as `topics.py` describes them; messages travel as bytes."""

from collections.abc import Callable, Iterable
from importlib import import_module
from typing import Any

from hda_msgs_json.topics import Topic
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription


def message_class(topic: Topic) -> Any:
    """Return the class of a topic's messages."""
    package, _, name = topic.message_type.split('/')
    return getattr(import_module(f'{package}.msg'), name)


def quality(topic: Topic, depth: int | None = None) -> QoSProfile:
    """Return the quality of service of a topic, with another depth if one is given."""
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST, depth=depth or topic.depth,
        reliability=ReliabilityPolicy[topic.reliability.upper()],
        durability=DurabilityPolicy[topic.durability.upper()])


def publisher(node: Node, topic: Topic) -> Publisher:
    """Return a publisher of a topic; it takes messages and their bytes."""
    return node.create_publisher(message_class(topic), topic.name, quality(topic))


def publishers(node: Node, topics: Iterable[Topic]) -> list[Publisher]:
    """Return a publisher for each topic."""
    return [publisher(node, topic) for topic in topics]


def subscribe(node: Node, topic: Topic, heard: Callable[[bytes], None], *,
              depth: int | None = None) -> Subscription:
    """Have the bytes of every message of a topic handed to `heard`."""
    return node.create_subscription(
        message_class(topic), topic.name, heard, quality(topic, depth), raw=True)
