"""
Which samples follow the last one, by their stamps: late ones, clocks that went back, two sources.

A single stamp of the past is a message that came late. Several in a row that grow again are a
clock that went back: a loop, a restart. Stamps that alternate are two publishers.
"""

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.compiled import compiled
from hda_msgs_json.samples import Stamps
import numpy as np
from numpy.typing import NDArray

USED, NOT_FINITE, NOT_LATER = range(3)
AFRESH, BACK = 0.0, -1.0        # instead of a time: after a gap; the clock went back (layout)
TWO = 1000.0                    # added to the time of a sample of two publishers [s] (layout)

# Memory, integers: last stamp used [ns] and whether there is one; last stamp of the past [ns] and
# how many of them came in a row; how often stamps went back between two that were used.
LAST, STARTED, PAST, IN_A_ROW, ALTERNATING = range(5)
ORDER = 5  # (layout)

# Choices unless stated otherwise.
FAR_BACK = 1_000_000_000        # beyond it no message is late (as in `sample_judge.py`) [ns]
ROW = 3                         # samples that grow again (choice)
TURNS = 3                       # as in `sample_judge.py`


@compiled
def follow_one(memory: Stamps, stamp: int, finite: bool, longest_gap: float) -> tuple[int, float]:
    """
    Return whether a sample is used, and the time since the last one [s] or what stands for it.

    `stamp` [ns]; `finite` says whether it has angles; after `longest_gap` [s] all begins afresh.
    """
    if not finite:
        return NOT_FINITE, AFRESH
    seconds = AFRESH
    if memory[STARTED] == 1 and stamp <= memory[LAST]:
        if not _went_back(memory, stamp):
            return NOT_LATER, AFRESH
        seconds = BACK
    elif memory[STARTED] == 1:
        gap = (stamp - memory[LAST]) * 1e-9
        seconds = AFRESH if gap > longest_gap else gap
        memory[ALTERNATING] = memory[ALTERNATING] + 1 if memory[IN_A_ROW] > 0 else 0
        if memory[ALTERNATING] >= TURNS:
            seconds += TWO
    memory[LAST], memory[STARTED], memory[IN_A_ROW] = stamp, 1, 0
    return USED, seconds


@compiled
def follow(memory: Stamps, stamps: Stamps, finite: NDArray[np.bool_], longest_gap: float,
           refusals: NDArray[np.int64], seconds: Array) -> None:
    """Fill what `follow_one` says of each sample into refusals and seconds (k,)."""
    for i in range(stamps.shape[0]):
        refusals[i], seconds[i] = follow_one(memory, stamps[i], finite[i], longest_gap)


@compiled
def _went_back(memory: Stamps, stamp: int) -> bool:
    """Count stamps of the past that grow, and return whether they are enough."""
    far = stamp <= memory[LAST] - FAR_BACK
    grows = memory[IN_A_ROW] > 0 and stamp > memory[PAST]
    memory[IN_A_ROW] = memory[IN_A_ROW] + 1 if grows and far else 1
    memory[PAST] = stamp
    return far and memory[IN_A_ROW] >= ROW
