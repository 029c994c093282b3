"""
The torsion law as a table: gear torque at evenly spaced torsions, with its slope.

The law is known as torsion over torque, each compliance in series adding its own; the table is
its inverse, read by cubic Hermite interpolation and continued straight beyond its end.
"""

import numba
import numpy as np
from numpy.typing import NDArray


Array = NDArray[np.float64]

CELLS = 2048
LARGEST = 80.0                  # torque at the end of the table [N*m]
KNEES = (3.9, 12.0, 24.0)       # torques where the catalogue's segments meet [N*m]
_FINE = 20001

# Forms of laws, by effect (`forms.py`); 0 is the one of README.md.
WHOLE, IN_SERIES = 1, 2         # stiffness_error
CUBIC, BLENDED = 1, 2           # stiffening_error
TANH, BAND = 1, 2               # wave_generator_compliance


def table(joint: np.void) -> Array:
    """Return the table of a joint (CELLS + 2, 2): the spacing, then torque and slope."""
    torque = np.linspace(0.0, LARGEST * joint['size'], _FINE)
    spacing = torsion(joint, torque)[-1] / CELLS
    nodes = inverse(joint, torque, spacing * np.arange(CELLS + 1))
    step = 1e-6 * joint['size']
    slope = 2.0 * step / (torsion(joint, nodes + step) - torsion(joint, nodes - step))
    return np.concatenate([[[spacing, 0.0]], np.stack([nodes, slope], axis=1)])


def inverse(joint: np.void, torque: Array, wanted: Array) -> Array:
    """Return the torques at which the torsion is as wanted, from a grid of torques and secants."""
    low = np.interp(wanted, torsion(joint, torque), torque)
    high = low + 1e-3 * joint['size']
    for _ in range(8):
        miss = torsion(joint, low) - wanted
        change = torsion(joint, high) - wanted - miss
        moving = np.abs(change) > 1e-19
        newer = low - np.where(moving, miss * (high - low) / np.where(moving, change, 1.0), 0.0)
        low, high = newer, low
    return low


def torsion(joint: np.void, torque: Array) -> Array:
    """Return flexspline and wave generator in series, odd in the torque [rad]."""
    size, factor = np.abs(torque), 1.0 + joint['stiffness_error_relative_error']
    softness = size / joint['soft_torque']
    wave = (-0.5 * joint['psi'] * np.expm1(-softness)
            + wound_up(joint, softness, 0.5 * (
                joint['wave_generator_compliance_psi'] - joint['psi'])))
    if joint['stiffness_error_form'] == WHOLE:
        wave = wave / factor
    if joint['stiffness_error_form'] == IN_SERIES:
        wave = wave + size * (1.0 / factor - 1.0) / joint['stiffness']
        factor = 1.0
    return np.sign(torque) * (flexspline(joint, size) / (joint['stiffness'] * factor) + wave)


def wound_up(joint: np.void, softness: Array, most: float) -> Array:
    """Return the lost motion beside the nominal one, at a torque over its scale [rad]."""
    first = joint['wave_generator_compliance_first']
    if joint['wave_generator_compliance_form'] == TANH:
        return most * np.tanh(first * softness)
    if joint['wave_generator_compliance_form'] == BAND:
        return most * np.minimum(first * softness, 1.0)
    return most * softness / (1.0 + softness ** 1.6) ** 0.625


def flexspline(joint: np.void, torque: Array) -> Array:
    """Return the torsion for a unit of initial stiffness, of positive torques [N*m]."""
    curvature, form = joint['stiffening_error_curvature'], joint['stiffening_error_form']
    if curvature == joint['curvature']:
        return np.arctan(curvature * torque) / curvature
    if form == CUBIC and curvature > 0.0:       # y + curvature^2 y^3 / 3 = torque
        return 2.0 / curvature * np.sinh(np.arcsinh(1.5 * curvature * torque) / 3.0)
    ends = np.array([0.0, *KNEES]) * joint['size']
    heights = np.arctan(curvature * ends) / curvature if curvature > 0.0 else ends
    if form == BLENDED:
        return blended(torque, ends, np.diff(heights) / np.diff(ends))
    last = (heights[-1] - heights[-2]) / (ends[-1] - ends[-2])
    return np.interp(torque, ends, heights) + last * np.maximum(torque - ends[-1], 0.0)


def blended(torque: Array, ends: Array, slopes: Array) -> Array:
    """Return the torsion of segments that pass into each other over a third of the first."""
    width = 0.35 * ends[1]
    torsion = slopes[0] * torque
    for knee, change in zip(ends[1:], np.diff(slopes)):
        torsion = torsion + change * width * (
            np.logaddexp(0.0, (torque - knee) / width) - np.logaddexp(0.0, -knee / width))
    return torsion


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
