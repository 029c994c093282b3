"""`hda diagnose --each`: every bag a diagnosis of its own, and one table of them all."""

import argparse
from collections.abc import Callable, Sequence
import os
from pathlib import Path
from typing import NamedTuple

from hda_msgs_json.bag_files import ENDINGS, METADATA_FILE
from hda_msgs_json.errors import HdaError

from .outcome import Outcome
from .whole_directory import check_directory, whole_directory, write_json
from ..fleet.fleet_report import fleet_document, fleet_page, Line, line_of
from ..fleet.spread import over_machines, over_processes
from ..told_errors import ToldErrors
from ..version import version

Diagnose = Callable[[argparse.Namespace], Outcome]
OWN = ('--workers', '--scheduler')      # options that need --each


class FleetError(HdaError):
    """Bags that cannot be diagnosed as a fleet."""


class Job(NamedTuple):
    """One bag and how to diagnose it; it travels to wherever the work is done."""

    diagnose: Diagnose
    options: argparse.Namespace
    bag: Path
    directory: str


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument('--each', action='store_true',
                        help='diagnose every BAG on its own, or every bag in a directory of bags; '
                             'DIR holds one directory each, fleet.json and fleet.html')
    parser.add_argument('--workers', type=int, metavar='N',
                        help='processes that --each uses, as many as cores if not given')
    parser.add_argument('--scheduler', metavar='ADDRESS',
                        help='Dask scheduler whose workers --each uses; they must see the same '
                             'files')


def check(options: argparse.Namespace) -> None:
    """Raise FleetError for options that need --each."""
    for name in OWN:
        if not options.each and getattr(options, name[2:]) is not None:
            raise FleetError(f'{name} spreads the diagnoses of --each; a joint diagnosis of all '
                             'bags runs here')


def execute(diagnose: Diagnose, options: argparse.Namespace) -> Outcome:
    """Diagnose every bag and write the table; raises FleetError if none could be diagnosed."""
    bags = _named([bag for path in options.bags for bag in bags_in(path)])
    check_directory(options.out, force=options.force, reads=bags.values())
    with whole_directory(options.out, force=options.force) as partial:
        lines = _lines([_job(diagnose, options, bag, name, partial)
                        for name, bag in bags.items()], options)
        told = fleet_document(lines, options.arm, version())
        write_json(partial / 'fleet.json', told)
        (partial / 'fleet.html').write_text(fleet_page(lines, options.arm, version()),
                                            encoding='utf-8')
    return Outcome('\n'.join(line.sentence() for line in lines), told)


def bags_in(path: Path) -> list[Path]:
    """
    Return the bag at a path, or all bags in it if it is a directory of bags.

    A bag is a directory with `metadata.yaml`, or a loose .mcap or .db3 file. A directory of such
    files alone is one too: its recording was cut off. Raises FleetError where there is none.
    """
    if not path.is_dir() or (path / METADATA_FILE).exists():
        return [path]
    folders = [entry for entry in path.iterdir() if entry.is_dir() and (
        (entry / METADATA_FILE).exists() or _loose(entry))]
    loose = _loose(path)
    if not folders and len({_of_split(file) for file in loose}) == 1:
        return [path]
    found = sorted([*folders, *loose])
    if not found:
        raise FleetError(f'{path} holds no bags; name bags, or a directory of them')
    return found


def _loose(directory: Path) -> list[Path]:
    """Return the recorded files that stand in a directory."""
    return [file for ending in ENDINGS for file in directory.glob(f'*{ending}') if file.is_file()]


def _of_split(file: Path) -> str:
    """Return the name that the files of one split recording share: bag of bag_0.mcap."""
    stem, _, number = file.name.partition('.')[0].rpartition('_')
    return stem if stem and number.isdecimal() else file.name


def _named(bags: Sequence[Path]) -> dict[str, Path]:
    """Return bags by the names of their directories; raises FleetError where two have one."""
    named: dict[str, Path] = {}
    for bag in bags:
        name = Path(os.path.abspath(bag)).name.removesuffix('.mcap')
        if name in named:
            raise FleetError(f'{named[name]} and {bag} would both be written to {name}; give one '
                             'of them another name')
        named[name] = bag
    return named


def _job(diagnose: Diagnose, options: argparse.Namespace, bag: Path, name: str,
         out: Path) -> Job:
    """Return the work on one bag."""
    own = argparse.Namespace(**{**vars(options), 'bags': [bag.absolute()], 'each': False,
                                'workers': None, 'scheduler': None,
                                'out': out.absolute() / name})
    return Job(diagnose, own, bag, name)


def _lines(jobs: Sequence[Job], options: argparse.Namespace) -> list[Line]:
    """Return the line of every bag; raises FleetError where no bag could be diagnosed."""
    lines = (over_processes(line, jobs, options.workers, failed=failed)
             if options.scheduler is None else
             over_machines(line, jobs, options.scheduler, failed=failed))
    if all(one.error is not None for one in lines):
        raise FleetError(f'none of {len(lines)} bags could be diagnosed; the first: '
                         f'{lines[0].error}')
    return lines


def line(job: Job) -> Line:
    """Return the line of one bag; what is wrong with it is its line and stops no other."""
    with ToldErrors() as told:
        return line_of(str(job.bag), job.directory, job.diagnose(job.options).report)
    return failed(job, told.sentence or '')


def failed(job: Job, reason: str) -> Line:
    """Return the line of a bag that could not be diagnosed."""
    return Line(str(job.bag), job.directory, None, error=reason)
