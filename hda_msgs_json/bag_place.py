"""Where a bag is written: in its place from the start, or beside it until it is whole."""

from pathlib import Path

from hda_msgs_json.mcap_records import BagError
from hda_msgs_json.outputs import OutputError, WholeDirectory


def whole_directory(path: Path, force: bool) -> WholeDirectory:
    """Make the directory that will take the place of the path; raise BagError if it cannot."""
    try:
        return WholeDirectory(path, force=force)
    except OutputError as error:
        raise BagError(str(error)) from None
    except OSError as error:
        raise cannot_write(path, error) from None


def growing_directory(path: Path) -> Path:
    """Make the directory of a bag that grows in its place; raise BagError if it cannot."""
    try:
        if path.is_dir() and any(path.iterdir()):
            raise BagError(f'{path} exists and is not empty; name another place for the bag')
        if path.exists() and not path.is_dir():
            raise BagError(f'{path} is a file; a bag is a directory')
        path.mkdir(parents=True, exist_ok=True)
        return path
    except OSError as error:
        raise cannot_write(path, error) from None


def cannot_write(path: Path, error: OSError) -> BagError:
    """Return the error for what the disk says of a bag."""
    return BagError(f'{path} cannot be written: {error.strerror or error}')
