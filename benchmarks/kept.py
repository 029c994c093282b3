"""Studies that can be stopped: outcomes are kept as lines of JSON as they come."""

from argparse import Namespace
from collections.abc import Callable, Sequence
from concurrent.futures import as_completed, ProcessPoolExecutor
from itertools import islice
import json
from pathlib import Path
import time
from typing import Any, Protocol, TypeVar

import numpy as np

Outcome = dict[str, Any]


class Case(Protocol):
    """A record of a study."""

    @property
    def group(self) -> str:
        """Return the row of the table it belongs to."""

    def key(self) -> str:
        """Return what distinguishes it from all others."""


AnyCase = TypeVar('AnyCase', bound=Case)


def kept_in(path: Path) -> dict[str, Outcome]:
    """Return the outcomes that a file keeps, by their cases."""
    lines = path.read_text(encoding='utf-8').splitlines() if path.exists() else []
    return {result['case']: result for result in map(json.loads, lines)}


def outcomes(planned: Sequence[AnyCase], outcome: Callable[[AnyCase], Outcome],
             asked: Namespace, last: Sequence[str]) -> list[Outcome]:
    """
    Run what is left of a study as it is asked for, and return what is known of it by now.

    The order is drawn, so that a limited study sees all groups alike; some groups come last.
    """
    known = kept_in(asked.kept)
    order = np.random.default_rng(asked.first).permutation(len(planned))
    left = [planned[k] for k in order if planned[k].key() not in known]
    study(sorted(left, key=lambda case: case.group in last), outcome, asked.kept,
          workers=asked.workers, limit=asked.limit)
    known = kept_in(asked.kept)
    return [known[case.key()] for case in planned if case.key() in known]


def study(todo: Sequence[AnyCase], outcome: Callable[[AnyCase], Outcome], path: Path, *,
          workers: int, limit: float) -> None:
    """Add the outcomes of cases to a file, as long as the limit allows [s], 0 for no limit."""
    end = time.monotonic() + (limit or float('inf'))
    left = iter(todo)
    path.parent.mkdir(parents=True, exist_ok=True)
    with ProcessPoolExecutor(workers) as pool, path.open('a') as kept:
        running = {pool.submit(outcome, case) for case in islice(left, 2 * workers)}
        while running:
            done = next(as_completed(running))
            running.remove(done)
            kept.write(json.dumps(done.result()) + '\n')
            kept.flush()
            if time.monotonic() < end:
                running |= {pool.submit(outcome, case) for case in islice(left, 1)}
