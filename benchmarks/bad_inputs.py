"""
Thousands of bad inputs into the commands: models, maps, tables, effects, bags, arguments.

Each is one line and exit code 2, or is taken. Counted is what must not be: tracebacks, hangs,
crashes, and files of others that were touched. The inputs follow from seeds.
"""

import argparse
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import redirect_stderr, redirect_stdout
import faulthandler
from importlib import import_module
import io
from multiprocessing import get_context
from multiprocessing.connection import Connection
import os
from pathlib import Path
import resource
import sys
from tempfile import TemporaryDirectory
import time
from typing import NamedTuple

from hda_torque_estimator.cli import COMMANDS, main as hda
from hostile_inputs import KINDS, Place
import numpy as np

MANY, FEW = 5400, 60            # inputs tried, and with --quick
PATIENCE = 60.0                 # processor time of one input: more is a hang [s]
WAITING = 600.0                 # and time on a clock, for a machine that is busy [s]
MEMORY = 6 << 30                # addresses of the process that reads them [bytes]
BATCH = 100                     # inputs of one process
OTHERS = 'what somebody else has written'


class Case(NamedTuple):
    """One bad input: what it is of, and the seed that makes it."""

    kind: str
    seed: int


class Ended(NamedTuple):
    """How a command ended on it."""

    code: int
    lines: int
    wrong: str = ''


def options() -> argparse.Namespace:
    """Return what was asked for on the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--quick', action='store_true', help='a few, to see that it runs')
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--inputs', type=int, default=MANY, help=f'{MANY} unless given')
    return parser.parse_args()


def main() -> int:
    """Try all inputs, print what came of them, and return 1 where one did harm."""
    asked = options()
    begin = time.monotonic()
    count = FEW if asked.quick else asked.inputs
    cases = [Case(list(KINDS)[number % len(KINDS)], asked.seed * 1_000_000 + number)
             for number in range(count)]
    found, by_kind = counted(cases)
    print(f'bad inputs tried             {count}'
          f' ({", ".join(f"{many} {kind}" for kind, many in by_kind.items())})')
    print(f'  refused / taken            {found["refused"]} / {found["taken"]}')
    for wrong in WRONGS:
        print(f'  {wrong:<26} {found[wrong]}')
    print(f'  seconds                    {time.monotonic() - begin:.0f}')
    return int(any(found[wrong] for wrong in WRONGS))


def counted(cases: list[Case]) -> tuple[Counter[str], Counter[str]]:
    """Return how often inputs ended in which way, and how many of each kind were tried."""
    for command in COMMANDS:                # once, not again in each process
        import_module(f'hda_torque_estimator.commands.{command}_command')
    found: Counter[str] = Counter()
    by_kind: Counter[str] = Counter()
    for case, ended in tried(cases):
        by_kind[case.kind] += 1
        if (done := by_kind.total()) % BATCH == 0:
            print(f'{done} of {len(cases)}', file=sys.stderr, flush=True)
        found['refused'] += ended.code == 2
        found['taken'] += ended.code == 0
        found[ended.wrong] += 1
        if ended.wrong:
            print(f'{ended.wrong}: {case.kind} of seed {case.seed}', flush=True)
    return found, by_kind


WRONGS = ('tracebacks', 'unforeseen errors', 'other codes or lines', f'hangs over {PATIENCE:g} s',
          'crashes', 'files of others touched')
TRACEBACK, UNFORESEEN, OTHERWISE, HANG, CRASH, TOUCHED = WRONGS


def tried(cases: Sequence[Case]) -> Iterator[tuple[Case, Ended]]:
    """Yield how each case ended; a process that dies or hangs is followed by another."""
    waiting = list(cases)
    while waiting:
        here, there = get_context('fork').Pipe(duplex=False)
        process = get_context('fork').Process(target=serve, args=(there, waiting[:BATCH]))
        process.start()
        there.close()
        for case in waiting[:BATCH]:
            ended = heard(here, process.pid or 0)
            yield case, ended
            waiting.pop(0)
            if ended.wrong in (HANG, CRASH):
                break
        process.kill()
        process.join()


def heard(here: Connection, pid: int) -> Ended:
    """Return what a process says of a case, or that it hangs or has died."""
    begin, spent = time.monotonic(), processor_time(pid)
    while not here.poll(1.0):
        if (processor_time(pid) - spent > PATIENCE
                or time.monotonic() - begin > WAITING):
            return Ended(-1, 0, HANG)
    try:
        code, lines, wrong = here.recv()
    except EOFError:
        return Ended(-1, 0, CRASH)
    return Ended(code, lines, wrong)


def processor_time(pid: int) -> float:
    """Return the processor time that a process has spent [s]."""
    try:
        words = Path(f'/proc/{pid}/stat').read_text().rpartition(')')[2].split()
    except OSError:                         # it has ended
        return 0.0
    return (int(words[11]) + int(words[12])) / os.sysconf('SC_CLK_TCK')


def serve(there: Connection, cases: Sequence[Case]) -> None:
    """Try cases in this process, and say how each ended."""
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, resource.getrlimit(resource.RLIMIT_AS)[1]))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    for case in cases:
        faulthandler.dump_traceback_later(0.9 * WAITING)            # where it hangs
        there.send(tuple(judged(case)))
        faulthandler.cancel_dump_traceback_later()


def judged(case: Case) -> Ended:
    """Return how one input ended, in a folder of its own among files of others."""
    with TemporaryDirectory(prefix='hda_bad_') as folder:
        place = Place(Path(folder))
        (place.folder / 'others').mkdir()
        (place.folder / 'others' / 'notes.txt').write_text(OTHERS)
        (place.folder / 'notes.partial').write_text(OTHERS)
        words = KINDS[case.kind](np.random.default_rng(case.seed), place)
        before = contents(place)
        code, said = called(words)
        after = contents(place)
        wrong = _wrong(code, said)
        if any(after.get(name) != content for name, content in before.items()):
            wrong = TOUCHED
        return Ended(code, len(said.splitlines()), wrong)


def _wrong(code: int, said: str) -> str:
    if 'Traceback' in said:
        return TRACEBACK
    if ' an unforeseen ' in said:
        return UNFORESEEN
    if code not in (0, 2) or len(said.splitlines()) != (code == 2):
        return OTHERWISE
    return ''


def called(words: Sequence[str]) -> tuple[int, str]:
    """Return the exit code of a command, and what it says on stderr."""
    said = io.StringIO()
    with redirect_stdout(io.StringIO()), redirect_stderr(said):
        try:
            code = hda(words)
        except SystemExit as stop:
            code = stop.code if isinstance(stop.code, int) else 1
    return code, said.getvalue()


def contents(place: Place) -> dict[Path, bytes]:
    """Return every plain file below a place, but for what the command was asked to write."""
    return {path: path.read_bytes() for path in place.folder.rglob('*')
            if path.is_file() and not path.is_symlink() and place.out not in path.parents}


if __name__ == '__main__':
    sys.exit(main())
