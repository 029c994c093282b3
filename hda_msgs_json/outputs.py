"""
Outputs that appear whole or not at all, and never in the place of what somebody else made.

What is written goes to a new name in the same folder, opened exclusively, and is renamed at the
end. What stands at the place is refused unless `force` is given; a link is replaced, never
followed.
"""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
import os
from pathlib import Path
from secrets import token_hex
import shutil
from typing import TextIO

from hda_msgs_json.errors import HdaError

ELSEWHERE = 'name another place, or say --force to replace it'
SIGNED = {
    **dict.fromkeys(('report.json', 'fleet.json', 'compare.json', 'paper.json'),
                    b'"schema": "hda.'),
    'metadata.yaml': b'made_by: hda_torque_estimator'}
"""What one of its files says in every directory that this package writes."""
SUFFIXES = {'.html', '.json', '.mcap', '.png', '.svg', '.yaml'}
"""And what all of its files are."""
LONGEST_METADATA = 1 << 20
LONGEST_NAME = 40       # of the place in the new name: file names have 255 bytes at most


class OutputError(HdaError):
    """A place where nothing may be written, or a disk that does not take it."""


class WholeDirectory:
    """A new directory, `partial`, beside the place that it takes when it is kept."""

    def __init__(self, path: Path, *, force: bool = False) -> None:
        """Make the directory; raises OutputError where the place is taken, or OSError."""
        self.path, self._force = _place(path), force
        check_directory(path, force=force)
        self.partial = _beside(self.path)
        self._parents = [one for one in self.path.parents if not os.path.lexists(one)]
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self.partial.mkdir()
        except OSError:
            self.drop()
            raise

    def keep(self) -> None:
        """Give the directory its name; raises OutputError or OSError, and leaves it as it is."""
        if not self._force or not os.path.lexists(self.path):
            self.partial.rename(self.path)          # fails where somebody was quicker
            return
        check_directory(self.path, force=True)
        aside = _beside(self.path)
        self.path.rename(aside)
        try:
            self.partial.rename(self.path)
        except OSError:
            aside.rename(self.path)
            raise
        _remove(aside)

    def drop(self) -> None:
        """Leave nothing of the directory, nor of parents that were made for it."""
        _remove(self.partial)
        for parent in self._parents:
            with suppress(OSError):
                parent.rmdir()


@contextmanager
def whole_directory(path: Path, *, force: bool = False) -> Iterator[Path]:
    """
    Give a new directory that becomes `path` at the end and is gone on any error.

    Raises OutputError where the place is taken or the disk refuses.
    """
    with _errors_named(path):
        directory = WholeDirectory(path, force=force)
        try:
            yield directory.partial
            directory.keep()
        except BaseException:
            directory.drop()
            raise


@contextmanager
def whole_file(path: Path, *, force: bool = False) -> Iterator[TextIO]:
    """
    Give a new text file that becomes `path` at the end and is gone on any error.

    Raises OutputError where the place is taken or the disk refuses.
    """
    check_file(path, force=force)
    target = _place(path)
    partial = _beside(target)
    with _errors_named(path):
        try:
            with partial.open('x', encoding='utf-8', newline='') as stream:
                yield stream
            _keep_file(partial, target, force)
        finally:
            partial.unlink(missing_ok=True)


def check_file(path: Path, *, force: bool = False, reads: Iterable[Path] = ()) -> None:
    """Raise OutputError unless a file may appear at a path, which is none of what is read."""
    target = _place(path)
    if not os.path.lexists(target):
        return
    if not (target.is_symlink() or target.is_file()):
        raise OutputError(f'{path} is a directory or a device; name a file to write')
    if not force:
        raise OutputError(f'{path} exists; {ELSEWHERE}')
    _check_not_read(path, reads)


def check_directory(path: Path, *, force: bool = False, reads: Iterable[Path] = ()) -> None:
    """
    Raise OutputError unless a directory may appear at a path, which holds nothing that is read.

    An empty one may be there. With `force` also one that this package wrote, or a link.
    """
    target = _place(path)
    if not os.path.lexists(target) or _is_empty(target):
        return
    if not target.is_symlink() and not target.is_dir():
        raise OutputError(f'{path} exists and is a file; name another place for a directory')
    if not force:
        raise OutputError(f'{path} exists and is not empty; {ELSEWHERE}')
    _check_not_read(path, reads)
    if not target.is_symlink() and not _is_own(target):
        raise OutputError(f'{path} holds what hda has not written, so not even --force replaces '
                          'it; name another place')


def _place(path: Path) -> Path:
    """Return where an output goes, with the links in its folder but not of its own."""
    target = Path(os.path.abspath(path))
    if not target.name:
        raise OutputError(f'{path} cannot be written: it has no name')
    return target


def _check_not_read(path: Path, reads: Iterable[Path]) -> None:
    place = Path(os.path.realpath(path))
    for read in reads:
        resolved = Path(os.path.realpath(read))
        if place in (resolved, *resolved.parents):
            raise OutputError(f'{path} cannot be written: {read} is read from there')


def _is_empty(directory: Path) -> bool:
    return directory.is_dir() and not directory.is_symlink() and not any(directory.iterdir())


def _is_own(directory: Path) -> bool:
    """Return whether a directory holds a file that says so, and none of another kind."""
    found = [Path(place, name) for place, below, names in os.walk(directory)
             for name in (*names, *(link for link in below if Path(place, link).is_symlink()))]
    if any(file.is_symlink() or file.suffix not in SUFFIXES or not file.is_file()
           for file in found):
        return False
    return any(file.parent == directory and file.name in SIGNED
               and SIGNED[file.name] in _start_of(file) for file in found)


def _start_of(file: Path) -> bytes:
    with file.open('rb') as stream:
        return stream.read(LONGEST_METADATA)


def _keep_file(partial: Path, target: Path, force: bool) -> None:
    """Give a file its name; without `force` never in the place of another."""
    if not force:
        try:
            os.link(partial, target)                # fails where somebody was quicker
            return
        except FileExistsError:
            raise
        except OSError:                             # this disk has no hard links
            check_file(target)
    partial.replace(target)


def _beside(path: Path) -> Path:
    """Return a new, hidden name in the folder of a path."""
    return path.with_name(f'.{path.name[:LONGEST_NAME]}.{token_hex(4)}')


def _remove(place: Path) -> None:
    """Remove what stands at a place; a link goes, what it leads to stays."""
    if place.is_symlink() or place.is_file():
        place.unlink(missing_ok=True)
    else:
        shutil.rmtree(place, ignore_errors=True)


@contextmanager
def _errors_named(path: Path) -> Iterator[None]:
    """Turn what the disk refuses into OutputError."""
    try:
        yield
    except OSError as error:
        raise OutputError(f'{path} cannot be written: {error.strerror or error}') from None
