"""Watch the samples of an arm one after another, and say what is wrong with one."""

import math

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
import numpy as np

from .sample_faults import Fault, FaultDetails, sentence
from .sample_judge import judge, PERIOD, STARTED, WATCH_MEMORY
from .sample_limits import watch_limits


class SampleWatch:
    """Judge one sample after another; `sentence` says what was wrong with the last one."""

    def __init__(self, arm: Arm, *, apart: float = math.inf) -> None:
        """Prepare for an arm; `apart` as `watch_limits` says [rad]."""
        self.limits = watch_limits(arm, apart=apart)
        self.memory = np.zeros((len(arm.joints), WATCH_MEMORY))
        self._labels, self._details = arm.labels, np.zeros(5)
        self._fault, self._last = Fault.NONE, 0

    def begin(self) -> None:
        """Forget every sample: the next one is the first."""
        self.memory[:] = 0.0

    def look(self, stamp: int, reading: Array) -> Fault:
        """Return what is wrong with a sample (n, 2) or (n, 4) and its stamp [ns]."""
        dt = (stamp - self._last) * 1e-9 if self.memory[0, STARTED] else 0.0
        self._fault = Fault(judge(self.limits, self.memory, reading, dt, self._details))
        if self._fault.believed:
            self._last = stamp
        return self._fault

    @property
    def period(self) -> float:
        """Return the usual time from stamp to stamp, 0 before two of them [s]."""
        return float(self.memory[0, PERIOD])

    @property
    def stamp(self) -> int:
        """Return the stamp of the last sample that was believed [ns]."""
        return self._last

    @property
    def sentence(self) -> str:
        """Return what was wrong with the last sample, empty if nothing was."""
        if self._fault is Fault.NONE:
            return ''
        joint, side, got, right, seconds = self._details.tolist()
        return sentence(self._fault, FaultDetails(int(joint), int(side), got, right, seconds),
                        self._labels)
