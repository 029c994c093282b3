"""Publishers and subscriptions as `topics.py` describes them; messages travel as bytes."""

from collections.abc import Callable, Generator, Iterable
from contextlib import contextmanager
from importlib import import_module
from typing import Any

from hda_msgs_json.errors import HdaError
from hda_msgs_json.schemas import schema, short_name
from hda_msgs_json.topics import Topic
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.qos_overriding_options import InvalidQosOverridesError, QoSOverridingOptions
from rclpy.subscription import Subscription


class QualityError(HdaError):
    """A quality of service that the parameters ask for and ROS does not know."""


def message_class(topic: Topic) -> Any:
    """
    Return the class of a topic's messages.

    Raises SchemaError, before anything is imported, for a type that is not installed: a bag names
    types, and importing a module runs it.
    """
    schema(topic.message_type)
    package, name = short_name(topic.message_type).split('/')
    return getattr(import_module(f'{package}.msg'), name)


def quality(topic: Topic, depth: int | None = None) -> QoSProfile:
    """Return the quality of service of a topic, with another depth if one is given."""
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST, depth=depth or topic.depth,
        reliability=ReliabilityPolicy[topic.reliability.upper()],
        durability=DurabilityPolicy[topic.durability.upper()])


def publisher(node: Node, topic: Topic) -> Publisher:
    """Return a publisher of a topic; it takes messages and their bytes. Raises QualityError."""
    with _overridden(topic):
        return node.create_publisher(
            message_class(topic), topic.name, quality(topic),
            qos_overriding_options=QoSOverridingOptions.with_default_policies())


def publishers(node: Node, topics: Iterable[Topic]) -> list[Publisher]:
    """Return a publisher for each topic."""
    return [publisher(node, topic) for topic in topics]


def subscribe(node: Node, topic: Topic, heard: Callable[[bytes], None], *,
              depth: int | None = None, adaptable: bool = True) -> Subscription:
    """
    Have the bytes of every message of a topic handed to `heard`; raises QualityError.

    Parameters may ask for another quality if it is `adaptable`. Nothing is said of publishers
    that offer less: `Listening` asks for less then, and hears them.
    """
    overriding = QoSOverridingOptions.with_default_policies() if adaptable else None
    with _overridden(topic):
        return node.create_subscription(
            message_class(topic), topic.name, heard, quality(topic, depth), raw=True,
            event_callbacks=SubscriptionEventCallbacks(use_default_callbacks=False),
            qos_overriding_options=overriding)


@contextmanager
def _overridden(topic: Topic) -> Generator[None, None, Any]:
    """Turn what ROS says of overrides that it does not know into QualityError."""
    try:
        yield
    except (InvalidQosOverridesError, RuntimeError) as error:
        if 'QoS override' not in str(error):
            raise
        raise QualityError(
            f'the parameters qos_overrides of {topic.name} cannot be used: {error}') from None
