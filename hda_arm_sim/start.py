"""
How a simulated arm stands before its first sample, (docs/model.md, eq:start).

Links in a plane are at rest behind unloaded gears. The links of a chain have weight. So its gears
are wound up by that, and its motors hold it, as after a brake has been opened under load.
"""

from typing import Any, NamedTuple

import numpy as np

from .foundation import chain
from .foundation.arrays import Array
from .foundation.compiled import borrowed, compiled
from .model.arm import Arm, ArmRecord
from .model.chain_links import ChainLinks
from .model.kernel import DRIVE, MOTOR_ANGLE, registers, slope, SLOPE_1, STATE, STATES
from .model.link_side import loaded_inertia
from .simulate import rest

# Choices unless stated otherwise.
_REACH = 0.5            # torsion that no gear bears, its play included [rad]
_HALVINGS = 60          # of twice that: below what a shaft's angle can say


class Start(NamedTuple):
    """An arm at rest: its state (n, STATES), and the motor torques (n,) that hold it [N*m]."""

    state: Array
    command: Array


def start_of(arm: Arm, link_angle: Array | tuple[float, ...]) -> Start:
    """Return an arm at rest at these link angles, a chain in equilibrium, (eq:start) [rad]."""
    state = rest(arm, link_angle)
    if not isinstance(arm.links, ChainLinks):
        return Start(state, np.zeros(len(arm.joints)))
    w, held = registers(state), np.empty(len(arm.joints))
    _wind_up(arm.record(), loaded_inertia(arm.record().body), w, held)
    most = [joint.torque_limit for joint in arm.joints]
    return Start(w[:len(held), STATE:STATE + STATES].copy(), np.clip(held, -np.array(most), most))


@compiled
def _wind_up(arm: ArmRecord, inertia: Any, w: Array, held: Array) -> None:
    """Turn each shaft until nothing moves its link, by bisection; fill what holds it there."""
    arm, w = ArmRecord(borrowed(arm.joints), arm.body), borrowed(w)
    low, high = np.empty(len(held)), np.empty(len(held))
    for j in range(len(held)):
        low[j] = w[j, STATE + MOTOR_ANGLE] - arm.joints[j].ratio * _REACH
        high[j] = w[j, STATE + MOTOR_ANGLE] + arm.joints[j].ratio * _REACH
    for _ in range(_HALVINGS):
        for j in range(len(held)):
            w[j, STATE + MOTOR_ANGLE] = 0.5 * (low[j] + high[j])
        slope(arm, inertia, w, STATE, SLOPE_1)
        for j in range(len(held)):
            if inertia.table[j + 1, chain.TORQUE] > 0.0:
                high[j] = w[j, STATE + MOTOR_ANGLE]
            else:
                low[j] = w[j, STATE + MOTOR_ANGLE]
    for j in range(len(held)):
        held[j] = -w[j, DRIVE]
