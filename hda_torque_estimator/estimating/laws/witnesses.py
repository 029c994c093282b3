"""
Weigh two witnesses of one torque sample by sample, and hold one within what the other allows.

The first witness is a torsion, which determines the torque by a law that stiffens. The second
determines it directly. What lasts in their difference is learnt elsewhere (`fusion.py`); here is
what changes from sample to sample. Nothing here knows of motors. Equations: docs/estimation.md.
"""

from typing import NamedTuple

from hda_arm_sim.foundation.compiled import compiled, inlined, Record
from hda_arm_sim.model.torsion import stiffer_torsion
import numpy as np

# Choices unless stated otherwise.
FAINT = 0.01            # weight below which a witness is left out: it makes 0.5 % more certain
_ALIKE = 1e-3           # share of a deviation, within which a law is its own tangent


class Spring(NamedTuple):
    """What the first witness shows: the torsion of its spring, and what is beside the spring."""

    torsion: float              # [rad]
    aside: float                # torque of hysteresis and damping, parallel to the spring [N*m]
    growing: float              # what each N*m adds to the torsion [rad/(N*m)]
    factor: float               # of the flexspline's stiffness


class Bound(NamedTuple):
    """What a witness allows [N*m]."""

    middle: float
    slack: float                # to either side, by what it cannot know
    doubt: float                # and by what it may be wrong


@compiled
def tangent(joint: Record, seen: Spring, near: float) -> tuple[float, float]:
    """
    Return torque [N*m] and stiffness [N*m/rad] of a torsion by a tangent, (eq:tangent).

    `near` is the torque at which it touches the law [N*m]. So the stiffening of the law does not
    enlarge a reading that is off by much.
    """
    spring = min(max(near - seen.aside, -joint.torsion.valid_torque), joint.torsion.valid_torque)
    there, slope = stiffer_torsion(joint.torsion, joint.ratio, spring, seen.factor, seen.growing)
    return spring + seen.aside + (seen.torsion - there) / slope, 1.0 / slope


@inlined
def within(bound: Bound, torque: float) -> float:
    """Return the torque that a bound allows nearest to another [N*m]."""
    most = bound.slack + bound.doubt
    return min(max(torque, bound.middle - most), bound.middle + most)


@inlined
def beyond(bound: Bound, torque: float) -> float:
    """Return how far a torque is beyond a bound, if that is not wrong [N*m]."""
    return max(abs(torque - bound.middle) - bound.slack, 0.0)


@inlined
def share_of_second(first: float, second: float) -> float:
    """Return the weight of the second witness by the variances of one sample, (eq:weight)."""
    return first / max(first + second, 1e-300)


@inlined
def is_near(torque: float, near: float, random: float) -> bool:
    """Return whether the law between two torques is straight enough."""
    return abs(torque - near) <= _ALIKE * np.sqrt(random)
