"""
What friction a motor may have: every effect there as a cause with its laws, by its own law.

The torque of a motor alone is explained by columns. That of an effect is its law along the motion,
for a unit of its first number. Numbers on which the law does not depend linearly are tried on a
grid. Published forms of a law differ from it by a smooth factor (eq:forms). Beside them stand
curves without a name along each coordinate.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import product
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.effects import Effect
from hda_arm_sim.model.effects.catalogue import effects_at
from hda_arm_sim.model.effects.place import BREAKAWAY, DRAG, DRY_LEVEL, MESH
import numpy as np
from numpy.typing import NDArray

from .motor_record import Sweep
from .posterior import Law, PossibleCause
from ..findings.certainty import NAMED
from ..fitting.hypotheses import HYPOTHESES
from ..judging.law_forms import factors_along, spread_of
from ...significance import HARDLY, MOSTLY

# Numerics; choices unless stated otherwise.
_POINTS = 8             # of a grid over a number that is a scale,
_WIDER = 3.0            # that goes so far beyond what is declared,
_WIDEST = 81.0          # and from its first to its last number
_ORDERS = (1.0, 2.0, 3.0, 4.0, 6.0)     # waves per link turn of a nameless curve
_APART = MOSTLY * HARDLY        # of a form, that is its own beside the law and those before it
_IDLE = 1e-3           # of its usual torque, below which a law does nothing along a motion
_AT_REST = 1e-300       # rms of a column along which nothing moved
_KNOTS, _TIMES = 8, 3   # of a curve along a coordinate, and of what drifts over a recording
_STEPS = 3              # of the sizes that a curve without a name may have

# Share of the torque that a curve without a name may have, rms: nothing of note, by power or rms.
_SIZES = np.geomspace(HARDLY ** 2, HARDLY, _STEPS).tolist()
# Prior probability of such a curve along each coordinate: that by which a name may be wrong.
_NAMELESS = 1.0 - NAMED


Rows = NDArray[np.intp]


class Along(NamedTuple):
    """The signals along a motion that friction reads, (k,) each."""

    motor_velocity: Array       # [rad/s] shaft
    sense: Array
    joint_torque: Array         # [N*m] at the output
    ratio: Array
    link_angle: Array           # [rad]
    time: Array                 # [s]

    def opposed(self, effect: Effect) -> Array:
        """Return the torque (k,) that a motor needs against an effect [N*m at the shaft]."""
        reads = effect.place.reads._fields
        signals = {name: value for name, value in self._asdict().items() if name in reads}
        if effect.place is DRAG:
            return np.asarray(effect(**signals)) * np.ones_like(self.time)
        return np.asarray(effect(**signals, budget=np.ones_like(self.time))) * self.sense


class FrictionLaw(NamedTuple):
    """One law of an effect, of which a fit finds the first number, or a wave."""

    effect: Effect              # with a unit of what is found, and a point of the grid
    numbers: tuple[str, ...]    # what is found: one number, or amplitude and phase of a wave
    unit: float                 # of the first of them
    plain: bool                 # the only law of its cause, or the usual one

    def columns(self, motion: Along) -> Array:
        """Return what the motor needs for each unit (k, p) [N*m at the shaft]."""
        waves = [{'phase': 0.0}, {'phase': 0.5 * np.pi}] if len(self.numbers) > 1 else [{}]
        return np.stack([motion.opposed(replace(self.effect, **wave)) for wave in waves], axis=1)


def along(sweep: Sweep, joint_torque: Array) -> Along:
    """Return the signals along a sweep under a load (k,) [N*m at the output]."""
    return Along(sweep.speed, np.sign(sweep.speed), joint_torque,
                 np.full_like(sweep.time, sweep.joint.ratio),
                 sweep.angle / sweep.joint.ratio, sweep.since)


def friction_effects() -> list[type[Effect]]:
    """Return the effects that oppose a sliding shaft, but for twins of what is always free."""
    return [kind for place in (DRY_LEVEL, BREAKAWAY, MESH, DRAG) for kind in effects_at(place)
            if kind.hypothesis is not None and not kind.hypothesis.twin]


def friction_laws(motion: Along, rows: Rows,
                  near: Mapping[str, tuple[Effect, float]]) -> dict[str, list[FrictionLaw]]:
    """
    Return the laws of every friction effect that some rows of a motion can show.

    One that is not plain must differ there from what those do together. Where an effect is
    known to be `near` one, scales are tried within that factor of its own.
    """
    every = {kind.name: list(_laws(kind, near.get(kind.name))) for kind in friction_effects()}
    plain = [law.columns(motion)[rows] for several in every.values() for law in several
             if law.plain]
    basis = np.linalg.qr(np.concatenate(plain, axis=1))[0]
    kept = {name: [law for law in several if _shows(law, motion, rows, basis)]
            for name, several in every.items()}
    return {name: several for name, several in kept.items() if several}


def _shows(law: FrictionLaw, motion: Along, rows: Rows, basis: Array) -> bool:
    """Return if a law does anything in some rows, and if not plain what no plain one does."""
    own = law.columns(motion)[rows]
    size = float(np.linalg.norm(own))
    if float(np.abs(own).max()) <= _IDLE * law.unit * _usual_torque(law, motion, rows):
        return False
    apart = own if law.plain else own - basis @ (basis.T @ own)
    return float(np.linalg.norm(apart)) > _APART * size


def _usual_torque(law: FrictionLaw, motion: Along, rows: Rows) -> float:
    """Return what a law usually does for each unit [N*m at the shaft]: loads are of any size."""
    loaded = law.effect.place is MESH
    return float(np.abs(motion.joint_torque / motion.ratio)[rows].max()) if loaded else 1.0


def _laws(kind: type[Effect], near: tuple[Effect, float] | None) -> Iterator[FrictionLaw]:
    """Yield the laws of an effect with a unit of its first number."""
    number, *others = (each.name for each in kind.declarations())
    found = (number, 'phase') if 'phase' in others else (number,)
    unit = min(1.0, kind.declaration(number).high)
    points = list(_grid(kind, found, near))
    for shape in _shapes(kind, near):
        for point in points:
            yield FrictionLaw(kind(**{number: unit}, **point, **shape), found, unit,
                              len(points) == 1 and not shape)


def _grid(kind: type[Effect], found: Sequence[str],
          near: tuple[Effect, float] | None) -> Iterator[dict[str, float]]:
    """Yield the points at which a law is tried: of the numbers that are not found by a fit."""
    sought = HYPOTHESES[kind.name].grid
    grids = {name: list(_around(kind, name, [float(str(value)) for value in sought[name]], near))
             for name in (each.name for each in kind.declarations())
             if name in sought and name not in found}
    yield from (dict(zip(grids, point)) for point in product(*grids.values()))


def _shapes(kind: type[Effect], near: tuple[Effect, float] | None) -> Iterator[dict[str, float]]:
    """Yield nothing for the usual law of an effect, and one number for each other law."""
    yield {}
    for name, values in HYPOTHESES[kind.name].shaped.items():
        known = near if near is not None and getattr(near[0], name) > 0.0 else None
        tried = values if known is None else _around(kind, name, values, known)
        yield from ({name: value} for value in tried)


def _around(kind: type[Effect], name: str, declared: Sequence[float],
            near: tuple[Effect, float] | None) -> Iterator[float]:
    """Yield orders as they are declared, and scales from below the declared ones to above."""
    rule = kind.declaration(name)
    if rule.unit == '1/turn':
        yield from declared
        return
    low, high = min(declared) / _WIDER, max(declared) * _WIDER
    if near is not None:
        low, high = (getattr(near[0], name) * factor for factor in (1.0 / near[1], near[1]))
    yield from np.unique(np.clip(np.geomspace(low, high, _POINTS), rule.low, rule.high)).tolist()


def spacing(finer: int) -> float:
    """Return the factor between neighbours of a grid over a scale that was made finer so often."""
    return float(_WIDEST ** (1.0 / (_POINTS - 1) * (2.0 / (_POINTS - 1)) ** finer))


def causes(motion: Along, laws: Mapping[str, list[FrictionLaw]], rows: Rows, torque: float,
           stated: Mapping[str, float]) -> list[PossibleCause]:
    """
    Return what may be at work in some rows of a motion, with and without a name.

    `torque` is that of the motor, rms [N*m at the shaft]. What is found of an effect comes on top
    of the number that is `stated`, which may be too large.
    """
    plain = [law.columns(motion)[rows] for several in laws.values() for law in several
             if law.plain]
    named = [PossibleCause(name, tuple(
        _law(law, motion, rows, torque, [] if law.plain else plain)._replace(
            least=_least(law, stated.get(name, 0.0)), weight=_weight(law, several))
        for law in several), _even())
        for name, several in laws.items()]
    return named + [PossibleCause(name, tuple(
        Law(curves[rows], np.full(curves.shape[1], size * torque / np.sqrt(curves.shape[1])),
            np.zeros((len(rows), 0))) for size in _SIZES), _NAMELESS, named=False)
        for name, curves in nameless(motion, rows).items()]


def _even() -> float:
    """Return how likely each cause is at first: as another one, or as none; so its usual power."""
    return 1.0 / (1.0 + len(friction_effects()))


def _weight(law: FrictionLaw, several: Sequence[FrictionLaw]) -> float:
    """Return how likely a law is beside others: the usual one is as likely as they together."""
    return max(len(several) - 1.0, 1.0) if law.plain else 1.0


def _least(law: FrictionLaw, stated: float) -> float:
    """Return the least of a number, in units of its law, beyond what is stated."""
    rule = type(law.effect).declaration(law.numbers[0])
    return (rule.low - stated) / law.unit if len(law.numbers) == 1 else -np.inf


def _law(law: FrictionLaw, motion: Along, rows: Rows, torque: float,
         plain: Sequence[Array]) -> Law:
    """
    Return a law as columns of some rows, with the forms that books have for it.

    A form of a law on a grid is no `plain` law: those have names of their own, and are near. They
    are as fine as the law has power alone: nothing else is known here of what a motor turns.
    """
    own = law.columns(motion)[rows]
    size = np.maximum(np.sqrt(np.mean(own ** 2, axis=0)), _AT_REST)
    unit = own[:, 0] / size[0]
    known = [unit, *(column[:, 0] / max(float(np.sqrt(np.mean(column ** 2))), _AT_REST)
                     for column in plain)]
    sought = HYPOTHESES[law.effect.name]
    power = np.zeros_like(motion.time)
    power[rows] = unit ** 2
    shapes = [*known, *(unit * factor[rows] for factor in
                        factors_along(power, motion._asdict(), sought.varies, count=0))]
    basis, upper = np.linalg.qr(np.stack(shapes, axis=1))
    apart = np.abs(np.diag(upper))[len(known):] > _APART * np.sqrt(len(rows))
    forms = basis[:, len(known):][:, apart] * np.sqrt(len(rows)) * size[0]
    return Law(own, np.sqrt(_even()) * torque / size, forms,
               float(spread_of(np.asarray(sought.reach))))


def nameless(motion: Along, rows: Rows) -> dict[str, Array]:
    """Return curves without a name (k, p) by the coordinate that they follow, of unit rms."""
    link = motion.link_angle
    turn = np.stack([wave(order * link) for order in _ORDERS for wave in (np.sin, np.cos)], axis=1)
    curves = {'motor_velocity': _hats(np.abs(motion.motor_velocity), rows)
              * motion.sense[:, None],
              'link_angle': turn, 'link_angle by sense': turn * motion.sense[:, None],
              'joint_torque': _hats(np.abs(motion.joint_torque), rows) * motion.sense[:, None],
              'time': _hats(motion.time, rows, _TIMES),
              'time by sense': _hats(motion.time, rows, _TIMES) * motion.sense[:, None]}
    return {name: each / np.maximum(np.sqrt(np.mean(each[rows] ** 2, axis=0)), _AT_REST)
            for name, each in curves.items()}


def _hats(values: Array, rows: Rows, count: int = _KNOTS) -> Array:
    """Return hat functions (k, p) over the quantiles of values (k,)."""
    knots = np.unique(np.quantile(values[rows], np.linspace(0.0, 1.0, count)))
    return np.stack([np.interp(values, knots, own) for own in np.eye(len(knots))], axis=1)
