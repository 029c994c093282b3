"""
An arm as plain arrays, for compiled code that is called sample by sample.

numba infers the types of the arguments at every call from Python. For records and tuples that
takes four times as long as a step of the arm, for arrays hardly any time. Whoever steps sample by
sample passes arrays, and has compiled code make `ArmRecord(joints, body[0])` of them.
"""

from typing import Any, NamedTuple

from numba.core import types
import numpy as np
from numpy.typing import NDArray

from .arm import ArmRecord
from .link_side import loaded_inertia
from ..foundation.arrays import Array
from ..foundation.chain import Chain
from ..foundation.compiled import either, inlined
from ..foundation.rigid import Inertia


class PlainArm(NamedTuple):
    """An arm as arrays, to be passed one by one."""

    joints: NDArray[Any]                # (n,) records
    body: NDArray[Any]                  # (1,) record
    inertia: Array                      # (6,) the fields of Inertia, or the table of a Chain


def plain(record: ArmRecord) -> PlainArm:
    """Return an arm as arrays."""
    inertia = loaded_inertia(record.body)
    return PlainArm(record.joints, np.array([record.body]),
                    inertia.table if isinstance(inertia, Chain) else np.array(inertia))


@inlined
def _pair_of(numbers: Array) -> Inertia:
    return Inertia(numbers[0], numbers[1], numbers[2], numbers[3], numbers[4], numbers[5])


@inlined
def _chain_of(numbers: Array) -> Chain:
    return Chain(numbers)


def _is_table(kind: Any) -> bool:
    return isinstance(kind, types.Array) and kind.ndim == 2


_chosen = either(_pair_of, _chain_of, _is_table)


@inlined
def inertia_of(numbers: Array) -> Any:
    """Return the Inertia or the Chain from its array."""
    return _chosen(numbers)
