"""
The torsion law as a table: gear torque at evenly spaced torsions, with its slope.

The law is known as torsion over torque, each compliance in series adding its own; the table is
its inverse, read by cubic Hermite interpolation and continued straight beyond its end.
"""

import numba
import numpy as np
from numpy.typing import NDArray

from .nominal import CURVATURE, PSI, SOFT_TORQUE

Array = NDArray[np.float64]

CELLS = 2048
LARGEST = 80.0                  # torque at the end of the table [N*m]
KNEES = (3.9, 12.0, 24.0)       # torques where the catalogue's segments meet [N*m]
_FINE = 20001


def table(joint: np.void) -> Array:
    """Return the table of a joint (CELLS + 2, 2): the spacing, then torque and slope."""
    torque = np.linspace(0.0, LARGEST, _FINE)
    spacing = torsion(joint, torque)[-1] / CELLS
    nodes = inverse(joint, torque, spacing * np.arange(CELLS + 1))
    step = 1e-6
    slope = 2.0 * step / (torsion(joint, nodes + step) - torsion(joint, nodes - step))
    return np.concatenate([[[spacing, 0.0]], np.stack([nodes, slope], axis=1)])


def inverse(joint: np.void, torque: Array, wanted: Array) -> Array:
    """Return the torques at which the torsion is as wanted, from a grid of torques and secants."""
    low = np.interp(wanted, torsion(joint, torque), torque)
    high = low + 1e-3
    for _ in range(8):
        miss = torsion(joint, low) - wanted
        change = torsion(joint, high) - wanted - miss
        moving = np.abs(change) > 1e-19
        newer = low - np.where(moving, miss * (high - low) / np.where(moving, change, 1.0), 0.0)
        low, high = newer, low
    return low


def torsion(joint: np.void, torque: Array) -> Array:
    """Return flexspline and wave generator in series, odd in the torque [rad]."""
    size = np.abs(torque)
    stiffness = joint['stiffness'] * (1.0 + joint['stiffness_error_relative_error'])
    softness = size / SOFT_TORQUE
    more = 0.5 * (joint['wave_generator_compliance_psi'] - PSI)
    wave = -0.5 * PSI * np.expm1(-softness) + more * softness / (1.0 + softness ** 1.6) ** 0.625
    return np.sign(torque) * (flexspline(size, joint['stiffening_error_curvature']) / stiffness
                              + wave)


def flexspline(torque: Array, curvature: float) -> Array:
    """Return the torsion for a unit of initial stiffness, of positive torques [N*m]."""
    if curvature == CURVATURE:
        return np.arctan(curvature * torque) / curvature
    ends = np.array([0.0, *KNEES])
    heights = np.arctan(curvature * ends) / curvature if curvature > 0.0 else ends
    last = (heights[-1] - heights[-2]) / (ends[-1] - ends[-2])
    return np.interp(torque, ends, heights) + last * np.maximum(torque - ends[-1], 0.0)


@numba.njit(cache=True, error_model='numpy')
def look_up(law: Array, x: float) -> float:
    """Return the torque at a torsion [N*m], odd in it."""
    size = abs(x)
    spacing = law[0, 0]
    cell = int(size / spacing)
    if cell >= law.shape[0] - 2:
        end = law.shape[0] - 1
        torque = law[end, 0] + law[end, 1] * (size - spacing * (end - 1))
        return torque if x > 0.0 else -torque
    s = size / spacing - cell
    low, high = law[cell + 1, 0], law[cell + 2, 0]
    rise, climb = spacing * law[cell + 1, 1], spacing * law[cell + 2, 1]
    bend = (rise - (high - low)) * (1.0 - s) + ((high - low) - climb) * s
    torque = low + s * (high - low) + s * (1.0 - s) * bend
    return torque if x > 0.0 else -torque
