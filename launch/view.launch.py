"""
RViz with the arm as it stands, its torques and the push on its tip, beside nodes that run.

`arm.launch.py` or a robot's driver and the estimator run on their own, or `nodes:=true` starts
the simulated arm with them. `view:=false` starts what TF needs, and no window.
"""

from pathlib import Path
import tempfile
from typing import Any

import yaml

ARGUMENTS = {
    'nodes': ('false', 'true: start the simulated arm, estimator and controller as well'),
    'arm': ('hda_arm.yaml', 'model file that all nodes believe in, or the name of a shipped one'),
    'view': ('true', 'false: no window, only the frames on /tf'),
}
TRUE = ('true', '1', 'yes')
TORQUE = 'torque of '        # how the displays of joint torques are called


def description(arm: str) -> str:
    """Return the URDF of an arm."""
    from hda_arm_sim.model.description import urdf
    from hda_arm_sim.model.files import read_arm
    return urdf(read_arm(arm))


def configuration(arm: str) -> dict[str, Any]:
    """Return what RViz shows of an arm: `view.rviz` with the torque of each of its joints."""
    from hda_arm_sim.model.files import read_arm
    file = Path(__file__).resolve().parent.parent / 'config' / 'view.rviz'
    shown = yaml.safe_load(file.read_text(encoding='utf-8'))
    displays = shown['Visualization Manager']['Displays']
    *_, torque = (one for one in displays if one['Name'].startswith(TORQUE))
    displays[:] = [*(one for one in displays if not one['Name'].startswith(TORQUE)), *(
        {**torque, 'Name': f'{TORQUE}{label}', 'Topic': {'Value': f'{label}/torque'}}
        for label in read_arm(arm).labels)]
    return shown


def generate_launch_description() -> Any:
    """Return the arguments, and the nodes that follow from them."""
    from launch import LaunchDescription
    from launch.actions import DeclareLaunchArgument, OpaqueFunction
    return LaunchDescription([
        *(DeclareLaunchArgument(name, default_value=default, description=meaning)
          for name, (default, meaning) in ARGUMENTS.items()),
        OpaqueFunction(function=_nodes)])


def _nodes(context: Any) -> list[Any]:
    """Return the frames of the arm, the window, and the nodes if they are asked for."""
    from launch.actions import IncludeLaunchDescription
    from launch.launch_description_sources import PythonLaunchDescriptionSource
    from launch.substitutions import LaunchConfiguration
    from launch_ros.actions import Node
    given = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    frames = Node(package='robot_state_publisher', executable='robot_state_publisher',
                  parameters=[{'robot_description': description(given['arm'])}])
    with tempfile.NamedTemporaryFile('w', suffix='.rviz', delete=False) as file:
        yaml.safe_dump(configuration(given['arm']), file)
    window = Node(package='rviz2', executable='rviz2', arguments=['-d', file.name])
    arm = IncludeLaunchDescription(
        PythonLaunchDescriptionSource(str(Path(__file__).with_name('arm.launch.py'))),
        launch_arguments={'arm': given['arm']}.items())
    return [frames, *([window] if given['view'].lower() in TRUE else []),
            *([arm] if given['nodes'].lower() in TRUE else [])]
