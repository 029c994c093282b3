"""Work that a second thread does ahead of time: reading, compression, checksums."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

AHEAD = 2
"""Results that wait at most; each is about as large as a chunk."""

Item = TypeVar('Item')
Result = TypeVar('Result')


def ahead(work: Callable[[Item], Result], items: Iterable[Item]) -> Iterator[Result]:
    """
    Yield the results of work in the order of the items, some of them made ahead of time.

    It pays where the work is done by libraries that let other threads run.
    """
    waiting: deque[Future[Result]] = deque()
    with ThreadPoolExecutor(1) as executor:
        for item in items:
            waiting.append(executor.submit(work, item))
            if len(waiting) > AHEAD:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
