"""The launch file of RViz starts what shows an arm, with every joint of it."""

import importlib.util
from pathlib import Path
import runpy
import signal
import subprocess
import sys
import time
from types import ModuleType, SimpleNamespace
from xml.etree import ElementTree

from hda_arm_sim.model.files import read_arm
from node_processes import PATIENCE
from project_files import ROOT
import pytest
import yaml

FILE = ROOT / 'launch' / 'view.launch.py'
ARMS = ('hda_arm.yaml', 'cobot7.yaml')
# Each program of the view writes down its words and the files among them, and stays.
STANDS_IN = """#!/bin/sh
for word in "$@"; do
  echo "$word"
  if test -f "$word"; then cat "$word"; fi
done > '{written}.part'
mv '{written}.part' '{written}'
exec sleep 60
"""
needs_launch = pytest.mark.skipif(importlib.util.find_spec('launch_ros') is None,
                                  reason='ROS 2 comes without its launch system here')


@pytest.fixture
def described() -> SimpleNamespace:
    """Return what the launch file defines."""
    return SimpleNamespace(**runpy.run_path(str(FILE)))


@pytest.fixture
def stand_ins(monkeypatch) -> list[tuple[str, SimpleNamespace]]:
    """Put classes that write down what is made in the place of the launch system."""
    made: list[tuple[str, SimpleNamespace]] = []

    def kind(name: str):
        def make(*values, **named):
            made.append((name, SimpleNamespace(values=values, **named)))
            return made[-1][1]
        return make

    def module(name: str, **content: object) -> None:
        found = ModuleType(name)
        vars(found).update(content)
        monkeypatch.setitem(sys.modules, name, found)
    module('launch', LaunchDescription=kind('description'))
    module('launch.actions', **{name: kind(name) for name in (
        'DeclareLaunchArgument', 'OpaqueFunction', 'IncludeLaunchDescription')})
    module('launch.launch_description_sources', PythonLaunchDescriptionSource=kind('source'))
    module('launch.substitutions', LaunchConfiguration=lambda name: SimpleNamespace(
        perform=lambda context: context[name]))
    module('launch_ros')
    module('launch_ros.actions', Node=kind('Node'))
    return made


def started(described: SimpleNamespace, made: list, **given: str) -> list[SimpleNamespace]:
    """Return the actions that a launch with these arguments comes to."""
    described.generate_launch_description()
    function, = (one.function for name, one in made if name == 'OpaqueFunction')
    defaults = {one.values[0]: one.default_value
                for name, one in made if name == 'DeclareLaunchArgument'}
    assert defaults.keys() == described.ARGUMENTS.keys()
    return function({**defaults, **given})


@pytest.mark.parametrize('arm', ARMS)
def test_frames_and_window_are_those_of_the_arm(described, stand_ins, arm):
    frames, window = started(described, stand_ins, arm=arm)
    assert (frames.package, window.package) == ('robot_state_publisher', 'rviz2')
    robot = ElementTree.fromstring(frames.parameters[0]['robot_description'])
    moving = [joint for joint in robot.findall('joint') if joint.get('type') == 'revolute']
    assert [joint.get('name') for joint in moving] == list(read_arm(arm).labels)
    flag, file = window.arguments
    assert flag == '-d'
    shown = yaml.safe_load(Path(file).read_text())['Visualization Manager']['Displays']
    torques = [one for one in shown if one['Name'].startswith('torque of ')]
    assert [one['Topic']['Value'] for one in torques] == [
        f'{label}/torque' for label in read_arm(arm).labels]
    assert all(one['Torque Arrow Scale'] > 0.0 for one in torques)
    Path(file).unlink()


def test_arguments_choose_what_is_started(described, stand_ins):
    frames, = started(described, stand_ins, view='false')
    assert frames.package == 'robot_state_publisher'


def test_the_nodes_of_the_arm_are_asked_for(described, stand_ins):
    frames, arm = started(described, stand_ins, view='false', nodes='true', arm='cobot7.yaml')
    assert dict(arm.launch_arguments) == {'arm': 'cobot7.yaml'}
    assert Path(arm.values[0].values[0]) == FILE.with_name('arm.launch.py')


@needs_launch
@pytest.mark.parametrize('arm', ARMS)
def test_the_launch_system_starts_the_view(tmp_path, monkeypatch, arm):
    """The launch system itself; programs that write down what they were given stand in."""
    prefix, written = tmp_path / 'prefix', {}
    index = prefix / 'share' / 'ament_index' / 'resource_index' / 'packages'
    index.mkdir(parents=True)
    for name in ('robot_state_publisher', 'rviz2'):
        (index / name).touch()
        program, written[name] = prefix / 'lib' / name / name, tmp_path / name
        program.parent.mkdir(parents=True)
        program.write_text(STANDS_IN.format(written=written[name]))
        program.chmod(0o755)
    monkeypatch.setenv('AMENT_PREFIX_PATH', str(prefix), prepend=':')
    monkeypatch.setenv('PYTHONPATH', str(ROOT), prepend=':')
    launch = ('import sys; from launch import LaunchDescription, LaunchService; '
              'from launch.actions import IncludeLaunchDescription as Include; '
              'from launch.launch_description_sources import PythonLaunchDescriptionSource as By; '
              'service = LaunchService(); service.include_launch_description(LaunchDescription(['
              'Include(By(sys.argv[1]), launch_arguments={"arm": sys.argv[2]}.items())])); '
              'sys.exit(service.run())')
    with subprocess.Popen([sys.executable, '-c', launch, str(FILE), arm]) as launched:
        try:
            end = time.monotonic() + PATIENCE
            while not all(file.exists() for file in written.values()):
                assert launched.poll() is None and time.monotonic() < end
                time.sleep(0.1)
        finally:
            launched.send_signal(signal.SIGINT)
        launched.wait(PATIENCE)
    assert '<robot name=' in written['robot_state_publisher'].read_text()
    shown = written['rviz2'].read_text()
    assert all(f'{label}/torque' in shown for label in read_arm(arm).labels)
