"""What gravity does to the joints of an arm at given angles, (docs/model.md, eq:links)."""

from typing import Any

from .arm import ArmRecord
from ..foundation import chain
from ..foundation.arrays import Array
from ..foundation.chain import Chain, of_links
from ..foundation.compiled import compiled, inlined
from ..foundation.rigid import gravity_torque, Inertia


@inlined
def _in_plane(record: ArmRecord, inertia: Inertia, angles: Array, weight: Array) -> None:
    both = gravity_torque(inertia, record.body.pull, record.body.direction, angles[0], angles[-1])
    if record.body.pull > 0.0:
        for j in range(len(weight)):
            weight[j] = both[j]


@compiled
def _in_space(record: ArmRecord, inertia: Chain, angles: Array, weight: Array) -> None:
    c = inertia.table
    for j in range(len(angles)):
        c[j + 1, chain.ANGLE] = angles[j]
    chain.place(c)
    chain.weights(c)
    for j in range(len(angles)):
        weight[j] = c[j + 1, chain.TORQUE]


_weights = of_links(_in_plane, _in_space)


@inlined
def weights(record: ArmRecord, inertia: Any, angles: Array, weight: Array) -> None:
    """
    Fill what gravity does to the joints (n,) [N*m]; without gravity `weight` stays.

    `inertia` is the Inertia or the Chain of the links with what they carry.
    """
    _weights(record, inertia, angles, weight)
