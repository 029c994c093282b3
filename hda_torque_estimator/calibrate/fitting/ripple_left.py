"""
What a fit leaves of the waves that the torque of a motor has over its turn.

An arm file states how large such waves may be. What a fit misses holds those that are there as
well. So of its error the waves take what it shows of them, and the rest is what no law describes.
"""

from dataclasses import replace
from typing import NamedTuple

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects.catalogue import known_as
import numpy as np
from numpy.typing import NDArray

from .motor_witness import MotorWitness

Floats = NDArray[np.float64]
RIPPLE = known_as('torque_ripple')
assert RIPPLE.known_by is not None
_TOLERANCE = RIPPLE.known_by.tolerance
ORDERS = tuple(float(name.rpartition('_')[2]) for name in RIPPLE.known_by.numbers)


class RippleLeft(NamedTuple):
    """Waves of a motor's torque, by what a fit leaves."""

    size: float                 # of each sine and cosine, one sigma [N*m motor]
    seen: float                 # of all of them, as rows of the fit see them [N*m rms]


def ripple_left(witness: MotorWitness, arm: Arm, rest: Floats, error: float) -> RippleLeft:
    """
    Return how large waves of the motor torque may be, by what a fit leaves, (eq:ripple-once).

    Before, each has the tolerance of the arm. The fit leaves `rest` (m,) of its rows. Rows that
    it has not seen it misses by `error` [N*m rms], which lasts for a stretch of seconds.
    """
    known = arm.tolerances.torque_ripple
    if known == 0.0 or error == 0.0:
        return RippleLeft(known, 0.0)
    waves = arm.joints[0].ratio * np.concatenate(
        [witness.waves(order) for order in ORDERS], axis=1)
    alone = len(np.unique(witness.blocks.stretch)) / len(rest) / error ** 2
    unsure = np.linalg.inv(np.eye(waves.shape[1]) / known ** 2 + alone * waves.T @ waves)
    left = alone * unsure @ (waves.T @ rest)
    seen = np.mean((waves @ left) ** 2 + np.sum((waves @ unsure) * waves, axis=1))
    size = np.sqrt(np.mean(left ** 2 + np.diag(unsure)))
    return RippleLeft(min(float(size), known), float(np.sqrt(seen)))


def with_ripple(arm: Arm, label: str, ripple: float) -> Arm:
    """Return the arm with waves of a motor's torque no larger than so much [N*m motor]."""
    known, place = arm.tolerances_of(label), f'tolerances.{label}.{_TOLERANCE}'
    if ripple >= known.torque_ripple:
        return arm
    origin = dict(arm.provenance).get(place, f'calibrated; {known.torque_ripple:g} before')
    joints = tuple(replace(joint, tolerances=replace(known, **{_TOLERANCE: ripple}))
                   if joint.label == label else joint for joint in arm.joints)
    return replace(arm, joints=joints, provenance=tuple(
        {**dict(arm.provenance), place: origin}.items()))
