"""
Hand an arm to compiled code as plain arrays.

numba tells the types of the arguments at every call from Python. For records and tuples that takes
four times as long as a step of the arm, for arrays hardly any time. Whoever steps sample by sample
passes arrays, and has compiled code make `ArmRecord(joints, body[0])` of them.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .arm import ArmRecord
from .link_side import loaded_inertia
from ..foundation.compiled import inlined
from ..foundation.rigid import Inertia


class PlainArm(NamedTuple):
    """An arm as arrays, to be passed one by one."""

    joints: NDArray[Any]                # (n,) records
    body: NDArray[Any]                  # (1,) record
    inertia: NDArray[np.float64]        # (6,) the fields of Inertia


def plain(record: ArmRecord) -> PlainArm:
    """Return an arm as arrays."""
    return PlainArm(record.joints, np.array([record.body]),
                    np.array(loaded_inertia(record.body)))


@inlined
def inertia_of(numbers: NDArray[np.float64]) -> Inertia:
    """Return the inertia from its array."""
    return Inertia(numbers[0], numbers[1], numbers[2], numbers[3], numbers[4], numbers[5])
