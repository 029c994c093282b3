"""Bags: rosbag2 directories that appear whole or not at all, or grow safely while one records."""

from collections.abc import Mapping, Sequence
from functools import partial
import os
from pathlib import Path
import shutil
from types import TracebackType

from hda_msgs_json.ahead import ahead
from hda_msgs_json.bag_merge import Chunk, Column, joint_column, merged, text_column, wrench_column
from hda_msgs_json.bag_metadata import channel_metadata, METADATA_FILE, rosbag2_metadata, to_yaml
from hda_msgs_json.mcap_chunk import COMPRESSIONS
from hda_msgs_json.mcap_file import METADATA_NAME
from hda_msgs_json.mcap_records import BagError
from hda_msgs_json.mcap_writer import McapWriter, pack, Packed
from hda_msgs_json.samples import JointSamples, TextSamples, WrenchSamples
from hda_msgs_json.schemas import Schema, schema
from hda_msgs_json.topics import Topic

SCHEMA_ENCODING = 'ros2msg'
ENCODING = 'cdr'


class BagWriter:
    """
    Write a bag; use it in a `with` statement.

    With `whole`, the directory appears when the statement ends, and nothing is left if it fails.
    Without, directory and metadata are there from the start, and `flush` makes safe what came.
    Messages that are written as samples go to the bag in the order of their log times, whatever
    their topics, when the bag is flushed or closed.
    """

    def __init__(
            self, path: Path | str, metadata: Mapping[str, str], *, compression: str = 'zstd',
            whole: bool = True, share_directories: Sequence[Path] | None = None) -> None:
        """
        Open the bag.

        The metadata is kept in the bag as it is. The share directories are searched for types
        that are not of this system; those of the ROS installation unless given. Raise BagError if
        the path is taken or cannot be written.
        """
        if compression not in COMPRESSIONS:
            raise BagError(
                f'the compression must be one of {", ".join(COMPRESSIONS)}, got {compression!r}')
        self.path = Path(os.path.abspath(path))
        self._share_directories = share_directories
        self._topics: dict[Topic, int] = {}
        self._schemas: dict[str, Schema] = {}
        self._columns: list[Column] = []
        self._described: list[int] = []
        self._directory = _new_directory(self.path, whole)
        try:
            self._stream = (self._directory / self._file_name).open('xb')
            self._mcap = McapWriter(self._stream, COMPRESSIONS[compression])
            self._mcap.add_metadata(METADATA_NAME, metadata)
            self._mcap.flush()      # a file without its head would be no recording
            self._describe()
        except OSError as error:
            self._remove()
            raise _cannot_write(self.path, error) from None

    def __enter__(self) -> 'BagWriter':
        """Return the writer."""
        return self

    def __exit__(
            self, kind: type[BaseException] | None, error: BaseException | None,
            trace: TracebackType | None) -> None:
        """Close the bag; after an error remove one that should be whole, or keep what it has."""
        if error is None or self._directory == self.path:
            self.close()
        else:
            self._abort()

    def write(self, topic: Topic, log_time_ns: int, message: bytes) -> None:
        """Write one message; raise SchemaError if its type is not known."""
        try:
            self._mcap.write(self._channel(topic), log_time_ns, message)
        except OSError as error:
            raise _cannot_write(self.path, error) from None
        except OverflowError:
            raise BagError(
                f'a log time must lie in 0 to 2^64 - 1 ns, got {log_time_ns}') from None

    def define(self, topic: Topic, definition: Schema) -> None:
        """Add a topic with the definition of its type, unless that is known."""
        self._schemas.setdefault(topic.message_type, definition)
        try:
            self._channel(topic)
        except OSError as error:
            raise _cannot_write(self.path, error) from None

    def add_metadata(self, metadata: Mapping[str, str]) -> None:
        """Add to the metadata, or replace what has the same name."""
        try:
            self._mcap.add_metadata(METADATA_NAME, metadata)
        except OSError as error:
            raise _cannot_write(self.path, error) from None

    def write_joint_states(self, topic: Topic, samples: JointSamples) -> None:
        """Write JointStates, their stamps as log times."""
        self._columns.append(joint_column(self._channel(topic), samples))

    def write_wrenches(self, topic: Topic, samples: WrenchSamples) -> None:
        """Write WrenchStampeds, their stamps as log times."""
        self._columns.append(wrench_column(self._channel(topic), samples))

    def write_texts(self, topic: Topic, samples: TextSamples) -> None:
        """Write Strings at their log times."""
        self._columns.append(text_column(self._channel(topic), samples))

    def flush(self) -> None:
        """Write all messages so far, and wait until the disk has them."""
        try:
            self._merge()
            self._mcap.flush()
            if self._described != (counts := self._counts()):
                self._describe()
                self._described = counts
        except OSError as error:
            raise _cannot_write(self.path, error) from None

    def close(self) -> None:
        """Write what is left, index and summary; a whole bag appears now."""
        try:
            self._merge()
            self._mcap.close_chunk()
            self._mcap.add_metadata('rosbag2', {'serialized_metadata': to_yaml(self._about())})
            self._mcap.finish()
            self._stream.close()
            self._describe()
            if self._directory != self.path:
                self._directory.rename(self.path)
        except OSError as error:
            self._abort()
            raise _cannot_write(self.path, error) from None

    @property
    def _file_name(self) -> str:
        return f'{self.path.name}_0.mcap'

    def _channel(self, topic: Topic) -> int:
        return self._topics.get(topic) or self._add(topic)

    def _add(self, topic: Topic) -> int:
        """Add a topic to the file, and return the number of its channel."""
        found = self._schemas.get(topic.message_type) or schema(
            topic.message_type, self._share_directories)
        self._schemas[topic.message_type] = found
        definition = topic.message_type, SCHEMA_ENCODING, found.text.encode()
        self._topics[topic] = self._mcap.add_channel(
            f'/{topic.name.lstrip("/")}', definition, ENCODING, channel_metadata(topic, found))
        return self._topics[topic]

    def _merge(self) -> None:
        columns, self._columns = self._columns, []
        chunks = merged(columns, self._mcap.counts)
        for chunk in ahead(partial(_packed, compression=self._mcap.compression), chunks):
            self._mcap.write_packed(chunk)

    def _about(self) -> dict[str, object]:
        return rosbag2_metadata(
            self._file_name,
            [(topic, self._schemas[topic.message_type], self._mcap.counts[channel])
             for topic, channel in self._topics.items()])

    def _counts(self) -> list[int]:
        return [counted.count for counted in self._mcap.counts.values()]

    def _describe(self) -> None:
        """Write metadata.yaml in one step."""
        text = to_yaml({'rosbag2_bagfile_information': self._about()})
        temporary = self._directory / f'.{METADATA_FILE}'
        temporary.write_text(text)
        temporary.replace(self._directory / METADATA_FILE)

    def _abort(self) -> None:
        self._stream.close()
        self._remove()

    def _remove(self) -> None:
        if self._directory != self.path:
            shutil.rmtree(self._directory, ignore_errors=True)


def _packed(chunk: Chunk, compression: str) -> Packed:
    return pack(chunk.content.data, chunk.indexes, compression)


def _new_directory(path: Path, whole: bool) -> Path:
    """Make the directory to write to: the path itself, or a sibling that will take its place."""
    try:
        if path.is_dir() and any(path.iterdir()):
            raise BagError(f'{path} exists and is not empty; name another place for the bag')
        if path.exists() and not path.is_dir():
            raise BagError(f'{path} is a file; a bag is a directory')
        directory = path.with_name(f'.{path.name}.{os.getpid()}') if whole else path
        directory.mkdir(parents=True, exist_ok=not whole)
        return directory
    except OSError as error:
        raise _cannot_write(path, error) from None


def _cannot_write(path: Path, error: OSError) -> BagError:
    return BagError(f'{path} cannot be written: {error.strerror or error}')
