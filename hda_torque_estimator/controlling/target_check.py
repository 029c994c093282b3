"""
Read and check trajectories beside the control loop, which must not wait for them.

A worker thread reads the bytes and looks at every piece, in steps of a few milliseconds. What is
left for the loop is to join the way to where its reference is by then.
"""

from collections import deque
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.health import Refused
from hda_arm_sim.model.arm import Arm
from hda_msgs_json.cdr import CdrError
from hda_msgs_json.cdr_trajectory import count_points, decode_trajectory
import numpy as np

from .reference import (joined, MOST_POINTS, Reference, too_many, TrajectoryError, Way,
                        way_of)

MOST_WAITING = 4
MOST_ANEW = 1000        # points that the loop joins anew: a millisecond, choice


class Checked(NamedTuple):
    """A way that an arm can follow, and the reference along it from where the arm was."""

    way: Way
    begin: Array                # (n, 2) angles and rates [rad, rad/s]
    reference: Reference

    def joining(self, arm: Arm, now: Array) -> Reference:
        """Return the reference from `now` (n, 2); raises TrajectoryError."""
        if np.array_equal(now, self.begin):
            return self.reference
        if len(self.way.moments) > MOST_ANEW:
            raise TrajectoryError(
                f'the reference moved while {len(self.way.moments)} points were checked; send '
                f'more than {MOST_ANEW} when it stands')
        return joined(arm, self.way, now, pieces=2)


class TargetCheck:
    """Check one trajectory after another; `done` gives them back in order."""

    def __init__(self, arm: Arm) -> None:
        """Prepare for an arm."""
        self._arm = arm
        self._worker = ThreadPoolExecutor(1, 'targets')
        self._waiting: deque[Future[Checked]] = deque()

    def add(self, message: bytes, now: Array) -> None:
        """Take a trajectory that begins near the reference `now` (n, 2); raises Refused."""
        if len(self._waiting) >= MOST_WAITING:
            raise Refused('too many targets', f'{MOST_WAITING} targets at most can wait for '
                          'their check')
        try:
            points = count_points(message)
        except CdrError as error:
            raise Refused('malformed message', str(error)) from None
        if points > MOST_POINTS:
            raise Refused('target out of bounds', str(too_many(points)))
        self._waiting.append(self._worker.submit(self._checked, message, now))

    def done(self) -> Iterator[Future[Checked]]:
        """Yield what was checked; its `result` raises Refused where a way cannot be followed."""
        while self._waiting and self._waiting[0].done():
            yield self._waiting.popleft()

    def close(self) -> None:
        """End the worker, whatever waits."""
        self._worker.shutdown(wait=False, cancel_futures=True)

    def close_after_all(self) -> None:
        """End the worker when everything that waits is checked."""
        self._worker.shutdown(wait=True)

    def _checked(self, message: bytes, now: Array) -> Checked:
        try:
            way = way_of(self._arm, *decode_trajectory(message))
            made = joined(self._arm, way, now)
        except CdrError as error:
            raise Refused('malformed message', str(error)) from None
        except TrajectoryError as error:
            raise Refused('target out of bounds', str(error)) from None
        return Checked(way, now, made)
