"""ROS parameters are the declarations: the same names, bounds and sentences, now and later."""

from collections.abc import Callable, Iterator

from hda_arm_sim.foundation.parameter import ParameterError
from hda_arm_sim.live import SimulationSettings
from hda_arm_sim.node import ArmSim
from hda_arm_sim.ros.arm_node import ArmNode
from hda_arm_sim.ros.process import run
from hda_torque_estimator.controlling.controller import ControllerSettings
from hda_torque_estimator.controlling.controller_node import JtfController
from hda_torque_estimator.controlling.live_controller import WatchSettings
from hda_torque_estimator.estimating.estimator import EstimatorSettings
from hda_torque_estimator.estimating.estimator_node import TorqueEstimator
from hda_torque_estimator.estimating.live_estimator import StateSettings
from hda_torque_estimator.recording.recorder_node import BagRecorder
import pytest
import rclpy
from rclpy.parameter import Parameter

GROUPS = {ArmSim: [SimulationSettings], TorqueEstimator: [EstimatorSettings, StateSettings],
          JtfController: [ControllerSettings, WatchSettings]}
Make = Callable[..., ArmNode]


class Plain(ArmNode):
    """A node without parameters of its own."""

    def __init__(self) -> None:
        """Have a name."""
        super().__init__('plain')


@pytest.fixture
def node() -> Iterator[Make]:
    """Return a function that makes a node with parameters given as on the command line."""
    made: list[ArmNode] = []

    def make(kind: type[ArmNode], *parameters: str) -> ArmNode:
        words = [word for parameter in parameters for word in ('-p', parameter)]
        rclpy.init(args=['node', '--ros-args', *words])
        made.append(kind())
        return made[-1]

    yield make
    for each in made:
        each.destroy_node()
    rclpy.try_shutdown()


def change(node: ArmNode, **values: object) -> list[tuple[bool, str]]:
    """Return whether each change was allowed, and why not."""
    results = node.set_parameters([Parameter(name, value=value) for name, value in values.items()])
    return [(result.successful, result.reason) for result in results]


@pytest.mark.parametrize('kind', GROUPS)
def test_every_declared_number_is_a_parameter(node, kind):
    made = node(kind)
    for group in GROUPS[kind]:
        for rule in group.declarations():
            descriptor = made.describe_parameter(rule.name)
            bounds = descriptor.floating_point_range[0]
            assert made.get_parameter(rule.name).value == rule.default
            assert (bounds.from_value, bounds.to_value) == (rule.low, rule.high)
            assert rule.meaning in descriptor.description
            assert f'[{rule.unit}]' in descriptor.description or not rule.unit


def test_whole_numbers_do_for_doubles(node):
    made = node(TorqueEstimator, 'velocity_bandwidth:=55')
    assert made.get_parameter('velocity_bandwidth').value == 55.0
    assert change(made, observer_bandwidth=7) == [(True, '')]


def test_change_reaches_the_law(node):
    made = node(JtfController, 'position_gain:=0.2')
    assert change(made, position_gain=0.7, sample_timeout=0.1) == [(True, '')] * 2
    assert made._live.controller.settings == ControllerSettings(position_gain=0.7)
    assert made._live.watchdog.timeout == 0.1


@pytest.mark.parametrize(('value', 'said'), [
    (-1.0, 'range'), (float('nan'), 'range'), ('high', 'must be a number in Hz'),
    (-1, 'estimator.velocity_bandwidth must lie in [0.1, 10000] Hz (low-pass of the velocities)'),
])
def test_change_out_of_bounds_is_refused(node, value, said):
    made = node(TorqueEstimator)
    (allowed, reason), = change(made, velocity_bandwidth=value)
    assert not allowed
    assert said in reason
    assert made._answer.estimator.settings == EstimatorSettings()


def test_what_is_read_at_the_start_cannot_change(node):
    made = node(ArmSim)
    assert [allowed for allowed, _ in change(made, rate=500.0, arm='paper_table1.yaml')] == [
        False, False]


def test_parameters_that_nobody_asked_for_are_reported(node, capfd):
    made = node(TorqueEstimator, 'velocity_bandwith:=30.0', 'use_sim_time:=false')
    assert made.parameters.unknown() == ['velocity_bandwith']
    said = [line for line in capfd.readouterr().err.splitlines() if 'WARN' in line]
    assert len(said) == 1
    assert 'unknown parameters are ignored: velocity_bandwith; there are arm' in said[0]


@pytest.mark.parametrize(('kind', 'parameters', 'said'), [
    (ArmSim, ['rate:=0'], 'arm_sim.rate must lie in [10, 20000] Hz (samples per second of its'),
    (ArmSim, ['rate:=fast'], 'arm_sim.rate must be a number in Hz (samples per second of its'),
    (ArmSim, ['arm:=none.yaml'], "no arm file 'none.yaml'; did you mean"),
    (ArmSim, ['arm:=7'], 'arm must be a text (model file, or the name of a shipped one), got 7'),
    (ArmSim, ['effects:=none.yaml'], "no file 'none.yaml' to read effects from"),
    (ArmSim, ['arm:=voraus_yucobot.yaml'], 'an arm without links'),
    (JtfController, ['torque_feedback:=1.5'], 'controller.torque_feedback must lie in [-2, 0.99]'),
    (JtfController, ['enabled:=yes please'], 'enabled must be true or false'),
    (BagRecorder, [], 'output must name the directory of the bag'),
    (BagRecorder, ['output:=.'], 'exists and is not empty'),
    (TorqueEstimator, ['arm:=[]'], 'a parameter was given an empty list'),
    (TorqueEstimator, ['arm'], 'the ROS arguments cannot be used'),
])
def test_unusable_parameters_end_in_one_line(kind, parameters, said, signals, tmp_path,
                                             monkeypatch, capsys):
    (tmp_path / 'something').touch()
    monkeypatch.chdir(tmp_path)
    words = [word for parameter in parameters for word in ('-p', parameter)]
    assert run('name', lambda: [kind()], ['name', '--ros-args', *words]) == 2
    output = capsys.readouterr().err.splitlines()
    assert len(output) == 1
    assert output[0].startswith('name: ')
    assert said in output[0]
    assert sorted(path.name for path in tmp_path.iterdir()) == ['something']


def test_other_arguments_are_refused(signals, capsys):
    assert run('name', list, ['name', '--rate', '5']) == 2
    assert "no argument '--rate' is known" in capsys.readouterr().err


def test_declared_group_checks_what_it_is_given(node):
    made = node(Plain, 'seed:=-3')
    with pytest.raises(ParameterError, match='arm_sim.seed must lie in'):
        made.parameters.group(SimulationSettings)
