"""
Stamp samples as a host does: some time after they were taken, and in their order.

Its chance is a stream of its own. So an arm moves alike, bit by bit, whatever its stamps are.
"""

import numpy as np
from numpy.typing import NDArray

from .model.arm import Arm
from .model.effect_loops import any_acts, numbers_at
from .model.effects.catalogue import sole_at
from .model.effects.place import STAMP, Stamped

_STREAM = 1             # of chance, beside that of noise


class Stamper:
    """Stamp the samples of an arm, one or many at a time, seeded and deterministic."""

    def __init__(self, arm: Arm, seed: int) -> None:
        """Start with an arm and the seed of its noise."""
        body = arm.record().body
        self.acts = any_acts(body, STAMP)       # whether stamps differ from the times of sampling
        self._own = numbers_at(body, STAMP)
        self._random = np.random.default_rng([seed, _STREAM])
        self._last = np.iinfo(np.int64).min

    def __call__(self, taken: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the stamps of the next samples, from the times when they were taken (k,) [ns]."""
        if not self.acts or not len(taken):
            return taken
        waits = sole_at(STAMP).law(self._own, Stamped(self._random.random(len(taken))))
        order = np.arange(len(taken))
        stamps = taken + np.rint(1e9 * waits).astype(np.int64) - order
        stamps[0] = max(int(stamps[0]), self._last + 1)
        stamps = np.maximum.accumulate(stamps) + order      # one after another, at least 1 ns
        self._last = int(stamps[-1])
        return np.asarray(stamps)
