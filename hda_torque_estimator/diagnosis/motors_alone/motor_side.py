"""
Diagnose a recording of motors alone: what balance A says without a link angle.

The motor torque is explained by inertia, a load that varies slowly with the link angle, friction,
and waves over the motor angle. Which friction acts is decided by the evidence of sets of causes
(`posterior`). The gear's torsion cancels in the balance of motor and link together. So nothing
that sits in it, in the timing or in the link encoder can be seen.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
import math
from typing import Any, NamedTuple

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import Effect, EFFECTS, Scope, Site
from hda_arm_sim.model.effects.catalogue import known_as, orders_at
from hda_arm_sim.model.effects.place import TURN
import numpy as np

from .friction_findings import friction_findings, friction_pairs, is_sure
from .motor_fit import Explained, explained, floor_of, gain_without, LOAD, METRIC
from .motor_friction import load_columns
from .motor_record import HELD, Sweep
from ..findings.certainty import margin_of, probability
from ..findings.gains import Gains
from ..findings.origin import RecordingFacts, RecordingPart
from ..findings.report import (Alike, Candidate, Detectable, Diagnosis, Evidence, Finding,
                               FittedNumber, Residual, TotalGain, with_gain)
from ..findings.rest import NOTHING, Unexplained
from ...significance import LOUD, NORMAL_90, STANDS_OUT

_UNSEEN = (Site.TORSION, Site.TIMING, Site.SENSING)
_SIDE = ('One encoder for each joint: torsion, timing and sensing cannot be seen; '
         'sizes of fast waves are what the drive answered them with.')
_LINE: Any = orders_at(TURN)        # a wave over the motor angle, of any order


class MotorConclusion(NamedTuple):
    """A diagnosis of motors alone, the arm extended by it, and what it rests on."""

    diagnosis: Diagnosis
    extended: Arm
    parts: tuple[Explained, ...]


def diagnose_motors(sweeps: Sequence[Sweep], arm: Arm, *, arm_file: str = '',
                    version: str = '', bags: Sequence[RecordingPart] = (),
                    said: Sequence[str] = ()) -> MotorConclusion:
    """
    Return what the torques of motors show; several recordings are `bags`.

    What is `said` of them stands among the remarks.
    """
    parts = tuple(explained(sweep, arm) for sweep in sweeps)
    findings = with_gain(found for part in parts for found in _findings(part, arm))
    pairs = tuple(pair for part in parts for pair in _pairs(part, arm))
    rests = [rest for part in parts for rest in _unexplained(part)]
    verdict = ('insufficient_excitation' if not parts else 'unknown' if rests else
               'ambiguous' if pairs else 'explained' if findings else 'no_discrepancy')
    remarks = [_SIDE, *said, *(_level(part) for part in parts if not part.sweep.both_ways)]
    diagnosis = Diagnosis(
        verdict, findings, pairs, rests[0] if rests else None, tuple(_unseen(parts)),
        _total(parts), tuple(_residual(part) for part in parts), _facts(sweeps, bags),
        arm_file, version, 0.0, tuple(remarks))
    return MotorConclusion(diagnosis, _extended(arm, findings), parts)


def _facts(sweeps: Sequence[Sweep], bags: Sequence[RecordingPart]) -> RecordingFacts:
    """Return what was diagnosed, and what of the first joint's motion was held out."""
    if not sweeps:
        return RecordingFacts(0.0, 0, math.nan, (), ())
    sweep = sweeps[0]
    spans = [(float(rows[0]), float(rows[-1]) + sweep.dt) for rows in np.split(
        sweep.time, np.flatnonzero(np.diff(sweep.block)) + 1)]
    held = spans[HELD - 1::HELD]
    duration = max(float(one.time[-1]) for one in sweeps)
    return RecordingFacts(duration, round(duration / sweep.dt) + 1, 1.0 / sweep.dt,
                          tuple(span for span in spans if span not in held), tuple(held),
                          tuple(bags) if len(bags) > 1 else ())


def _findings(part: Explained, arm: Arm) -> Iterator[Finding]:
    """Return friction, where motion both ways shows it, and every line."""
    yield from (found for found in friction_findings(part, arm) if is_sure(found))
    label = part.sweep.joint.label
    for number, line in enumerate(part.lines):
        places = part.wave(number)
        effect, spread = _wave(part, number), float(part.spread[places].mean())
        yield _finding(part, effect, label, places, {
            'amplitude': (effect.amplitude, spread),
            'order': (effect.order, spread / effect.amplitude / max(
                float(part.sweep.angle[part.sweep.moving].std()), 1e-9)),
            'phase': (effect.phase, spread / effect.amplitude)}, line.stands_out, STANDS_OUT)


def _pairs(part: Explained, arm: Arm) -> Iterator[Alike]:
    """Yield the causes of a motor that look alike here."""
    if part.friction is None:
        yield _one_way(part)
    else:
        yield from friction_pairs(part, arm)


def _wave(part: Explained, number: int) -> Any:
    """Return a line as cogging, which the commanded torque has to make up for."""
    along, across = -part.numbers[part.wave(number)]
    return _LINE(amplitude=math.hypot(along, across), order=part.lines[number].order,
                 phase=math.atan2(across, along))


def _finding(part: Explained, effect: Effect, label: str, places: Sequence[int],
             numbers: dict[str, tuple[float, float]], score: float, least: float) -> Finding:
    known = {name: FittedNumber(value, type(effect).declaration(name).unit,
                                value - NORMAL_90 * spread, value + NORMAL_90 * spread)
             for name, (value, spread) in numbers.items()}
    evidence = Evidence(score, least, None, math.exp(min(0.5 * score, 700.0)))
    return Finding(effect.name, label, effect.site.value, effect.cause, known, evidence,
                   gain_without(part, places).gain(), probability(margin_of(evidence)))


def _one_way(part: Explained) -> Alike:
    """Return what a sweep in one direction cannot distinguish, each as if it alone resisted."""
    label, (resists, reach) = part.sweep.joint.label, _resistance(part)
    way = float(np.sign(np.median(part.sweep.speed[part.sweep.moving])))
    sizes = ((known_as('dry_friction'), 'level', resists),
             (known_as('drive_offset'), 'offset', -way * resists))
    return Alike(tuple((kind.name, label) for kind, _, _ in sizes), 'the same sweep back', tuple(
        Candidate(kind.name, label, {name: FittedNumber(size, kind.declaration(name).unit,
                                                        size - reach, size + reach)}, False)
        for kind, name, size in sizes) if resists > 0.0 else ())


def _resistance(part: Explained) -> tuple[float, float]:
    """Return the torque that resists a sweep at its mean speed, and how far it is in doubt."""
    friction = [LOAD, LOAD + 1]
    speed = float(np.abs(part.sweep.speed[part.sweep.moving]).mean())
    along = np.array([1.0, speed])
    left = part.without(())[part.sweep.moving & part.sweep.held_out]
    return float(along @ part.numbers[friction]), NORMAL_90 * float(left.std())


def _level(part: Explained) -> str:
    """Return how much resists a sweep in one direction, at its mean speed."""
    friction, use = [LOAD, LOAD + 1], part.sweep.moving & part.sweep.held_out
    speed = float(np.abs(part.sweep.speed[part.sweep.moving]).mean())
    without, left = (float(np.sqrt(np.mean(part.without(taken)[use] ** 2)))
                     for taken in (friction, ()))
    return (f'{part.sweep.joint.label} moves one way: {_resistance(part)[0]:.3g} N*m at the shaft '
            f'resist at {speed:.3g} rad/s, friction and offset together; the held-out error is '
            f'{left:.2g} N*m with it and {without:.2g} N*m without')


def _unexplained(part: Explained) -> Iterator[Unexplained]:
    """Return the rest of a motor if a curve explains it, or if it is far above white noise."""
    rest = part.without(())[part.sweep.moving]
    power, floor = float(np.mean(rest ** 2)), floor_of(part)
    follows = part.friction.nameless if part.friction else None
    if follows or power > (1.0 + LOUD ** 2) * floor:
        yield Unexplained('motor', part.sweep.joint.label, follows or NOTHING, None,
                          max(1.0 - floor / power, 0.0))


def _residual(part: Explained) -> Residual:
    """Return what the motor balance misses on held-out stretches, rms at the output."""
    use, ratio = part.sweep.moving & part.sweep.held_out, part.sweep.joint.ratio
    before, after = (ratio * float(np.sqrt(np.mean(part.without(taken)[use] ** 2)))
                     for taken in (_found_columns(part), ()))
    return Residual('motor', part.sweep.joint.label, before, after,
                    ratio * math.sqrt(floor_of(part)), 'N*m')


def _found_columns(part: Explained) -> list[int]:
    """Return the columns of what is named: waves, and friction where motion both ways shows it."""
    first = part.first_wave if part.friction is None else load_columns(part.sweep).shape[1]
    return list(range(first, part.columns.shape[1]))


def _total(parts: Sequence[Explained]) -> TotalGain:
    """Return the gain of friction and waves of all motors together."""
    each = [gain_without(part, _found_columns(part)) for part in parts if _found_columns(part)]
    if not each:
        none = math.nan
        return TotalGain(none, none, none, none, none, none, METRIC, '1')
    whole = Gains(*(np.concatenate(column) for column in zip(*each)))
    return replace(whole.total(), metric=METRIC)


def _unseen(parts: Sequence[Explained]) -> Iterator[Detectable]:
    """Return what a motor alone cannot show."""
    for kind in EFFECTS:
        if kind.site in _UNSEEN:
            unit = next(iter(kind.declarations())).unit
            for part in parts if kind.scope is Scope.JOINT else ():
                yield Detectable(kind.name, part.sweep.joint.label, None, unit)


def _extended(arm: Arm, findings: Sequence[Finding]) -> Arm:
    """Return the arm with the friction that is named and the strongest line of each motor."""
    strongest: dict[str | None, float] = {}
    for found in findings:
        numbers = {name: number.value for name, number in found.parameters.items()}
        if found.effect == _LINE.name:
            if numbers['amplitude'] < strongest.get(found.joint, 0.0):
                continue
            strongest[found.joint] = numbers['amplitude']
        arm = arm.with_effect(replace(arm.effect(found.effect, found.joint), **numbers),
                              found.joint)
    return arm
