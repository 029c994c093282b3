"""Where the diagnoses of a fleet go: all anew, or added to those that are there already."""

import argparse
from collections.abc import Sequence
from contextlib import suppress
import hashlib
import json
import os
from pathlib import Path
import shutil
import time
from types import TracebackType

from hda_arm_sim.model.files import shipped_arms
from hda_msgs_json.outputs import OutputError, whole_file, WholeDirectory

from .bag_option import NAMING
from ..fleet.fleet_page import fleet_page
from ..fleet.fleet_report import fleet_document, SCHEMA
from ..fleet.lines import BagLine, line_from
from ..version import version

FLEET_FILE, PAGE = 'fleet.json', 'fleet.html'
EVERY = 10.0            # time between two notes of what is done (choice) [s]
_MATTERS = ('about', 'degrees', 'motor_at_link', 'flip', *NAMING)   # for a diagnosis


class FleetOut:
    """
    Collect lines within a `with` statement, and write the tables; diagnoses go to `place`.

    Anew everything appears whole or not at all. An update writes down every few seconds what is
    done, so that one that is cut off goes on from there. Raises OutputError.
    """

    def __init__(self, out: Path, arm: str, *, force: bool, update: bool,
                 skipped: Sequence[str] = ()) -> None:
        """Find out what is there already."""
        self._out, self._arm, self._skipped = out, arm, skipped
        self._whole = None if update else _whole_directory(out, force)
        self._made = update and not os.path.lexists(out)
        self._lines = _known(out) if update else {}
        self._noted = time.monotonic()
        self.place = out if self._whole is None else self._whole.partial
        self.fresh = 0

    def __enter__(self) -> 'FleetOut':
        """Begin to collect."""
        self.place.mkdir(parents=True, exist_ok=True)
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        """Give the directory its name, or leave nothing of it."""
        if self._whole is not None:
            self._whole.keep() if error is None else self._whole.drop()
        elif error is not None and self._made and not self.has_diagnoses:
            shutil.rmtree(self._out, ignore_errors=True)

    @property
    def has_diagnoses(self) -> bool:
        """Return whether any recording could be diagnosed."""
        return any(line.error is None for line in self._lines.values())

    def knows(self, directory: str, state: str) -> bool:
        """Return whether a diagnosis stands that depends on just the same."""
        line = self._lines.get(directory)
        return line is not None and line.state == state and (
            line.error is not None or (self._out / directory / 'report.json').is_file())

    def add(self, line: BagLine) -> None:
        """Take the line of a recording in the place of an older one."""
        self._lines[line.directory] = line
        self.fresh += 1
        if self._whole is None and time.monotonic() - self._noted > EVERY:
            self._note()

    def finish(self) -> list[BagLine]:
        """Write the tables, and return all lines in the order of their directories."""
        self._note()
        lines = self._sorted()
        page = fleet_page(lines, self._arm, version(), self._skipped)
        with whole_file(self.place / PAGE, force=True) as stream:
            stream.write(page)
        return lines

    def _note(self) -> None:
        document = fleet_document(self._sorted(), self._arm, version(), self._skipped)
        with whole_file(self.place / FLEET_FILE, force=True) as stream:
            stream.write(json.dumps(document, indent=1, allow_nan=False) + '\n')
        self._noted = time.monotonic()

    def _sorted(self) -> list[BagLine]:
        return [line for _, line in sorted(self._lines.items())]


def state_of(bag: Path, arm: str, options: argparse.Namespace) -> str:
    """Return a digest of what a diagnosis depends on: bag, arm file, options and version."""
    digest = hashlib.sha256(repr([version(), [getattr(options, name, None) for name in _MATTERS]]
                                 ).encode())
    files = sorted(bag.iterdir()) if bag.is_dir() else [bag]
    for file in files:
        with suppress(OSError):
            about = file.stat()
            digest.update(repr((file.name, about.st_size, about.st_mtime_ns)).encode())
    is_shipped = arm in shipped_arms() and not Path(arm).is_file()
    with suppress(OSError):
        digest.update(arm.encode() if is_shipped else Path(arm).read_bytes())
    return digest.hexdigest()[:16]


def _whole_directory(out: Path, force: bool) -> WholeDirectory:
    try:
        return WholeDirectory(out, force=force)
    except OSError as error:
        raise OutputError(f'{out} cannot be written: {error.strerror or error}') from None


def _known(out: Path) -> dict[str, BagLine]:
    """Return the lines of a fleet by their directories; raises OutputError for what is none."""
    if not os.path.lexists(out) or (out.is_dir() and not any(out.iterdir())):
        return {}
    try:
        document = json.loads((out / FLEET_FILE).read_text(encoding='utf-8'))
        if document['schema'] != SCHEMA:
            raise ValueError
        return {line['directory']: line_from(line) for line in document['bags']}
    except (OSError, ValueError, LookupError, TypeError):
        raise OutputError(f'{out} holds no {FLEET_FILE} of {SCHEMA} that --update could add to; '
                          'name another place') from None
