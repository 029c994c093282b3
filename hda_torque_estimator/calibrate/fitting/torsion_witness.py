"""The torsion as a witness: the estimator itself, run over recordings with trial numbers."""

from collections.abc import Sequence
from functools import lru_cache

from hda_arm_sim.model.arm import Arm
import numpy as np
from numpy.typing import NDArray

from .torsion_fits import UNFUSED
from .witness import blocks_of, LAGS, per_recording
from ..passages.joint_recording import Measured
from ...estimating.estimator import Estimator
from ...samples.readings import LINK_READING

Floats = NDArray[np.float64]
# Choices unless stated otherwise.
_KEPT = 256             # runs that are known: other lags and priors ask for the same again


class TorsionWitness:
    """The rows of the torsion's torque; its zero is that of the link encoder [rad]."""

    usual_zero = 0.01       # [rad] (choice) half a degree is wide for a zero that anyone has set

    def __init__(self, arm: Arm, recordings: Sequence[Measured]) -> None:
        """Take recordings that all have both encoders; rows that the arm refuses do not count."""
        self.recordings = recordings
        self.dt = max(one.dt for one in recordings)
        self._rows = lru_cache(_KEPT)(self._run)
        self.reference = lru_cache(LAGS)(self._reference)
        self._used = [np.isfinite(rows) for rows in self._rows(arm, ())]
        self.blocks = blocks_of(recordings, self._used)

    @property
    def is_observed(self) -> bool:
        """Return whether every recording has rows."""
        return all(used.any() for used in self._used)

    def torque(self, arm: Arm, zeros: Floats) -> Floats:
        """Return the torque of the rows (m,) [N*m] with zeros of the link moved (r,) [rad]."""
        return np.concatenate([rows[used] for rows, used
                               in zip(self._rows(arm, tuple(zeros.tolist())), self._used)])

    def _run(self, arm: Arm, zeros: tuple[float, ...]) -> list[Floats]:
        """Return the torque of all rows of each recording, NaN where no sample is believed."""
        estimator, found = Estimator(arm, UNFUSED), []
        for one, zero in zip(self.recordings, per_recording(zeros, self.recordings)):
            readings = one.readings.copy()
            readings[:, 0, LINK_READING] -= zero
            estimator.reset()
            found.append(one.thinned(estimator.run(one.stamps, readings).torque[:, 0]))
        return found

    def _reference(self, lag: float) -> Floats:
        """Return the reference of the rows (m,) [N*m]."""
        return np.concatenate([one.thinned(one.later(lag))[used]
                               for one, used in zip(self.recordings, self._used)])
