"""
The simulated arm, the estimator and the controller; with a recorder, or in one process.

`processes` decides what is started and with which parameters. It needs nothing of the launch
system, so that it can be asked where ROS 2 comes without it.
"""

from collections.abc import Mapping
import os
import sys
import tempfile
from typing import Any, NamedTuple

import yaml

PACKAGE = 'hda_torque_estimator'
NODES = ('arm_sim', 'torque_estimator', 'jtf_controller')
ARGUMENTS = {
    'arm': 'model file that all nodes believe in, or the name of a shipped one',
    'effects': 'file of effects that the simulated arm has and the other nodes do not know',
    'rate': 'samples of the simulated arm per second [Hz]',
    'record': 'directory of a bag to record, which must be new; none without',
    'composed': 'true: simulator, estimator and controller run in one process',
    'namespace': 'of all nodes and topics; below the one that is pushed, if one is',
    'params_file': 'parameters of the nodes; what the other arguments say goes before it',
    'use_sim_time': 'true: the nodes take their time from /clock',
}
DISCOVERY = 'ROS_AUTOMATIC_DISCOVERY_RANGE'
Values = dict[str, Any]


class Process(NamedTuple):
    """How a process is started, and the parameters of its nodes by the names of these."""

    how: Values
    parameters: dict[str, Values]

    def text(self) -> str:
        """Return the parameters as a file of them, whatever the namespace of the nodes."""
        return yaml.safe_dump({f'/**/{node}': {'ros__parameters': values}
                               for node, values in self.parameters.items()})


def processes(given: Mapping[str, str]) -> list[Process]:
    """Return what is started for these arguments; one that is empty leaves it to the nodes."""
    shared = {'arm': given['arm'], 'use_sim_time': _typed(given['use_sim_time'])}
    own = {'arm_sim': {'effects': given['effects'], 'rate': _typed(given['rate'])},
           'bag_recorder': {'output': given['record']}}
    names = [*NODES, *(['bag_recorder'] if given['record'] else [])]
    parameters = {name: {key: value for key, value in {**shared, **own.get(name, {})}.items()
                         if value not in ('', None)} for name in names}
    apart = names
    started = []
    if given['composed'].lower() in ('true', '1', 'yes'):
        module = ['-m', f'{PACKAGE}.composed_node']
        started.append(Process(
            {'executable': sys.executable, 'exec_name': 'arm', 'arguments': module},
            {name: parameters[name] for name in NODES}))
        apart = names[len(NODES):]
    return started + [Process({'package': PACKAGE, 'executable': name}, {name: parameters[name]})
                      for name in apart]


def environment(present: Mapping[str, str]) -> dict[str, str]:
    """Return what keeps the nodes to this machine, unless the user has said how far they reach."""
    return {} if DISCOVERY in present else {DISCOVERY: 'LOCALHOST'}


def generate_launch_description() -> Any:
    """Return the arguments, and the nodes that follow from them."""
    from launch import LaunchDescription
    from launch.actions import DeclareLaunchArgument, OpaqueFunction
    return LaunchDescription([
        *(DeclareLaunchArgument(name, default_value='', description=meaning)
          for name, meaning in ARGUMENTS.items()),
        OpaqueFunction(function=_nodes)])


def _nodes(context: Any) -> list[Any]:
    """Return the nodes; when one of them ends, all do."""
    from launch.actions import Shutdown
    from launch.substitutions import LaunchConfiguration
    from launch_ros.actions import Node
    given = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    files = [given['params_file']] if given['params_file'] else []
    for file in files:
        if not os.path.isfile(file):            # the launch system would go on without it
            raise FileNotFoundError(f'params_file must name a file of parameters, got {file!r}')
    return [Node(output='screen', on_exit=Shutdown(), namespace=given['namespace'] or None,
                 parameters=[*files, _file(process.text())],
                 additional_env=environment(context.environment), **process.how)
            for process in processes(given)]


def _file(text: str) -> str:
    """Return the path of a new file that holds a text."""
    handle, path = tempfile.mkstemp('.yaml', 'launch_params_')
    with os.fdopen(handle, 'w') as file:
        file.write(text)
    return path


def _typed(word: str) -> Any:
    """Return the number or truth value that a word is in YAML."""
    return yaml.safe_load(word)
