"""The option --page: a page for people beside an output that is for machines."""

import argparse
from collections.abc import Iterable
from pathlib import Path

from hda_msgs_json.outputs import check_file, OutputError, whole_file

from .out_option import place


def add_page(parser: argparse.ArgumentParser) -> None:
    """Declare --page."""
    parser.add_argument('--page', type=place, metavar='FILE',
                        help='page to write as well, an .html file that needs no network')


def check_page(options: argparse.Namespace, reads: Iterable[Path]) -> None:
    """Raise OutputError unless the page, if there is one, may appear at its place."""
    if options.page is None:
        return
    if options.page.absolute() == options.out.absolute():
        raise OutputError(f'{options.page} is to be the output and its page; name two places')
    check_file(options.page, force=options.force, reads=reads)


def write_page(options: argparse.Namespace, text: str) -> None:
    """Write a page, whole or not at all."""
    with whole_file(options.page, force=options.force) as stream:
        stream.write(text)
