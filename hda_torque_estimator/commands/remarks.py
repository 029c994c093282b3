"""What a command has to remark beside its result, held back until there is one."""

import logging
import sys

from hda_msgs_json.printable import one_line

_SOURCE = logging.getLogger('hda_arm_sim')


class Remarks(logging.Handler):
    """
    Hold what is remarked within a `with` statement; `show` prints it to stderr.

    A command that refuses its input says that alone, in one line.
    """

    def __init__(self) -> None:
        """Hold nothing yet."""
        super().__init__(logging.WARNING)
        self._held: list[str] = []

    def __enter__(self) -> 'Remarks':
        """Begin to hold."""
        _SOURCE.addHandler(self)
        return self

    def __exit__(self, *error: object) -> None:
        """Hold no more."""
        _SOURCE.removeHandler(self)

    def emit(self, record: logging.LogRecord) -> None:
        """Hold one remark."""
        self._held.append(one_line(record.getMessage()))

    def show(self) -> None:
        """Print every remark once."""
        held, self._held = self._held, []
        for remark in held:
            sys.stderr.write(f'{remark}\n')


def remark_on(line: str) -> None:
    """Remark something beside the result of a command, as reading an arm file does."""
    _SOURCE.warning(line)
