"""The simple diagnosis that a better one must beat: the best correlation with one column."""

from collections.abc import Sequence

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.typical_sizes import SIZED, typical
from hda_torque_estimator.diagnosis.balances.balance import Balancer
from hda_torque_estimator.diagnosis.findings.smallest import places
from hda_torque_estimator.measurements.measurement import Measurement
import numpy as np

ENOUGH = 0.5                    # share of the residual's power from which the best is named


def best_correlation(measurement: Measurement, arm: Arm,
                     names: Sequence[str]) -> tuple[str, str | None, float] | None:
    """
    Return effect and joint whose first-order column follows the residual best, and its share.

    None where the best explains less than half of the power: then nothing is named.
    """
    try:
        balancer = Balancer(measurement)
        before = balancer(arm)
    except ValueError:
        return None
    spread = np.maximum(before.residual.std(axis=0), 1e-12)
    residual = ((before.residual - before.residual.mean(axis=0)) / spread * before.valid).ravel()
    best: tuple[str, str | None, float] = ('', None, 0.0)
    for name in (name for name in names if name in SIZED):
        for joint in places(arm, name):
            try:
                after = balancer(arm.with_effect(typical(arm, name, joint), joint))
            except ValueError:
                continue
            column = ((after.residual - before.residual) / spread * before.valid).ravel()
            explained = (residual @ column) ** 2 / max(
                (column @ column) * (residual @ residual), 1e-300)
            best = max(best, (name, joint, float(explained)), key=lambda one: one[2])
    return best if best[2] >= ENOUGH else None
