"""The recorder as its users run it: whatever ends it, the bag holds what came until then."""

import resource
import signal

from hda_msgs_json.bag import open_recording
from hda_msgs_json.bag_repair import repair
from hda_msgs_json.cdr import encode_joint_state, encode_string
from hda_msgs_json.topics import JOINT_STATES, STRING, Topic
from hda_torque_estimator.recording.held_messages import Held, HeldMessages
from node_processes import running, watching
import pytest
from std_srvs.srv import Trigger
import yaml

pytestmark = pytest.mark.xdist_group('nodes')


def counted(bag):
    """Return how many messages metadata.yaml says there are."""
    try:
        about = yaml.safe_load((bag / 'metadata.yaml').read_text())
    except FileNotFoundError:
        return 0
    return about['rosbag2_bagfile_information']['message_count']


@pytest.mark.parametrize('count', [1, 40, 300])
def test_a_killed_recorder_keeps_what_it_has(count, tmp_path):
    """Messages reach the file while it records, and metadata.yaml counts them."""
    bag = tmp_path / 'bag'
    sent = [encode_joint_state(n, '', ('joint1',), (float(n),)) for n in range(count)]
    with watching() as watcher, running(
            tmp_path, bag_recorder=(f'output:={bag}', 'topics:=[joint_states]')) as nodes:
        send = watcher.send(JOINT_STATES, 1)
        for message in sent:
            send(message)
        watcher.until(lambda: counted(bag) == count, 'all messages')
        nodes['bag_recorder'].send(signal.SIGKILL)
        assert nodes['bag_recorder'].wait() == -signal.SIGKILL
    repair(bag, tmp_path / 'whole')
    assert open_recording(tmp_path / 'whole').raw('joint_states')[1] == sent
    assert counted(tmp_path / 'whole') == count


def samples(count):
    """Return so many joint states."""
    return [encode_joint_state(n, '', ('joint1',), (float(n),)) for n in range(count)]


def test_topics_come_late_and_as_their_publishers_offer_them(tmp_path):
    """A driver that does its best only, a text that is kept for who comes late, and a pause."""
    bag, sent = tmp_path / 'bag', samples(10)
    text = encode_string('kept')
    hurried = Topic('joint_states', JOINT_STATES.message_type, 100, 'best_effort')
    kept = Topic('/extra/text', STRING, 5, durability='transient_local')
    with watching() as watcher:
        watcher.send(kept, 0)(text)
        with running(tmp_path, bag_recorder=(
                f'output:={bag}', 'topics:=[joint_states, extra/*]', 'exclude:=[extra/no*]',
                'compression:=none', 'split_time:=1e-9')) as nodes:
            watcher.send(Topic('/extra/not', STRING, 5), 0)(text)
            send = watcher.send(hurried, 1)
            watcher.until(lambda: counted(bag) == 1, 'the text')
            for number, message in enumerate(sent):
                send(message)
                watcher.until(lambda least=number + 2: counted(bag) >= least, 'the message')
                if number == 5:
                    assert watcher.call(Trigger, 'bag_recorder/pause').success
                    send(message)
                    assert not watcher.call(Trigger, 'bag_recorder/snapshot').success
                    assert watcher.call(Trigger, 'bag_recorder/resume').success
            nodes['bag_recorder'].send(signal.SIGINT)
            assert nodes['bag_recorder'].wait() == 0
    recording = open_recording(bag)
    assert recording.warnings == []
    assert set(recording.topics) == {'/joint_states', '/extra/text'}
    assert recording.raw('joint_states')[1] == sent
    assert recording.raw('extra/text')[1] == [text]
    assert 'best_effort' in recording.qualities('/joint_states')[0]
    assert 'transient_local' in recording.qualities('/extra/text')[0]
    assert len(list(bag.glob('*.mcap'))) == 11


def test_a_snapshot_holds_what_came_before_it(tmp_path):
    bag, sent = tmp_path / 'bag', samples(30)
    with watching() as watcher, running(tmp_path, bag_recorder=(
            f'output:={bag}', 'topics:=[joint_states]', 'snapshot_time:=3600')) as nodes:
        send = watcher.send(JOINT_STATES, 1)
        for message in sent:
            send(message)
        written = []
        while len(written) < 30:
            said = watcher.call(Trigger, 'bag_recorder/snapshot')
            assert said.success
            written += range(int(said.message.split()[0]))
            assert counted(bag) == len(written)
        send(sent[0])
        nodes['bag_recorder'].send(signal.SIGTERM)
        assert nodes['bag_recorder'].wait() == 0
    assert open_recording(bag).raw('joint_states')[1] == sent


def test_messages_are_held_for_a_time_and_not_too_many():
    held = HeldMessages(10, most_bytes=30)
    for time in range(20):
        held.add(Held('t', time, b'12'))
    assert len(held) == 11
    held.add(Held('t', 20, bytes(15)))
    assert [message.log_time for message in held.take()] == [*range(13, 21)]
    assert len(held) == 0


def test_a_disk_that_takes_no_more_ends_the_recorder_and_keeps_the_bag(tmp_path):
    bag, sent = tmp_path / 'bag', samples(3000)
    with watching() as watcher, running(tmp_path, bag_recorder=(
            f'output:={bag}', 'topics:=[joint_states]', 'compression:=none')) as nodes:
        recorder, send = nodes['bag_recorder'], watcher.send(JOINT_STATES, 1)
        send(sent[0])
        watcher.until(lambda: counted(bag) == 1, 'a message')
        resource.prlimit(recorder.pid, resource.RLIMIT_FSIZE, (50_000, resource.RLIM_INFINITY))
        for message in sent[1:]:
            send(message)
        assert recorder.wait() == 1
        line, = (line for line in recorder.said.splitlines() if 'INFO' not in line)
    assert line == f'bag_recorder: {bag} cannot be written: File too large; the bag keeps what ' \
        'came before'
    recording = open_recording(bag)
    found = recording.raw('joint_states')[1]
    assert found == sent[:len(found)]
    assert 0 < len(found) == counted(bag) < len(sent)


@pytest.mark.parametrize(('parameters', 'said'), [
    (('compression:=gzip',), 'the compression must be one of zstd, lz4, none'),
    (('split_time:=-1.0',), 'bag_recorder.split_time must lie in [0, 1e+09] s')])
def test_wrong_parameters_are_one_line(tmp_path, parameters, said):
    with running(tmp_path, bag_recorder=(f'output:={tmp_path / "bag"}', *parameters)) as nodes:
        assert nodes['bag_recorder'].wait() == 2
        assert len(nodes['bag_recorder'].said.splitlines()) == 1
        assert said in nodes['bag_recorder'].said
