"""`hda live`: a page on this machine that shows a running arm."""

import argparse
from importlib.util import find_spec
from pathlib import Path

from hda_msgs_json.errors import HdaError

from .outcome import Outcome
from .progress import starting

EXAMPLES = (
    'hda live --open',
    'hda live --arm arm.yaml --port 8080 --out recordings',
)
NEEDED = {'rclpy': 'a sourced ROS 2, or the extra `ros`', 'aiohttp': 'the extra `live`'}
"""What the page needs beyond the other commands, and where it comes from."""

_LAST_PORT = 65535      # (source: TCP has 16 bits for it)


class LiveError(HdaError):
    """Raised where the page cannot be served."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument('--arm', default='hda_arm.yaml', metavar='FILE',
                        help='model file, or the name of a shipped one')
    parser.add_argument('--port', type=_port, default=0,
                        help='port on this machine; 0 takes any that is free')
    parser.add_argument('--open', action='store_true', help='open the page in the browser')
    parser.add_argument('--out', type=Path, default=Path('recordings'), metavar='DIR',
                        help='directory in which the button of the page makes bags')


def _port(text: str) -> int:
    """Return the number of a port; raises ArgumentTypeError."""
    if not text.isdecimal() or int(text) > _LAST_PORT:
        raise argparse.ArgumentTypeError(
            f'it must be a number from 0 to {_LAST_PORT}, got {text!r:.60}')
    return int(text)


def execute(options: argparse.Namespace) -> Outcome:
    """Serve the page until Ctrl-C; raises LiveError."""
    if missing := [name for name in NEEDED if find_spec(name) is None]:
        raise LiveError(f'{missing[0]} is not installed: it comes with {NEEDED[missing[0]]}')
    with starting('live'):
        from ..live.live_node import main
    values = {'arm': options.arm, 'port': options.port, 'folder': options.out,
              'open': str(options.open).lower()}
    words = [word for name, value in values.items() for word in ('-p', f'{name}:={value}')]
    if main(['live_view', '--ros-args', *words]):
        raise LiveError('the page could not be served, as said above')
    return Outcome('the page is closed', {'port': options.port})
