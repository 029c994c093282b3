"""
Friction of a joint at its motor: what the motor's torque does beyond inertia and load.

Only sliding counts: at rest friction takes any value up to its level. Which parts there are is
decided by what each gains on stretches that the fit has not seen.
"""

from collections.abc import Callable, Sequence
import math
from typing import Any, NamedTuple

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import Effect, effect_named
from hda_arm_sim.model.effects.catalogue import known_as, unmeasured_at
from hda_arm_sim.model.effects.place import BREAKAWAY, DRY_LEVEL, MESH
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d, minimum_filter1d
from scipy.stats import t as student

from .arm_numbers import ArmNumber, LEVEL, number, SLOPE
from .torsion_fits import STRETCH
from ..passages.passage import Passage
from ...least_squares.bounds import declaration
from ...least_squares.descent import damped, improved, SHARES
from ...least_squares.normal import RIDGE, within
from ...least_squares.rows import FOLDS, rms
from ...measurements.motion import WINDOW
from ...significance import NORMAL_90

Floats = NDArray[np.float64]
# Choices unless stated otherwise.
SLOWEST = 1.0           # shaft speed from which friction slides for certain [rad/s]
FEWEST = 200            # rows that slide
GAIN = 0.01             # least relative gain that makes a part worth it
CERTAIN = 3.0           # sigmas from zero, from which a part is there
MOMENT = 1.0            # time that is left out to see what the numbers rest on [s]
LEAST = 1e-9            # dry friction of which a share is observable [N*m]
FEWEST_BESIDE = 3       # samples that derivatives see on either side at low rates
LARGE = 3e-3            # error that counts less, for it passes for another cause [N*m motor]
PASSES = 40             # of a fit at most
SMALLEST = 1e-9         # gain of the score of a fit that ends it
SLIGHT = 1e-6           # of a number, or of its usual size, for a slope
_LEVEL, _DRAG = known_as('dry_friction'), known_as('viscous_friction')
_OF_LOAD, _NEAR_REST = unmeasured_at(MESH), unmeasured_at(BREAKAWAY)
# Fitted in N*m, stated as a share of the dry level.
ASYMMETRY = f'{unmeasured_at(DRY_LEVEL).name}.asymmetry'


class Sliding(NamedTuple):
    """Rows in which a joint slides one way: speed, torque through the gear, friction (m,)."""

    velocity: Floats    # [rad/s]
    load: Floats        # [N*m output]
    friction: Floats    # against the motion [N*m motor]
    doubt: Floats       # (m, DOUBTS + 1) what loads and torque constant may add, one sigma each
    stretch: NDArray[np.int64]
    moment: NDArray[np.int64]       # which second the row belongs to


class FrictionPart(NamedTuple):
    """A part of friction: names, where to begin, and its share of the law."""

    names: tuple[str, ...]
    start: tuple[float, ...]
    torque: Callable[[Sliding, Floats, float], Floats]


def _asymmetric(seen: Sliding, values: Floats, ratio: float) -> Floats:
    return np.sign(seen.velocity) * values[0]


def _of_load(seen: Sliding, values: Floats, ratio: float) -> Floats:
    return _budget(_OF_LOAD, values, joint_torque=seen.load, ratio=ratio)


def _near_rest(seen: Sliding, values: Floats, ratio: float) -> Floats:
    return _budget(_NEAR_REST, values, motor_velocity=seen.velocity)


def _budget(kind: type[Effect], values: Floats, **signals: Floats | float) -> Floats:
    """Return a law's budget for its first numbers, beyond their bounds as well; others do none."""
    own = np.array((*values, *kind().values()[len(values):]), kind.record_type())[()]
    return np.asarray(kind.law(own, kind.place.reads(**signals)))


def _part(torque: Callable[[Sliding, Floats, float], Floats], *names: str) -> FrictionPart:
    """Return a part of friction that begins at the typical sizes of its numbers."""
    return FrictionPart(names, tuple(_typical(*name.split('.')) for name in names), torque)


def _typical(effect: str, number: str) -> float:
    usual = effect_named(effect).typical
    assert usual is not None
    return {**usual.more, **usual.shape}[number]


def _dry(seen: Sliding, values: Floats, ratio: float) -> Floats:
    return _budget(_LEVEL, values[:1]) + _budget(_DRAG, values[1:],
                                                 motor_velocity=np.abs(seen.velocity))


DRY = _part(_dry, LEVEL, SLOPE)
MORE = (_part(_of_load, f'{_OF_LOAD.name}.coefficient'),
        _part(_near_rest, f'{_NEAR_REST.name}.excess', f'{_NEAR_REST.name}.speed'),
        FrictionPart((ASYMMETRY,), (0.0,), _asymmetric))


def friction(arm: Arm, passages: Sequence[Passage]) -> list[ArmNumber]:
    """Return the friction of the only joint of an arm; none where the motor hardly slides."""
    seen = sliding(arm, passages)
    if len(seen.friction) < FEWEST:
        return []
    ratio, parts, rest = arm.joints[0].ratio, [DRY], list(MORE)
    best = _held_out(seen, parts, ratio)
    while rest:
        trials = [_held_out(seen, [*parts, part], ratio) for part in rest]
        part = rest.pop(int(np.argmin(trials)))
        if min(trials) > (1.0 - GAIN) * best:
            break
        if _is_certain(seen, [*parts, part], ratio):
            parts.append(part)
            best = min(trials)
    return _numbers(seen, parts, ratio)


def _is_certain(seen: Sliding, parts: Sequence[FrictionPart], ratio: float) -> bool:
    """Return whether the size of the last part is not zero, for all that is in doubt."""
    values, sigma = _known(seen, parts, ratio)
    size = -len(parts[-1].names)
    return bool(abs(values[size]) > CERTAIN * sigma[size])


def sliding(arm: Arm, passages: Sequence[Passage]) -> Sliding:
    """Return the rows of passages in which the joint slides and its command is known."""
    joint = arm.joints[0]
    inertia = float(arm.record().joints['motor_inertia'][0])
    parts, stretches, moments = [], 0, 0
    for passage in passages:
        part = _sliding(passage, inertia, joint.ratio, arm.tolerances.torque_constant)
        parts.append(part._replace(stretch=stretches + part.stretch,
                                   moment=moments + part.moment))
        stretches += 1 + int(part.stretch.max(initial=0))
        moments += 1 + int(part.moment.max(initial=0))
    columns: list[Any] = [np.concatenate(column) for column in zip(*parts)]
    return Sliding(*columns)


def _sliding(passage: Passage, inertia: float, ratio: float, tolerance: float) -> Sliding:
    """Return the rows of one passage; `tolerance` is that of the torque constant."""
    rest = passage.thinned(passage.command - inertia * passage.motor_acceleration
                           - passage.reference / ratio)
    velocity, load = passage.thinned(passage.motor_rate), passage.thinned(passage.reference)
    doubt = np.column_stack([passage.thinned(passage.doubt) / ratio,
                             tolerance * passage.thinned(passage.command)])
    sense = np.sign(velocity)
    seconds = np.arange(len(rest)) * passage.dt * passage.every
    used = passage.rows_used() & _one_way(passage) & np.isfinite(rest)
    return Sliding(velocity[used], load[used], (sense * rest)[used],
                   (sense[:, None] * doubt)[used], (seconds // STRETCH).astype(np.int64)[used],
                   (seconds // MOMENT).astype(np.int64)[used])


def _one_way(passage: Passage) -> NDArray[np.bool_]:
    """Return the rows whose derivatives saw the shaft slide one way only, all the time."""
    reach = 1 + 2 * math.ceil(max(0.5 * WINDOW / passage.dt, FEWEST_BESIDE))
    slides = ((minimum_filter1d(passage.motor_rate, reach) > SLOWEST)
              | (maximum_filter1d(passage.motor_rate, reach) < -SLOWEST))
    return passage.thinned(slides.astype(float)) == 1.0


def _law(seen: Sliding, parts: Sequence[FrictionPart], values: Floats, ratio: float) -> Floats:
    """Return the friction of these parts (m,) [N*m motor]."""
    total, first = np.zeros_like(seen.velocity), 0
    for part in parts:
        last = first + len(part.names)
        total, first = total + part.torque(seen, values[first:last], ratio), last
    return total


class _Fit(NamedTuple):
    """Values of the parts (p,) with their errors (m,); smaller scores are better."""

    values: Floats
    error: Floats
    score: float

    @property
    def soft(self) -> Floats:
        """Return by what large errors count less (m,): their square roots count (soft l1)."""
        return 1.0 + (self.error / LARGE) ** 2


def _fit(seen: Sliding, parts: Sequence[FrictionPart], ratio: float) -> tuple[Floats, Floats]:
    """Return the values of the parts, and the slopes of their errors (m, p), as they count."""
    start = np.array([value for part in parts for value in part.start])
    usual, bounds = np.maximum(start, 0.01), _bounds(parts)

    def at(values: Floats) -> _Fit:
        error = _law(seen, parts, values, ratio) - seen.friction
        return _Fit(values, error, float(2.0 * (np.sqrt(1.0 + (error / LARGE) ** 2) - 1.0).sum()))

    def slopes(fit: _Fit) -> Floats:
        steps = np.where(fit.values + SLIGHT * usual <= bounds[1], SLIGHT, -SLIGHT) * usual
        columns = [(at(fit.values + row).error - fit.error) / step
                   for row, step in zip(np.diag(steps), steps)]
        return np.stack(columns, axis=1)

    def step(fit: _Fit) -> _Fit:
        own = slopes(fit)
        weighed = own.T * fit.soft ** -0.5      # no step by these passes what it aims at
        move = within(weighed @ own, -weighed @ fit.error, fit.values, bounds, RIDGE)
        return damped(lambda share: at(np.clip(fit.values + share * move, *bounds)), SHARES,
                      lambda trial: trial.score < fit.score) or fit

    found = improved(at(start), step, lambda fit, _: fit, PASSES, SMALLEST)
    return found.values, slopes(found) * (found.soft ** -0.75)[:, None]


def _bounds(parts: Sequence[FrictionPart]) -> tuple[Floats, Floats]:
    """Return where the search of each value ends (p,); one is no number of the arm file."""
    names = [name for part in parts for name in part.names]
    rules = [declaration(LEVEL if name == ASYMMETRY else name) for name in names]
    low = [-rule.high if name == ASYMMETRY else rule.low for name, rule in zip(names, rules)]
    return np.array(low), np.array([rule.high for rule in rules])


def _held_out(seen: Sliding, parts: Sequence[FrictionPart], ratio: float) -> float:
    """Return the error on stretches that the fit has not seen [N*m motor, rms]."""
    left = np.empty_like(seen.friction)
    for fold in range(FOLDS):
        other = seen.stretch % FOLDS != fold
        values, _ = _fit(_rows(seen, other), parts, ratio)
        left[~other] = _law(_rows(seen, ~other), parts, values, ratio) - seen.friction[~other]
    return rms(left)


def _rows(seen: Sliding, chosen: NDArray[np.bool_]) -> Sliding:
    columns: list[Any] = [column[chosen] for column in seen]
    return Sliding(*columns)


def _known(seen: Sliding, parts: Sequence[FrictionPart], ratio: float) -> tuple[Floats, Floats]:
    """Return the values of the parts and their sigmas (p,)."""
    values, slopes = _fit(seen, parts, ratio)
    return values, _spread(seen, slopes, _law(seen, parts, values, ratio) - seen.friction)


def _numbers(seen: Sliding, parts: Sequence[FrictionPart], ratio: float) -> list[ArmNumber]:
    """Return the numbers of the parts with intervals."""
    values, spread = _known(seen, parts, ratio)
    names = [name for part in parts for name in part.names]
    found = []
    for name, value, sigma in zip(names, values, spread):
        if name == ASYMMETRY:
            value, sigma = value / max(values[0], LEAST), sigma / max(values[0], LEAST)
        found.append(number(name, float(value), float(sigma)))
    return found


def _spread(seen: Sliding, slopes: Floats, error: Floats) -> Floats:
    """
    Return the sigmas of values (p,) that a normal interval of 90 % needs.

    They come from how far values move as each second is left out in turn, so errors may follow
    each other. Few seconds are little to know a sigma by (Student). What the loads and the torque
    constant may be off by comes on top.
    """
    normal = slopes.T @ slopes
    weighed = error * (1.0 + (error / LARGE) ** 2) ** 0.25      # as the slopes count
    left_out = []
    for moment in np.unique(seen.moment):
        own = slopes[seen.moment == moment]
        pull = own.T @ weighed[seen.moment == moment]
        left_out.append(np.linalg.lstsq(normal - own.T @ own, pull, rcond=None)[0])
    count = len(left_out)
    moved = np.stack(left_out) - np.mean(left_out, axis=0)
    chance = (count - 1.0) / count * (moved ** 2).sum(axis=0)
    certain = np.linalg.lstsq(normal, slopes.T @ seen.doubt, rcond=None)[0]
    few = student.ppf(0.95, max(count - 1, 1)) / NORMAL_90
    return np.asarray(np.sqrt(few ** 2 * chance + (certain ** 2).sum(axis=1)))
