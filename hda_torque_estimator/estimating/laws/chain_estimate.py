"""
External torques and the wrench on the tip of a chain (docs/model.md#estimator).

The momentum observer is that of two links, with momentum, drift and weight of the chain.
"""

from typing import NamedTuple

from hda_arm_sim.foundation import chain
from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.chain import COUPLING, momenta
from hda_arm_sim.foundation.chain_doubts import own_doubts
from hda_arm_sim.foundation.compiled import compiled, inlined
import numpy as np

from .chain_payload import Felt, weigh
from .compiled_settings import Model
from .layout import (ACCELERATION, CONTACT_DEVIATIONS, EXTERNAL, EXTERNAL_DEVIATION,
                     EXTERNAL_TORQUE, LATE, LATE_RATE, PAYLOAD, QUICK_LINK, TORQUE,
                     TORQUE_DEVIATION)
from .momentum import hold
from .observer import observe, observed_variance, shares_of
from .tip_wrench import tip_wrench


class ChainMotion(NamedTuple):
    """Where the links are at a sample."""

    angles: Array               # (n,) [rad]
    dt: float                   # since the last one, 0 starts afresh [s]


@compiled
def in_space(model: Model, memory: Array, moved: ChainMotion, result: Array, tip: Array) -> None:
    """Fill external torques and tip of a chain."""
    c = model.inertia.table
    for j in range(len(moved.angles)):
        c[j + 1, chain.ANGLE] = moved.angles[j]
        c[j + 1, chain.SPEED] = memory[j, QUICK_LINK]
    chain.place(c)
    _observe(model, c, memory, moved, result)
    precision = _precision(model, c, memory, moved, result)
    torque = result[:, EXTERNAL_TORQUE].copy()
    tip_wrench(c, torque, precision, tip)
    tip[CONTACT_DEVIATIONS] = np.sqrt(torque @ precision @ torque)
    weigh(c, memory[0, PAYLOAD:], Felt(torque, precision), moved.dt, tip)


@inlined
def _observe(model: Model, c: Array, memory: Array, moved: ChainMotion, result: Array) -> None:
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
def _precision(model: Model, c: Array, memory: Array, moved: ChainMotion, result: Array) -> Array:
    """
    Return the inverse covariance (n, n) of the external torques, and fill their deviations.

    It holds gear, lag and bearing at rest of each joint, and the links, (eq:sigma-ext). What is
    not known of a link shows in all joints before it at once.
    """
    for j in range(len(moved.angles)):
        c[j + 1, chain.SPEEDING] = memory[j, ACCELERATION]
    covariance = np.empty((len(moved.angles), len(moved.angles)))
    own_doubts(c, model.settings.links_known, covariance)
    for j in range(len(moved.angles)):
        _, doubt = hold(model.record.joints[j], moved.angles[j], memory[j, QUICK_LINK])
        covariance[j, j] += memory[j, LATE] ** 2 + doubt ** 2 + observed_variance(
            memory[j], result[j, TORQUE_DEVIATION], shares_of(model.settings, moved.dt))
        result[j, EXTERNAL_DEVIATION] = np.sqrt(covariance[j, j])
    return np.linalg.inv(covariance).T          # symmetric, and so in rows again
