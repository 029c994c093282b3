"""Security of ROS: where it is asked for and the middleware has none, nothing may run open."""

from collections.abc import Mapping
from pathlib import Path

from rclpy.utilities import get_rmw_implementation_identifier

ENABLE = 'ROS_SECURITY_ENABLE'
_ASKED = ('true', '1', 'yes', 'on')
_LIBRARY = 'librmw_fastrtps_shared_cpp'
_BUILT_WITHOUT = b"This Fast DDS version doesn't have the security libraries"
_LOADED = Path('/proc/self/maps')


def why_insecure(environment: Mapping[str, str]) -> str:
    """
    Return why nodes would not be as secure as was asked for, nothing if they are.

    A middleware that was built without it ends a node with a keystore in a traceback. Without one
    it runs open where the strategy is `Permissive`, which is the default.
    """
    asked = environment.get(ENABLE, '')
    if asked.lower() not in _ASKED:
        return ''
    if asked != 'true':
        return f'{ENABLE} must be true, in these letters, got {asked!r}: ROS would run open'
    if any(_BUILT_WITHOUT in library.read_bytes() for library in _middleware()):
        return (f'{ENABLE} is true, but the middleware here was built without security, so '
                'nothing is started; use ROS 2 of its own packages (apt), or unset the variable')
    return ''


def _middleware() -> set[Path]:
    """Return the libraries of the middleware that are loaded."""
    get_rmw_implementation_identifier()         # loads them
    words = (line.split(maxsplit=5) for line in _LOADED.read_text().splitlines())
    return {Path(word[5]) for word in words if len(word) == 6 and _LIBRARY in word[5]}
