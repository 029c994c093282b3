"""How a node is doing: what it refused and why, and a report that people and tools can read."""

from collections import Counter
from dataclasses import dataclass
from enum import IntEnum

PAUSE = 2.0             # between two lines in the log about one reason [s]


class Refused(ValueError):
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
        self._told: dict[str, float] = {}
        self._reported = 0

    def add(self, reason: str, now: float) -> bool:
        """Count one; returns whether a line about it is due at `now` [s]."""
        self.counts[reason] += 1
        due = now - self._told.get(reason, -self._pause) >= self._pause
        if due:
            self._told[reason] = now
        return due

    def take_new(self) -> int:
        """Return how many were counted since this was asked before."""
        total = self.counts.total()
        new, self._reported = total - self._reported, total
        return new

    def values(self) -> dict[str, object]:
        """Return the counts as values of a report."""
        return {f'refused: {reason}': count for reason, count in sorted(self.counts.items())}
