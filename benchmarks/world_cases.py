"""The records of the study of worlds: what is drawn, and what a diagnosis says of it."""

from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
import json
import time
from typing import Any

from baseline import best_correlation
from hda_torque_estimator.diagnosis.diagnose import diagnose, sought_effects
from hda_torque_estimator.diagnosis.fitting.alignment import together
from hda_torque_estimator.measurements.sample_grid import measurement_from
from hidden_truth import (
    arm_of, CATALOGUE, logged, MOTIONS, OUTSIDE, TruthError, worlds)
import numpy as np
from world_numbers import library_numbers, powers, size_and_smallest

Outcome = dict[str, Any]
NAMES = [effect.name for effect in CATALOGUE]
MANY, SMALL = 15, 0.4           # imperfections of one arm, as shares of their usual sizes
LEFT_OUT = 'left out'
LENGTHS = (15.0, 60.0, 240.0, 600.0)        # of the recordings of one arm [s]
BAGS = 5                        # of 12 s each, of one arm
NOT_MANY = {'external_contact', 'base_vibration', 'inertial_coupling', 'payload',
            'torque_saturation', 'presliding_friction', 'coarse_quantisation', 'dropped_samples',
            'clock_jitter'}


@dataclass(frozen=True)
class Case:
    """One record: what is hidden in which world, and how it is recorded and diagnosed."""

    group: str                      # row of the table it belongs to
    seed: int
    hidden: tuple[str, ...] = ()
    motion: str | None = None
    rate: int | None = None
    without: str | None = None      # an effect that the catalogue lacks
    seconds: float = 60.0
    bags: int = 1
    joints: int | None = None

    def key(self) -> str:
        """Return what distinguishes it from all others."""
        return json.dumps(asdict(self))


def cases(first: int, scale: float) -> Iterator[Case]:
    """Yield all records of a study, from a seed on; `scale` 1 is the whole of some 2300."""
    seeds = iter(range(first, first + 1_000_000_000))
    final = worlds.is_final(first)
    random = np.random.default_rng(first)
    moved = [name for name in MOTIONS.MOTIONS if name not in ('rich', 'standstill', 'hand_guided')
             and (final or name not in MOTIONS.HELD_OUT)]
    for name in (name for name in NAMES for _ in range(_count(5, scale))):
        yield Case('rich, 1 kHz', next(seeds), (name,), 'rich', 1000)
        yield Case('rich, 250 Hz', next(seeds), (name,), 'rich', 250)
        yield Case('other motions, 1 kHz', next(seeds), (name,), str(random.choice(moved)), 1000)
        yield Case('any rate', next(seeds), (name,), 'rich')
        yield Case(LEFT_OUT, next(seeds), (name,), 'rich', 1000, without=name)
    for _ in range(_count(600, scale)):
        yield Case('healthy', next(seeds))
    for size, group in ((2, 'two'), (3, 'three')):
        for _ in range(_count(120, scale)):
            yield Case(group, next(seeds), _some(random, NAMES, size), 'rich', 1000, joints=2)
    few = [name for name in NAMES if name not in NOT_MANY]
    for _ in range(_count(60, scale)):
        yield Case('fifteen', next(seeds), _some(random, few, MANY), 'rich', 1000, joints=2)
    for effect in (effect for effect in OUTSIDE for _ in range(_count(20, scale))):
        yield Case('outside', next(seeds), (effect.name,), 'rich', 1000, joints=2)
    for name in _some(random, NAMES, _count(20, scale)):
        seed = next(seeds)
        for seconds in LENGTHS:
            yield Case('duration', seed, (name,), 'rich', 1000, seconds=seconds)
        yield Case('duration', seed, (name,), 'rich', 1000, seconds=60.0 / BAGS, bags=BAGS)


def _count(whole: int, scale: float) -> int:
    return max(1, round(scale * whole))


def _some(random: np.random.Generator, names: list[str], size: int) -> tuple[str, ...]:
    return tuple(str(name) for name in random.choice(names, min(size, len(names)), replace=False))


def world_of(case: Case) -> Any:
    """Return the world of a case; raises TruthError where there is no such world."""
    many = len(case.hidden) == MANY
    if not many:
        return worlds.draw(case.seed, case.hidden, motion=case.motion, rate=case.rate,
                           joints=case.joints, seconds=case.seconds)
    world = worlds.draw(case.seed, (), motion=case.motion, rate=case.rate, joints=case.joints,
                        seconds=case.seconds)
    world = replace(world, arm=worlds.resolving(world.arm, case.hidden))
    for place, name in enumerate(case.hidden):
        world = worlds.hide(world, name, np.random.default_rng([case.seed, 12, place]),
                            shrink=SMALL)
    return world


def attempted(case: Case) -> Outcome:
    """Return the outcome of a case; what cannot be drawn, recorded or diagnosed says why."""
    try:
        world = world_of(case)
    except TruthError as error:
        return {'case': case.key(), 'group': case.group, 'seed': case.seed,
                'impossible': str(error)}
    known = {'case': case.key(), **about(case, world)}
    try:
        return {**known, **said_of(case, world)}
    except ValueError as error:
        return {**known, 'error': str(error)}


def about(case: Case, world: Any) -> Outcome:
    """Return what is true of a world, as far as a table needs it."""
    return {
        'group': case.group, 'seed': case.seed, 'motion': world.motion, 'rate': world.rate,
        'controller': world.controller, 'joints': len(world.arm.axes), 'counts': world.arm.counts,
        'jitter': world.logger.jitter, 'seconds_recorded': case.seconds * case.bags,
        'torque': world.arm.axes[0].torque, 'tolerated': sorted(world.tolerated),
        'hidden': [(one.effect, one.joint, one.parameters, one.site, one.coordinate, one.form)
                   for one in world.hidden],
        'numbers': [library_numbers(world, one) for one in world.hidden],
        'powers': powers(world) if case.group == 'fifteen' else None}


def said_of(case: Case, world: Any) -> Outcome:
    """Return what the diagnosis says of the record of a world, and what the baseline says."""
    arm = arm_of(world)
    parts = [measurement_from(arm.labels, logged(replace(world, part=part), arm))
             for part in range(case.bags)]
    names = [name for name in sought_effects() if name != case.without]
    began = time.process_time()
    measurement = together(parts)
    said = diagnose(measurement, arm, names=names).diagnosis
    taken, rest = time.process_time() - began, said.unexplained
    return {
        'seconds': taken, 'verdict': said.verdict, 'removed': said.gain.removed,
        'probability': getattr(said, 'probability', None),
        'said': [(one.effect, one.joint, {name: (number.value, number.low, number.high)
                                          for name, number in one.parameters.items()},
                  getattr(one, 'probability', None)) for one in said.findings],
        'alike': [list(pair.effects) for pair in said.ambiguous],
        'sizes': [size_and_smallest(world, one, said.excitation) for one in world.hidden],
        'rest': None if rest is None else (rest.site, rest.joint, rest.depends_on),
        'oscillating': [loop.joint for loop in said.recording.oscillating],
        'baseline': best_correlation(measurement, arm, names)}
