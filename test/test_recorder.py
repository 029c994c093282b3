"""The recorder as its users run it: whatever ends it, the bag holds what came until then."""

import signal

from hda_msgs_json.bag import open_recording
from hda_msgs_json.bag_repair import repair
from hda_msgs_json.cdr import encode_joint_state
from hda_msgs_json.topics import JOINT_STATES
from node_processes import running, watching
import pytest
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
