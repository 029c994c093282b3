"""A repaired bag holds every complete message, opens everywhere, and leaves the original alone."""

from pathlib import Path
import shutil

from bag_content import contents, some_messages, START, write_mcap, write_ours
from hda_msgs_json.bag import BagError, BagWriter, open_recording
from hda_msgs_json.bag_repair import repair
from hda_msgs_json.bag_writer import Files
from hda_torque_estimator.cli import main
from mcap.writer import CompressionType
import pytest


@pytest.mark.parametrize('compression', ['none', 'zstd', 'lz4'])
@pytest.mark.parametrize('share', [0.3, 0.6, 0.95])
def test_cut_off_bags_become_whole(tmp_path: Path, compression: str, share: float) -> None:
    """What a reader still finds in a cut-off bag is what its repaired copy holds, unwarned."""
    rosbag2 = pytest.importorskip('rosbags.rosbag2')
    file = write_ours(tmp_path / 'bag', some_messages(400), files=Files(compression))
    cut = file.read_bytes()[:int(share * file.stat().st_size)]
    file.write_bytes(cut)
    (tmp_path / 'bag' / 'metadata.yaml').unlink()
    expected = contents(open_recording(tmp_path / 'bag'))
    done = repair(tmp_path / 'bag', tmp_path / 'new')
    recording = open_recording(tmp_path / 'new')
    assert recording.warnings == []
    assert contents(recording) == expected
    assert recording.metadata == {'seed': '7'}
    assert done.messages == len(expected) and 'cut off' in ' '.join(done.warnings)
    assert file.read_bytes() == cut
    with rosbag2.Reader(tmp_path / 'new') as reader:
        assert sorted((connection.topic, time, bytes(message)) for connection, time, message
                      in reader.messages()) == sorted(expected)


def test_splits_are_kept(tmp_path: Path) -> None:
    """All files of a directory go into one bag, the last of them cut off."""
    messages = some_messages(60)
    (tmp_path / 'bag').mkdir()
    for n in range(3):
        write_mcap(tmp_path / 'bag' / f'bag_{n}.mcap', messages[40 * n:40 * (n + 1)],
                   use_chunking=n != 1, compression=CompressionType.NONE)
    last = tmp_path / 'bag' / 'bag_2.mcap'
    last.write_bytes(last.read_bytes()[:2000])
    expected = contents(open_recording(tmp_path / 'bag'))
    assert 80 < len(expected) < 120
    repair(tmp_path / 'bag', tmp_path / 'new')
    assert contents(open_recording(tmp_path / 'new')) == expected


def test_a_wrong_checksum_costs_its_chunk_only(tmp_path: Path) -> None:
    """No number changes: what fails its checksum is left out, with a warning."""
    file = tmp_path / 'a.mcap'
    write_mcap(file, some_messages(90), chunk_size=500, compression=CompressionType.NONE)
    content = bytearray(file.read_bytes())
    content[len(content) // 3] ^= 1
    file.write_bytes(content)
    done = repair(file, tmp_path / 'new')
    assert contents(open_recording(tmp_path / 'new')) == contents(open_recording(file))
    assert 'checksum' in ' '.join(done.warnings)


def test_command_writes_beside_the_original(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    """A loose file becomes a directory NAME_repaired; a second run refuses to overwrite it."""
    file = tmp_path / 'a.mcap'
    write_mcap(file, some_messages(9))
    assert main(['repair', str(file)]) == 0
    assert contents(open_recording(tmp_path / 'a_repaired'))[0][1] == START
    assert main(['repair', str(file)]) == 2
    assert 'is not empty' in capsys.readouterr().err


@pytest.mark.parametrize('content', [b'', b'hello world', b'\x89MCAP'])
def test_bad_input_is_one_line_and_leaves_nothing(tmp_path: Path, content: bytes) -> None:
    """What holds nothing to repair is named, and no bag appears."""
    (tmp_path / 'a.mcap').write_bytes(content)
    with pytest.raises(BagError, match=r'a\.mcap') as caught:
        repair(tmp_path / 'a.mcap', tmp_path / 'new')
    assert '\n' not in str(caught.value)
    assert [path.name for path in tmp_path.iterdir()] == ['a.mcap']


def test_a_bag_killed_at_its_first_moment_becomes_an_empty_one(tmp_path: Path) -> None:
    """The head of the file is on the disk before anything comes."""
    bag = BagWriter(tmp_path / 'bag', {'seed': '7'}, whole=False)
    shutil.copytree(tmp_path / 'bag', tmp_path / 'killed')
    bag.close()
    assert repair(tmp_path / 'killed', tmp_path / 'new').messages == 0
    assert open_recording(tmp_path / 'new').metadata == {'seed': '7'}
