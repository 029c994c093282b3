"""The definitions of the message types that bags carry, as rosbag2 stores them in a bag."""

from collections.abc import Iterable, Iterator
import json
import os
from pathlib import Path
import re
import sys
from typing import NamedTuple

from hda_msgs_json.errors import HdaError

BUILTIN = re.compile(
    r'(bool|byte|char|float32|float64|u?int(8|16|32|64)|w?string(<=\d+)?)$')
TYPE_NAME = re.compile(r'([a-z][a-z0-9_]*)/(?:msg/)?([A-Za-z][A-Za-z0-9]*)')
SEPARATOR = '=' * 80

DEFINITIONS = {
    'builtin_interfaces/Duration': 'int32 sec\nuint32 nanosec\n',
    'builtin_interfaces/Time': 'int32 sec\nuint32 nanosec\n',
    'diagnostic_msgs/DiagnosticArray':
        'std_msgs/Header header\ndiagnostic_msgs/DiagnosticStatus[] status\n',
    'diagnostic_msgs/DiagnosticStatus':
        'byte OK=0\nbyte WARN=1\nbyte ERROR=2\nbyte STALE=3\n'
        'byte level\nstring name\nstring message\nstring hardware_id\n'
        'diagnostic_msgs/KeyValue[] values\n',
    'diagnostic_msgs/KeyValue': 'string key\nstring value\n',
    'geometry_msgs/Vector3': 'float64 x\nfloat64 y\nfloat64 z\n',
    'geometry_msgs/Wrench': 'geometry_msgs/Vector3 force\ngeometry_msgs/Vector3 torque\n',
    'geometry_msgs/WrenchStamped': 'std_msgs/Header header\ngeometry_msgs/Wrench wrench\n',
    'rosgraph_msgs/Clock': 'builtin_interfaces/Time clock\n',
    'sensor_msgs/JointState':
        'std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\n'
        'float64[] effort\n',
    'std_msgs/Float64': 'float64 data\n',
    'std_msgs/Header': 'builtin_interfaces/Time stamp\nstring frame_id\n',
    'std_msgs/String': 'string data\n',
    'trajectory_msgs/JointTrajectory':
        'std_msgs/Header header\nstring[] joint_names\n'
        'trajectory_msgs/JointTrajectoryPoint[] points\n',
    'trajectory_msgs/JointTrajectoryPoint':
        'float64[] positions\nfloat64[] velocities\nfloat64[] accelerations\n'
        'float64[] effort\nbuiltin_interfaces/Duration time_from_start\n',
}
"""Fields of the types of this system, so that a bag can be written where no ROS is installed."""

HASHES = {
    'diagnostic_msgs/DiagnosticArray':
        'RIHS01_5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e',
    'geometry_msgs/WrenchStamped':
        'RIHS01_8dc3deaf06b2ab281f9f9a742a8961c328ca7cec16e3fd6586d3a5c83fa78f77',
    'rosgraph_msgs/Clock':
        'RIHS01_692f7a66e93a3c83e71765d033b60349ba68023a8c689a79e48078bcb5c58564',
    'sensor_msgs/JointState':
        'RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e',
    'std_msgs/Float64':
        'RIHS01_705ba9c3d1a09df43737eb67095534de36fd426c0587779bda2bc51fe790182a',
    'std_msgs/String':
        'RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18',
    'trajectory_msgs/JointTrajectory':
        'RIHS01_179b33eba59d676f6d967ac71fe35e7ca2f64b2f3928f4a018cec115e213796e',
}
"""What ROS 2 compares to decide whether two programs mean the same by a type (REP 2011)."""


class SchemaError(HdaError):
    """Raised when the definition of a type cannot be found."""


class Schema(NamedTuple):
    """Hold the definition of a type: `ros2msg` text and hash, empty where it is not known."""

    text: str
    type_hash: str


def short_name(message_type: str) -> str:
    """Return 'package/Name' for that or 'package/msg/Name'; raise SchemaError for any else."""
    if not (match := TYPE_NAME.fullmatch(message_type)):
        raise SchemaError(
            f'a message type looks like sensor_msgs/msg/JointState, got {message_type!r}')
    return '/'.join(match.groups())


def schema(message_type: str, share_directories: Iterable[Path] | None = None) -> Schema:
    """
    Return the definition of a type: one of this system, or one installed in a share directory.

    The share directories are those of the ROS installation unless given. Raise SchemaError if
    none of them has the type.
    """
    name = short_name(message_type)
    if name in HASHES:
        return Schema(schema_text(name), HASHES[name])
    for share in ros_share_directories() if share_directories is None else share_directories:
        if _message_file(name, share).is_file():
            return Schema(schema_text(name, share), _installed_hash(name, share))
    raise SchemaError(
        f'the type {message_type} is not installed: no share directory has {name}.msg')


def schema_text(message_type: str, share_directory: Path | None = None) -> str:
    """Return a definition followed by those of all types it is made of; raise SchemaError."""
    name = short_name(message_type)
    texts = {name: _definition(name, share_directory)}
    waiting = [name]
    while waiting:
        package = waiting[0].split('/')[0]
        for part in _parts(texts[waiting.pop(0)], package):
            if part not in texts:
                texts[part] = _definition(part, share_directory)
                waiting.append(part)
    first, *others = texts.items()
    return first[1] + ''.join(f'{SEPARATOR}\nMSG: {part}\n{text}' for part, text in others)


def ros_share_directories() -> Iterator[Path]:
    """Yield the share directories of the ROS installation and of the Python environment."""
    for prefix in (*os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep), sys.prefix):
        if prefix:
            yield Path(prefix) / 'share'


def _definition(name: str, share_directory: Path | None) -> str:
    if name in DEFINITIONS:
        return DEFINITIONS[name]
    if share_directory is None:
        raise SchemaError(f'the type {name} is not one of {", ".join(sorted(DEFINITIONS))}')
    path = _message_file(name, share_directory)
    try:
        return path.read_text().rstrip('\n') + '\n'
    except (OSError, UnicodeDecodeError):
        raise SchemaError(f'the definition of {name} cannot be read from {path}') from None


def _parts(text: str, package: str) -> Iterator[str]:
    """Yield the types that the fields of a definition have, other than the built-in ones."""
    for line in text.splitlines():
        words = line.split('#')[0].split()
        if not words or BUILTIN.fullmatch(kind := words[0].split('[')[0]):
            continue
        yield 'std_msgs/Header' if kind == 'Header' else (
            short_name(kind) if '/' in kind else f'{package}/{kind}')


def _message_file(name: str, share_directory: Path) -> Path:
    package, message = name.split('/')
    return Path(share_directory) / package / 'msg' / f'{message}.msg'


def _installed_hash(name: str, share_directory: Path) -> str:
    """Return the hash that ROS installs beside the definition, or nothing."""
    try:
        found = json.loads(_message_file(name, share_directory).with_suffix('.json').read_text())
        hashes = {entry['type_name']: entry['hash_string'] for entry in found['type_hashes']}
        return str(hashes[name.replace('/', '/msg/')])
    except (OSError, ValueError, LookupError, TypeError):
        return ''
