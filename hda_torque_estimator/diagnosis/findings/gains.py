"""How much better an extended arm predicts what no fit has seen, over the noise."""

from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
import numpy as np
from numpy.typing import NDArray

from .report import Gain, TotalGain
from ..balances.balance import Balancer
from ..balances.predict import HORIZON, prediction_errors
from ...measurements.running_clock import Spans

# Numerics; choices unless stated otherwise.
_RESAMPLES = 400        # of windows, for the interval of a gain
_EXACT = 1e-30          # mean squared error of a prediction that counts as none [rad^2]
METRIC = (f'mean squared error of motor angles, link angles and torsions predicted over '
          f'{HORIZON:g} s from measured states on held-out stretches, each over its noise floor')


class Gains(NamedTuple):
    """Prediction errors of windows (w,) over the noise floor: before, after, and noise alone."""

    before: Array
    after: Array
    floor: Array

    def removed(self, rows: NDArray[np.int64] | slice = slice(None)) -> float:
        """
        Return the share of the excess error that is gone: 1 at the floor or below it.

        A floor that is above what is left in truth is no floor. Where all is below it and more is
        left than before, the share is -1.
        """
        before, after, floor = (part[rows].mean() for part in self)
        excess = before - min(floor, after)
        if excess > 0.0:
            return float((before - after) / excess)
        return -1.0 if after > before else float('nan')

    def interval(self) -> tuple[float, float]:
        """Return the 90 % interval of `removed`, by drawing windows again."""
        random = np.random.default_rng(0)
        draws = [self.removed(random.integers(0, len(self.before), len(self.before)))
                 for _ in range(_RESAMPLES)]
        low, high = np.quantile(draws, (0.05, 0.95))
        return float(low), float(high)

    def gain(self) -> Gain:
        """Return the gain as the report states it."""
        low, high = self.interval()
        return Gain(float(self.before.mean()), float(self.after.mean()),
                    float(self.floor.mean()), self.removed(), low, high)

    def total(self) -> TotalGain:
        """Return the gain of all causes together."""
        gain = self.gain()
        return TotalGain(gain.before, gain.after, gain.floor, gain.removed, gain.low, gain.high,
                         METRIC, '1')


def gains(balancer: Balancer, twin: Balancer, before: Arm, after: Arm, spans: Spans) -> Gains:
    """Return how well both arms predict the held-out stretches; `twin` shows the floor."""
    parts = [prediction_errors(source, arm, spans) for source, arm in
             ((balancer, before), (balancer, after), (twin, after))]
    floor = np.maximum(parts[2].mean(axis=0), _EXACT)       # ideal encoders show no noise
    return Gains(*((part / floor).mean(axis=1) for part in parts))
