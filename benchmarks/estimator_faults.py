"""
Inject faults into the streams that the estimator reads, and count what it believes.

    estimator_faults.py [--minutes M] [--first SEED] [--quick]

A fault is survived where every torque stays right (within 3.3 deviations or 0.5 N*m), flagged
where `valid` is false within 50 ms of the first wrong torque, and silent else. Healthy arms of
several sizes, each wrong within its tolerances, move for the given minutes; nothing may be
reported of them.
"""

from argparse import ArgumentParser
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import islice, product
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.model.parts import Joint, Links
from hda_arm_sim.motions import motion
from hda_torque_estimator.estimating.belief_words import believed, doubts_in_words
from hda_torque_estimator.estimating.estimates import Estimates
from hda_torque_estimator.estimating.estimator import Estimator
from hda_torque_estimator.estimating.laws import layout
from hda_torque_estimator.estimating.route_health import health_in_words, UNTAUGHT, WELL
from hda_torque_estimator.simulating.closed_loop import ClosedLoopRun, run
import numpy as np
from numpy.typing import NDArray

SIZES = (1.0, 0.3, 4.0)         # of torques and inertias against the shipped arm
PATHS, PERIODS = ('rich', 'sine', 'turn'), (1e-3, 2e-3)
SOON = 0.05                     # [s]
LEAST, DEVIATIONS = 0.5, 3.3    # error that is wrong, times the size [N*m], and deviations
BEGIN = 3.0                     # of a fault [s]


class Stream(NamedTuple):
    """What an estimator reads, and what is true."""

    stamps: NDArray[np.int64]
    reading: Array
    command: Array
    torque: Array


Spoil = Callable[[Stream, int], None]


def sized(size: float) -> Arm:
    """Return the shipped arm with all torques and inertias `size` times as large."""
    arm = read_arm('hda_arm.yaml')
    assert arm.links is not None
    links = Links(**{rule.name: getattr(arm.links, rule.name) * (
        size if rule.name in ('p1', 'p2', 'p3', 'first', 'second') else 1.0)
        for rule in Links.declarations()})
    return replace(arm, joints=tuple(_sized_joint(joint, size) for joint in arm.joints),
                   links=links)


def _sized_joint(joint: Joint, size: float) -> Joint:
    law = joint.torsion
    torsion = replace(
        law, flexspline_stiffness=law.flexspline_stiffness * size,
        wave_generator_stiffness=law.wave_generator_stiffness * size, damping=law.damping * size,
        flexspline_curvature=law.flexspline_curvature / size,
        wave_generator_curvature=law.wave_generator_curvature / size,
        valid_torque=law.valid_torque * size)
    return replace(joint, torsion=torsion, motor_inertia=joint.motor_inertia * size,
                   dry_friction=joint.dry_friction * size, torque_limit=joint.torque_limit * size,
                   viscous_friction=joint.viscous_friction * size)


def tolerated(arm: Arm, random: np.random.Generator) -> Arm:
    """Return an arm whose numbers are off by as much as the tolerances say."""
    known = arm.tolerances
    joints = []
    for joint in arm.joints:
        off = 1.0 + random.standard_normal(3) * (
            known.stiffness, known.dry_friction, known.viscous_friction)
        joints.append(replace(
            joint, torsion=replace(joint.torsion, flexspline_stiffness=(
                joint.torsion.flexspline_stiffness * off[0])),
            dry_friction=joint.dry_friction * off[1],
            viscous_friction=joint.viscous_friction * off[2]))
    return replace(arm, joints=tuple(joints))


def stream(made: ClosedLoopRun) -> Stream:
    """Return a run as a stream that may be spoilt."""
    stamps = 1_000_000_000 + np.round(made.time * 1e9).astype(np.int64)
    return Stream(stamps, made.reading.copy(), made.command.copy(), made.joint_torque)


def moving(size: float, path: str, dt: float, seconds: float, seed: int) -> tuple[Arm, Stream]:
    """Return the arm that is believed in, and the stream of one that is a little different."""
    arm = sized(size)
    true = tolerated(arm, np.random.default_rng(seed))
    return arm, stream(run(true, arm, motion(path, 2, seconds, dt, seed), seed))


def _angle(side: int, size: float, lasts: int | None = None) -> Spoil:
    def spoil(seen: Stream, at: int) -> None:
        seen.reading[at:None if lasts is None else at + lasts, 0, side] += size
    return spoil


def _frozen(sides: slice, rates: bool) -> Spoil:
    def spoil(seen: Stream, at: int) -> None:
        seen.reading[at:, 0, :2][:, sides] = seen.reading[at, 0, :2][sides]
        if rates:
            seen.reading[at:, 0, 2:][:, sides] = 0.0
    return spoil


def _scaled(places: slice, factor: float) -> Spoil:
    def spoil(seen: Stream, at: int) -> None:
        seen.reading[at:, :, places] *= factor
    return spoil


def _effort(factor: float) -> Spoil:
    def spoil(seen: Stream, at: int) -> None:
        seen.command[at:] *= factor
    return spoil


def _swapped(seen: Stream, at: int) -> None:
    seen.reading[at:] = seen.reading[at:, ::-1].copy()


def _back(seen: Stream, at: int) -> None:
    seen.stamps[at:] -= 3600 * 10**9


def _other_pose(seen: Stream, at: int) -> None:
    seen.reading[at + 1::2] = seen.reading[at // 2]


TURN = 2.0 * np.pi
FAULTS: dict[str, Spoil] = {
    'one angle 1e308': _angle(1, 1e308, 1), 'one angle + 1 rad': _angle(1, 1.0, 1),
    'link + 1 turn': _angle(1, TURN), 'motor + 1 turn': _angle(0, TURN),
    'motor - 1 turn': _angle(0, -TURN), 'link slips 1 line': _angle(1, TURN / 4e6),
    'link slips 100 lines': _angle(1, 100 * TURN / 4e6),
    'link slips 1000 lines': _angle(1, 1000 * TURN / 4e6),
    'motor slips 100 counts': _angle(0, 100 * TURN / 16384),
    'link frozen': _frozen(slice(1, 2), False), 'motor frozen': _frozen(slice(0, 1), True),
    'joint frozen': _frozen(slice(0, 2), True), 'velocities * 1000': _scaled(slice(2, 4), 1e3),
    'velocities * 1e300': _scaled(slice(2, 4), 1e300),
    'degrees': _scaled(slice(0, 4), 180.0 / np.pi),
    'effort flipped': _effort(-1.0), 'effort * 1e300': _effort(1e300), 'joints swapped': _swapped,
    'clock back an hour': _back, 'two publishers': _other_pose}


def valid(found: Estimates) -> NDArray[np.bool_]:
    """Return which estimates are said to be right (k, n)."""
    doubts = found.joints[:, :, layout.DOUBT]
    values, places = np.unique(doubts, return_inverse=True)
    is_right = np.array([believed(value) for value in values.tolist()])[places]
    return is_right.reshape(doubts.shape) & ~(found.joints[:, :, layout.BEYOND_RANGE] > 0.0)


def outcome(arm: Arm, seen: Stream, spoil: Spoil, size: float) -> str:
    """Return what became of a fault: survived, flagged or silent."""
    dt = (seen.stamps[1] - seen.stamps[0]) * 1e-9
    at = round(BEGIN / dt)
    spoil(seen, at)
    found = Estimator(arm).run(seen.stamps, seen.reading, seen.command)
    used = np.delete(np.arange(len(seen.stamps)), found.refused)
    error = np.abs(found.torque - seen.torque[used])
    wrong = ~(error <= np.maximum(LEAST * size, DEVIATIONS * found.torque_deviation))
    wrong[used < at] = False
    if not wrong.any():
        return 'survived'
    joint = int(np.argmax(wrong.any(axis=0)))
    first = int(np.argmax(wrong[:, joint]))
    soon = slice(first, first + round(SOON / dt))
    return 'silent' if valid(found)[soon, joint].all() else 'flagged'


def inject(cases: Sequence[tuple[float, str, float]]) -> None:
    """Print what became of every fault in every stream."""
    totals: Counter[str] = Counter()
    print('fault                    injected  survived  flagged  silent')
    made = [(size, *moving(size, path, dt, 6.0, 11 + k))
            for k, (size, path, dt) in enumerate(cases)]
    for name, spoil in FAULTS.items():
        counts = Counter(outcome(arm, Stream(*(part.copy() for part in seen)), spoil, size)
                         for size, arm, seen in made)
        totals += counts
        _row(name, counts)
    _row('all', totals)


def _row(name: str, counts: Counter[str]) -> None:
    print(f'{name:24} {counts.total():8} {counts["survived"]:9} {counts["flagged"]:8} '
          f'{counts["silent"]:7}')


def alarms(arm: Arm, seen: Stream) -> list[str]:
    """Return what is reported of an arm, each sentence once."""
    made, found = Estimator(arm), []
    second = round(1e9 / (seen.stamps[1] - seen.stamps[0]))
    for begin in range(0, len(seen.stamps), second):
        rows = slice(begin, begin + second)
        part = made.run(seen.stamps[rows], seen.reading[rows], seen.command[rows])
        for row in np.unique(part.joints[:, :, layout.DOUBT], axis=0).tolist():
            found += doubts_in_words(arm.labels, row)
        words = [health_in_words(joint, arm.tolerances_of(joint.label), memory[layout.FUSION:])
                 for joint, memory in zip(arm.joints, made.memory)]
        found += [word for word in words if word not in (WELL, UNTAUGHT)]
    return list(dict.fromkeys(found))


def healthy(cases: Iterator[tuple[float, str, float]], minutes: int, seconds: float,
            first: int) -> None:
    """Print what is reported of healthy arms."""
    remarked = [(case, words) for k, case in enumerate(islice(cases, minutes))
                for words in alarms(*moving(*case, seconds, first + k))]
    hours = minutes * seconds / 3600.0
    print(f'healthy arms: {len(remarked)} false alarms in {hours:.3g} h')
    for case, words in remarked:
        print('  ', *case, words)


def main(arguments: Sequence[str] | None = None) -> None:
    """Inject, listen, and print."""
    parser = ArgumentParser(description=__doc__.split('\n')[1])
    parser.add_argument('--minutes', type=int, default=60, help='of healthy arms')
    parser.add_argument('--first', type=int, default=100, help='seed of the healthy arms')
    parser.add_argument('--quick', action='store_true', help='one stream, one short healthy one')
    chosen = parser.parse_args(arguments)
    cases = list(product(SIZES, PATHS, PERIODS))
    inject(cases[:1] if chosen.quick else cases)
    minutes, seconds = (1, 3.0) if chosen.quick else (chosen.minutes, 60.0)
    repeated = (cases[k % len(cases)] for k in range(minutes))
    healthy(repeated, minutes, seconds, chosen.first)


if __name__ == '__main__':
    main()
