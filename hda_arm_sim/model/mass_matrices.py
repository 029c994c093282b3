"""Mass matrices of an arm in given postures, for links in a plane and chains in space."""

import numpy as np

from .arm import Arm
from .link_side import loaded_inertia
from ..foundation.arrays import Array
from ..foundation.chain import ANGLE, Chain, MATRIX, place
from ..foundation.chain import mass_matrix as set_mass_matrix
from ..foundation.compiled import compiled, interpreted
from ..foundation.rigid import mass_matrix


def mass_matrices(arm: Arm, angle: Array) -> Array:
    """Return the mass matrices (h, n, n) of the links at some of their angles (h, n) [kg*m^2]."""
    inertia, joints = loaded_inertia(arm.record().body), angle.shape[1]
    matrices = np.empty((*angle.shape, joints))
    if isinstance(inertia, Chain):
        _fill_of_chain(inertia.table, np.ascontiguousarray(angle), matrices)
        return matrices
    first, both, second = interpreted(mass_matrix)(inertia, angle[:, -1])
    if joints == 1:
        matrices[:, 0, 0] = inertia.p1
    else:
        matrices[:, 0, 0], matrices[:, 1, 1] = first, second
        matrices[:, 0, 1] = matrices[:, 1, 0] = both
    return matrices


@compiled
def _fill_of_chain(c: Array, angle: Array, matrices: Array) -> None:
    """Fill the mass matrices (h, n, n) of a chain at some of its angles (h, n)."""
    joints = angle.shape[1]
    for row in range(angle.shape[0]):
        for j in range(joints):
            c[j + 1, ANGLE] = angle[row, j]
        place(c)
        set_mass_matrix(c)
        for j in range(joints):
            for k in range(joints):
                matrices[row, j, k] = c[j + 1, MATRIX + k]
