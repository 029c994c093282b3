"""Keep samples on an absolute schedule of real time, and know how well that goes."""

from typing import NamedTuple

LONGEST_LAG = 50_000_000        # behind the schedule, beyond which real time is given up [ns]
SHORTEST_TICK = 500_000         # between two calls; samples that are closer come together [ns]


class Punctuality(NamedTuple):
    """How well a schedule was kept since this was last asked."""

    rate: float                 # samples per second of real time [Hz]
    worst: float                # largest delay of a call [s]
    late: int                   # calls that a delay of others swallowed
    skipped: float              # real time that was given up [s]


class Schedule:
    """Say how many samples are due; times are of a steady clock [ns]."""

    def __init__(self, period: int, speed: float = 1.0) -> None:
        """Let a sample be due every `period` [ns] of an arm's time, `speed` times faster."""
        self._period = period / speed
        self.tick = round(max(self._period, SHORTEST_TICK))
        self._start: int | None = None
        self._made = 0
        self._asked, self._made_when_asked = 0, 0
        self._worst, self._late, self._skipped = 0.0, 0, 0.0

    def due(self, now: int) -> int:
        """
        Return how many samples to make now, and count them as made.

        To be called every `tick` [ns]. A delay below half a period goes unnoticed, a longer one
        is caught up, and one beyond `LONGEST_LAG` is given up.
        """
        if self._start is None:
            self._start = self._asked = now
        lag = now - self._start - self._made * self._period
        self._worst = max(self._worst, lag * 1e-9)
        self._late += int(max(lag, 0.0) // self.tick)
        if lag > LONGEST_LAG:
            self._start += round(lag)
            self._skipped += lag * 1e-9
            lag = 0.0
        count = max(int(lag / self._period + 1.5), 0)
        self._made += count
        return count

    def postpone(self, count: int) -> None:
        """Take back samples that were due but not made: they are due again."""
        self._made -= count

    def take_punctuality(self, now: int) -> Punctuality:
        """Return how well it went since this was asked before, and begin anew."""
        seconds = (now - self._asked) * 1e-9
        made = self._made - self._made_when_asked
        found = Punctuality(made / seconds if seconds > 0.0 else 0.0, self._worst, self._late,
                            self._skipped)
        self._asked, self._made_when_asked = now, self._made
        self._worst, self._late, self._skipped = 0.0, 0, 0.0
        return found


class Patience:
    """Say how long to wait for what is late; times are of a steady clock [ns]."""

    def __init__(self, longest: float) -> None:
        """Wait for `longest` [s] at most, each time."""
        self._longest = longest * 1e9
        self._since: int | None = None

    def waits(self, late: bool, now: int) -> bool:
        """Return whether to go on waiting, for something that is late or has come."""
        if not late:
            self._since = None
            return False
        if self._since is None:
            self._since = now
        return now - self._since < self._longest
