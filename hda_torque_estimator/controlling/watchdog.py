"""Notice when something that must keep coming has stopped."""


class Watchdog:
    """Expires a time after it was last fed; times are of a steady clock [s]."""

    def __init__(self, timeout: float) -> None:
        """Expire `timeout` seconds after the last feeding; never before the first."""
        self.timeout = timeout
        self._fed: float | None = None

    def wait_for(self, timeout: float) -> None:
        """Expire another time after the last feeding, from now on [s]."""
        self.timeout = timeout

    def feed(self, now: float) -> None:
        """Note that it came."""
        self._fed = now

    def forget(self) -> None:
        """Wait for a first feeding again."""
        self._fed = None

    def alive(self, now: float) -> bool:
        """Return whether it was fed, and lately."""
        return self._fed is not None and now - self._fed <= self.timeout

    def expired(self, now: float) -> bool:
        """Return whether it was fed, but not lately."""
        return self._fed is not None and now - self._fed > self.timeout
