"""`hda diagnose --each`: every bag a diagnosis of its own, and one table of them all."""

import argparse
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from datetime import datetime, timezone
import os
from pathlib import Path
import time
from typing import NamedTuple

from hda_arm_sim.model.files import read_arm
from hda_msgs_json.bag import open_recording
from hda_msgs_json.errors import HdaError
from hda_msgs_json.outputs import check_directory

from .fleet_bags import fleet_of, FleetBag, FleetError
from .fleet_out import FleetOut, state_of
from .fleet_table import ALARM, alarms, table_text
from .outcome import Outcome
from .progress import how_far, Notify, progress
from ..error_sentences import OneLineErrors
from ..fleet.fleet_report import fleet_document
from ..fleet.lines import BagLine, line_of
from ..fleet.spread import over_machines, over_processes
from ..version import version

Diagnose = Callable[[argparse.Namespace], Outcome]
OWN = ('--workers', '--scheduler', '--update', '--alarm')       # options that need --each
ALARMED = 3             # exit code of a fleet with an alarm
USUAL_ARM = 'default.yaml'      # of a folder of arms, for devices without a file of their own
EARLIEST = datetime(2000, 1, 1, tzinfo=timezone.utc)    # before it a clock was not set (choice)


class Job(NamedTuple):
    """One bag and how to diagnose it; it travels to wherever the work is done."""

    diagnose: Diagnose
    options: argparse.Namespace
    bag: FleetBag
    state: str


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    fleet = parser.add_argument_group('many recordings')
    fleet.add_argument('--each', action='store_true',
                       help='diagnose every BAG on its own, and every bag in folders below BAG; '
                            'the first folder names the device; ARM may be a folder of DEVICE.yaml'
                            f' and {USUAL_ARM}; DIR holds one directory each, fleet.json and '
                            'fleet.html')
    fleet.add_argument('--update', action='store_true',
                       help='with --each: add to DIR what is new or has changed')
    fleet.add_argument('--alarm', type=float, nargs='?', const=ALARM, metavar='TIMES',
                       help=f'with --each: exit code {ALARMED} if the latest recording of a '
                            'device cannot be diagnosed, or its simulation errs so many times as '
                            f'much as noise, {ALARM:g} unless given')
    fleet.add_argument('--workers', type=int, metavar='N',
                       help='processes that --each uses, as many as cores if not given')
    fleet.add_argument('--scheduler', metavar='ADDRESS',
                       help='Dask scheduler whose workers --each uses; they must see the same '
                            'files')


def check(options: argparse.Namespace) -> None:
    """Raise FleetError for options that need --each."""
    for name in OWN:
        if not options.each and getattr(options, name[2:]) not in (None, False):
            raise FleetError(f'{name} is for the diagnoses of --each; a joint diagnosis of all '
                             'bags runs here')


def execute(diagnose: Diagnose, options: argparse.Namespace) -> Outcome:
    """Diagnose every bag and write the table; raises FleetError if none could be diagnosed."""
    bags, skipped = fleet_of(options.bags, options.out)
    arms = {device: _arm_of(options.arm, device)
            for device in dict.fromkeys(bag.device for bag in bags)}
    if not options.update:
        check_directory(options.out, force=options.force, reads=[bag.path for bag in bags])
    with FleetOut(options.out, options.arm, force=options.force, update=options.update,
                  skipped=skipped) as out:
        jobs = [Job(diagnose, _own(options, bag, arms[bag.device], out.place), bag,
                    state_of(bag.path, arms[bag.device], options)) for bag in bags]
        new = [job for job in jobs if not out.knows(job.bag.directory, job.state)]
        with progress('reading', quiet=options.json) as notify:
            _diagnose_all(new, options, out, notify)
        lines = out.finish()
    document = fleet_document(lines, options.arm, version(), skipped)
    raised = alarms(lines, options.alarm)
    text = table_text(lines, skipped, raised, fresh=len(new))
    return Outcome(text, document if options.alarm is None else {**document, 'alarms': raised},
                   ALARMED if raised else 0)


def _arm_of(given: str, device: str) -> str:
    """Return the arm file of a device; raises FleetError or ArmError where there is none."""
    folder = Path(given)
    if not folder.is_dir():
        return given
    file = next((file for file in (folder / f'{device}.yaml', folder / USUAL_ARM)
                 if file.is_file()), None)
    if file is None:
        raise FleetError(f'{folder} has no arm file for {device}: add {device}.yaml, or '
                         f'{USUAL_ARM} for all devices without one')
    read_arm(str(file))                                 # before anything is diagnosed
    return str(file)


def _own(options: argparse.Namespace, bag: FleetBag, arm: str, out: Path) -> argparse.Namespace:
    """Return the options of the diagnosis of one bag."""
    return argparse.Namespace(**{
        **vars(options), 'bags': [bag.path.absolute()], 'each': False, 'workers': None,
        'scheduler': None, 'arm': os.path.abspath(arm) if Path(arm).exists() else arm,
        'out': out.absolute() / bag.directory, 'force': options.force or options.update})


def _diagnose_all(jobs: Sequence[Job], options: argparse.Namespace, out: FleetOut,
                  notify: Notify) -> None:
    """Add the line of every bag; raises FleetError where no bag could be diagnosed."""
    began = time.monotonic()

    def heard(made: BagLine) -> None:
        out.add(made)
        notify(f'diagnosing {how_far(out.fresh, len(jobs), began)}')

    notify(f'diagnosing {how_far(0, len(jobs), began)}')
    if options.scheduler is None:
        made = over_processes(line, jobs, options.workers, failed=failed, heard=heard,
                              needed=[job.diagnose.__module__ for job in jobs[:1]])
    else:
        made = over_machines(line, jobs, options.scheduler, failed=failed, heard=heard)
    if not out.has_diagnoses:
        first = next((one.error for one in made if one.error is not None), '')
        raise FleetError(f'none of {len(jobs)} bags could be diagnosed; the first: {first}')


def line(job: Job) -> BagLine:
    """Return the line of one bag; what is wrong with it is its line and stops no other."""
    with OneLineErrors() as errors:
        found = line_of(str(job.bag.path), job.bag.directory,
                        job.diagnose(job.options).report)
        return _about(found, job, date_of(job.bag.path))
    return failed(job, errors.sentence or '')


def failed(job: Job, reason: str) -> BagLine:
    """Return the line of a bag that could not be diagnosed."""
    return _about(BagLine(str(job.bag.path), job.bag.directory, None, error=reason), job,
                  date_of(job.bag.path))


def _about(made: BagLine, job: Job, date: str | None) -> BagLine:
    return replace(made, device=job.bag.device, date=date, arm=str(job.options.arm),
                   state=job.state)


def date_of(bag: Path) -> str | None:
    """Return when a recording began (UTC), None where its clock was not set."""
    with suppress(HdaError, OSError, OverflowError, ValueError):
        topics = open_recording(bag).topics.values()
        first = min((topic.first for topic in topics if topic.count), default=0)
        began = datetime.fromtimestamp(first * 1e-9, timezone.utc)
        if began > EARLIEST:
            return began.isoformat(timespec='seconds')
    return None
