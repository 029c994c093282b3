"""Where security is asked for, nothing runs open; the policy names what the nodes really use."""

from collections.abc import Iterator
import os
from pathlib import Path
import subprocess
import sys
import xml.etree.ElementTree as ElementTree

from hda_arm_sim.model.files import read_arm
from hda_arm_sim.node import ArmSim
from hda_arm_sim.ros import security
from hda_arm_sim.ros.arm_node import ReportingNode
from hda_msgs_json.bag import BagWriter
from hda_msgs_json.topics import Topic
from hda_torque_estimator.controlling.controller_node import JtfController
from hda_torque_estimator.estimating.estimator_node import TorqueEstimator
from hda_torque_estimator.playing.player_node import BagPlayer
from hda_torque_estimator.recording.recorded_topics import system_topics
from hda_torque_estimator.recording.recorder_node import BagRecorder
from node_processes import MODULES
from project_files import ROOT
import pytest
import rclpy
from rclpy.node import Node

KINDS = (ArmSim, TorqueEstimator, JtfController, BagRecorder, BagPlayer)
POLICY = ROOT / 'config' / 'sros2_policy.xml'
Uses = dict[tuple[str, str], set[str]]
pytestmark = pytest.mark.xdist_group('nodes')


def built_without_security() -> bool:
    """Return whether the middleware of this run knows no security."""
    return bool(security.why_insecure({security.ENABLE: 'true'}))


@pytest.mark.parametrize('strategy', ['', 'Permissive', 'Enforce'])
@pytest.mark.parametrize('keystore', [False, True])
def test_nothing_runs_open_where_security_is_asked_for(tmp_path, strategy, keystore):
    """The middleware of the wheels has none: one line and the exit code of wrong use."""
    if not built_without_security():
        pytest.skip('the middleware here has security')
    asked = {security.ENABLE: 'true'}
    if strategy:
        asked['ROS_SECURITY_STRATEGY'] = strategy
    if keystore:
        (tmp_path / 'enclaves').mkdir()
        asked['ROS_SECURITY_KEYSTORE'] = str(tmp_path)
    done = subprocess.run([sys.executable, '-m', MODULES['bag_recorder'], '--ros-args', '-p',
                           f'output:={tmp_path / "bag"}'], env={**os.environ, **asked},
                          capture_output=True, text=True)
    assert done.returncode == 2
    line, = done.stderr.splitlines()
    assert line.startswith('bag_recorder: ')
    assert 'security' in line.lower()
    assert not (tmp_path / 'bag').exists()


@pytest.mark.parametrize(('asked', 'open_'), [('TRUE', True), ('1', True), ('false', False),
                                              ('', False)])
def test_what_ros_does_not_take_for_true_is_reported(asked, open_):
    assert ('must be true' in security.why_insecure({security.ENABLE: asked})) == open_


@pytest.fixture
def nodes(tmp_path) -> Iterator[list[ReportingNode]]:
    """Have one of every node, and a bag of all topics for the player."""
    bag = tmp_path / 'played'
    kinds = {f'/{topic.name.lstrip("/")}': topic.message_type
             for topic in system_topics(read_arm('hda_arm.yaml')) if topic.name != '/clock'}
    write_all(bag, kinds)
    rclpy.init(args=['all', '--ros-args', '-p', f'output:={tmp_path / "bag"}', '-p',
                     f'bag:={bag}', '-p', 'paused:=true', '-p', 'speed:=2.0'])
    made: list[ReportingNode] = [kind() for kind in KINDS]
    yield made
    for node in made:
        node.close()
        node.destroy_node()
    rclpy.try_shutdown()


def write_all(bag: Path, kinds: dict[str, str]) -> None:
    """Write a bag with one message on each of these topics."""
    with BagWriter(bag, {}) as writer:
        for name, kind in kinds.items():
            writer.write(Topic(name, kind, 10), 1, bytes(8))


def used(node: Node, watcher: Node) -> Uses:
    """Return the names that a node uses, as ROS sees it."""
    own = node.get_name(), '/'
    found = {('topics', 'publish'): watcher.get_publisher_names_and_types_by_node(*own),
             ('topics', 'subscribe'): watcher.get_subscriber_names_and_types_by_node(*own),
             ('services', 'reply'): watcher.get_service_names_and_types_by_node(*own),
             ('services', 'request'): watcher.get_client_names_and_types_by_node(*own)}
    return {use: {name for name, _ in names} for use, names in found.items() if names}


def allowed(profile: ElementTree.Element) -> Uses:
    """Return the names that a profile of the policy allows."""
    return {(part.tag, way): {f'/{each.text.lstrip("/")}' for each in part}
            for part in profile for way in part.attrib}


def test_the_policy_names_what_the_nodes_use(nodes):
    profiles = {profile.get('node'): allowed(profile)
                for profile in ElementTree.parse(POLICY).iter('profile')}
    assert profiles == {node.get_name(): used(node, nodes[0]) for node in nodes}
