"""The quality of service that publishers offered, as rosbag2 records it, for publishing again."""

from collections.abc import Mapping, Sequence
from typing import Any

from hda_msgs_json.topics import SAMPLED_DEPTH
from hda_msgs_json.yaml_text import yaml_document, YamlError
from rclpy.duration import Duration
from rclpy.qos import DurabilityPolicy, LivelinessPolicy, QoSProfile, ReliabilityPolicy

# rosbag2 wrote the numbers of rmw before it wrote words.
BEST_EFFORT, TRANSIENT_LOCAL, MANUAL = (2, 'best_effort'), (1, 'transient_local'), (
    3, 'manual_by_topic')
DEEPEST = 1 << 20
FOREVER = 1 << 62       # and beyond: no bound [ns]


def strongest(texts: Sequence[str]) -> QoSProfile:
    """
    Return the strongest of the qualities that texts state: it suits every subscriber of them.

    It is reliable without any. Depth is no part of what ROS matches, so queues are deep, except
    where it says how much a late subscriber gets. Messages do not expire.
    """
    profiles = [profile for text in texts for profile in _profiles(text)]
    kept = _any(profiles, 'durability', TRANSIENT_LOCAL)
    hurried = bool(profiles) and all(
        profile.get('reliability') in BEST_EFFORT for profile in profiles)
    depths = [depth for profile in profiles
              if isinstance(depth := profile.get('depth'), int) and 0 < depth < DEEPEST]
    return QoSProfile(
        depth=max(depths, default=1) if kept else max([SAMPLED_DEPTH, *depths]),
        reliability=ReliabilityPolicy.BEST_EFFORT if hurried else ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if kept else DurabilityPolicy.VOLATILE,
        deadline=_shortest(profiles, 'deadline'),
        liveliness=LivelinessPolicy.MANUAL_BY_TOPIC if _any(profiles, 'liveliness', MANUAL)
        else LivelinessPolicy.AUTOMATIC,
        liveliness_lease_duration=_shortest(profiles, 'liveliness_lease_duration'))


def _any(profiles: Sequence[Mapping[str, Any]], policy: str, values: Sequence[object]) -> bool:
    return any(profile.get(policy) in values for profile in profiles)


def _shortest(profiles: Sequence[Mapping[str, Any]], policy: str) -> Duration:
    """Return the shortest of durations; 0 where there is no bound."""
    found = [profile.get(policy) for profile in profiles]
    bounds = [each.get('sec', 0) * 1_000_000_000 + each.get('nsec', 0) for each in found
              if isinstance(each, dict) and all(isinstance(part, int) for part in each.values())]
    return Duration(nanoseconds=min((each for each in bounds if 0 < each < FOREVER), default=0))


def _profiles(text: str) -> list[Mapping[str, Any]]:
    """Return the profiles of a text, none if it is damaged."""
    try:
        found = yaml_document(text)
    except YamlError:
        return []
    return [each for each in found if isinstance(each, dict)] if isinstance(found, list) else []
