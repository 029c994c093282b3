"""Call what may crash on damaged data in a process of its own, which alone ends then."""

from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from typing import ParamSpec, TypeVar

Given = ParamSpec('Given')
Result = TypeVar('Result')


def in_own_process(function: Callable[Given, Result], *arguments: Given.args,
                   **named: Given.kwargs) -> Result:
    """Return or raise what a function of a module does; raises ValueError where it crashes."""
    with ProcessPoolExecutor(1, get_context('spawn')) as pool:
        try:
            return pool.submit(function, *arguments, **named).result()
        except BrokenProcessPool:
            raise ValueError('its reader crashes on it, so it is damaged') from None
