"""SQLite bags are read as MCAP bags are, by every command, whatever a file holds."""

from collections.abc import Callable
from pathlib import Path
import sqlite3

from bag_content import contents, joint_samples, some_messages, TYPES, write_ours
from hda_msgs_json.bag import BagError, BagWriter, open_recording
from hda_msgs_json.topics import JOINT_STATES
from hda_torque_estimator.cli import main
from hda_torque_estimator.commands.fleet_bags import bags_in
import pytest
from rosbags.rosbag2 import CompressionFormat, CompressionMode, Reader, StoragePlugin, Writer
import yaml
import zstandard

TOPICS = ('CREATE TABLE topics(id INTEGER PRIMARY KEY,name TEXT NOT NULL,type TEXT NOT NULL,'
          'serialization_format TEXT NOT NULL,offered_qos_profiles TEXT NOT NULL)')
MESSAGES = ('CREATE TABLE messages(id INTEGER PRIMARY KEY,topic_id INTEGER NOT NULL,'
            'timestamp INTEGER NOT NULL, data BLOB NOT NULL)')


def write_db3(path: Path, messages: list[tuple[str, int, bytes]]) -> sqlite3.Connection:
    """Write a file as rosbag2 does; returns its connection, still open."""
    bag = sqlite3.connect(path)
    bag.execute(TOPICS)
    bag.execute(MESSAGES)
    bag.execute('CREATE INDEX timestamp_idx ON messages (timestamp ASC)')
    numbers = {topic: number for number, topic in enumerate(TYPES, start=1)}
    bag.executemany("INSERT INTO topics VALUES (?, ?, ?, 'cdr', '')",
                    [(number, topic, TYPES[topic]) for topic, number in numbers.items()])
    bag.executemany('INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)',
                    [(numbers[topic], time, message) for topic, time, message in messages])
    bag.commit()
    return bag


def test_a_bag_of_the_rosbags_library_is_read(tmp_path: Path) -> None:
    """Its directory has metadata.yaml of SQLite storage."""
    messages = some_messages(9)
    with Writer(tmp_path / 'bag', version=9, storage_plugin=StoragePlugin.SQLITE3) as bag:
        connections = {topic: bag.add_connection(topic, kind, msgdef='', rihs01='unknown')
                       for topic, kind in TYPES.items()}
        for topic, time, message in messages:
            bag.write(connections[topic], time, message)
    recording = open_recording(tmp_path / 'bag')
    assert contents(recording) == messages and recording.warnings == []


@pytest.mark.parametrize('mode', [CompressionMode.MESSAGE, CompressionMode.FILE])
def test_a_compressed_bag_is_read_and_copied_plain(mode, tmp_path: Path) -> None:
    """rosbag2 compresses each message on its own, or the file as a whole."""
    messages = some_messages(9)
    writer = Writer(tmp_path / 'bag', version=9, storage_plugin=StoragePlugin.SQLITE3)
    writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer as bag:
        connections = {topic: bag.add_connection(topic, kind, msgdef='', rihs01='unknown')
                       for topic, kind in TYPES.items()}
        for topic, time, message in messages:
            bag.write(connections[topic], time, message)
    assert contents(open_recording(tmp_path / 'bag')) == messages
    assert main(['repair', str(tmp_path / 'bag'), '--out', str(tmp_path / 'plain')]) == 0
    with Reader(tmp_path / 'plain') as plain:
        assert [bytes(message) for _, _, message in plain.messages()] == [
            message for _, _, message in messages]


@pytest.mark.parametrize('name', ['bag_0.db3', 'renamed.mcap'])
def test_a_loose_file_is_read_whatever_its_name(tmp_path: Path, name: str) -> None:
    """Messages come in the order of their times."""
    messages = some_messages(9)
    write_db3(tmp_path / name, messages[::-1]).close()
    assert contents(open_recording(tmp_path / name)) == messages


def test_a_directory_without_metadata_and_a_compressed_file(tmp_path: Path) -> None:
    """The first file is as rosbag2 compresses it."""
    messages = some_messages(12)
    write_db3(tmp_path / 'bag_0.db3', messages[:10]).close()
    packed = zstandard.compress((tmp_path / 'bag_0.db3').read_bytes())
    (tmp_path / 'bag_0.db3').unlink()
    (tmp_path / 'bag_0.db3.zstd').write_bytes(packed)
    write_db3(tmp_path / 'bag_1.db3', messages[10:]).close()
    assert contents(open_recording(tmp_path)) == messages
    assert bags_in(tmp_path) == [tmp_path]


def test_what_a_killed_recorder_left_in_a_journal_is_read(tmp_path: Path) -> None:
    """The file of a recorder that still runs, or was killed, changes in nothing."""
    messages = some_messages(9)
    bag = write_db3(tmp_path / 'bag.db3', messages[:-1])
    bag.execute('PRAGMA journal_mode = WAL')
    topic, time, message = messages[-1]
    bag.execute('INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)',
                (list(TYPES).index(topic) + 1, time, message))
    bag.commit()
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    assert len(before) > 1
    assert contents(open_recording(tmp_path / 'bag.db3')) == messages
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before
    bag.close()


def test_a_cut_off_file_gives_its_first_messages_or_one_line(tmp_path: Path) -> None:
    """Every message that is read is one of those that were written."""
    messages = some_messages(600)
    write_db3(tmp_path / 'bag.db3', messages).close()
    whole = (tmp_path / 'bag.db3').read_bytes()
    for length in range(len(whole) - 1, 0, -len(whole) // 12):
        (tmp_path / 'bag.db3').write_bytes(whole[:length])
        try:
            recording = open_recording(tmp_path / 'bag.db3')
        except BagError as refused:
            assert '\n' not in str(refused) and 'bag.db3' in str(refused)
        else:
            found = contents(recording)
            assert set(found) <= set(messages) and (recording.warnings or found == messages)


def test_rows_without_sense_are_left_out(tmp_path: Path) -> None:
    """Unknown topics, texts for bytes and times before 1970 are counted."""
    messages = some_messages(3)
    bag = write_db3(tmp_path / 'bag.db3', messages)
    bag.executemany('INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)', [
        (77, 1, b'x'), (1, -1, b'x'), (1, 'noon', b'x'), (1, 1, 'text')])
    bag.commit()
    bag.close()
    recording = open_recording(tmp_path / 'bag.db3')
    assert contents(recording) == messages
    assert recording.warnings == [
        'bag.db3: 4 messages without topic, time or content are left out']


ENDLESS = 'WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT '
HOSTILE: dict[str, Callable[[sqlite3.Connection], object]] = {
    'no table': lambda bag: None,
    "no table 'messages'": lambda bag: bag.execute(TOPICS),
    "has no table 'messages'": lambda bag: (bag.execute(TOPICS), bag.execute(
        f"CREATE VIEW messages AS {ENDLESS} i AS id, 1 AS topic_id, i AS timestamp, x'00' AS data "
        'FROM n')),
    'is not one of plain columns': lambda bag: (bag.execute(TOPICS), bag.execute(
        'CREATE TABLE messages(id INTEGER, topic_id INTEGER, timestamp INTEGER, '
        'data BLOB GENERATED ALWAYS AS (zeroblob(900000000)))')),
    "has no column 'data'": lambda bag: (bag.execute(TOPICS), bag.execute(
        'CREATE TABLE messages(id INTEGER, topic_id INTEGER, timestamp INTEGER)')),
}


@pytest.mark.parametrize('said', HOSTILE)
def test_other_data_bases_are_one_line(
        tmp_path: Path, said: str, capsys: pytest.CaptureFixture[str]) -> None:
    """No view and no expression of a stranger is evaluated."""
    bag = sqlite3.connect(tmp_path / 'bag.db3')
    bag.execute('PRAGMA user_version = 1')
    HOSTILE[said](bag)
    bag.commit()
    bag.close()
    assert main(['info', str(tmp_path / 'bag.db3')]) == 2
    line = capsys.readouterr().err
    assert said in line and 'is an SQLite bag' in line and len(line.splitlines()) == 1


def test_commands_read_and_repair_writes_mcap(
        tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """`hda repair` makes an MCAP bag of an SQLite one."""
    messages = some_messages(50)
    write_db3(tmp_path / 'bag.db3', messages).close()
    assert main(['info', str(tmp_path / 'bag.db3')]) == 0
    assert 'joint states at' in capsys.readouterr().out
    assert main(['repair', str(tmp_path / 'bag.db3'), '--out', str(tmp_path / 'whole')]) == 0
    assert contents(open_recording(tmp_path / 'whole')) == messages


def test_missing_sqlite_files_are_named(tmp_path: Path) -> None:
    """The metadata may name files that are not there."""
    write_ours(tmp_path / 'bag', [])
    file = tmp_path / 'bag' / 'metadata.yaml'
    about = yaml.safe_load(file.read_text())
    about['rosbag2_bagfile_information'].update(
        storage_identifier='sqlite3', relative_file_paths=['bag_0.db3'])
    file.write_text(yaml.safe_dump(about))
    with pytest.raises(BagError, match='has no .mcap file, and no .db3'):
        open_recording(tmp_path / 'bag')


def test_samples_are_the_same_as_from_mcap(tmp_path: Path) -> None:
    """Arrays of both kinds of storage have the same bits."""
    samples = joint_samples(40)
    with BagWriter(tmp_path / 'bag', {}) as bag:
        bag.write_joint_states(JOINT_STATES, samples)
    mcap = open_recording(tmp_path / 'bag')
    write_db3(tmp_path / 'bag.db3', contents(mcap)).close()
    found = open_recording(tmp_path / 'bag.db3').joint_states()
    assert found.names == samples.names
    assert all(one.tobytes() == other.tobytes()
               for one, other in zip(found.numbers, samples.numbers))
