"""An outcome as a terminal shows it: lines as wide as it is, the verdict in its colour."""

from collections.abc import Mapping
import shutil
from textwrap import wrap
from typing import Any, TextIO

from hda_msgs_json.printable import printable

_HANGING = 4            # of the lines that go on
COLOURS: Mapping[str, str] = {
    'no_discrepancy': 'green', 'explained': 'cyan', 'ambiguous': 'yellow', 'unknown': 'magenta',
    'insufficient_excitation': 'yellow'}
"""The colour of each verdict: healthy, explained, several explanations, none, not visible."""


def show(text: str, report: Mapping[str, Any], stream: TextIO) -> None:
    """Print a text: as it is to a pipe or file, in lines that fit and colours to a terminal."""
    plain = printable(text, keep='\n')
    if not stream.isatty():
        stream.write(plain + '\n')
        return
    from rich.console import Console        # a quarter of a second that only a terminal waits for
    from rich.text import Text
    width = shutil.get_terminal_size().columns
    lines = [part for line in plain.split('\n') for part in fitted(line, width)]
    colour = COLOURS.get(str(report.get('verdict')))
    shown = Text('\n'.join(lines))
    if colour:
        first = len(fitted(plain.partition('\n')[0], width))
        shown.stylize(f'bold {colour}', 0, len('\n'.join(lines[:first])))
    Console(file=stream, width=width, soft_wrap=True).print(shown)


def complain(line: str, stream: TextIO) -> None:
    """Print one line, to a terminal in parts that end between words."""
    width = shutil.get_terminal_size().columns
    stream.write('\n'.join(fitted(line, width) if stream.isatty() else [line]) + '\n')


def fitted(line: str, width: int) -> list[str]:
    """Return a line in parts of at most a width, those that go on behind a margin."""
    if len(line) <= width:
        return [line]
    margin = ' ' * (len(line) - len(line.lstrip()))
    return wrap(line, width, subsequent_indent=margin + ' ' * _HANGING, drop_whitespace=True,
                break_on_hyphens=False, break_long_words=False) or [line]
