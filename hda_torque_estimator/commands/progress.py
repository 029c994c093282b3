"""What a command is doing: one line on a terminal, which is gone when the command is done."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
import sys

from hda_msgs_json.printable import printable


@contextmanager
def progress(*, quiet: bool) -> Iterator[Callable[[str], None]]:
    """Yield what shows a text on a terminal; nothing is shown elsewhere, or if `quiet`."""
    if quiet or not sys.stderr.isatty():
        yield lambda text: None
        return
    from rich.console import Console        # a quarter of a second that only a terminal waits for
    from rich.text import Text
    with Console(stderr=True).status('') as status:
        yield lambda text: status.update(Text(printable(text), no_wrap=True, overflow='ellipsis'))
