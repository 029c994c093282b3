"""Any error of a command becomes one sentence for its user, here and nowhere else."""

from contextlib import AbstractContextManager
import os
import traceback
from types import TracebackType

from hda_msgs_json.errors import HdaError
from hda_msgs_json.printable import one_line

DEBUG = 'HDA_DEBUG'
"""What is set in the environment to see the traceback of every error as well."""


class OneLineErrors(AbstractContextManager['OneLineErrors']):
    """
    End a `with` statement at an error, and keep the sentence that explains it in `sentence`.

    What is no mistake of anybody, as an interrupt or an exit, goes on.
    """

    sentence: str | None = None

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> bool:
        """Take the error, unless it asks to end the process."""
        if not isinstance(error, Exception):
            return False
        if os.environ.get(DEBUG):
            traceback.print_exception(error)
        self.sentence = sentence(error)
        return True


def sentence(error: Exception) -> str:
    """Return what is said of an error: its own words, or what it is where nobody foresaw it."""
    words = one_line(str(error))
    if isinstance(error, HdaError):
        return words
    if isinstance(error, MemoryError):
        return f'it needs more memory than there is{": " * bool(words)}{words}'
    if isinstance(error, OSError) and error.strerror:
        place = '' if error.filename is None else f'{error.filename}: '
        return one_line(f'{place}{error.strerror}')
    return (f'an unforeseen {type(error).__name__}{": " * bool(words)}{words}; '
            f'{DEBUG}=1 before the command shows where')
