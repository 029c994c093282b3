"""Whether everybody is there who should hear a recording from its first message on."""

from collections.abc import Mapping, Sequence


class Audience:
    """Judge numbers of subscribers by topic as they change; all times are given, none is read."""

    def __init__(self, needed: Sequence[str], settle_time: float) -> None:
        """Need a subscriber of these topics, of any without; then `settle_time` [s] no new one."""
        self._needed, self._settle_time = tuple(needed), settle_time
        self._counts: dict[str, int] = {}
        self._since = 0.0

    def complete(self, counts: Mapping[str, int], now: float) -> bool:
        """Return whether it is complete with these numbers at `now` [s]."""
        if self._counts != counts:
            self._counts, self._since = dict(counts), now
        return not self.missing() and now - self._since >= self._settle_time

    def missing(self) -> str:
        """Return what nobody hears yet, nothing if all is heard."""
        silent = [name for name in self._needed if not self._counts.get(name)]
        return ', '.join(silent) if self._needed else '' if any(
            self._counts.values()) else 'any of the topics'
