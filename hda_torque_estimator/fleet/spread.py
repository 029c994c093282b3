"""
Spread independent work over processes, or over machines with Dask.

Every item is worked on by the same function wherever it runs, and results come back in the order
of the items. So neither the number of workers nor where they are changes an answer. An item
that crashes its process, or asks for more memory than its share, ends no other. Processes fork
from a server that has imported what the work needs: to import it for each item takes seconds.
"""

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import as_completed, Future, ThreadPoolExecutor
from importlib import import_module
from multiprocessing import forkserver, get_context
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
import os
from pathlib import Path
import resource
import signal
from threading import Lock
from typing import Any, TypeVar

from hda_msgs_json.errors import HdaError

from ..error_sentences import OneLineErrors

Item = TypeVar('Item')
Result = TypeVar('Result')
PATIENCE = 10.0         # for a scheduler to answer [s]
RESERVED = 2 << 30      # addresses beside the share: libraries take 0.7 GiB, most of it unused
LEAST_SHARE = 1 << 30   # memory in which an ordinary recording is diagnosed [bytes]
CHILDREN = Lock()       # one thread at a time starts a process or asks how one ended
CONTAINER = ('/sys/fs/cgroup/memory.max', '/sys/fs/cgroup/memory/memory.limit_in_bytes')


class SpreadError(HdaError):
    """Workers that cannot be had, or that failed."""


def _refuse(item: object, reason: str) -> Any:
    """Raise SpreadError for an item whose worker failed."""
    raise SpreadError(f'{item}: {reason}')


def over_processes(work: Callable[[Item], Result], items: Sequence[Item],
                   workers: int | None = None, *,
                   failed: Callable[[Item, str], Result] = _refuse,
                   heard: Callable[[Result], None] | None = None,
                   needed: Sequence[str] = ()) -> list[Result]:
    """
    Return the results of all items, each from a process of its own.

    So many run at once, or as many as there are cores. `failed` makes the result of an item whose
    process failed, from the reason. `heard` gets every result as soon as it is there, in whatever
    order they come. `needed` are modules that are imported once for all. Raises SpreadError unless
    there is at least one worker.
    """
    count = min(os.cpu_count() or 1 if workers is None else workers, len(items))
    if workers is not None and workers < 1:
        raise SpreadError(f'--workers must be at least 1, got {workers}')
    share = max(machine_memory() // max(count, 1), LEAST_SHARE)
    _start_server([work.__module__, *needed])
    pool = ThreadPoolExecutor(max(count, 1))
    try:
        futures = [pool.submit(_apart, work, failed, share, item) for item in items]
        _hand_over(as_completed(futures), heard)
        return [future.result() for future in futures]
    finally:
        pool.shutdown(cancel_futures=True)


def _start_server(needed: list[str]) -> None:
    """
    Start the server that processes fork from, in a folder without files of the user.

    A module is looked for where the server starts, before anywhere else (until Python 3.13). So a
    file of the user's folder could stand in for one. The processes go back to that folder.
    """
    get_context('forkserver').set_forkserver_preload(needed)
    folder = os.open('.', os.O_RDONLY)
    try:
        os.chdir('/')
        forkserver.ensure_running()
    finally:
        os.fchdir(folder)
        os.close(folder)


def _hand_over(done: Iterable[Future[Result]],
               heard: Callable[[Result], None] | None) -> None:
    """Give `heard` each result as it comes; raises what the work has raised."""
    for future in done:
        result = future.result()
        if heard is not None:
            heard(result)


def machine_memory() -> int:
    """Return the memory of this machine, or of the container that we are in [bytes]."""
    limits = [Path(place).read_text().strip() for place in CONTAINER if Path(place).is_file()]
    return min([os.sysconf('SC_PAGE_SIZE') * os.sysconf('SC_PHYS_PAGES'),
                *(int(limit) for limit in limits if limit.isdecimal())])


def _apart(work: Callable[[Item], Result], failed: Callable[[Item, str], Result], share: int,
           item: Item) -> Result:
    """Return the result of one item from a process with its share of memory [bytes]."""
    context = get_context('forkserver')
    here, there = context.Pipe(duplex=False)
    process = context.Process(target=_work, args=(there, work, item, share), daemon=True)
    try:
        with CHILDREN:
            process.start()
    except OSError as error:
        return failed(item, f'no process could be started for it: {error.strerror}')
    there.close()
    try:
        sent = here.recv()
    except (EOFError, OSError):
        sent = None
    code = _exit_code(process)
    if sent is None:
        return failed(item, _end(code))
    result, reason = sent
    return result if reason is None else failed(item, reason)


def _exit_code(process: BaseProcess) -> int:
    """
    Wait until a process has ended, and return its code.

    Starting a process asks all others how they ended. The answer can be read once: two threads
    that ask at the same time would take it from each other, and one would be told 255.
    """
    wait([process.sentinel])
    with CHILDREN:
        process.join()
    return process.exitcode or 0


def _work(there: Connection, work: Callable[[Item], Result], item: Item, share: int) -> None:
    """Send the result of an item, or the reason why there is none."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    _, most = resource.getrlimit(resource.RLIMIT_AS)
    limit = RESERVED + share
    resource.setrlimit(resource.RLIMIT_AS, (limit if most < 0 else min(limit, most), most))
    errors = OneLineErrors()
    with errors:
        there.send((work(item), None))
    if errors.sentence is not None:
        there.send((None, errors.sentence))


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
    result as soon as it is there. Raises SpreadError where Dask is not installed or the scheduler
    does not answer.
    """
    dask = _dask()
    with _client(dask, scheduler) as client:
        futures = client.map(work, items, pure=False)
        places = {future.key: place for place, future in enumerate(futures)}
        found: dict[int, Result] = {}
        for future in dask.as_completed(futures, loop=client.loop):
            place, error = places[future.key], future.exception()
            found[place] = future.result() if error is None else failed(
                items[place], f'its worker failed: {error}')
            if heard is not None:
                heard(found[place])
        return [found[place] for place in range(len(items))]


def _dask() -> Any:
    """Return the package of the scheduler; raises SpreadError where it is not installed."""
    try:
        return import_module('distributed')
    except ImportError:
        raise SpreadError('--scheduler needs Dask, which is not installed; install the extra '
                          '"fleet", or leave the option away to use all cores here') from None


def _client(dask: Any, scheduler: str) -> Any:
    """Return a client of the scheduler at an address."""
    try:
        return dask.Client(scheduler, timeout=PATIENCE, set_as_default=False)
    except (OSError, TimeoutError, ValueError, TypeError):
        raise SpreadError(f'no Dask scheduler answers at {scheduler} within {PATIENCE:g} s; give '
                          'the address that `dask scheduler` prints, as tcp://HOST:8786'
                          ) from None
