"""The launch file starts executables that exist, with parameters that reach their nodes."""

from collections.abc import Callable
import importlib.util
from pathlib import Path
import re
import runpy
import signal
import subprocess
import sys
from types import SimpleNamespace
from xml.etree import ElementTree

from catkin_pkg.package import parse_package
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.node import ArmSim
from hda_arm_sim.ros.arm_node import ArmNode
from hda_torque_estimator.controlling.controller_node import JtfController
from hda_torque_estimator.estimating.estimator_node import TorqueEstimator
from hda_torque_estimator.recording.recorder_node import BagRecorder
from node_processes import MODULES, PATIENCE, watching
from project_files import ROOT
import pytest
from rcl_interfaces.srv import GetParameters
import rclpy
from rclpy.parameter import parameter_value_to_python
import setuptools

PACKAGE = 'hda_torque_estimator'
FILE = ROOT / 'launch' / 'arm.launch.py'
KINDS = {'arm_sim': ArmSim, 'torque_estimator': TorqueEstimator, 'jtf_controller': JtfController,
         'bag_recorder': BagRecorder}
NODES = tuple(KINDS)[:3]
OTHER_ARM = 'paper_table1.yaml'
TWO_ARMS = """
import sys
from launch import LaunchDescription, LaunchService
from launch.actions import GroupAction, IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch_ros.actions import PushRosNamespace

file, composed, arm = sys.argv[1:]

def included(**arguments):
    return IncludeLaunchDescription(
        PythonLaunchDescriptionSource(file),
        launch_arguments={'composed': composed, **arguments}.items())

service = LaunchService()
service.include_launch_description(LaunchDescription([
    GroupAction([PushRosNamespace('left'), included(arm=arm, record='20261122', rate='100')]),
    GroupAction([included(namespace='right', rate='50')])]))
sys.exit(service.run())
"""
needs_launch = pytest.mark.skipif(importlib.util.find_spec('launch_ros') is None,
                                  reason='ROS 2 comes without its launch system here')


@pytest.fixture
def described() -> SimpleNamespace:
    """Return what the launch file defines."""
    return SimpleNamespace(**runpy.run_path(str(FILE)))


@pytest.fixture
def planned(described) -> Callable[..., list]:
    """Return a function that gives the processes for some arguments."""
    return lambda **given: described.processes({**dict.fromkeys(described.ARGUMENTS, ''), **given})


@pytest.fixture
def alive(tmp_path, monkeypatch) -> Callable[..., dict[str, ArmNode]]:
    """Return a function that makes the nodes of a process, given its parameters by a file."""
    made: list[ArmNode] = []

    def make(process: SimpleNamespace, *files: Path, namespace: str) -> dict[str, ArmNode]:
        own = tmp_path / 'own.yaml'
        own.write_text(process.text())
        words = [word for file in (*files, own) for word in ('--params-file', str(file))]
        monkeypatch.setattr(sys, 'argv', ['process', '--ros-args', '-r', f'__ns:={namespace}',
                                          *words])
        rclpy.init()
        made.extend(KINDS[name]() for name in process.parameters)
        return {node.get_name(): node for node in made}

    yield make
    for node in made:
        node.close()
        node.destroy_node()
    rclpy.try_shutdown()


def executables(monkeypatch) -> list[str]:
    """Return the executables that setup.py declares."""
    reported: dict[str, dict[str, list[str]]] = {}
    monkeypatch.setattr(setuptools, 'setup', reported.update)
    monkeypatch.chdir(ROOT)
    runpy.run_path('setup.py')
    return [word.split(' = ')[0] for word in reported['entry_points']['console_scripts']]


def test_three_executables_of_the_package(planned, monkeypatch):
    started = [process.how['executable'] for process in planned()]
    assert started == ['arm_sim', 'torque_estimator', 'jtf_controller']
    assert {process.how['package'] for process in planned(record='bag')} == {PACKAGE}
    assert {process.how['executable'] for process in planned(record='bag')} <= set(
        executables(monkeypatch))


def test_only_the_simulator_knows_the_effects(planned):
    given = {node: values for process in planned(effects='effects.yaml', record='bag', arm='a')
             for node, values in process.parameters.items()}
    assert [node for node, values in given.items() if 'effects' in values] == ['arm_sim']
    assert {values['arm'] for values in given.values()} == {'a'}
    assert given.keys() == KINDS.keys()


def test_composed_nodes_are_one_process_with_the_same_parameters(planned):
    options = {'effects': 'effects.yaml', 'arm': 'arm.yaml', 'record': 'bag'}
    apart = {node: values for process in planned(**options)
             for node, values in process.parameters.items()}
    together, recorder = planned(**options, composed='true')
    assert together.parameters | recorder.parameters == apart
    assert together.how['executable'] == sys.executable
    assert importlib.util.find_spec(together.how['arguments'][1]) is not None


@pytest.mark.parametrize('composed', ['true', 'false'])
@pytest.mark.parametrize('namespace', ['/', '/left', '/cell/left'])
def test_parameters_reach_the_nodes_in_any_namespace(planned, alive, tmp_path, namespace,
                                                     composed, monkeypatch):
    """The nodes are real, and so is what reads their parameters; all values are no defaults."""
    monkeypatch.chdir(tmp_path)
    effects = tmp_path / 'effects.yaml'
    effects.write_text('[]')
    nodes: dict[str, ArmNode] = {}
    for process in planned(arm=OTHER_ARM, effects=str(effects), record='20261122', rate='200',
                           use_sim_time='true', composed=composed):
        nodes |= alive(process, namespace=namespace)
        rclpy.try_shutdown()
    assert nodes.keys() == KINDS.keys()
    assert {node.get_namespace() for node in nodes.values()} == {namespace}
    assert all(node.parameters.unknown() == [] for node in nodes.values())
    values = {name: node.parameters.values() for name, node in nodes.items()}
    assert {value['arm'] for value in values.values()} == {OTHER_ARM}
    assert values['arm_sim']['effects'] == str(effects)
    assert values['arm_sim']['rate'] == 200.0
    assert values['bag_recorder']['output'] == '20261122'
    assert all(node.get_parameter('use_sim_time').value for node in nodes.values())
    nodes['bag_recorder'].close()
    assert (tmp_path / '20261122' / 'metadata.yaml').is_file()


def test_arguments_go_before_the_file_of_parameters(planned, alive, tmp_path):
    file = tmp_path / 'parameters.yaml'
    file.write_text(f'/**:\n  ros__parameters: {{arm: {OTHER_ARM}}}\n'
                    '/left/arm_sim:\n  ros__parameters: {rate: 300, seed: 5}\n')
    left = planned()[0]
    assert left.parameters == {'arm_sim': {}}
    values = alive(left, file, namespace='/left')['arm_sim'].parameters.values()
    assert (values['arm'], values['rate'], values['seed']) == (OTHER_ARM, 300.0, 5.0)
    rclpy.try_shutdown()
    given = planned(arm='hda_arm.yaml', rate='400')[0]
    values = alive(given, file, namespace='/left')['arm_sim'].parameters.values()
    assert (values['arm'], values['rate'], values['seed']) == ('hda_arm.yaml', 400.0, 5.0)


def test_a_file_of_parameters_that_misses_its_node_is_reported(planned, alive, tmp_path, capfd):
    """The key `arm_sim` means `/arm_sim` only: in a namespace the default arm would run."""
    file = tmp_path / 'parameters.yaml'
    file.write_text(f'arm_sim:\n  ros__parameters: {{arm: {OTHER_ARM}}}\n'
                    '/right/arm_sim:\n  ros__parameters: {rate: 300}\n'
                    '/**/bag_player:\n  ros__parameters: {rate: 3}\n')
    alive(planned()[0], file, namespace='/left')
    said, = (line for line in capfd.readouterr().err.splitlines() if 'WARN' in line)
    assert f'{file} has parameters of arm_sim, /right/arm_sim, not of /left/arm_sim' in said
    assert '/**/arm_sim' in said


def test_nodes_stay_on_this_machine_unless_asked_otherwise(described):
    assert described.environment({'PATH': ''}) == {
        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}
    assert described.environment({'ROS_AUTOMATIC_DISCOVERY_RANGE': 'SUBNET'}) == {}


@pytest.fixture
def installed(tmp_path, monkeypatch) -> None:
    """Have ROS find the executables of this checkout."""
    prefix = tmp_path / 'prefix'
    index = prefix / 'share' / 'ament_index' / 'resource_index' / 'packages'
    index.mkdir(parents=True)
    (index / PACKAGE).touch()
    (prefix / 'lib' / PACKAGE).mkdir(parents=True)
    for name, module in MODULES.items():
        script = prefix / 'lib' / PACKAGE / name
        script.write_text(f'#!/bin/sh\nexec {sys.executable} -m {module} "$@"\n')
        script.chmod(0o755)
    monkeypatch.setenv('AMENT_PREFIX_PATH', str(prefix))
    monkeypatch.setenv('PYTHONPATH', str(ROOT), prepend=':')


def parameter(watcher, node: str, name: str) -> object:
    """Return a parameter of a node that runs."""
    response = watcher.call(GetParameters, f'{node}/get_parameters', names=[name])
    return parameter_value_to_python(response.values[0])


@needs_launch
@pytest.mark.xdist_group('nodes')
@pytest.mark.parametrize('composed', ['true', 'false'])
def test_two_arms_in_two_namespaces(installed, tmp_path, monkeypatch, composed):
    """The launch system itself: one arm in a namespace that is pushed, one in a given one."""
    monkeypatch.chdir(tmp_path)
    words = [sys.executable, '-c', TWO_ARMS, str(FILE), composed, OTHER_ARM]
    with watching() as watcher, subprocess.Popen(words) as launched:
        try:
            assert [parameter(watcher, f'/left/{name}', 'arm') for name in KINDS] == [
                OTHER_ARM] * 4
            assert [parameter(watcher, f'/right/{name}', 'arm') for name in NODES] == [
                'hda_arm.yaml'] * 3
            assert [parameter(watcher, f'/{side}/arm_sim', 'rate')
                    for side in ('left', 'right')] == [100.0, 50.0]
        finally:
            launched.send_signal(signal.SIGINT)
        assert launched.wait(PATIENCE) == 0
    assert (tmp_path / '20261122' / 'metadata.yaml').is_file()


def test_the_view_shows_the_frames_of_the_arm():
    """TF and RViz find every frame that messages name, and the tip where the laws have it."""
    defined = SimpleNamespace(**runpy.run_path(str(ROOT / 'launch' / 'view.launch.py')))
    robot = ElementTree.fromstring(defined.description('hda_arm.yaml'))
    assert {link.get('name') for link in robot.findall('link')} == {
        'base', 'joint1_link', 'joint2_link', 'tool'}
    reach = sum(float(joint.find('origin').get('xyz').split()[0])
                for joint in robot.findall('joint'))
    links = read_arm('hda_arm.yaml').links
    assert reach == pytest.approx(links.length1 + links.length2)
    shown = defined.configuration('hda_arm.yaml')['Visualization Manager']
    assert shown['Global Options']['Fixed Frame'] == 'base'


def test_what_launch_files_start_comes_with_the_package():
    """Each package whose executables a launch file starts is declared, so rosdep brings it."""
    declared = {depend.name for depend in parse_package(str(ROOT / 'package.xml')).exec_depends}
    named = {found for file in (ROOT / 'launch').glob('*.launch.py') for found in re.findall(
        r"Node\(package='(\w+)'", file.read_text(encoding='utf-8'))}
    assert named == {'robot_state_publisher', 'rviz2'}
    assert named <= declared
