"""The messages of the last seconds, held in memory until somebody asks for them."""

from collections import deque
from typing import Generic, NamedTuple, TypeVar

MOST_BYTES = 256 << 20

Topic = TypeVar('Topic')


class Held(NamedTuple, Generic[Topic]):
    """Hold one message, and when it came [ns]."""

    topic: Topic
    log_time: int
    content: bytes


class HeldMessages(Generic[Topic]):
    """Hold messages for a time, as long as they are not too many."""

    def __init__(self, span: int, most_bytes: int = MOST_BYTES) -> None:
        """Hold what came within `span` [ns] before the last one."""
        self._span, self._most_bytes = span, most_bytes
        self._messages: deque[Held[Topic]] = deque()
        self._bytes = 0

    def __len__(self) -> int:
        """Return how many are held."""
        return len(self._messages)

    def add(self, message: Held[Topic]) -> None:
        """Hold one more, and forget what is too old or too much."""
        self._messages.append(message)
        self._bytes += len(message.content)
        oldest = message.log_time - self._span
        while self._messages and (self._messages[0].log_time < oldest
                                  or self._bytes > self._most_bytes):
            self._bytes -= len(self._messages.popleft().content)

    def take(self) -> list[Held[Topic]]:
        """Return all in their order, and hold none of them any more."""
        taken = list(self._messages)
        self._messages.clear()
        self._bytes = 0
        return taken
