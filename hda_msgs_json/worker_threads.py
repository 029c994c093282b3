"""Work that other threads do ahead of time: reading, compression, checksums, decoding."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from itertools import islice
import os
from typing import TypeVar

MOST_THREADS = 4
"""More threads than this wait for each other; every one of them holds about a chunk."""

Item = TypeVar('Item')
Result = TypeVar('Result')


def ahead(work: Callable[[Item], Result], items: Iterable[Item]) -> Iterator[Result]:
    """
    Yield the results of work in the order of the items, some of them made ahead of time.

    It pays where the work is done by libraries that let other threads run.
    """
    threads = max(1, min(MOST_THREADS, os.cpu_count() or 1))
    waiting: deque[Future[Result]] = deque()
    with ThreadPoolExecutor(threads) as executor:
        for item in items:
            waiting.append(executor.submit(work, item))
            if len(waiting) > threads:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()


def drawn_ahead(items: Iterator[Item], page: int, pages: int = 4) -> Iterator[Item]:
    """Yield items that one other thread draws, up to some pages of them ahead of time."""
    def draw() -> list[Item]:
        return list(islice(items, page))

    with ThreadPoolExecutor(1) as executor:
        waiting = deque(executor.submit(draw) for _ in range(pages))
        while drawn := waiting.popleft().result():
            waiting.append(executor.submit(draw))
            yield from drawn
