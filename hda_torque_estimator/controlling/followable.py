"""
Find out if an arm can follow a reference: angle, speed, motor torque, also between points.

Angles and rates of a cubic have their extremes in closed form. The torque does not: it is sampled
so densely that it hardly bends between two samples, and what it may bend is added.
"""

from typing import NamedTuple, TYPE_CHECKING

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.chain import Chain, torques_along
from hda_arm_sim.foundation.compiled import interpreted
from hda_arm_sim.foundation.rigid import coriolis, gravity_torque, mass_matrix
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.link_side import loaded_inertia
import numpy as np

if TYPE_CHECKING:
    from scipy.interpolate import PPoly

# Choices unless stated otherwise.
PER_PIECE = 8           # samples of the torque in a piece: it bends with waves longer than a piece
TOGETHER = 4096         # pieces that are looked at together: a few milliseconds each


class Worst(NamedTuple):
    """What goes beyond a limit first: which joint, what it is, and its limit."""

    joint: str
    what: str
    value: float
    bounds: tuple[float, float]
    unit: str
    time: float                 # since the start of the reference [s]

    def __str__(self) -> str:
        """Return one sentence."""
        return (f'{self.joint}: the {self.what} must stay within {within(*self.bounds)} '
                f'{self.unit}, got {self.value:.4g} {self.unit} at {self.time:.3g} s')


def within(low: float, high: float) -> str:
    """Return a range in words: `+-2` where it is the same both ways."""
    return f'+-{high:g}' if low == -high else f'{low:g} to {high:g}'


def worst(arm: Arm, curve: 'PPoly', pieces: int | None = None) -> Worst | None:
    """Return what an arm cannot follow in a cubic curve or its first pieces; None if it can."""
    count = curve.c.shape[1] if pieces is None else min(pieces, curve.c.shape[1])
    with np.errstate(all='ignore'):
        for begin in range(0, count, TOGETHER):
            rows = slice(begin, min(begin + TOGETHER, count))
            found = _beyond(arm, curve.c[:, rows], np.diff(curve.x)[rows], curve.x[rows])
            if found is not None:
                return found
    return None


def _beyond(arm: Arm, c: Array, span: Array, begin: Array) -> Worst | None:
    """Judge pieces with coefficients c (4, m, n) over spans (m,) [s]."""
    ranges = arm.ranges()
    middle = ranges.mean(axis=1)
    angle, rate = _extremes(np.concatenate([c[:3], c[3:] - middle]), span)
    limits = [(angle + middle, 'angle', ranges, 'rad'),
              (rate, 'rate', _both_ways([joint.velocity_limit / joint.ratio
                                         for joint in arm.joints]), 'rad/s')]
    for values, what, most, unit in limits:
        if (found := _first(arm, values, what, most, unit, begin)) is not None:
            return found
    torque = _torques(arm, c, span)
    return _first(arm, torque, 'motor torque',
                  _both_ways([joint.torque_limit for joint in arm.joints]), 'N*m', begin)


def _both_ways(most: list[float]) -> Array:
    return np.outer(most, (-1.0, 1.0))


def _first(arm: Arm, values: Array, what: str, ranges: Array, unit: str,
           begin: Array) -> Worst | None:
    """Return the first of values (m, n) that is not in its range (n, 2); NaN never is."""
    bad = ~((ranges[:, 0] <= values) & (values <= ranges[:, 1]))
    if not bad.any():
        return None
    piece, joint = np.argwhere(bad)[0]
    low, high = ranges[joint].tolist()
    return Worst(arm.labels[joint], what, float(values[piece, joint]), (low, high), unit,
                 float(begin[piece]))


def _extremes(c: Array, span: Array) -> tuple[Array, Array]:
    """Return the angle and the rate (m, n) of the largest size in every piece."""
    end = span[:, None]
    root = np.sqrt(np.maximum(c[1] ** 2 - 3.0 * c[0] * c[2], 0.0))
    turns = [(-c[1] + sign * root) / (3.0 * c[0]) for sign in (1.0, -1.0)]
    turns.append(-c[2] / (2.0 * c[1]))                  # of a piece that is no cubic
    angles = [_inside(turn, end, c) for turn in (0.0 * end, end, *turns)]
    bend = -c[1] / (3.0 * c[0])
    rates = [_slope(np.where((bend > 0.0) & (bend < end), bend, 0.0), c), _slope(0.0 * end, c),
             _slope(end, c)]
    return _largest(angles), _largest(rates)


def _inside(turn: Array, end: Array, c: Array) -> Array:
    at = np.where((turn > 0.0) & (turn < end), turn, np.where(turn == end, end, 0.0))
    return np.asarray(((c[0] * at + c[1]) * at + c[2]) * at + c[3])


def _slope(at: Array, c: Array) -> Array:
    return np.asarray((3.0 * c[0] * at + 2.0 * c[1]) * at + c[2])


def _largest(choices: list[Array]) -> Array:
    """Return of several arrays (m, n) the values of the largest size; NaN wins."""
    table = np.array(np.broadcast_arrays(*choices))
    size = np.where(np.isnan(table), np.inf, np.abs(table))
    return np.asarray(np.take_along_axis(table, size.argmax(axis=0)[None], axis=0)[0])


def _torques(arm: Arm, c: Array, span: Array) -> Array:
    """Return the motor torques (m, n) of the largest size in every piece [N*m, shaft]."""
    at = (np.linspace(0.0, 1.0, PER_PIECE + 1)[:, None, None] * span[None, :, None])
    angle = ((c[0] * at + c[1]) * at + c[2]) * at + c[3]
    rate, speeding = _slope(at, c), 6.0 * c[0] * at + 2.0 * c[1]
    torque = motor_torques(arm, angle, rate, speeding)
    bend = np.abs(np.diff(torque, 2, axis=0)).max(axis=0) / 8.0     # of a parabola between two
    top = _largest(list(torque))
    return np.asarray(top + np.copysign(bend, top))


def motor_torques(arm: Arm, angle: Array, rate: Array, speeding: Array) -> Array:
    """
    Return the motor torques that a motion (..., n) needs, backwards by (eq:motor) [N*m, shaft].

    `angle` [rad], `rate` [rad/s] and `speeding` [rad/s^2] are those of the links. An arm without
    links is asked for its rotors and their friction alone.
    """
    joints = arm.record().joints
    ratio, inertia = joints['ratio'], joints['motor_inertia']
    made = inertia * ratio * speeding
    made += np.array([joint.viscous_friction for joint in arm.joints]) * ratio * rate
    if arm.links is not None:
        made += _gear_torques(arm, angle, rate, speeding) / ratio
    sense = np.where(rate != 0.0, np.sign(rate), np.sign(made))     # at rest: about to start
    return np.asarray(made + np.array([joint.dry_friction for joint in arm.joints]) * sense)


def _gear_torques(arm: Arm, angle: Array, rate: Array, speeding: Array) -> Array:
    """Return the torques through the gears; the laws are called as they stand, on arrays."""
    body, last = arm.record().body, angle.shape[-1] - 1
    inertia = loaded_inertia(body)
    if isinstance(inertia, Chain):
        motion = np.stack([angle, rate, speeding], axis=-1).reshape(-1, last + 1, 3)
        needed = np.empty(motion.shape[:2])
        torques_along(inertia.table, motion, needed)
        return needed.reshape(angle.shape)
    q1, q2 = angle[..., 0], angle[..., last]
    if last == 0:
        weight = interpreted(gravity_torque)(
            inertia, body['pull'], body['direction'], q1, 0.0 * q1)[0]
        return np.asarray((inertia.p1 * speeding[..., 0] - weight)[..., None])
    m11, m12, m22 = interpreted(mass_matrix)(inertia, q2)
    swing = interpreted(coriolis)(inertia, q2, rate[..., 0], rate[..., 1])
    weight1, weight2 = interpreted(gravity_torque)(
        inertia, body['pull'], body['direction'], q1, q2)
    return np.stack([m11 * speeding[..., 0] + m12 * speeding[..., 1] + swing[0] - weight1,
                     m12 * speeding[..., 0] + m22 * speeding[..., 1] + swing[1] - weight2],
                    axis=-1)
