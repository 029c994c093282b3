"""
Spread independent work over processes, or over machines with Dask.

Every item is worked on by the same function wherever it runs, and results come back in the order
of the items, so that neither the number of workers nor where they are changes an answer.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from importlib import import_module
from multiprocessing import get_context
import os
from typing import Any, TypeVar

Item = TypeVar('Item')
Result = TypeVar('Result')
PATIENCE = 10.0         # for a scheduler to answer [s]


class SpreadError(ValueError):
    """Workers that cannot be had."""


def over_processes(work: Callable[[Item], Result], items: Sequence[Item],
                   workers: int | None = None) -> list[Result]:
    """
    Return the results of all items, on so many processes, or as many as there are cores.

    Raises SpreadError unless there is at least one worker.
    """
    count = min(os.cpu_count() or 1 if workers is None else workers, len(items))
    if workers is not None and workers < 1:
        raise SpreadError(f'--workers must be at least 1, got {workers}')
    if count <= 1:
        return [work(item) for item in items]
    with ProcessPoolExecutor(count, mp_context=get_context('spawn')) as pool:
        return list(pool.map(work, items))


def over_machines(work: Callable[[Item], Result], items: Sequence[Item],
                  scheduler: str) -> list[Result]:
    """
    Return the results of all items, from the workers of a Dask scheduler.

    Raises SpreadError where Dask is not installed or the scheduler does not answer.
    """
    with _client(scheduler) as client:
        results: list[Result] = client.gather(client.map(work, items, pure=False))
    return results


def _client(scheduler: str) -> Any:
    """Return a client of the scheduler at an address."""
    try:
        dask = import_module('distributed')
    except ImportError:
        raise SpreadError('--scheduler needs Dask, which is not installed; install the extra '
                          '"fleet", or leave the option away to use all cores here') from None
    try:
        return dask.Client(scheduler, timeout=PATIENCE, set_as_default=False)
    except (OSError, TimeoutError, ValueError, TypeError):
        raise SpreadError(f'no Dask scheduler answers at {scheduler} within {PATIENCE:g} s; give '
                          'the address that `dask scheduler` prints, as tcp://HOST:8786'
                          ) from None
