"""Which recordings a fleet has: bags at any depth, whose they are, and what holds none."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
import os
from pathlib import Path

from hda_msgs_json.bag_files import ENDINGS, METADATA_FILE
from hda_msgs_json.errors import HdaError

ROS1 = '.bag'
DEEPEST = 12            # folders below one that was named (choice)


class FleetError(HdaError):
    """Bags that cannot be diagnosed as a fleet."""


@dataclass(frozen=True)
class FleetBag:
    """A bag of a fleet: its device, and where its diagnosis goes, below that of the fleet."""

    path: Path
    device: str
    directory: str


@dataclass
class FoundBags:
    """What a search found: bags in order, and what holds no recording, in words."""

    bags: list[Path] = field(default_factory=list)
    skipped: list[str] = field(default_factory=list)


def fleet_of(paths: Sequence[Path], out: Path) -> tuple[list[FleetBag], list[str]]:
    """
    Return the bags at paths, or in the folders below them, and what was skipped, in words.

    A bag belongs to the device whose name the first folder has; without one, the folder that was
    named. The place of the output is no part of the fleet. Raises FleetError.
    """
    bags: list[FleetBag] = []
    skipped: list[str] = []
    for path in paths:
        found = search(path, [out])
        skipped += found.skipped
        bags += [_bag(path, one) for one in found.bags]
    _check_names(bags)
    return bags, skipped


def bags_in(path: Path) -> list[Path]:
    """
    Return the bag at a path, or all bags in the folders below it.

    A bag is a directory with `metadata.yaml`, or a loose .mcap or .db3 file. A directory of such
    files alone is one too: its recording was cut off. Raises FleetError where there is none.
    """
    return search(path).bags


def search(path: Path, besides: Iterable[Path] = ()) -> FoundBags:
    """Return the bags at and below a path, none in the folders `besides`; raises FleetError."""
    if not path.is_dir() or (path / METADATA_FILE).exists():
        return FoundBags([path])
    found = FoundBags()
    _look(path, found, {Path(os.path.realpath(one)) for one in besides}, 0)
    if not found.bags:
        raise FleetError(f'{path} holds no bags; name bags, or a directory of them')
    found.bags.sort()
    return found


def _look(folder: Path, found: FoundBags, seen: set[Path], depth: int) -> None:
    """Add what a folder holds; that it is no recording is noted."""
    real = Path(os.path.realpath(folder))
    if real in seen:                                    # the output, or a link that leads back
        return
    seen.add(real)
    try:
        entries = sorted(folder.iterdir())
    except OSError as error:
        found.skipped.append(f'{folder}: it cannot be read: {error.strerror}')
        return
    loose = [entry for entry in entries if entry.name.endswith(ENDINGS) and entry.is_file()]
    below = [entry for entry in entries if entry.is_dir() and not entry.name.startswith('.')]
    found.skipped.extend(f'{entry}: a bag of ROS 1; convert it to rosbag2 first'
                         for entry in entries if entry.suffix == ROS1)
    before = len(found.bags), len(found.skipped)
    if _is_bag(folder, loose, below):
        found.bags.append(folder)
        return
    found.bags.extend(loose)
    for entry in below:
        if depth < DEEPEST:
            _look(entry, found, seen, depth + 1)
    if len(found.bags) == before[0] and depth:
        del found.skipped[before[1]:]                   # one line for all that is below
        found.skipped.append(f'{folder}: no recording in it')


def _is_bag(folder: Path, loose: Sequence[Path], below: Sequence[Path]) -> bool:
    """Return whether a folder is one recording, whole or cut off."""
    if (folder / METADATA_FILE).exists():
        return True
    return not below and len({_of_split(file) for file in loose}) == 1


def _of_split(file: Path) -> str:
    """Return the name that the files of one split recording share: bag of bag_0.mcap."""
    stem, _, number = file.name.partition('.')[0].rpartition('_')
    return stem if stem and number.isdecimal() else file.name


def _bag(named: Path, path: Path) -> FleetBag:
    """Return a bag with its names, from the path that was named."""
    whole = Path(os.path.abspath(path))
    above = Path(os.path.abspath(named))
    parts = whole.relative_to(above).parts
    directory = '/'.join(parts or (whole.name,)).removesuffix('.mcap')
    if not parts:
        return FleetBag(path, whole.parent.name, directory)
    return FleetBag(path, parts[0] if len(parts) > 1 else above.name, directory)


def _check_names(bags: Sequence[FleetBag]) -> None:
    """Raise FleetError where two bags have one name, or one lies within another's directory."""
    taken: dict[str, Path] = {}
    for bag in bags:
        for name in _lineage(bag.directory):
            if name in taken:
                raise FleetError(f'{taken[name]} and {bag.path} would both be written to {name}; '
                                 'give one of them another name')
        taken[bag.directory] = bag.path


def _lineage(directory: str) -> Iterator[str]:
    """Yield a directory and all that it lies in."""
    parts = directory.split('/')
    return ('/'.join(parts[:count]) for count in range(len(parts), 0, -1))
