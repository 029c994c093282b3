"""
Friction of a joint at its motor: what the motor's torque does beyond inertia and load.

Only sliding counts: at rest friction takes any value up to its level. Which parts there are is
decided by what each gains on stretches that the fit has not seen.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects.friction import load_budget, stribeck_budget
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from .arm_numbers import NINETY, Number
from .descent import FOLDS, noise_of, rms, STRETCH
from .passage import Passage

Floats = NDArray[np.float64]
SLOWEST = 1.0           # shaft speed from which friction slides for certain [rad/s]
FEWEST = 200            # rows that slide
GAIN = 0.01             # least relative gain that makes a part worth it


class Sliding(NamedTuple):
    """Rows in which a joint slides: speed, torque through the gear, friction (m,)."""

    velocity: Floats    # [rad/s]
    load: Floats        # [N*m output]
    friction: Floats    # against the motion [N*m motor]
    stretch: NDArray[np.int64]


class Part(NamedTuple):
    """A part of friction: names, units, where to begin and end, and its share of the law."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    start: tuple[float, ...]
    high: tuple[float, ...]
    torque: Callable[[Sliding, Floats, float], Floats]


def _asymmetric(seen: Sliding, values: Floats, ratio: float) -> Floats:
    return np.sign(seen.velocity) * values[0]


DRY = Part(('coulomb_friction.level', 'viscous_friction.slope'), ('N*m', 'N*m*s/rad'),
           (0.03, 1e-4), (5.0, 1.0),
           lambda seen, values, ratio: values[0] + values[1] * np.abs(seen.velocity))
MORE = (
    Part(('load_dependent_friction.coefficient',), ('',), (0.05,), (0.9,),
         lambda seen, values, ratio: load_budget(seen.load, ratio, values[0])),
    Part(('stribeck_friction.excess', 'stribeck_friction.speed'), ('N*m', 'rad/s'),
         (0.01, 6.0), (5.0, 50.0),
         lambda seen, values, ratio: stribeck_budget(seen.velocity, values[0], values[1])),
    Part(('asymmetric_friction.asymmetry',), ('',), (0.0,), (1.0,), _asymmetric))


def friction(arm: Arm, passages: Sequence[Passage]) -> list[Number]:
    """Return the friction of the only joint of an arm; none where the motor hardly slides."""
    seen = sliding(arm, passages)
    if len(seen.friction) < FEWEST:
        return []
    parts = [DRY]
    best = _held_out(seen, parts, arm.joints[0].ratio)
    while rest := [part for part in MORE if part not in parts]:
        trials = [_held_out(seen, [*parts, part], arm.joints[0].ratio) for part in rest]
        if min(trials) > (1.0 - GAIN) * best:
            break
        best = min(trials)
        parts.append(rest[int(np.argmin(trials))])
    return _numbers(seen, parts, arm.joints[0].ratio)


def sliding(arm: Arm, passages: Sequence[Passage]) -> Sliding:
    """Return the rows of passages in which the joint slides and its command is known."""
    joint, label = arm.joints[0], arm.labels[0]
    inertia = joint.motor_inertia * (1.0 + arm.effect('motor_inertia_error', label).values()[0])
    columns, first = [], 0
    for passage in passages:
        held = np.concatenate([passage.command[:1], passage.command[:-1]])
        torque = 0.5 * (passage.command + held) - inertia * passage.motor_acceleration
        rest = passage.thinned(torque - passage.reference / joint.ratio)
        velocity, load = (passage.thinned(passage.motor_rate), passage.thinned(passage.reference))
        used = passage.rows_used() & (np.abs(velocity) > SLOWEST) & np.isfinite(rest)
        length = max(1, round(STRETCH / (passage.dt * passage.every)))
        stretch = first + np.arange(len(rest)) // length
        first = int(stretch[-1]) + 1
        columns.append((velocity[used], load[used], (np.sign(velocity) * rest)[used],
                        stretch[used]))
    return Sliding(*(np.concatenate(column) for column in zip(*columns)))


def _law(seen: Sliding, parts: Sequence[Part], values: Floats, ratio: float) -> Floats:
    """Return the friction of these parts (m,) [N*m motor]."""
    total, first = np.zeros_like(seen.velocity), 0
    for part in parts:
        last = first + len(part.names)
        total, first = total + part.torque(seen, values[first:last], ratio), last
    return total


def _fit(seen: Sliding, parts: Sequence[Part], ratio: float) -> tuple[Floats, Floats]:
    """Return the values of the parts, and the slopes of their errors (m, p)."""
    start = np.array([value for part in parts for value in part.start])
    high = np.array([value for part in parts for value in part.high])
    low = np.array([-1.0 if name.startswith('asym') else 0.1 if name.endswith('speed') else 0.0
                    for part in parts for name in part.names])

    def error(values: Floats) -> Floats:
        return _law(seen, parts, values, ratio) - seen.friction

    found = least_squares(error, start, bounds=(low, high), x_scale=np.maximum(start, 0.01),
                          loss='soft_l1', f_scale=3e-3)
    return found.x, np.asarray(found.jac)


def _held_out(seen: Sliding, parts: Sequence[Part], ratio: float) -> float:
    """Return the error on stretches that the fit has not seen [N*m motor, rms]."""
    left = np.empty_like(seen.friction)
    for fold in range(FOLDS):
        other = seen.stretch % FOLDS != fold
        values, _ = _fit(_rows(seen, other), parts, ratio)
        left[~other] = _law(_rows(seen, ~other), parts, values, ratio) - seen.friction[~other]
    return rms(left)


def _rows(seen: Sliding, chosen: NDArray[np.bool_]) -> Sliding:
    return Sliding(seen.velocity[chosen], seen.load[chosen], seen.friction[chosen],
                   seen.stretch[chosen])


def _numbers(seen: Sliding, parts: Sequence[Part], ratio: float) -> list[Number]:
    """Return the numbers of the parts with intervals."""
    values, slopes = _fit(seen, parts, ratio)
    error = _law(seen, parts, values, ratio) - seen.friction
    spread = np.sqrt(np.diag(np.linalg.pinv(slopes.T @ slopes, hermitian=True)))
    spread *= noise_of(error, seen.stretch)
    names = [name for part in parts for name in part.names]
    units = [unit for part in parts for unit in part.units]
    found = []
    for name, unit, value, sigma in zip(names, units, values, spread):
        if name == 'asymmetric_friction.asymmetry':     # a share of the dry level
            value, sigma = value / values[0], sigma / values[0]
        found.append(Number(name, float(value), float(value - NINETY * sigma),
                            float(value + NINETY * sigma), unit))
    return found
