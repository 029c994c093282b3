"""What rosbag2 says about a bag beside the messages: metadata.yaml and quality of service."""

from collections.abc import Iterable, Sequence

from hda_msgs_json.mcap_pack import ChannelCount
from hda_msgs_json.schemas import Schema
from hda_msgs_json.topics import Topic
import yaml

METADATA_FILE = 'metadata.yaml'
VERSION = 9
ROS_DISTRO = 'jazzy'
MADE_BY = 'hda_torque_estimator'
DUMPER = yaml.CSafeDumper if yaml.__with_libyaml__ else yaml.SafeDumper
"""A live bag describes itself many times a second: in C that takes a seventh of the time."""
FOREVER = {'sec': 9223372036, 'nsec': 854775807}


def to_yaml(content: object) -> str:
    """Return YAML text in the order of the content."""
    return str(yaml.dump(content, Dumper=DUMPER, sort_keys=False, allow_unicode=True))


def channel_metadata(topic: Topic, schema: Schema) -> dict[str, str]:
    """Return what rosbag2 keeps with a channel."""
    return {'offered_qos_profiles': to_yaml([quality_of_service(topic)]),
            'topic_type_hash': schema.type_hash}


def quality_of_service(topic: Topic) -> dict[str, object]:
    """Return the quality of service of a topic in the words of rosbag2."""
    return {
        'history': 'keep_last',
        'depth': topic.depth,
        'reliability': topic.reliability,
        'durability': topic.durability,
        'deadline': dict(FOREVER),
        'lifespan': dict(FOREVER),
        'liveliness': 'automatic',
        'liveliness_lease_duration': dict(FOREVER),
        'avoid_ros_namespace_conventions': False,
    }


def rosbag2_metadata(
        files: Sequence[tuple[str, ChannelCount]],
        topics: Sequence[tuple[Topic, Schema, ChannelCount]]) -> dict[str, object]:
    """Return the content of metadata.yaml for the files of a bag, by name, and its topics."""
    whole = total(counted for _, counted in files)
    return {
        'version': VERSION,
        'storage_identifier': 'mcap',
        **_span(whole),
        'message_count': whole.count,
        'topics_with_message_count': [_topic_metadata(*topic) for topic in topics],
        'compression_format': '',
        'compression_mode': '',
        'relative_file_paths': [name for name, _ in files],
        'files': [{'path': name, **_span(counted), 'message_count': counted.count}
                  for name, counted in files],
        'custom_data': {'made_by': MADE_BY},
        'ros_distro': ROS_DISTRO,
    }


def total(counts: Iterable[ChannelCount]) -> ChannelCount:
    """Return the count of all together."""
    found = ChannelCount()
    for counted in counts:
        found.add(counted.count, counted.first, counted.last)
    return found


def _span(counted: ChannelCount) -> dict[str, object]:
    start = counted.first if counted.count else 0
    return {'duration': {'nanoseconds': max(counted.last - start, 0)},
            'starting_time': {'nanoseconds_since_epoch': start}}


def _topic_metadata(topic: Topic, schema: Schema, counted: ChannelCount) -> dict[str, object]:
    return {
        'topic_metadata': {
            'name': f'/{topic.name.lstrip("/")}',
            'type': topic.message_type,
            'serialization_format': 'cdr',
            'offered_qos_profiles': [quality_of_service(topic)],
            'type_description_hash': schema.type_hash,
        },
        'message_count': counted.count,
    }
