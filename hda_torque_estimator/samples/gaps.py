"""Count samples that never came, from the stamps of those that did."""

# Choices unless stated otherwise.
_OUTLIER = 1.5          # of the usual period: beyond it something is missing
_SHARE = 0.05           # of each new period in the usual one
_PATIENCE = 10          # outliers in a row after which they are what is usual


class Gaps:
    """Learn the usual period of stamps and count what is missing between them."""

    def __init__(self) -> None:
        """Know nothing yet."""
        self.lost = 0                   # samples that never came
        self.longest = 0                # time between two samples [ns]
        self._last: int | None = None
        self._usual = 0.0
        self._outliers = 0

    def add(self, stamp: int) -> None:
        """Take the stamp [ns] of the next sample, later than that of the last one."""
        last, self._last = self._last, stamp
        if last is None:
            return
        period = stamp - last
        self.longest = max(self.longest, period)
        if not self._usual or self._outliers >= _PATIENCE:
            self._usual, self._outliers = float(period), 0
        elif period > _OUTLIER * self._usual:
            self.lost += round(period / self._usual) - 1
            self._outliers += 1
        else:
            self._usual += _SHARE * (period - self._usual)
            self._outliers = 0

    def restart(self) -> None:
        """Expect nothing of the next stamp; what was counted stays."""
        self._last, self._usual, self._outliers = None, 0.0, 0
