"""The simulated arm, the estimator and the controller; with a recorder, or in one process."""

import sys

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction, Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

PACKAGE = 'hda_torque_estimator'
ARGUMENTS = {
    'arm': ('hda_arm.yaml', 'model file that all nodes believe in, or the name of a shipped one'),
    'effects': ('', 'file of effects that the simulated arm has and the other nodes do not know'),
    'record': ('', 'directory of a bag to record, which must be new; none without'),
    'composed': ('false', 'true: simulator, estimator and controller run in one process'),
}


def generate_launch_description() -> LaunchDescription:
    """Return the arguments, and the nodes that follow from them."""
    arguments = [DeclareLaunchArgument(name, default_value=default, description=meaning)
                 for name, (default, meaning) in ARGUMENTS.items()]
    return LaunchDescription([*arguments, OpaqueFunction(function=nodes)])


def nodes(context: LaunchContext) -> list[Node]:
    """Return the nodes; when one of them ends, all do."""
    given = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    parameters = {'arm_sim': {'arm': given['arm']}, 'torque_estimator': {'arm': given['arm']},
                  'jtf_controller': {'arm': given['arm']}}
    if given['effects']:
        parameters['arm_sim']['effects'] = given['effects']
    if given['composed'].lower() in ('true', '1', 'yes'):
        started = [_process(parameters, executable=sys.executable, exec_name='arm',
                            arguments=['-m', f'{PACKAGE}.composed_node'])]
    else:
        started = [_process({name: own}, package=PACKAGE, executable=name)
                   for name, own in parameters.items()]
    if given['record']:
        recorder = {'bag_recorder': {'arm': given['arm'], 'output': given['record']}}
        started.append(_process(recorder, package=PACKAGE, executable='bag_recorder'))
    return started


def _process(parameters: dict[str, dict[str, str]], **how: object) -> Node:
    """Return a process with parameters for each of its nodes."""
    ros_arguments = [word for node, own in parameters.items() for name, value in own.items()
                     for word in ('-p', f'{node}:{name}:={value}')]
    return Node(output='screen', on_exit=Shutdown(), ros_arguments=ros_arguments, **how)
