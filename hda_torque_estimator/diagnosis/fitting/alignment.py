"""
Bring several recordings of one arm together: the zeros of their encoders may differ.

An encoder that counts from where it was switched on has another zero in every recording. Zeros are
no property of the arm: the readings are shifted until all recordings have the zeros of the first.
"""

from collections.abc import Sequence
from dataclasses import replace
import math

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
import numpy as np

from .nuisance import Zero
from ..balances.balance import Balancer, RATE
from ...least_squares.term import with_terms
from ...measurements.joined_recordings import joined, resampled
from ...measurements.measurement import Measurement
from ...measurements.rates import check_rate
from ...measurements.upsampling import parts_of

# Numerics; choices unless stated otherwise.
_PASSES = 3             # the torsion law is not straight
_LINK = 1               # side of a reading (layout)
_SETTLED = 0.5          # of the noise, that a zero may still be off


def together(recordings: Sequence[Measurement], sources: Sequence[str] = ()) -> Measurement:
    """
    Return recordings of one arm as one measurement; raises GateError where rates differ much.

    The clock of a driver is not the same on every day: all get the period of the first.
    """
    first = recordings[0]
    if len(recordings) == 1:
        return first
    for place, other in enumerate(recordings):
        check_rate(1.0 / other.dt, sources[place] if sources else f'recording {place + 1}',
                   1.0 / first.dt, sources[0] if sources else 'the first')
    return joined([resampled(one, first.dt) for one in recordings],
                  _grain(first.dt))


def _grain(dt: float) -> int:
    """Return the samples whose multiples, on the finer grid, are multiples of a balance's."""
    parts = parts_of(dt)
    kept = max(1, round(parts / (RATE * dt)))
    return math.lcm(kept, parts) // parts


def aligned(measurement: Measurement, arm: Arm) -> Measurement:
    """Return the measurement with the link encoders' zeros of its first recording in all."""
    if len(measurement.begins) == 1:
        return measurement
    for _ in range(_PASSES):
        zeros = zeros_of(Balancer(measurement), arm)
        reading = measurement.reading.copy()
        for piece, zero in zip(measurement.pieces(), zeros - zeros[0]):
            reading[piece, :, _LINK] -= zero
        measurement = replace(measurement, reading=reading)
    return measurement


def zeros_of(balancer: Balancer, arm: Arm) -> Array:
    """Return how far the link encoders' zeros are from the arm's in each recording (r, n)."""
    zeros = [Zero(label) for label in arm.labels]
    step = float(zeros[0].all_steps()[0])
    shifted = with_terms(arm, [replace(zero, value=step) for zero in zeros])
    balance = balancer(arm)
    joints, residual = len(arm.labels), balance.residual
    slope = (balancer(shifted).residual - residual) / step
    of_links = slice(joints, 2 * joints)
    use = np.where(balance.valid, 1.0, 0.0)[:, of_links]
    along = _by_recording(balancer, use * (slope * residual)[:, of_links])
    return -along / np.maximum(_by_recording(balancer, use * slope[:, of_links] ** 2), 1e-30)


def _by_recording(balancer: Balancer, rows: Array) -> Array:
    """Return the sums of rows (m, n) over each recording (r, n)."""
    begins = [begin // balancer.every for begin in balancer.measurement.begins]
    return np.add.reduceat(rows, begins, axis=0)


def is_aligned(balancer: Balancer, arm: Arm, noise: Array) -> bool:
    """Return whether the zeros of all recordings differ by less than the noise (c,) can show."""
    if len(balancer.measurement.begins) == 1:
        return True
    zeros = zeros_of(balancer, arm)
    stiffness = np.array([joint.torsion.flexspline_stiffness for joint in arm.joints])
    joints = len(arm.labels)
    return bool((np.abs(zeros - zeros[0]) * stiffness
                 < _SETTLED * noise[joints:2 * joints]).all())
