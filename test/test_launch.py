"""The launch file starts executables that exist, with parameters that they have."""

from collections.abc import Callable
import importlib.util
from pathlib import Path
import runpy
import sys
from types import ModuleType, SimpleNamespace

from hda_arm_sim.node import ArmSim
from hda_torque_estimator.controller_node import JtfController
from hda_torque_estimator.estimator_node import TorqueEstimator
from hda_torque_estimator.recorder_node import BagRecorder
from project_files import ROOT
import pytest
import rclpy
import setuptools

PACKAGE = 'hda_torque_estimator'
NODES = {'arm_sim': ArmSim, 'torque_estimator': TorqueEstimator, 'jtf_controller': JtfController,
         'bag_recorder': BagRecorder}
Words = list[str]


class Recorded:
    """Remember how an action was made."""

    def __init__(self, *positional: object, **how: object) -> None:
        """Keep the arguments."""
        self.positional, self.how = positional, how


class Configuration(Recorded):
    """The value of a launch argument."""

    def perform(self, given: dict[str, str]) -> str:
        """Return what was given."""
        return given[str(self.positional[0])]


@pytest.fixture
def launched(monkeypatch) -> Callable[..., list[SimpleNamespace]]:
    """Return a function that gives the nodes which the launch file starts with arguments."""
    stands_for = {
        'launch': ('LaunchContext', 'LaunchDescription'),
        'launch.actions': ('DeclareLaunchArgument', 'OpaqueFunction', 'Shutdown'),
        'launch_ros': (), 'launch_ros.actions': ('Node',)}
    for name, classes in stands_for.items():
        module = ModuleType(name)
        vars(module).update({each: type(each, (Recorded,), {}) for each in classes})
        monkeypatch.setitem(sys.modules, name, module)
    substitutions = ModuleType('launch.substitutions')
    vars(substitutions)['LaunchConfiguration'] = Configuration
    monkeypatch.setitem(sys.modules, 'launch.substitutions', substitutions)

    def launch(**given: str) -> list[SimpleNamespace]:
        file = runpy.run_path(str(ROOT / 'launch' / 'arm.launch.py'))
        *arguments, function = file['generate_launch_description']().positional[0]
        defaults = {each.positional[0]: each.how['default_value'] for each in arguments}
        assert set(given) <= set(defaults)
        return [SimpleNamespace(**node.how) for node in
                function.how['function']({**defaults, **given})]

    return launch


def parameters_of(node: SimpleNamespace) -> dict[tuple[str, str], str]:
    """Return the parameters of a process by node and name."""
    words = node.ros_arguments
    assert words[::2] == ['-p'] * (len(words) // 2)
    found = {}
    for word in words[1::2]:
        place, _, value = word.partition(':=')
        found[tuple(place.split(':'))] = value
    return found


def described(monkeypatch) -> Words:
    """Return the executables that setup.py declares."""
    told: dict[str, dict[str, Words]] = {}
    monkeypatch.setattr(setuptools, 'setup', told.update)
    monkeypatch.chdir(ROOT)
    runpy.run_path('setup.py')
    return [word.split(' = ')[0] for word in told['entry_points']['console_scripts']]


def test_three_executables_of_the_package(launched, monkeypatch):
    nodes = launched()
    assert [node.executable for node in nodes] == ['arm_sim', 'torque_estimator', 'jtf_controller']
    assert {node.package for node in nodes} == {PACKAGE}
    assert {node.executable for node in nodes} <= set(described(monkeypatch))


def test_recorder_comes_on_demand(launched):
    *_, recorder = launched(record='somewhere')
    assert recorder.executable == 'bag_recorder'
    assert parameters_of(recorder)['bag_recorder', 'output'] == 'somewhere'


def test_only_the_simulator_knows_the_effects(launched):
    given = {key: value for node in launched(effects='effects.yaml', record='bag')
             for key, value in parameters_of(node).items()}
    assert {key for key, value in given.items() if value == 'effects.yaml'} == {
        ('arm_sim', 'effects')}
    assert {node for node, name in given if name == 'arm'} == set(NODES)


def test_composed_nodes_are_one_process_with_the_same_parameters(launched):
    options = {'effects': 'effects.yaml', 'arm': 'arm.yaml'}
    apart = {key: value for node in launched(**options)
             for key, value in parameters_of(node).items()}
    together, = launched(**options, composed='true')
    assert parameters_of(together) == apart
    assert together.executable == sys.executable
    assert together.arguments[0] == '-m'
    assert importlib.util.find_spec(together.arguments[1]) is not None


def test_every_parameter_is_one_of_its_node(launched, tmp_path):
    effects = tmp_path / 'effects.yaml'
    effects.write_text('[]')
    for node in launched(effects=str(effects), record=str(tmp_path / 'bag')):
        (name,) = {place for place, _ in parameters_of(node)}
        rclpy.init(args=[name, '--ros-args', *node.ros_arguments])
        try:
            made = NODES[name]()
            assert made.parameters.unknown() == []
            made.close()
            made.destroy_node()
        finally:
            rclpy.try_shutdown()
    assert Path(tmp_path / 'bag' / 'metadata.yaml').is_file()
