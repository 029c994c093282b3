"""
Stamps of a host made even: when samples were taken, not when a busy computer handed them on.

Samples are taken by a clock of their own. What a host stamps comes late, by turns and in bursts,
but never too early. So samples count evenly, except where so many were lost that even the least
late stamps jump.
"""

import numpy as np
from numpy.typing import NDArray

Stamps = NDArray[np.int64]
REACH = 64              # samples to either side that show the period, and the least delay (choice)
LOST = 0.75             # periods by which the least delay jumps where a sample was lost (choice)


def evened(stamps: Stamps) -> Stamps:
    """
    Return stamps [ns] (n,) on an even clock; lost samples leave their places free.

    Those that go back are no stamps of a host, and stay as they are.
    """
    if len(stamps) < 3 or (np.diff(stamps) < 0).any() or stamps[0] == stamps[-1]:
        return stamps
    since = (stamps - stamps[0]).astype(np.float64)
    ticks = np.arange(len(stamps)) + _lost_before(since, _period(since))
    period, begin = np.polyfit(ticks, since, 1)
    even = stamps[0] + np.rint(begin + period * ticks).astype(np.int64)
    return even - min(even[0], 0)                       # a stamp is not negative


def _period(since: NDArray[np.float64]) -> float:
    """Return the usual time from sample to sample, from stretches longer than a burst [ns]."""
    reach = min(REACH, len(since) - 1)
    return float(np.median(since[reach:] - since[:-reach])) / reach


def _lost_before(since: NDArray[np.float64], period: float) -> NDArray[np.int64]:
    """Return how many samples were lost before each (n,)."""
    lost = np.zeros(len(since), np.int64)
    if period <= 0.0:
        return lost
    late = since - period * np.arange(len(since))
    for place in np.flatnonzero(np.diff(since) > (1.0 + LOST) * period) + 1:
        before = late[max(place - REACH, 0):place].min()
        jump = (late[place:place + REACH].min() - before) / period
        if jump > LOST:
            lost[place:] += round(jump)
            late[place:] -= round(jump) * period
    return lost
