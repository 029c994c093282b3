"""`hda repair`: make a recording that was cut off whole."""

import argparse
from pathlib import Path

from hda_msgs_json.bag_repair import repair
from hda_msgs_json.outputs import check_directory

from .out_option import add_out
from .outcome import Outcome
from .progress import progress

EXAMPLES = (
    'hda repair bag                                      # writes bag_repaired',
    'hda repair bag.mcap --out whole')


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument('bag', type=Path, metavar='BAG', help='bag directory or .mcap file')
    add_out(parser, 'BAG', 'bag to write; NAME_repaired beside the original unless given',
            required=False)


def execute(options: argparse.Namespace) -> Outcome:
    """Repair a bag; raises the project's errors."""
    with progress(f'repairing {options.bag.name}', quiet=options.json):
        return _repaired(options)


def _repaired(options: argparse.Namespace) -> Outcome:
    bag = options.bag.absolute()
    out = options.out or bag.with_name(f'{bag.stem if bag.is_file() else bag.name}_repaired')
    check_directory(out, force=options.force, reads=[bag])
    done = repair(bag, out, force=options.force)
    lines = [f'{out}: {done.messages} messages of {done.topics} topics',
             *(f'  warning: {sentence}' for sentence in done.warnings)]
    return Outcome('\n'.join(lines), {
        'bag': str(options.bag), 'out': str(out), 'messages': done.messages,
        'topics': done.topics, 'warnings': done.warnings})
