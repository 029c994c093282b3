"""One MCAP file of a bag that is being written: its channels by topic."""

from collections.abc import Mapping
from pathlib import Path

from hda_msgs_json.bag_metadata import channel_metadata, total
from hda_msgs_json.mcap_file import METADATA_NAME
from hda_msgs_json.mcap_pack import ChannelCount
from hda_msgs_json.mcap_writer import McapWriter
from hda_msgs_json.schemas import Schema
from hda_msgs_json.topics import Topic

SCHEMA_ENCODING = 'ros2msg'
ENCODING = 'cdr'


class BagFile:
    """Write one file; everything raises OSError where the disk does not take it."""

    def __init__(self, path: Path, metadata: Mapping[str, str], compression: str) -> None:
        """Write the head, without which the file would be no recording."""
        self.name, self._path = path.name, path
        self._stream = path.open('xb', buffering=0)
        self._channels: dict[Topic, int] = {}
        try:
            self.mcap = McapWriter(self._stream, compression)
            self.mcap.add_metadata(METADATA_NAME, metadata)
            self.mcap.flush()
        except OSError:
            self._stream.close()
            raise

    def holds(self, topic: Topic) -> bool:
        """Return whether the file has a channel for a topic."""
        return topic in self._channels

    def channel(self, topic: Topic) -> int:
        """Return the number of the channel of a topic that the file holds."""
        return self._channels[topic]

    def add(self, topic: Topic, definition: Schema) -> None:
        """Add a channel for a topic."""
        content = topic.message_type, SCHEMA_ENCODING, definition.text.encode()
        self._channels[topic] = self.mcap.add_channel(
            f'/{topic.name.lstrip("/")}', content, ENCODING, channel_metadata(topic, definition))

    def counts(self) -> dict[Topic, ChannelCount]:
        """Return how many messages of each topic are in the file."""
        return {topic: self.mcap.counts[channel] for topic, channel in self._channels.items()}

    def count(self) -> ChannelCount:
        """Return how many messages are in the file."""
        return total(self.mcap.counts.values())

    def finish(self, about: str) -> None:
        """Write what the bag says of itself as YAML, index and summary, and close; only once."""
        if self._stream.closed:
            return
        self.mcap.close_chunk()
        self.mcap.add_metadata('rosbag2', {'serialized_metadata': about})
        self.mcap.finish()
        self.mcap.close()

    def close(self) -> None:
        """Close the file as it is."""
        self.mcap.close()

    def remove(self) -> None:
        """Close the file and leave nothing of it."""
        self.mcap.close()
        self._path.unlink()
