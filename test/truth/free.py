"""The arm without controller, encoders and clock: given torques in, true angles out."""

import numba
import numpy as np
from numpy.typing import NDArray

from .plant import drift, kick, locate, Plant, relative, State

Array = NDArray[np.float64]


def swing(plant: Plant, state: State, torque: Array, force: Array, h: float, every: int) -> Array:
    """
    Integrate motor torques (k, 2) and tip forces (k, 2), one step of h [s] each.

    Return the trajectory (k // every + 1, 2, 4): motor angle and rate, link angle and rate.
    """
    out = np.zeros((len(torque) // every + 1, 2, 4))
    _swing(plant, state, torque, force, h, every, out)
    return out


@numba.njit(cache=True, error_model='numpy')
def _swing(plant: Plant, state: State, torque: Array, force: Array, h: float, every: int,
           out: Array) -> None:
    spare = np.zeros((2, 5))
    _keep(state, out[0])
    for i in range(torque.shape[0]):
        drift(plant, state, 0.5 * h)
        locate(plant, state, force[i, 0], force[i, 1], (i + 0.5) * h)
        for j in range(2):
            state.held[j].applied = torque[i, j]
        kick(plant, state, h, spare[0], spare[1])
        drift(plant, state, 0.5 * h)
        if (i + 1) % every == 0:
            _keep(state, out[(i + 1) // every])


@numba.njit(cache=True, error_model='numpy')
def _keep(state: State, row: Array) -> None:
    for j in range(2):
        row[j, 0], row[j, 1] = state.position[j], state.rate[j]
        row[j, 2], row[j, 3] = relative(state.position, j), relative(state.rate, j)
