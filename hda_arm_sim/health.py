"""How a node is doing: what it refused and why, and a report that people and tools can read."""

from collections import Counter
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple

from hda_msgs_json.errors import HdaError

PAUSE = 2.0             # between two lines in the log about one reason [s]
FOREIGN = 10.0          # difference beyond which stamps are not of this machine's clock [s]


class Refused(HdaError):
    """A message that cannot be used: `reason` in a few words to count it by, and a sentence."""

    def __init__(self, reason: str, sentence: str) -> None:
        """Keep the reason apart from the sentence, which names values."""
        super().__init__(sentence)
        self.reason = reason


class Level(IntEnum):
    """How serious a report is; the numbers of diagnostic_msgs."""

    OK = 0
    WARN = 1
    ERROR = 2


@dataclass(frozen=True)
class Report:
    """What a node says of itself once a second."""

    level: Level
    message: str
    values: dict[str, object]


class Refusals:
    """Count what was refused by reason, and choose the few that are worth a line in the log."""

    def __init__(self, pause: float = PAUSE) -> None:
        """Let `pause` seconds go by between two lines about the same reason."""
        self.counts: Counter[str] = Counter()
        self._pause = pause
        self._last: dict[str, float] = {}
        self._reported = 0

    def add(self, reason: str, now: float) -> bool:
        """Count one; returns whether a line about it is due at `now` [s]."""
        self.counts[reason] += 1
        due = now - self._last.get(reason, -self._pause) >= self._pause
        if due:
            self._last[reason] = now
        return due

    def take_new(self) -> int:
        """Return how many were counted since this was asked before."""
        total = self.counts.total()
        new, self._reported = total - self._reported, total
        return new

    def values(self) -> dict[str, object]:
        """Return the counts as values of a report."""
        return {f'refused: {reason}': count for reason, count in sorted(self.counts.items())}


class Pace(NamedTuple):
    """How samples were answered."""

    rate: float                 # answers per second [Hz]
    work: float                 # mean time from message to answer [s]
    worst: float                # longest time from message to answer [s]
    latency: float              # mean time from stamp to answer [s]

    def values(self) -> dict[str, object]:
        """Return the numbers as values of a report."""
        known = abs(self.latency) < FOREIGN
        return {'rate [Hz]': self.rate,
                'work per sample, mean [us]': self.work * 1e6,
                'work per sample, worst [us]': self.worst * 1e6,
                'latency from the stamp [ms]':
                    self.latency * 1e3 if known else 'unknown: the stamps are of another clock'}


class Stopwatch:
    """Collect how samples were answered; all times are given, none is read."""

    def __init__(self, now: float) -> None:
        """Begin at `now` [s]."""
        self._begin(now)

    def _begin(self, now: float) -> None:
        self._since, self._count = now, 0
        self._work = self._worst = self._latency = 0.0

    def add(self, work: float, latency: float) -> None:
        """Take one answer: seconds from its message, and from its stamp."""
        self._count += 1
        self._work += work
        self._worst = max(self._worst, work)
        self._latency += latency

    def take(self, now: float) -> Pace:
        """Return the pace since this was asked before, and begin anew."""
        count, seconds = max(self._count, 1), now - self._since
        pace = Pace(self._count / seconds if seconds > 0.0 else 0.0, self._work / count,
                    self._worst, self._latency / count)
        self._begin(now)
        return pace
