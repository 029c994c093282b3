"""How much torque feedback the loop bears: frequency response of arm, sampling and delay."""

from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
import numpy as np

from .bench import STEP
from .linear import Linear, linearised

_DELAY = 1.5 * STEP                 # a command answers the sample before it, and is held [s]
_FREQUENCY = np.geomspace(0.05, 400.0, 40000)


class Limits(NamedTuple):
    """The K_J of a loop at which it begins to swing by itself, below and above zero."""

    following: float
    rejecting: float
    at: float                       # frequency of the swing when following [Hz]


def limits(arm: Arm, *, held: bool) -> Limits:
    """
    Return the limits of K_J for one axis whose motor slides, without PD.

    With the link held (`held`) the gear carries whatever the motor drives; a free link carries
    its inertia.
    """
    loop = loop_response(arm, held=held)
    real = np.flatnonzero(np.diff(np.sign(loop.imag)) != 0)
    share = loop.imag[real] / (loop.imag[real] - loop.imag[real + 1])
    crossed = loop.real[real] + share * (loop.real[real + 1] - loop.real[real])
    ends = np.append(crossed, loop.real[0])         # at rest every response is real
    lowest = int(np.argmin(crossed))
    return Limits(1.0 / float(crossed.min()), 1.0 / float(ends.max()),
                  float(_FREQUENCY[real[lowest]]))


def loop_response(arm: Arm, *, held: bool) -> Array:
    """Return the motor torque that comes back per motor torque at K_J = 1, over frequency."""
    linear = linearised(arm, (0.3,))
    linear = _with_held_link(linear) if held else linear
    back = linear.response(linear.gear[0], 0, _FREQUENCY) / arm.joints[0].ratio
    return np.asarray(back * np.exp(-2j * np.pi * _FREQUENCY * _DELAY))


def frequencies() -> Array:
    """Return the frequencies of `loop_response` [Hz]."""
    return _FREQUENCY


def _with_held_link(linear: Linear) -> Linear:
    shaft = slice(0, 2)
    return Linear(linear.matrix[shaft, shaft], linear.motor[shaft], linear.gear[:, shaft])
