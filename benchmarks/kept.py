"""Studies that can be stopped: outcomes are kept as lines of JSON as they come."""

from collections.abc import Callable, Sequence
from concurrent.futures import as_completed, ProcessPoolExecutor
from itertools import islice
import json
from pathlib import Path
import time
from typing import Any, TypeVar

Outcome = dict[str, Any]
Case = TypeVar('Case')


def kept_in(path: Path) -> dict[str, Outcome]:
    """Return the outcomes that a file keeps, by their cases."""
    lines = path.read_text(encoding='utf-8').splitlines() if path.exists() else []
    return {result['case']: result for result in map(json.loads, lines)}


def study(todo: Sequence[Case], outcome: Callable[[Case], Outcome], path: Path, *, workers: int,
          limit: float) -> None:
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
