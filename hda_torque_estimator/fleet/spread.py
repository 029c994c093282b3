"""
Spread independent work over processes, or over machines with Dask.

Every item is worked on by the same function wherever it runs, and results come back in the order
of the items. So neither the number of workers nor where they are changes an answer. An item
that crashes its process, or asks for more memory than its share, ends no other.
"""

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from importlib import import_module
from multiprocessing import get_context
from multiprocessing.connection import Connection
import os
from pathlib import Path
import resource
import signal
from typing import Any, TypeVar

from hda_msgs_json.errors import HdaError

from ..error_sentences import ToldErrors

Item = TypeVar('Item')
Result = TypeVar('Result')
PATIENCE = 10.0         # for a scheduler to answer [s]
RESERVED = 2 << 30      # addresses beside the share: libraries take 0.7 GiB, most of it unused
LEAST_SHARE = 1 << 30   # memory in which an ordinary recording is diagnosed [bytes]
CONTAINER = ('/sys/fs/cgroup/memory.max', '/sys/fs/cgroup/memory/memory.limit_in_bytes')


class SpreadError(HdaError):
    """Workers that cannot be had, or that failed."""


def _refuse(item: object, reason: str) -> Any:
    """Raise SpreadError for an item whose worker failed."""
    raise SpreadError(f'{item}: {reason}')


def over_processes(work: Callable[[Item], Result], items: Sequence[Item],
                   workers: int | None = None, *,
                   failed: Callable[[Item, str], Result] = _refuse,
                   heard: Callable[[Result], None] | None = None) -> list[Result]:
    """
    Return the results of all items, each from a process of its own.

    So many run at once, or as many as there are cores. `failed` makes the result of an item whose
    process failed, from the reason. `heard` gets every result as soon as those before it are
    there. Raises SpreadError unless there is at least one worker.
    """
    count = min(os.cpu_count() or 1 if workers is None else workers, len(items))
    if workers is not None and workers < 1:
        raise SpreadError(f'--workers must be at least 1, got {workers}')
    share = max(machine_memory() // max(count, 1), LEAST_SHARE)
    pool = ThreadPoolExecutor(max(count, 1))
    try:
        return _handed(pool.map(partial(_apart, work, failed, share), items), heard)
    finally:
        pool.shutdown(cancel_futures=True)


def _handed(results: Iterable[Result], heard: Callable[[Result], None] | None) -> list[Result]:
    """Return results; `heard` gets each as it comes."""
    found = []
    for result in results:
        found.append(result)
        if heard is not None:
            heard(result)
    return found


def machine_memory() -> int:
    """Return the memory of this machine, or of the container that we are in [bytes]."""
    limits = [Path(place).read_text().strip() for place in CONTAINER if Path(place).is_file()]
    return min([os.sysconf('SC_PAGE_SIZE') * os.sysconf('SC_PHYS_PAGES'),
                *(int(limit) for limit in limits if limit.isdecimal())])


def _apart(work: Callable[[Item], Result], failed: Callable[[Item, str], Result], share: int,
           item: Item) -> Result:
    """Return the result of one item from a process with its share of memory [bytes]."""
    context = get_context('spawn')
    here, there = context.Pipe(duplex=False)
    process = context.Process(target=_work, args=(there, work, item, share), daemon=True)
    try:
        process.start()
    except OSError as error:
        return failed(item, f'no process could be started for it: {error.strerror}')
    there.close()
    try:
        result, reason = here.recv()
    except (EOFError, OSError):
        process.join()
        result, reason = None, _end(process.exitcode or 0)
    process.join()
    return result if reason is None else failed(item, reason)


def _work(there: Connection, work: Callable[[Item], Result], item: Item, share: int) -> None:
    """Send the result of an item, or the reason why there is none."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    _, most = resource.getrlimit(resource.RLIMIT_AS)
    limit = RESERVED + share
    resource.setrlimit(resource.RLIMIT_AS, (limit if most < 0 else min(limit, most), most))
    told = ToldErrors()
    with told:
        there.send((work(item), None))
    if told.sentence is not None:
        there.send((None, told.sentence))


def _end(code: int) -> str:
    """Return how a process ended that sent nothing."""
    if code >= 0:
        return f'its process ended with {code}'
    name = signal.Signals(-code).name
    return f'its process was ended by {name}' + (
        ', as where memory runs out' if -code == signal.SIGKILL else '')


def over_machines(work: Callable[[Item], Result], items: Sequence[Item], scheduler: str, *,
                  failed: Callable[[Item, str], Result] = _refuse,
                  heard: Callable[[Result], None] | None = None) -> list[Result]:
    """
    Return the results of all items, from the workers of a Dask scheduler.

    `failed` makes the result of an item whose worker failed, from the reason. `heard` gets every
    result in its turn. Raises SpreadError where Dask is not installed or the scheduler does not
    answer.
    """
    with _client(scheduler) as client:
        futures = client.map(work, items, pure=False)
        return _handed((future.result() if (error := future.exception()) is None else
                        failed(item, f'its worker failed: {error}')
                        for item, future in zip(items, futures)), heard)


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
