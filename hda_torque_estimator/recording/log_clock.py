"""At which time messages are recorded: by simulated time, if anybody publishes it."""

PATIENCE = 2_000_000_000        # with /clock, after the first message [ns]


class LogClock:
    """
    Choose the clock of a recording once, so that all of its times are of the same.

    Times are given, none is read. Simulated time is 0 as long as nobody has published it.
    """

    def __init__(self, *, simulated: bool) -> None:
        """Wait for simulated time at first, or never."""
        self.simulated = simulated
        self.gave_up = False
        self._first: int | None = None
        self._patience = PATIENCE

    def hurry(self) -> None:
        """Wait no more: the recording ends."""
        self._patience = 0

    def time(self, simulated: int, real: int) -> int | None:
        """Return the time of a message that comes now [ns], None while it cannot be known."""
        if not self.simulated:
            return real
        if simulated:
            return simulated
        self._first = real if self._first is None else self._first
        if real - self._first < self._patience:
            return None
        self.simulated, self.gave_up = False, True
        return real
