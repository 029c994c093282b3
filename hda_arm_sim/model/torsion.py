"""
Torsion of the harmonic drive: flexspline and wave generator in series (docs/model.md).

Torque is the torque through the gear at its output [N*m], positive when it drives the link.
Torsion is motor side minus link side at the output [rad], so both have the same sign.
"""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ..foundation.compiled import compiled, Number, Record
from ..foundation.parameter import Declared, parameter, ParameterError

_LINEAR = 1e-9          # below this curvature [1/(N*m)] a law is its own tangent to 1e-15
_MAX_ITERATIONS = 60
_STEPS = 4              # to the torque of another stiffness, half to twice it: leaves 1e-6 of it


@compiled
def flexspline_torsion(torque: Number, stiffness: float, curvature: float) -> Number:
    """Return the flexspline's torsion, (eq:flexspline) atan(c_f tau) / (c_f K_f0) [rad]."""
    c = np.maximum(curvature, _LINEAR)
    return np.arctan(c * torque) / (c * stiffness)


@compiled
def segmented_torsion(torque: Number, stiffness: float, knee_1: float, second_stiffness: float,
                      knee_2: float, third_stiffness: float) -> Number:
    """Return a flexspline's torsion with up to three straight segments, (eq:segments) [rad]."""
    size = np.abs(torque)
    far = knee_2 if knee_2 > knee_1 else np.inf
    torsion = (np.minimum(size, knee_1) / stiffness
               + np.minimum(np.maximum(size - knee_1, 0.0), far - knee_1) / second_stiffness)
    if knee_2 > knee_1:
        torsion += np.maximum(size - knee_2, 0.0) / third_stiffness
    return np.sign(torque) * torsion


@compiled
def chords(stiffness: float, curvature: float, knee_1: float,
           knee_2: float) -> tuple[float, float, float]:
    """Return K1, K2, K3 of segments that meet the tangent law at T1, T2, 2 T2, (eq:stiffening)."""
    ends = [flexspline_torsion(torque, stiffness, curvature)
            for torque in (knee_1, knee_2, 2.0 * knee_2)]
    return (knee_1 / ends[0], (knee_2 - knee_1) / (ends[1] - ends[0]),
            knee_2 / (ends[2] - ends[1]))


@compiled
def wave_generator_torsion(torque: Number, ratio: float, stiffness: float,
                           curvature: float) -> Number:
    """Return the wave generator's wind-up seen at the output, (eq:wind-up) [rad]."""
    c = np.maximum(curvature, _LINEAR)
    return -np.sign(torque) * np.expm1(-c * np.abs(torque) / ratio) / (ratio * c * stiffness)


@compiled
def torsion_of_torque(law: Record, ratio: float, torque: Number) -> Number:
    """Return the total torsion under a torque within the valid range, (eq:torsion) [rad]."""
    wound = wave_generator_torsion(torque, ratio, law.wave_generator_stiffness,
                                   law.wave_generator_curvature)
    if law.knee_1 > 0.0:
        return wound + segmented_torsion(torque, law.flexspline_stiffness, law.knee_1,
                                         law.second_stiffness, law.knee_2, law.third_stiffness)
    return wound + flexspline_torsion(torque, law.flexspline_stiffness, law.flexspline_curvature)


@compiled
def _series(law: Record, ratio: float, torque: float) -> tuple[float, float, float]:
    """Return torsion, its slope and half its curvature at a torque >= 0, from one atan and exp."""
    cw = max(law.wave_generator_curvature, _LINEAR) / ratio
    soft = 1.0 / (ratio * ratio * law.wave_generator_stiffness)
    wound = -np.expm1(-cw * torque)
    torsion, slope = soft * wound / cw, soft * (1.0 - wound)
    bend = -0.5 * cw * slope
    if law.knee_1 > 0.0:
        flexed, flex = _segment(law, torque)
        return torsion + flexed, slope + flex, bend
    c, k = max(law.flexspline_curvature, _LINEAR), law.flexspline_stiffness
    flex = 1.0 / (k * (1.0 + (c * torque) ** 2))
    return (torsion + np.arctan(c * torque) / (c * k), slope + flex,
            bend - flex * flex * k * c * c * torque)


@compiled
def _segment(law: Record, torque: float) -> tuple[float, float]:
    """Return the torsion of the segments and its slope at a torque >= 0."""
    torsion = segmented_torsion(torque, law.flexspline_stiffness, law.knee_1,
                                law.second_stiffness, law.knee_2, law.third_stiffness)
    stiffness = law.flexspline_stiffness
    if torque > law.knee_1:
        stiffness = law.second_stiffness
    if torque > law.knee_2 > law.knee_1:
        stiffness = law.third_stiffness
    return torsion, 1.0 / stiffness


@compiled
def _flexed(law: Record, torque: float) -> tuple[float, float]:
    """Return the flexspline's torsion [rad] and its slope at a torque >= 0."""
    if law.knee_1 > 0.0:
        return _segment(law, torque)
    c, k = max(law.flexspline_curvature, _LINEAR), law.flexspline_stiffness
    return np.arctan(c * torque) / (c * k), 1.0 / (k * (1.0 + (c * torque) ** 2))


@compiled
def flexed(law: Record, torque: float) -> float:
    """Return the flexspline's part of the torsion at a torque of the valid range [rad]."""
    torsion = _flexed(law, min(abs(torque), law.valid_torque))[0]
    return torsion if torque > 0.0 else -torsion


@compiled
def _softer(law: Record, ratio: float, torque: float, factor: float,
            more: float) -> tuple[float, float]:
    """Return torsion and slope at a torque >= 0, the flexspline being stiffer by a factor."""
    near = min(torque, law.valid_torque)
    torsion, slope, _ = _series(law, ratio, near)
    bent, flex = _flexed(law, near)
    softer = 1.0 / factor - 1.0
    slope += softer * flex + more
    return torsion + softer * bent + more * near + slope * (torque - near), slope


@compiled
def stiffer_torsion(law: Record, ratio: float, torque: float, factor: float,
                    growing: float) -> tuple[float, float]:
    """
    Return torsion [rad] and its slope if the flexspline is stiffer by a factor, (eq:stiffer).

    `growing` is as in `torque_of_torsion`. Beyond the valid torque both follow the last slope.
    """
    more = -growing if torque > 0.0 else growing
    torsion, slope = _softer(law, ratio, abs(torque), factor, more)
    return (torsion if torque > 0.0 else -torsion), slope


@compiled
def stiffer_torque(law: Record, ratio: float, torque: float, factor: float,
                   growing: float) -> float:
    """
    Return the torque of a torsion if the flexspline is stiffer by a factor, (eq:stiffer) [N*m].

    `torque` is what the law gives for that torsion as it stands. The law is concave: so its
    tangent at zero bounds the torque from below, and from there Newton's steps do not pass it.
    """
    if factor == 1.0 or torque == 0.0:
        return torque
    size, more = abs(torque), (-growing if torque > 0.0 else growing)
    torsion = _softer(law, ratio, size, 1.0, more)[0]
    lowest = torsion / _softer(law, ratio, 0.0, factor, more)[1]
    for _ in range(_STEPS):
        there, slope = _softer(law, ratio, size, factor, more)
        size = max(size + (torsion - there) / slope, lowest)
    return size if torque > 0.0 else -size


@compiled
def stiffness_at(law: Record, ratio: float, torque: float) -> float:
    """Return the local stiffness d tau / d torsion [N*m/rad] at a torque [N*m]."""
    return 1.0 / _series(law, ratio, min(abs(torque), law.valid_torque))[1]


@compiled
def torque_from_guess(law: Record, ratio: float, torsion: float, guess: float,
                      accuracy: float, growing: float = 0.0) -> tuple[float, float]:
    """
    Return the torque under a torsion [N*m] and its local slope [rad/(N*m)], for one value.

    Halley's iteration on the concave law (eq:torsion), from a guess of the torque. The tangent at
    zero bounds the root from below, and no step may pass under that bound. So the pole of the
    tangent law is never met. It ends with a step below `accuracy` (relative), and being cubic
    leaves an error of about its third power. `growing` is what every N*m of the torque, whatever
    its sign, adds to the torsion: a compliance in series, of another sign on either side.
    """
    size, more = abs(torsion), (-growing if torsion > 0.0 else growing)
    end = law.valid_torsion + more * law.valid_torque
    if size >= end:
        last = law.last_stiffness / (1.0 + more * law.last_stiffness)
        torque = law.valid_torque + last * (size - end)
        return (torque if torsion > 0.0 else -torque), 1.0 / last
    lowest = size * law.first_stiffness * (1.0 - more * law.first_stiffness)
    torque = min(max(abs(guess), lowest), law.valid_torque)
    slope = 0.0
    for _ in range(_MAX_ITERATIONS):
        value, slope, bend = _series(law, ratio, torque)
        if more != 0.0:
            value, slope = value + more * torque, slope + more
        newton = (size - value) / slope
        change = newton / max(1.0 + newton * bend / slope, 0.5)
        torque = max(torque + change, lowest)
        if abs(newton) <= accuracy * torque:
            break
    return (torque if torsion > 0.0 else -torque), slope


@compiled
def torque_of_torsion(law: Record, ratio: float, torsion: float, growing: float = 0.0) -> float:
    """
    Return the torque under a torsion, the inverse of (eq:torsion), for one value [N*m].

    Beyond `valid_torque` the torque goes on along the last slope, (eq:beyond-range). `growing`
    [rad/(N*m)] is what the torque adds to the torsion for each of its N*m, whatever its sign.
    """
    return torque_from_guess(law, ratio, torsion, 0.0, 1e-5, growing)[0]


@dataclass(frozen=True)
class TorsionLaw(Declared):
    """Stiffness of one joint's gear, (eq:torsion); an infinite stiffness leaves its part out."""

    name: ClassVar[str] = 'torsion'
    flexspline_stiffness: float = parameter(
        9743.939, 'N*m/rad', 1.0, 1e7, 'K_f0, flexspline at zero torque, output side')
    flexspline_curvature: float = parameter(
        0.0831, '1/(N*m)', 0.0, 10.0, 'c_f, stiffening of the flexspline, 0 for linear')
    wave_generator_stiffness: float = parameter(
        2.5517, 'N*m/rad', 1e-3, np.inf, 'K_w0, wave generator at zero torque, motor side')
    wave_generator_curvature: float = parameter(
        27.027, '1/(N*m)', 0.0, 1e4, 'c_w, stiffening of the wave generator, motor side')
    knee_1: float = parameter(
        0.0, 'N*m', 0.0, 1e4, 'T1, end of the first of three segments, 0 for the tangent law')
    second_stiffness: float = parameter(
        0.0, 'N*m/rad', 0.0, 1e7, 'K2, flexspline between T1 and T2, output side')
    knee_2: float = parameter(
        0.0, 'N*m', 0.0, 1e4, 'T2, end of the second segment, 0 for none')
    third_stiffness: float = parameter(
        0.0, 'N*m/rad', 0.0, 1e7, 'K3, flexspline beyond T2, output side')
    damping: float = parameter(
        8.0, 'N*m*s/rad', 0.0, 1e4, 'D, damping of the torsion, output side')
    valid_torque: float = parameter(
        37.0, 'N*m', 1e-3, 1e4, 'largest torque of the curved law; beyond, the last slope')
    deviation: float = parameter(
        0.0, 'N*m', 0.0, 1e3, 'of true torques from all that is known of the torsion, one sigma')

    def __post_init__(self) -> None:
        """Check every parameter, and that segments have stiffnesses; raises ParameterError."""
        super().__post_init__()
        for knee, stiffness in (('knee_1', 'second_stiffness'), ('knee_2', 'third_stiffness')):
            if getattr(self, knee) > 0.0 and getattr(self, stiffness) <= 0.0:
                raise ParameterError(f'torsion.{knee} needs torsion.{stiffness} > 0 N*m/rad '
                                     'beyond the knee, got 0')
        if self.knee_2 > 0.0 and not 0.0 < self.knee_1 < self.knee_2:
            raise ParameterError('torsion.knee_2 must lie beyond torsion.knee_1 > 0 N*m, got '
                                 f'{self.knee_1:g} and {self.knee_2:g}')

    @classmethod
    def record_type(cls) -> np.dtype[Any]:
        """Return the declared fields and the derived ones that the inverse needs."""
        derived = ('valid_torsion', 'first_stiffness', 'last_stiffness')
        return np.dtype([*super().record_type().descr, *((name, float) for name in derived)])

    def record(self, ratio: float) -> Any:
        """Return the law as compiled code reads it, for a gear of this ratio."""
        record = np.zeros((), self.record_type())[()]
        for rule in self.declarations():
            record[rule.name] = getattr(self, rule.name)
        record['first_stiffness'] = 1.0 / _series(record, ratio, 0.0)[1]
        value, slope, _ = _series(record, ratio, self.valid_torque)
        record['valid_torsion'], record['last_stiffness'] = value, 1.0 / slope
        return record
