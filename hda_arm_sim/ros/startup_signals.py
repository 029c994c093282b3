"""Signals while a process starts: a compiler lets no handler run, so another thread ends it."""

import os
import signal
from threading import Event, Thread
from types import TracebackType

GRACE = 1.0         # in which a start that is nearly over ends as usual [s]


class EarlyEnd:
    """
    Watch for signals in another thread, while a `with` statement runs.

    The signals must have handlers. A process that does not come to the end of the statement soon
    after one has come ends at once. Nothing of it is worth closing yet.
    """

    def __init__(self, code: int) -> None:
        """End with this exit code."""
        self._code = code
        self._over = Event()

    def __enter__(self) -> None:
        """Begin to watch."""
        self._read, self._write = os.pipe()
        os.set_blocking(self._write, False)
        self._before = signal.set_wakeup_fd(self._write, warn_on_full_buffer=False)
        self._thread = Thread(target=self._watch, daemon=True)
        self._thread.start()

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        """Watch no more."""
        self._over.set()
        signal.set_wakeup_fd(self._before)
        os.write(self._write, bytes(1))
        self._thread.join()
        os.close(self._read)
        os.close(self._write)

    def _watch(self) -> None:
        os.read(self._read, 1)
        if not self._over.wait(GRACE):
            os._exit(self._code)
