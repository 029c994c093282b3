"""
The paper's equations as they are printed, for comparison only.

Numbers in brackets are those of the paper. Nothing of the product uses these: where a printed
equation is wrong, that is what is to be shown.
"""

from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.gear_catalogue import gear
import numpy as np


class TableOne(NamedTuple):
    """Table I, and the viscous friction that (A.1) adds to it."""

    motor_inertia: float = 1.21e-4              # J_m [kg*m^2]
    wave_generator_inertia: float = 0.079e-4    # J_w [kg*m^2]
    link_inertia: float = 0.876                 # J_l [kg*m^2]
    wave_generator_stiffness: float = 2.5517    # K_w0 [N*m/rad, shaft]
    wave_generator_curvature: float = 27.027    # c_w [1/(N*m), shaft]
    tangent_stiffness: float = 9743.939         # K_f0 [N*m/rad]
    flexspline_curvature: float = 0.0831        # c_f [1/(N*m)]
    linear_stiffness: float = 10000.0           # K_f [N*m/rad]
    starting_torque: float = 0.037              # T_fs [N*m, shaft]
    viscous_friction: float = 5.96e-5           # r_m, by (A.1) [N*m*s/rad, shaft]
    ratio: float = 100.0                        # N
    link_length: float = 0.15                   # l_a [m]


class Catalogue(NamedTuple):
    """Torsion of a gear in three segments."""

    first_stiffness: float                      # K_1 [N*m/rad]
    second_stiffness: float                     # K_2 [N*m/rad]
    third_stiffness: float                      # K_3 [N*m/rad]
    knee_1: float                               # T_1 [N*m]
    knee_2: float                               # T_2 [N*m]


PRINTED = TableOne()
_GEAR = gear('CSG-17-100')
CATALOGUE = Catalogue(*_GEAR.stiffness, *_GEAR.knees)


def viscous_friction(torque_constant: float, current: float, speed: float) -> float:
    """Return r_m by (A.1) [N*m*s/rad] of k_m [N*m/A], I_0 [A] and n_0 [1/min]."""
    return 30.0 * torque_constant * current / (speed * np.pi)


def flexspline_torque(torsion: Array | float) -> Array:
    """Return the torque of a torsion [rad] by (B.2), with its pole and what is beyond [N*m]."""
    c, k = PRINTED.flexspline_curvature, PRINTED.tangent_stiffness
    return np.asarray(np.tan(np.asarray(torsion) * c * k) / c)


def wave_generator_torsion(torque: Array | float) -> Array:
    """Return the wind-up of a torque at the wave generator [N*m, shaft] by (B.1) [rad, shaft]."""
    c, k = PRINTED.wave_generator_curvature, PRINTED.wave_generator_stiffness
    size = np.asarray(torque, float)
    return np.asarray(-np.sign(size) * np.expm1(-c * np.abs(size)) / (c * k))


def estimated_torque(torsion: Array | float, wave_generator_torque: Array | float) -> Array:
    """Return (13): the torque of a total torsion [rad], kinematic torsion taken off [N*m]."""
    wound = wave_generator_torsion(wave_generator_torque)
    return flexspline_torque(torsion + wound / PRINTED.ratio)


def tip_force(torque_1: Array, torque_2: Array, elbow: Array) -> tuple[Array, Array]:
    """Return F_x and F_y by (14a, b) [N] of joint torques [N*m] at an elbow angle [rad]."""
    length = PRINTED.link_length
    return (torque_2 / length,
            (torque_2 * (1.0 + length * np.cos(elbow)) - torque_1) / length)


def force_direction(torque_1: Array, torque_2: Array, elbow: Array) -> Array:
    """Return theta_F by (15) [rad]."""
    length = PRINTED.link_length
    below = torque_2 * (1.0 + length * np.cos(elbow)) - torque_1
    return np.asarray(np.arctan(torque_2 * np.sin(elbow) / below))
