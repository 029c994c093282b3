"""`hda calibrate`: ordinary recordings make a new model file, with an interval for each number."""

import argparse
from collections.abc import Callable
from pathlib import Path
import sys

from hda_msgs_json.printable import printable

from .out_option import add_out
from .outcome import Outcome
from ..calibrate.run import run_calibration


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument('bags', type=Path, nargs='+', metavar='BAG',
                        help='bag with joint_states, motor torques in them; also read where '
                             'there are any: reference/JOINT/torque, reference/tip/wrench')
    parser.add_argument('--arm', required=True, help='model file, or the name of a shipped one')
    parser.add_argument('--joint', action='append', metavar='NAME',
                        help='calibrate this joint only; may be given again')
    parser.add_argument('--tilt', action='append', default=[], nargs=3,
                        metavar=('BAG', 'DEGREES', 'DIRECTION'),
                        help='the base stood tilted in this bag, downhill towards DIRECTION '
                             '(degrees from the x axis of the base); its weight is then known')
    parser.add_argument('--payload', action='append', default=[], nargs=2,
                        metavar=('BAG', 'KG'), help='a mass that hung at the tip in this bag')
    add_out(parser, 'FILE', 'model file to write')


def execute(options: argparse.Namespace) -> Outcome:
    """Calibrate and write; raises the project's errors."""
    found = run_calibration(options.bags, options.arm, options.out, joints=options.joint,
                            tilts=options.tilt, payloads=options.payload,
                            tell=_progress(options.json), force=options.force)
    _progress(options.json)('')
    return Outcome(f'{options.out}\n{found.text()}', {'arm': str(options.out), **found.report()})


def _progress(quiet: bool) -> Callable[[str], None]:
    """Return what shows progress: a line on a terminal, nothing elsewhere."""
    if quiet or not sys.stderr.isatty():
        return lambda text: None

    def show(text: str) -> None:
        sys.stderr.write(f'\r\033[K{printable(text)}')
        sys.stderr.flush()
    return show
