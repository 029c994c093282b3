"""Bags: rosbag2 directories that appear whole or not at all, or grow safely while one records."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from functools import partial
import os
from pathlib import Path
from types import TracebackType
from typing import NamedTuple

from hda_msgs_json.bag_file import BagFile
from hda_msgs_json.bag_merge import (Chunk, joint_column, merged, number_column, PendingMessages,
                                     text_column, wrench_column)
from hda_msgs_json.bag_metadata import METADATA_FILE, rosbag2_metadata, to_yaml, total
from hda_msgs_json.bag_place import cannot_write, growing_directory, whole_directory
from hda_msgs_json.mcap_chunk import COMPRESSIONS
from hda_msgs_json.mcap_file import METADATA_NAME
from hda_msgs_json.mcap_pack import ChannelCount, pack, Packed
from hda_msgs_json.mcap_records import BagError
from hda_msgs_json.samples import JointSamples, NumberSamples, TextSamples, WrenchSamples
from hda_msgs_json.schemas import Schema, schema
from hda_msgs_json.topics import Topic
from hda_msgs_json.worker_threads import ahead


class Files(NamedTuple):
    """Say how files of a bag are written, and when it goes on in another one, 0 for never."""

    compression: str = 'zstd'
    size: int = 0               # of one [bytes]
    time: int = 0               # of one [ns]


class BagWriter:
    """
    Write a bag; use it in a `with` statement.

    With `whole`, the directory appears when the statement ends, and nothing is left if it fails.
    Without, directory and metadata are there from the start, and `flush` makes safe what came.
    Messages that are written as samples go to the bag when it is flushed or closed. They go
    in the order of their log times, whatever their topics.
    """

    def __init__(
            self, path: Path | str, metadata: Mapping[str, str], *, files: Files = Files(),
            whole: bool = True, force: bool = False,
            share_directories: Sequence[Path] | None = None) -> None:
        """
        Open the bag.

        The metadata is kept in the bag as it is. The share directories are searched for types
        that are not of this system; those of the ROS installation unless given. A whole bag takes
        the place of another one with `force`. Raise BagError if the path is taken or cannot be
        written.
        """
        if files.compression not in COMPRESSIONS:
            raise BagError(f'the compression must be one of {", ".join(COMPRESSIONS)}, '
                           f'got {files.compression!r}')
        self.path = Path(os.path.abspath(path))
        self._compression, self._files = COMPRESSIONS[files.compression], files
        self._share_directories = share_directories
        self._metadata = dict(metadata)
        self._schemas: dict[str, Schema] = {}
        self._columns: list[PendingMessages] = []
        self._written: dict[str, ChannelCount] = {}         # files that are finished
        self._totals: dict[Topic, ChannelCount] = {}        # and what is in them
        self._described: ChannelCount | None = None
        self._failed = False
        self._whole = whole_directory(self.path, force) if whole else None
        self._directory = self._whole.partial if self._whole else growing_directory(self.path)
        try:
            self._file = self._open()
            self._describe()
        except OSError as error:
            self._remove()
            raise cannot_write(self.path, error) from None

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
        with self._writing():
            if self._is_full(log_time_ns):
                self._go_on()
            try:
                self._file.mcap.write(self._channel(topic), log_time_ns, message)
            except OverflowError:
                raise BagError(
                    f'a log time must lie in 0 to 2^64 - 1 ns, got {log_time_ns}') from None

    def define(self, topic: Topic, definition: Schema) -> None:
        """Add a topic with the definition of its type, unless that is known."""
        self._schemas.setdefault(topic.message_type, definition)
        with self._writing():
            self._channel(topic)

    def add_metadata(self, metadata: Mapping[str, str]) -> None:
        """Add to the metadata, or replace what has the same name."""
        self._metadata.update(metadata)
        with self._writing():
            self._file.mcap.add_metadata(METADATA_NAME, metadata)

    def write_joint_states(self, topic: Topic, samples: JointSamples) -> None:
        """Write JointStates, their stamps as log times."""
        with self._writing():
            self._columns.append(joint_column(self._channel(topic), samples))

    def write_wrenches(self, topic: Topic, samples: WrenchSamples) -> None:
        """Write WrenchStampeds, their stamps as log times."""
        with self._writing():
            self._columns.append(wrench_column(self._channel(topic), samples))

    def write_texts(self, topic: Topic, samples: TextSamples) -> None:
        """Write Strings at their log times."""
        with self._writing():
            self._columns.append(text_column(self._channel(topic), samples))

    def write_numbers(self, topic: Topic, samples: NumberSamples) -> None:
        """Write Float64s at their log times."""
        with self._writing():
            self._columns.append(number_column(self._channel(topic), samples))

    def merge(self) -> None:
        """Write all samples so far in the order of their log times; later ones come after them."""
        with self._writing():
            self._merge()

    def flush(self) -> None:
        """Write all messages so far, and have the disk take them in its own time."""
        with self._writing():
            self._merge()
            self._file.mcap.flush()
            if self._described != total([*self._totals.values(), self._file.count()]):
                self._describe()

    def close(self) -> None:
        """
        Write what is left, index and summary; a whole bag appears now.

        A bag that grows ends with what the disk has taken, if that is not all.
        """
        if self._failed:
            self._end_early()
            return
        try:
            self._merge()
            self._file.finish(to_yaml(self._about()))
            self._describe()
            if self._whole:
                self._whole.keep()
        except OSError as error:
            self._abort()
            raise cannot_write(self.path, error) from None

    @property
    def messages(self) -> int:
        """Return how many messages are in the files, without those on their way."""
        return total([*self._totals.values(), self._file.count()]).count

    @contextmanager
    def _writing(self) -> Iterator[None]:
        """Turn what the disk says into BagError, and remember it."""
        try:
            yield
        except OSError as error:
            self._failed = True
            raise cannot_write(self.path, error) from None

    def _open(self, number: int = 0) -> BagFile:
        name = f'{self.path.name}_{number}.mcap'
        return BagFile(self._directory / name, self._metadata, self._compression)

    def _is_full(self, log_time: int) -> bool:
        """Return whether the next message goes to another file."""
        _, size, time = self._files
        if not (size or time) or (first := self._file.mcap.first) is None:
            return False
        return 0 < size <= self._file.mcap.size or 0 < time <= log_time - first

    def _go_on(self) -> None:
        """Finish the file and go on in another one."""
        self._merge()
        following = self._open(len(self._written) + 1)
        try:
            self._file.finish(to_yaml(self._about()))
        except OSError:
            following.remove()
            raise
        for topic, counted in self._file.counts().items():
            self._totals[topic] = total([self._totals.get(topic, ChannelCount()), counted])
        self._written[self._file.name] = self._file.count()
        self._file = following
        self._describe()

    def _channel(self, topic: Topic) -> int:
        """Return the number of the channel of a topic, which is added if it is new."""
        if not self._file.holds(topic):
            found = self._schemas.get(topic.message_type) or schema(
                topic.message_type, self._share_directories)
            self._schemas[topic.message_type] = found
            self._file.add(topic, found)
        return self._file.channel(topic)

    def _merge(self) -> None:
        self._file.mcap.close_chunk()
        columns, self._columns = self._columns, []
        chunks = merged(columns, self._file.mcap.counts)
        for chunk in ahead(partial(_packed, compression=self._compression), chunks):
            self._file.mcap.write_packed(chunk)

    def _about(self) -> dict[str, object]:
        now = self._file.counts()
        topics = dict.fromkeys([*self._totals, *now])
        nothing = ChannelCount()
        return rosbag2_metadata(
            [*self._written.items(), (self._file.name, self._file.count())],
            [(topic, self._schemas[topic.message_type], total(
                [self._totals.get(topic, nothing), now.get(topic, nothing)]))
             for topic in topics])

    def _describe(self) -> None:
        """Write metadata.yaml in one step."""
        text = to_yaml({'rosbag2_bagfile_information': self._about()})
        temporary = self._directory / f'.{METADATA_FILE}'
        try:
            temporary.write_text(text)
            temporary.replace(self._directory / METADATA_FILE)
        except OSError:
            temporary.unlink(missing_ok=True)
            raise
        self._described = total([*self._totals.values(), self._file.count()])

    def _abort(self) -> None:
        """End after an error: leave nothing of a bag that should be whole."""
        if self._directory == self.path:
            self._end_early()
        self._file.close()
        self._remove()

    def _end_early(self) -> None:
        """Finish with what the disk has; what it does not take now is left out."""
        self._columns.clear()
        with suppress(OSError):
            self._file.mcap.close_chunk()
        self._file.mcap.drop_chunk()
        with suppress(OSError):
            self._file.finish(to_yaml(self._about()))
        with suppress(OSError):
            self._describe()
        self._file.close()

    def _remove(self) -> None:
        if self._whole:
            self._whole.drop()


def _packed(chunk: Chunk, compression: str) -> Packed:
    return pack(chunk.content.data, chunk.indexes, compression)
