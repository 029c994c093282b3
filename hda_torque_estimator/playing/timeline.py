"""The time of a recording while it is played: it runs at a rate, or stands."""

LONGEST_LAG = 50_000_000        # beyond it time is given up: a burst would overrun queues [ns]


class Timeline:
    """Relate log times to a steady clock, both [ns]; no clock is read here."""

    def __init__(self, rate: float = 1.0, *, paused: bool = False) -> None:
        """Run at a rate from now on, unless paused; both times are 0."""
        self.paused, self.rate = paused, rate
        self.given_up = 0               # real time by which the rest comes later [ns]
        self._log = self._steady = 0

    def time(self, now: int) -> int:
        """Return the log time at a steady time."""
        return self._log if self.paused else self._log + round((now - self._steady) * self.rate)

    def due(self, log_time: int) -> int:
        """Return the steady time at which a log time comes if time runs on like this."""
        return self._steady + round((log_time - self._log) / self.rate)

    def jump(self, log_time: int, now: int) -> None:
        """Go on from another log time."""
        self._log, self._steady = log_time, now

    def pause(self, now: int) -> None:
        """Stand still."""
        self.jump(self.time(now), now)
        self.paused = True

    def resume(self, now: int) -> None:
        """Run on."""
        self.jump(self.time(now), now)
        self.paused = False

    def run_at(self, rate: float, now: int) -> None:
        """Run at another rate from now on."""
        self.jump(self.time(now), now)
        self.rate = rate

    def forgive(self, log_time: int, now: int) -> None:
        """Go on from a log time that has come too long ago to catch up."""
        if (lag := now - self.due(log_time)) > LONGEST_LAG:
            self.given_up += lag
            self.jump(log_time, now)
