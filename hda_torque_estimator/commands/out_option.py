"""The option that says where a command writes, the same for all that do."""

import argparse
from pathlib import Path


def add_out(parser: argparse.ArgumentParser, metavar: str, meaning: str, *,
            required: bool = True) -> None:
    """Declare --out, and --force to replace what is there."""
    parser.add_argument('--out', required=required, type=place, metavar=metavar, help=meaning)
    parser.add_argument('--force', action='store_true',
                        help='replace what hda has written there before')


def place(text: str) -> Path:
    """Return a path; raises ArgumentTypeError for none, which would be the current folder."""
    if not text.strip():
        raise argparse.ArgumentTypeError('it must name a place to write to, got nothing')
    return Path(text)
