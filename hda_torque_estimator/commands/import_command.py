"""`hda import`: a table with a column map becomes bags."""

import argparse
from pathlib import Path

from hda_msgs_json.errors import HdaError

from .out_option import add_out
from .outcome import Outcome
from .progress import progress
from ..importing.maps import shipped_maps
from ..importing.run import guess_map, run_import
from ..importing.side_by_side import names_of

EXAMPLES = (
    'hda import log.csv --guess > map.yaml                # read it, and edit it',
    'hda import log.csv --map map.yaml --out bag',
    'hda import pos.csv current.csv --guess     # tables with the same rows',
    'hda import joints.parquet --map voraus_yucobot.yaml --out bag')


class ImportUseError(HdaError):
    """Raised when the options do not say what to do."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument('tables', type=Path, nargs='+', metavar='TABLE',
                        help='CSV or other text, JSON lines, Parquet, MAT or NPZ; several with '
                             'the same rows are put side by side')
    parser.add_argument('--guess', action='store_true',
                        help='print a map guessed from names and numbers, to be edited')
    parser.add_argument('--map', type=Path, metavar='FILE',
                        help=f'column map, or a shipped one: {", ".join(shipped_maps())}')
    add_out(parser, 'BAG', 'bag to write; a map that splits the table adds _VALUE to it',
            required=False)


def execute(options: argparse.Namespace) -> Outcome:
    """Import and write, or guess a map; raises the project's errors."""
    with progress(f'reading {names_of(options.tables)}', quiet=options.json):
        return _imported(options)


def _imported(options: argparse.Namespace) -> Outcome:
    if options.guess:
        text = guess_map(options.tables)
        return Outcome(text.rstrip(), {'map': text})
    if options.map is None or options.out is None:
        raise ImportUseError('give --map FILE and --out BAG, or --guess for a map to edit')
    written = run_import(options.tables, options.map, options.out, force=options.force)
    bags = [str(path) for path in written]
    return Outcome('\n'.join(bags), {'bags': bags})
