"""
Calibrate the imperfect rig from slow turns under load, by one linear least-squares fit.

What the total torsion holds beyond the zero is linear in nearly all that is not known. This is
waves of the shaft and of the link, the skew, the compliance of each segment of the gear, the loop.
"""

from functools import cache
import math

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import (ClockSkew, KinematicError, LinkEncoderEccentricity,
                                       StiffeningError, StiffnessError, TorsionalHysteresis,
                                       WaveGeneratorCompliance)
from hda_arm_sim.model.effects.place import SLIDERS
from hda_arm_sim.model.parts import Joint
import numpy as np

from . import bench
from .printed import CATALOGUE
from .shapes import sine, step
from ...estimating.laws.torsion_torque import slide
from ...samples.readings import LINK_RATE, LINK_READING, MOTOR_READING

SHAFT_ORDERS, LINK_ORDERS = (1, 2, 4), (1, 2)
WIDTH = 1.5e-4                      # of the loop: half an arcmin, as usual [rad]
_SPEED, _SECONDS = 0.2, 36.0        # of the slow turns [rad/s], [s]
_SETTLED = 2500                     # samples at the start that are not used
_SMOOTH = 25                        # samples over which rates and torsion are averaged
_ELASTIC = 3                        # columns of the gear's segments


@cache
def calibrated(true: Arm, known: Arm) -> Arm:
    """
    Return what a slow turn of `true` forth and back, with a torque sensor, teaches about `known`.

    The loop follows the elastic torsion, which a first fit without the loop has to find.
    """
    made, torque = _recorded(true, known)
    used = slice(_SETTLED, None)
    columns, torsion = _columns(made.reading[:, 0], torque), made.torsion[:, 0]
    first = _fit(columns[used], torsion[used])
    elastic = _smooth(torsion - columns[:, _ELASTIC:] @ first[_ELASTIC:])
    with_loop = np.hstack([columns, _loop(elastic)[:, None]])
    return _with_values(known, _fit(with_loop[used], torsion[used]))


def _recorded(true: Arm, known: Arm) -> tuple[bench.BenchRun, Array]:
    """Return a slow turn forth and back under a slowly changing load, and the measured torque."""
    time = bench.quiet(1, 2.0 * _SECONDS).time
    rate = _SPEED * (step(time, 1.0, _SECONDS, 1.0) - step(time, _SECONDS, 2.0 * _SECONDS, 1.0))
    torque = 10.0 * sine(time, 0.07, 2.0) + 3.0 * sine(time, 0.31, 2.0)
    return bench.follow(true, known, rate, -torque), torque


def _fit(columns: Array, torsion: Array) -> Array:
    return np.asarray(np.linalg.lstsq(columns, torsion, rcond=None)[0])


def _smooth(values: Array) -> Array:
    """Return a running mean, the ends held."""
    padded = np.pad(values, _SMOOTH // 2, mode='edge')
    return np.convolve(padded, np.full(_SMOOTH, 1.0 / _SMOOTH), 'valid')


def _columns(reading: Array, torque: Array) -> Array:
    """Return what the torsion is made of (k, 15): three segments of torque, then all else."""
    shaft, link = reading[:, MOTOR_READING], reading[:, LINK_READING]
    return np.stack([*_segments(torque), *waves(shaft, SHAFT_ORDERS), *waves(link, LINK_ORDERS),
                     _smooth(np.nan_to_num(reading[:, LINK_RATE])), np.ones_like(shaft)], axis=1)


def waves(angle: Array, orders: tuple[int, ...]) -> list[Array]:
    """Return sine and cosine of each order of an angle."""
    return [shape(order * angle) for order in orders for shape in (np.sin, np.cos)]


def _segments(torque: Array) -> list[Array]:
    """Return the torque within each of the catalogue's segments, with its sign [N*m]."""
    size, (first, second) = np.abs(torque), (CATALOGUE.knee_1, CATALOGUE.knee_2)
    return [np.sign(torque) * part for part in (
        np.minimum(size, first), np.clip(size - first, 0.0, second - first),
        np.maximum(size - second, 0.0))]


def _loop(elastic: Array) -> Array:
    """Return the state of a hysteresis loop of the usual width along an elastic torsion (k,)."""
    arm = Arm((Joint(),)).with_effect(TorsionalHysteresis(level=1.0, width=WIDTH), 'joint1')
    joint, stretch, found = arm.record().joints[0], np.zeros(SLIDERS), np.empty(len(elastic))
    for k, change in enumerate(np.diff(elastic, prepend=elastic[0])):
        found[k] = slide(joint, change, stretch)
    return found


def _with_values(arm: Arm, values: Array) -> Arm:
    """Return the arm with the effects that the coefficients mean."""
    label, law = arm.labels[0], arm.joints[0].torsion
    stiffness, rest = 1.0 / np.maximum(values[:_ELASTIC], 1e-6), values[_ELASTIC:]
    kinematic = [_wave(-rest[k:k + 2]) for k in (0, 2, 4)]
    scale = [_wave(-rest[k:k + 2]) for k in (6, 8)]
    effects = (
        KinematicError(amplitude_1=kinematic[0][0], phase_1=kinematic[0][1],
                       amplitude_2=kinematic[1][0], phase_2=kinematic[1][1],
                       amplitude_4=kinematic[2][0], phase_4=kinematic[2][1]),
        LinkEncoderEccentricity(amplitude_1=scale[0][0], phase_1=scale[0][1],
                                amplitude_2=scale[1][0], phase_2=scale[1][1]),
        ClockSkew(skew=-float(rest[10])),
        StiffnessError(error=float(stiffness[0]) / law.flexspline_stiffness - 1.0),
        StiffeningError(knee_1=CATALOGUE.knee_1, second_stiffness=float(stiffness[1]),
                        knee_2=CATALOGUE.knee_2, third_stiffness=float(stiffness[2])),
        WaveGeneratorCompliance(compliance=-1.0 / law.wave_generator_stiffness),
        TorsionalHysteresis(level=max(-float(rest[12]) * float(stiffness[0]), 0.0),
                            width=WIDTH))
    for effect in effects:
        arm = arm.with_effect(effect, label)
    return arm


def _wave(parts: Array) -> tuple[float, float]:
    """Return amplitude and phase of sine and cosine parts."""
    return math.hypot(*parts), math.atan2(parts[1], parts[0])
