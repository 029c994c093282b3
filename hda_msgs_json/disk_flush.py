"""Have the disk take a file without waiting for it: a crash spares what the kernel has."""

from concurrent.futures import Future, ThreadPoolExecutor
from io import FileIO
import os


class DiskPush:
    """
    Push what was written to a file towards the disk.

    A process that is killed loses nothing that was written, a machine that loses its power what
    was not pushed. Everything raises OSError where the disk did not take it.
    """

    def __init__(self, stream: FileIO) -> None:
        """Push what is written to this stream."""
        self._stream = stream
        self._executor: ThreadPoolExecutor | None = None
        self._running: Future[None] | None = None

    def begin(self) -> None:
        """Push in another thread, unless it is still at it; raise what the push before met."""
        if self._running is not None and not self._running.done():
            return
        self._settle()
        self._executor = self._executor or ThreadPoolExecutor(1, 'disk')
        self._running = self._executor.submit(os.fsync, self._stream.fileno())

    def complete(self) -> None:
        """Return when the disk has everything."""
        try:
            self._settle()
            os.fsync(self._stream.fileno())
        finally:
            self.end()

    def end(self) -> None:
        """Leave no thread behind."""
        if self._executor is not None:
            self._executor.shutdown()
            self._executor = None

    def _settle(self) -> None:
        running, self._running = self._running, None
        if running is not None:
            running.result()
