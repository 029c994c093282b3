"""`hda calibrate`: recordings with reference torques make a new model file."""

import argparse
from pathlib import Path

from .outcome import Outcome
from ..calibrate.run import run_calibration


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument('bags', type=Path, nargs='+', metavar='BAG',
                        help='bag with joint_states and reference/JOINT/torque')
    parser.add_argument('--arm', required=True, help='model file, or the name of a shipped one')
    parser.add_argument('--joint', action='append', metavar='NAME',
                        help='calibrate this joint only; may be given again')
    parser.add_argument('--out', required=True, type=Path, metavar='FILE',
                        help='model file to write')


def execute(options: argparse.Namespace) -> Outcome:
    """Calibrate and write; raises the project's errors."""
    found = run_calibration(options.bags, options.arm, options.out, joints=options.joint)
    return Outcome(f'{options.out}\n{found.text()}', {'arm': str(options.out), **found.report()})
