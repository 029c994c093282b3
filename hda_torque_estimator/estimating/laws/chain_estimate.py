"""
External torques and the wrench on the tip of a chain (docs/model.md#estimator).

The momentum observer is that of two links, with momentum, drift and weight of the chain.
"""

from typing import NamedTuple

from hda_arm_sim.foundation import chain
from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.chain import COUPLING, momenta
from hda_arm_sim.foundation.compiled import compiled, inlined
import numpy as np

from .compiled_settings import Model
from .layout import (ACCELERATION, EXTERNAL, EXTERNAL_DEVIATION, EXTERNAL_TORQUE, LATE, LATE_RATE,
                     MASS, MASS_DEVIATION, QUICK_LINK, TORQUE, TORQUE_DEVIATION)
from .momentum import hold
from .observer import observe, shares_of
from .tip_wrench import tip_wrench


class Moved(NamedTuple):
    """Where the links are at a sample."""

    angles: Array               # (n,) [rad]
    dt: float                   # since the last one, 0 starts afresh [s]


@compiled
def in_space(model: Model, memory: Array, moved: Moved, result: Array, tip: Array) -> None:
    """Fill external torques and tip of a chain; the payload is not looked for."""
    c = model.inertia.table
    for j in range(len(moved.angles)):
        c[j + 1, chain.ANGLE] = moved.angles[j]
        c[j + 1, chain.SPEED] = memory[j, QUICK_LINK]
    chain.place(c)
    _observe(model, c, memory, moved, result)
    _deviations(model, c, memory, moved, result)
    tip_wrench(c, result[:, EXTERNAL_TORQUE], result[:, EXTERNAL_DEVIATION], tip)
    tip[MASS] = tip[MASS_DEVIATION] = np.nan


@inlined
def _observe(model: Model, c: Array, memory: Array, moved: Moved, result: Array) -> None:
    """Renew the momentum observer, (eq:observer): p = M dq, dp/dt = tau + g + C^T dq."""
    share = shares_of(model.settings, moved.dt)
    momenta(c)
    for j in range(len(moved.angles)):
        now, drift = c[j + 1, chain.TORQUE], c[j + 1, COUPLING]
        pull, _ = hold(model.record.joints[j], moved.angles[j], memory[j, QUICK_LINK])
        observe(memory[j], now, result[j, TORQUE] + pull + drift, share)
    chain.weights(c)                            # in the place of the momenta
    for j in range(len(moved.angles)):
        memory[j, LATE_RATE] += share.quick * c[j + 1, chain.TORQUE]
        result[j, EXTERNAL_TORQUE] = memory[j, EXTERNAL]


@inlined
def _deviations(model: Model, c: Array, memory: Array, moved: Moved, result: Array) -> None:
    """Fill how sure external torques are: gear, links, lag, bearing at rest, (eq:sigma-ext)."""
    for j in range(len(moved.angles)):
        c[j + 1, chain.SPEEDING] = memory[j, ACCELERATION]
    squares = np.empty(len(moved.angles))
    chain.own_needs(c, squares)
    for j in range(len(moved.angles)):
        _, doubt = hold(model.record.joints[j], moved.angles[j], memory[j, QUICK_LINK])
        result[j, EXTERNAL_DEVIATION] = np.sqrt(
            result[j, TORQUE_DEVIATION] ** 2
            + model.settings.inertia_tolerance ** 2 * squares[j]
            + memory[j, LATE] ** 2 + doubt ** 2)
