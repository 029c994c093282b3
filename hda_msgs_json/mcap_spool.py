"""Records that wait for the end of a file, on disk: a recording of hours has very many."""

from collections.abc import Iterator
from pathlib import Path
import tempfile
from typing import BinaryIO

MOST_HELD = 1 << 16         # what stays in memory [bytes]
PIECE = 1 << 20


class Spool:
    """
    Keep pieces in their order in a file that has no name, so that a kill leaves none behind.

    What the disk does not take stays in memory: nothing is ever lost or raised here.
    """

    def __init__(self, directory: Path) -> None:
        """Use a file in this directory, when there is more than fits in memory."""
        self.count = 0
        self._directory = directory
        self._held = bytearray()
        self._file: BinaryIO | None = None
        self._stored = 0

    def add(self, piece: bytes) -> None:
        """Keep one more piece."""
        self.count += 1
        self._held += piece
        if len(self._held) >= MOST_HELD:
            self._store()

    def __iter__(self) -> Iterator[bytes]:
        """Yield the bytes of all pieces in their order, cut anywhere."""
        if self._file is not None:
            self._file.seek(0)
            for start in range(0, self._stored, PIECE):
                yield self._file.read(min(PIECE, self._stored - start))
        yield bytes(self._held)

    def close(self) -> None:
        """Give the file back."""
        if self._file is not None:
            self._file.close()
            self._file = None

    def _store(self) -> None:
        """Move what is held to the file, all of it or, if the disk is full, nothing."""
        try:
            if self._file is None:
                self._file = _unnamed(self._directory)
            self._file.seek(self._stored)
            left = memoryview(bytes(self._held))
            while left:
                left = left[self._file.write(left):]
        except OSError:
            return
        self._stored += len(self._held)
        self._held.clear()


def _unnamed(directory: Path) -> BinaryIO:
    return tempfile.TemporaryFile(dir=directory, buffering=0)
