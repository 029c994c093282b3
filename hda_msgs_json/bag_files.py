"""The files of a recording: what metadata.yaml names, or what is there if it is missing."""

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

from hda_msgs_json.bag_sqlite import is_sqlite, to_mcap
from hda_msgs_json.errors import HdaError
from hda_msgs_json.mcap_chunk import expand_file
from hda_msgs_json.mcap_records import BagError
from hda_msgs_json.yaml_text import yaml_document

METADATA_FILE = 'metadata.yaml'
LARGEST_METADATA = 1 << 20
"""Bytes: what some thousand files of a split bag need, and what YAML reads in 20 s."""
COMPRESSED = '.zstd'
ENDINGS = ('.mcap', '.db3', f'.mcap{COMPRESSED}', f'.db3{COMPRESSED}')


class BagFiles(NamedTuple):
    """Hold the MCAP files of a recording in their order, and what is wrong with it."""

    paths: list[Path]
    warnings: list[str]
    expanded: TemporaryDirectory[str] | None = None
    """Where copies of compressed and SQLite files are, as long as the recording is used."""


def find_files(path: Path) -> BagFiles:
    """Return the files of a rosbag2 directory or a loose file; raise BagError if there is none."""
    try:
        return _find(path)
    except OSError as error:
        raise BagError(f'{path} cannot be read: {error.strerror}') from None


def _find(path: Path) -> BagFiles:
    if path.name == METADATA_FILE:
        path = path.parent
    if not path.exists():
        raise BagError(f'there is no recording at {path}')
    if not path.is_dir():
        if not path.is_file():
            raise BagError(f'{path} is not a recording: it is neither a file nor a directory')
        return _opened([path], [])
    try:
        listed = [path / Path(name).name for name in _listed(path)]
        missing = [file.name for file in listed if not file.is_file()]
        present = [file for file in listed if file.is_file()]
        warnings = [f'{METADATA_FILE} names files that are missing: {", ".join(missing)}'
                    ] if missing else []
    except _NoListError as error:
        # A pipe would be waited for, and a device has no end.
        files = filter(Path.is_file, [file for ending in ENDINGS
                                      for file in path.glob(f'*{ending}')])
        present, warnings = sorted(files, key=_natural), [str(error)]
    if not present:
        raise BagError(f'{path} is not a recording: it has no .mcap file, and no .db3')
    return _opened(present, warnings)


def _opened(paths: list[Path], warnings: list[str]) -> BagFiles:
    """Return the files, copies of compressed and SQLite ones in a temporary directory."""
    if not any(path.suffix == COMPRESSED or is_sqlite(path) for path in paths):
        return BagFiles(paths, warnings)
    directory = TemporaryDirectory(prefix='hda_bag_')
    copies = []
    for path in paths:
        copy = _expanded(path, Path(directory.name))
        if is_sqlite(copy):
            copy, found = to_mcap(copy, Path(directory.name))
            warnings += found
        copies.append(copy)
    return BagFiles(copies, warnings, directory)


def _expanded(path: Path, directory: Path) -> Path:
    """Return the file, or what it holds as a file in the directory if it was compressed."""
    if path.suffix != COMPRESSED:
        return path
    expand_file(path, directory / path.stem)
    return directory / path.stem


class _NoListError(HdaError):
    """Raised when metadata.yaml names no files."""


def _listed(directory: Path) -> list[str]:
    """Return the files that metadata.yaml names; raise _NoListError if it does not."""
    try:
        if not (directory / METADATA_FILE).is_file():
            raise FileNotFoundError
        with (directory / METADATA_FILE).open('rb') as stream:
            about: Any = yaml_document(stream.read(LARGEST_METADATA + 1).decode(),
                                       LARGEST_METADATA)
        about = about['rosbag2_bagfile_information']
        names = about['relative_file_paths']
    except FileNotFoundError:
        raise _NoListError(f'{METADATA_FILE} is missing') from None
    except (OSError, ValueError, LookupError, TypeError):
        raise _NoListError(f'{METADATA_FILE} is damaged') from None
    if not isinstance(names, list) or not all(
            isinstance(name, str) and name.isprintable() for name in names):
        raise _NoListError(f'{METADATA_FILE} is damaged')
    if len({Path(name).name for name in names}) < len(names):
        raise _NoListError(f'{METADATA_FILE} names a file more than once')
    return names


def _natural(path: Path) -> tuple[int, str]:
    """Return a key that sorts the files of a split bag by number: bag_2 before bag_10."""
    number = path.name.partition('.')[0].rpartition('_')[2]
    return (int(number) if number.isdecimal() else 0, path.name)
