"""Messages handed over one after another, each when its time comes."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from threading import Condition
from time import monotonic_ns
from typing import Generic, Protocol, TypeVar

from .timeline import Timeline

LONGEST_WAIT = 1_000_000_000    # for anything, before looking again [ns]


class Timed(Protocol):
    """What has a log time [ns]."""

    @property
    def log_time(self) -> int:
        """Return the log time."""
        raise NotImplementedError


Message = TypeVar('Message', bound=Timed)


@dataclass(frozen=True)
class Outlets(Generic[Message]):
    """Where messages go, and where the log time goes every `period` of real time [ns]."""

    hand_over: Callable[[Message], None]
    publish_time: Callable[[int], None]
    period: int


class Playback(Generic[Message]):
    """
    Play messages in their order; one thread plays, others pause, step, change the rate, end.

    Messages of equal or earlier time than the one before follow it at once.
    """

    def __init__(self, read: Callable[[], Iterator[Message]], outlets: Outlets[Message], *,
                 rate: float = 1.0, paused: bool = False, loop: bool = False) -> None:
        """Draw the first message; `read` gives all of them, again for every loop."""
        self.played = 0
        self._read, self._outlets, self._loop = read, outlets, loop
        self._changed = Condition()
        self._timeline = Timeline(rate, paused=paused)
        self._tick = 0
        self._begun = self._ended = False
        self._messages = read()
        self._next = next(self._messages, None)

    @property
    def empty(self) -> bool:
        """Return whether there is no message to come."""
        return self._next is None

    @property
    def paused(self) -> bool:
        """Return whether time stands."""
        return self._timeline.paused

    @property
    def rate(self) -> float:
        """Return the log time per real time."""
        return self._timeline.rate

    @property
    def given_up(self) -> float:
        """Return the real time by which the rest comes later than it should [s]."""
        return self._timeline.given_up * 1e-9

    def play(self) -> bool:
        """Play until the end, or until asked to end; returns whether it was the end."""
        with self._changed:
            if self._next is not None:
                self._timeline.jump(self._next.log_time, monotonic_ns())
            self._begun = True
            while self._next is not None and not self._ended:
                now = monotonic_ns()
                self._publish_time(now, self._next)
                wait = min(self._due(self._next), self._tick, now + LONGEST_WAIT) - now
                if wait > 0:
                    self._changed.wait(wait * 1e-9)
                elif not self._timeline.paused:
                    self._timeline.forgive(self._next.log_time, now)
                    self._hand_over(self._next)
            return not self._ended

    def pause(self) -> None:
        """Stand still."""
        with self._changed:
            self._timeline.pause(monotonic_ns())
            self._changed.notify()

    def resume(self) -> None:
        """Play on."""
        with self._changed:
            self._timeline.resume(monotonic_ns())
            self._changed.notify()

    def run_at(self, rate: float) -> None:
        """Play at another rate."""
        with self._changed:
            self._timeline.run_at(rate, monotonic_ns())
            self._changed.notify()

    def step(self) -> Message | None:
        """Hand over the next message and return it; None unless begun and paused."""
        with self._changed:
            message = self._next
            if message is None or not (self._begun and self._timeline.paused):
                return None
            self._timeline.jump(message.log_time, monotonic_ns())
            self._hand_over(message)
            self._changed.notify()
            return message

    def end(self) -> None:
        """Have `play` return."""
        with self._changed:
            self._ended = True
            self._changed.notify()

    def _due(self, message: Message) -> int:
        """Return when a message is due, without end while time stands."""
        return self._tick + LONGEST_WAIT if self.paused else self._timeline.due(message.log_time)

    def _hand_over(self, message: Message) -> None:
        self._outlets.hand_over(message)
        self.played += 1
        following = next(self._messages, None)
        if following is None and self._loop:
            self._messages = self._read()
            if (following := next(self._messages, None)) is not None:
                self._timeline.jump(following.log_time, monotonic_ns())
        self._next = following

    def _publish_time(self, now: int, message: Message) -> None:
        """Publish the time if that is due, never beyond a message that is still to come."""
        if now >= self._tick:
            self._tick = max(self._tick + self._outlets.period, now)
            self._outlets.publish_time(min(self._timeline.time(now), message.log_time))
