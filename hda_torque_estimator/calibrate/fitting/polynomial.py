"""The paper's kinematic torsion, its (10): a polynomial in the link angle, to compare with."""

from collections.abc import Sequence
from dataclasses import dataclass

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.torsion import torsion_of_torque
import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from .torsion_fits import STRETCH, UNFUSED
from ..passages.passage import Passage
from ...estimating.estimator import Estimator
from ...least_squares.rows import FOLDS, rms
from ...samples.readings import LINK_READING, MOTOR_READING

Floats = NDArray[np.float64]
# (source: the paper, its equation 10)
DEGREE = 5              # of the polynomial


@dataclass(frozen=True)
class PolynomialMethod:
    """The paper's way from angles to torque: minus a polynomial, through the inverse law."""

    arm: Arm                    # one joint, without loop, skew and waves
    kinematic: Polynomial       # kinematic torsion over the link angle, with its zero [rad]

    def torque(self, stamps: NDArray[np.int64], readings: Floats) -> Floats:
        """Return the torque of readings (k, 1, READINGS) of the joint (k,) [N*m]."""
        freed = readings.copy()
        freed[:, 0, LINK_READING] += self.kinematic(readings[:, 0, LINK_READING])
        return Estimator(self.arm, UNFUSED).run(stamps, freed).torque[:, 0]


def polynomial_method(arm: Arm, passages: Sequence[Passage], *, fold: int | None = None
                      ) -> PolynomialMethod:
    """Return the paper's method, fitted to passages of the only joint, but for one fold."""
    joint = arm.joints[0]
    law, angles, torsions = joint.torsion.record(joint.ratio), [], []
    for passage in passages:
        used = passage.usable & (folds(passage) != fold)
        angle = passage.readings[used, 0, LINK_READING]
        total = passage.readings[used, 0, MOTOR_READING] / joint.ratio - angle
        angles.append(angle)
        torsions.append(total - torsion_of_torque(law, joint.ratio, passage.reference[used]))
    fitted = Polynomial.fit(np.concatenate(angles), np.concatenate(torsions), DEGREE)
    return PolynomialMethod(arm, fitted)


def folds(passage: Passage) -> NDArray[np.int64]:
    """Return which fifth of its stretches a sample belongs to (k,)."""
    length = max(1, round(STRETCH / passage.dt))
    return np.arange(len(passage.usable)) // length % FOLDS


def held_out_error(arm: Arm, passages: Sequence[Passage]) -> float:
    """Return the error of the paper's method where it has not seen [N*m rms]."""
    errors = []
    for fold in range(FOLDS):
        method = polynomial_method(arm, passages, fold=fold)
        for passage in passages:
            error = method.torque(passage.stamps, passage.readings) - passage.reference
            errors.append(error[passage.usable & (folds(passage) == fold)])
    return rms(np.concatenate(errors))
