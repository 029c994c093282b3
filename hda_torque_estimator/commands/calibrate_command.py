"""`hda calibrate`: ordinary recordings make a new model file, with an interval for each number."""

import argparse
from pathlib import Path

from .bag_option import add_naming, opener
from .out_option import add_out
from .outcome import Outcome
from .page_option import add_page, check_page, write_page
from .progress import progress
from ..calibrate.page import page
from ..calibrate.run import run_calibration, Sources
from ..version import version

EXAMPLES = (
    'hda calibrate monday tuesday --arm arm.yaml --out calibrated.yaml',
    'hda calibrate tilted --arm arm.yaml --tilt tilted 30 0 --out calibrated.yaml',
    'hda calibrate loaded --arm arm.yaml --payload loaded 1.5 --out calibrated.yaml')


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
    parser.add_argument('--zero-moves', action='store_true',
                        help='where reference torques are read: the zero of a torsion is another '
                             'after every start, and the motor gives it')
    add_out(parser, 'FILE', 'model file to write')
    add_naming(parser)
    add_page(parser)


def execute(options: argparse.Namespace) -> Outcome:
    """Calibrate and write; raises the project's errors."""
    check_page(options, options.bags)
    with progress(quiet=options.json) as notify:
        sources = Sources(options.bags, options.tilt, options.payload, opener(options),
                          options.zero_moves)
        found = run_calibration(sources, options.arm, options.out, joints=options.joint,
                                force=options.force, notify=notify)
    if options.page is not None:
        write_page(options, page(found, out=str(options.out), arm=options.arm, version=version(),
                                 bags=[str(bag) for bag in options.bags]))
    return Outcome(f'{options.out}\n{found.text()}', {'arm': str(options.out), **found.report()})
