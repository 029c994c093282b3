"""The last few of something that takes long to find, by what it depends on."""

from collections.abc import Callable, Hashable
from typing import Generic, TypeVar

Kept = TypeVar('Kept')


class RecentCache(Generic[Kept]):
    """What was found or asked for last; what was not for longest is forgotten first."""

    def __init__(self, most: int) -> None:
        """Keep so many at most."""
        self._most = most
        self._kept: dict[Hashable, Kept] = {}

    def of(self, key: Hashable, find: Callable[[], Kept]) -> Kept:
        """Return what belongs to a key, found anew if it is not known."""
        found = self._kept.pop(key) if key in self._kept else find()
        self._kept[key] = found                         # the newest stands last
        if len(self._kept) > self._most:
            self._kept.pop(next(iter(self._kept)))
        return found
