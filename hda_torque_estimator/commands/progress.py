"""What a command is doing: one line on a terminal, which is gone when the command is done."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
import sys
from threading import Timer
import time

from hda_msgs_json.printable import printable

Notify = Callable[[str], None]
_SPINNER = 2            # columns before the text
_AT_ONCE = 0.5          # a start that takes longer is said: a choice [s]
_ERASED = '\r\x1b[K'
_MINUTE, _HOUR = 60.0, 3600.0       # [s]


@contextmanager
def progress(first: str = 'starting', *, quiet: bool) -> Iterator[Notify]:
    """
    Yield what shows a text on a terminal, and show a first one.

    Nothing is shown elsewhere, or if `quiet`. The line also says that laws are being compiled.
    """
    if quiet or not sys.stderr.isatty():
        yield lambda text: None
        return
    from rich.console import Console        # a quarter of a second that only a terminal waits for
    from rich.text import Text
    with Console(stderr=True).status('') as status:
        line = _Line(lambda text: status.update(Text(text)), status.console.width - _SPINNER)
        line.notify(first)
        _say_when_compiling(line)
        try:
            yield line.notify
        finally:
            line.close()


@contextmanager
def starting(command: str) -> Iterator[None]:
    """
    Say on a terminal that a command is being started, where that takes its time.

    Its libraries are being read, so no other one is read for this line.
    """
    if not sys.stderr.isatty():
        yield
        return
    said: list[str] = []

    def say(text: str) -> None:
        said.append(text)
        sys.stderr.write(text)
        sys.stderr.flush()
    slow = Timer(_AT_ONCE, say, [f'  starting hda {command}'])
    slow.daemon = True
    slow.start()
    try:
        yield
    finally:
        slow.cancel()
        slow.join()
        if said:
            say(_ERASED)


class _Line:
    """The line as it stands: what is being done, or that something is compiled for it."""

    def __init__(self, show: Notify, width: int) -> None:
        self._show, self._width, self._closed = show, width, False

    def notify(self, text: str) -> None:
        """Show what is being done, in one line."""
        said = printable(text)
        if not self._closed:
            self._show(said if len(said) <= self._width else f'{said[:self._width - 4]} ...')

    def close(self) -> None:
        """Show nothing any more."""
        self._closed = True


def _say_when_compiling(line: _Line) -> None:
    from hda_arm_sim.foundation.compiled import say_when_compiling
    say_when_compiling(line.notify)


def how_far(done: int, total: int, began: float) -> str:
    """Return `12 of 40, 3 min left` for work that began at a monotonic time [s]."""
    said = f'{done} of {total}'
    if not 0 < done < total:
        return said
    return f'{said}, {duration((time.monotonic() - began) / done * (total - done))} left'


def duration(seconds: float) -> str:
    """Return a time [s] as people say it."""
    if seconds < _MINUTE:
        return f'{max(seconds, 1.0):.0f} s'
    if seconds < _HOUR:
        return f'{seconds / _MINUTE:.0f} min'
    hours, minutes = divmod(round(seconds / _MINUTE), 60)
    return f'{hours} h {minutes} min'
