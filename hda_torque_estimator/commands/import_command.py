"""`hda import`: a table with a column map becomes bags."""

import argparse
from pathlib import Path

from .outcome import Outcome
from ..importing.run import run_import, shipped_maps


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument('table', type=Path, metavar='TABLE', help='CSV, Parquet, MAT or NPZ')
    parser.add_argument('--map', required=True, type=Path, metavar='FILE',
                        help=f'column map, or a shipped one: {", ".join(shipped_maps())}')
    parser.add_argument('--out', required=True, type=Path, metavar='BAG',
                        help='bag to write; a map that splits the table adds _VALUE to it')


def execute(options: argparse.Namespace) -> Outcome:
    """Import and write; raises the project's errors."""
    bags = [str(path) for path in run_import(options.table, options.map, options.out)]
    return Outcome('\n'.join(bags), {'bags': bags})
