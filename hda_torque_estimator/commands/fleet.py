"""`hda diagnose --each`: every bag a diagnosis of its own, and one table of them all."""

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from .outcome import Outcome
from .whole_directory import whole_directory, write_json
from ..fleet.fleet_report import fleet_document, fleet_page, Line, line_of
from ..fleet.spread import over_machines, over_processes
from ..version import version

Diagnose = Callable[[argparse.Namespace], Outcome]
OWN = ('--workers', '--scheduler')      # options that need --each


class FleetError(ValueError):
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
    if options.out.exists():
        raise FleetError(f'{options.out} exists; name another place for the diagnoses')
    bags = _named([bag for path in options.bags for bag in bags_in(path)])
    with whole_directory(options.out, FleetError) as partial:
        lines = _lines([_job(diagnose, options, bag, name, partial)
                        for name, bag in bags.items()], options)
        told = fleet_document(lines, options.arm, version())
        write_json(partial / 'fleet.json', told)
        (partial / 'fleet.html').write_text(fleet_page(lines, options.arm, version()),
                                            encoding='utf-8')
    return Outcome('\n'.join(line.sentence() for line in lines), told)


def bags_in(path: Path) -> list[Path]:
    """Return the bag at a path, or all bags in it if it is a directory of bags."""
    if not path.is_dir() or (path / 'metadata.yaml').exists() or any(path.glob('*.mcap')):
        return [path]
    found = sorted(entry.parent for entry in path.glob('*/metadata.yaml'))
    if not found:
        raise FleetError(f'{path} holds no bags; name bags, or a directory of them')
    return found


def _named(bags: Sequence[Path]) -> dict[str, Path]:
    """Return bags by the names of their directories; raises FleetError where two have one."""
    named: dict[str, Path] = {}
    for bag in bags:
        name = bag.name.removesuffix('.mcap')
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
    lines = (over_processes(line, jobs, options.workers) if options.scheduler is None else
             over_machines(line, jobs, options.scheduler))
    if all(one.error is not None for one in lines):
        raise FleetError(f'none of {len(lines)} bags could be diagnosed; the first: '
                         f'{lines[0].error}')
    return lines


def line(job: Job) -> Line:
    """Return the line of one bag; what is wrong with it is its line and stops no other."""
    try:
        return line_of(str(job.bag), job.directory, job.diagnose(job.options).report)
    except (ValueError, OSError) as error:
        return Line(str(job.bag), job.directory, None, error=' '.join(str(error).split()))
