"""
Diagnose a recording of motors alone: what balance A says without a link angle.

The motor torque is explained by inertia, a load that varies slowly with the link angle, friction,
and waves over the motor angle. The gear's torsion cancels in the balance of motor and link
together. So nothing that sits in it, in the timing or in the link encoder can be seen.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
import math
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import (CoulombFriction, DriveOffset, Effect, EFFECTS,
                                       MotorCogging, Scope, Site, ViscousFriction)
import numpy as np
from scipy.ndimage import uniform_filter1d

from .motor_record import HELD, Sweep
from .ripple import Line, STANDS_OUT, strongest_line, waves
from ..findings.certainty import margin_of, probability
from ..findings.gains import Gains
from ..findings.origin import Part, RecordingFacts
from ..findings.report import (Alike, Candidate, Detectable, Diagnosis, Evidence, Finding, Number,
                               Residual, told, TotalGain)
from ..findings.rest import Unexplained
from ...significance import FOURTH_DIFFERENCES, NORMAL_90, NORMAL_MEDIAN

# Choices unless told otherwise.
MOST = 12               # lines of one motor that are tried
_PERIODS = 3.0          # of a line, over which slower errors are taken out of it
KNOWN = 0.15            # of a number, its standard deviation beyond which it is not told
REST = 2.5              # rms left over white noise that asks for an explanation
METRIC = ('mean squared error of the motor torque that the measured motion calls for, on held-out '
          'stretches, over white noise')
_LOAD = 3               # columns: inertia, and the load over the link angle (layout)
_WINDOW = 0.1           # of held-out errors [s]
_UNSEEN = (Site.TORSION, Site.TIMING, Site.SENSING)
_SIDE = ('One encoder for each joint: torsion, timing and sensing cannot be seen; '
         'sizes of fast waves are what the drive answered them with.')


class Explained(NamedTuple):
    """A sweep and the columns (k, p) that explain its torque: load, friction, then waves."""

    sweep: Sweep
    columns: Array
    lines: tuple[Line, ...]
    numbers: Array          # (p,)
    spread: Array           # (p,) standard deviations

    def without(self, taken: Sequence[int]) -> Array:
        """Return what the torque departs by (k,) if columns are taken away and the rest refit."""
        kept = [place for place in range(self.columns.shape[1]) if place not in taken]
        return _rest(self.sweep, self.columns[:, kept])


def explained(sweep: Sweep) -> Explained:
    """Return what explains the torque of a sweep, fitted to its training stretches."""
    columns, lines = _base(sweep), list[Line]()
    tried: list[float] = []
    use = sweep.moving & ~sweep.held_out
    while len(tried) < MOST:
        rest = _rest(sweep, columns)
        line = strongest_line(sweep.angle[use], rest[use], sweep.dt, tried)
        if line is None:
            break
        tried.append(line.order)
        more = np.concatenate([columns, waves(sweep.angle, line.order)], axis=1)
        if _repeats(sweep, line, rest, _rest(sweep, more)):
            columns = more
            lines.append(line)
    return _without_losses(_fitted(sweep, columns, tuple(lines)))


def _without_losses(part: Explained) -> Explained:
    """Return what explains a torque without lines that lose on the held-out stretches."""
    first = _base(part.sweep).shape[1]
    gains = [_gain_without(part, [first + 2 * number, first + 2 * number + 1]).removed()
             for number in range(len(part.lines))]
    if all(gain > 0.0 for gain in gains):
        return part
    worst = int(np.argmin(gains))
    kept = [column for column in range(part.columns.shape[1])
            if column not in (first + 2 * worst, first + 2 * worst + 1)]
    return _without_losses(_fitted(part.sweep, part.columns[:, kept],
                                   part.lines[:worst] + part.lines[worst + 1:]))


def _repeats(sweep: Sweep, line: Line, before: Array, after: Array) -> bool:
    """Tell whether a line gains on the held-out stretches, slower errors left aside."""
    pace = line.order * float(np.median(np.abs(sweep.speed[sweep.moving])))
    span = max(3, round(_PERIODS * 2.0 * math.pi / pace / sweep.dt))
    fast = [rest - uniform_filter1d(rest, span) for rest in (before, after)]
    return _gains(sweep, fast[0], fast[1], 1.0).interval()[0] > 0.0


class MotorConclusion(NamedTuple):
    """A diagnosis of motors alone, the arm extended by it, and what it rests on."""

    diagnosis: Diagnosis
    extended: Arm
    parts: tuple[Explained, ...]


def diagnose_motors(sweeps: Sequence[Sweep], arm: Arm, *, arm_file: str = '',
                    version: str = '', bags: Sequence[Part] = ()) -> MotorConclusion:
    """Return what the torques of motors show; several recordings are `bags`."""
    parts = tuple(explained(sweep) for sweep in sweeps)
    findings = told(found for part in parts for found in _findings(part))
    pairs = tuple(_one_way(part) for part in parts if not part.sweep.both_ways)
    rests = [rest for part in parts for rest in _unexplained(part)]
    verdict = ('insufficient_excitation' if not parts else 'unknown' if rests else
               'ambiguous' if pairs else 'explained' if findings else 'no_discrepancy')
    remarks = [_SIDE, *(_level(part) for part in parts if not part.sweep.both_ways)]
    diagnosis = Diagnosis(
        verdict, findings, pairs, rests[0] if rests else None, tuple(_unseen(parts)),
        _total(parts), tuple(_residual(part) for part in parts), _facts(sweeps, bags),
        arm_file, version, 0.0, tuple(remarks))
    return MotorConclusion(diagnosis, _extended(arm, findings), parts)


def _facts(sweeps: Sequence[Sweep], bags: Sequence[Part]) -> RecordingFacts:
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


def _base(sweep: Sweep) -> Array:
    """Return the columns of a torque without waves (k, 5), and of the drive's offset (k, 6)."""
    link = sweep.angle / sweep.joint.ratio
    columns = [sweep.acceleration, np.cos(link), np.sin(link), np.sign(sweep.speed), sweep.speed]
    if sweep.both_ways:
        columns.append(np.ones_like(link))
    return np.stack(columns, axis=1)


def _solve(sweep: Sweep, columns: Array) -> tuple[Array, Array]:
    """Return numbers (p,) that fit the training stretches, and the inverse of their normal."""
    use = sweep.moving & ~sweep.held_out
    scale = np.maximum(np.sqrt(np.mean(columns[use] ** 2, axis=0)), 1e-30)
    scaled = columns[use] / scale
    inverse = np.linalg.pinv(scaled.T @ scaled, rcond=1e-9, hermitian=True)
    numbers = inverse @ (scaled.T @ sweep.torque[use]) / scale
    return numbers, inverse / np.outer(scale, scale)


def _rest(sweep: Sweep, columns: Array) -> Array:
    """Return what columns fitted to the training stretches leave of the torque (k,)."""
    return sweep.torque - columns @ _solve(sweep, columns)[0]


def _fitted(sweep: Sweep, columns: Array, lines: tuple[Line, ...]) -> Explained:
    """Return the fit with standard deviations that know how long the rest remembers."""
    numbers, inverse = _solve(sweep, columns)
    rest = (sweep.torque - columns @ numbers)[sweep.moving]
    rest = rest - rest.mean()
    spectrum = np.abs(np.fft.rfft(rest, 2 * len(rest))) ** 2
    memory = np.fft.irfft(spectrum)[:max(1, round(0.3 / sweep.dt))]
    fewer = max(1.0, 2.0 * float(np.sum(np.maximum(memory, 0.0)) / max(memory[0], 1e-30)) - 1.0)
    variance = float(np.mean(rest ** 2))
    spread = np.sqrt(np.maximum(np.diag(inverse), 0.0) * variance)
    spread[:_base(sweep).shape[1]] *= math.sqrt(fewer)
    return Explained(sweep, columns, lines, numbers, spread)


def _gains(sweep: Sweep, before: Array, after: Array, floor: float) -> Gains:
    """Return the errors of windows on held-out stretches, over a floor [N^2*m^2]."""
    use = sweep.moving & sweep.held_out
    window = np.asarray(sweep.time / _WINDOW, np.int64)[use]
    count = np.bincount(window)
    parts = [np.bincount(window, rest[use] ** 2)[count > 0] / count[count > 0] / floor
             for rest in (before, after)]
    return Gains(parts[0], parts[1], np.ones_like(parts[0]) if floor != 1.0 else 0.0 * parts[0])


def _floor(part: Explained) -> float:
    """Return the power of white noise in the torque, by its fourth differences [N^2*m^2]."""
    rest = part.without(())[part.sweep.moving]
    usual = np.median(np.abs(np.diff(rest, 4))) / NORMAL_MEDIAN
    return float(usual) ** 2 / FOURTH_DIFFERENCES


def _gain_without(part: Explained, taken: Sequence[int]) -> Gains:
    return _gains(part.sweep, part.without(taken), part.without(()), _floor(part))


def _findings(part: Explained) -> Iterator[Finding]:
    """Return friction, where motion both ways shows it, and every line."""
    label, first = part.sweep.joint.label, _base(part.sweep).shape[1]
    if part.sweep.both_ways:
        for place, kind, name in ((_LOAD, CoulombFriction, 'level'),
                                  (_LOAD + 1, ViscousFriction, 'slope')):
            if part.spread[place] < KNOWN * part.numbers[place]:
                yield _finding(part, kind(**{name: part.numbers[place]}), label, [place],
                               {name: (part.numbers[place], part.spread[place])},
                               (part.numbers[place] / part.spread[place]) ** 2, 60.0)
    for number, line in enumerate(part.lines):
        places = [first + 2 * number, first + 2 * number + 1]
        effect, spread = _wave(part, number), float(part.spread[places].mean())
        yield _finding(part, effect, label, places, {
            'amplitude': (effect.amplitude, spread),
            'order': (effect.order, spread / effect.amplitude / max(
                float(part.sweep.angle[part.sweep.moving].std()), 1e-9)),
            'phase': (effect.phase, spread / effect.amplitude)}, line.stands_out, STANDS_OUT)


def _wave(part: Explained, number: int) -> MotorCogging:
    """Return a line as cogging, which the commanded torque has to make up for."""
    along, across = -part.numbers[_base(part.sweep).shape[1] + 2 * number:][:2]
    return MotorCogging(math.hypot(along, across), part.lines[number].order,
                        math.atan2(across, along))


def _finding(part: Explained, effect: Effect, label: str, places: Sequence[int],
             numbers: dict[str, tuple[float, float]], score: float, least: float) -> Finding:
    known = {name: Number(value, type(effect).declaration(name).unit,
                          value - NORMAL_90 * spread, value + NORMAL_90 * spread)
             for name, (value, spread) in numbers.items()}
    evidence = Evidence(score, least, None, math.exp(min(0.5 * score, 700.0)))
    return Finding(effect.name, label, effect.site.value, effect.cause, known, evidence,
                   _gain_without(part, places).gain(), probability(margin_of(evidence)))


def _one_way(part: Explained) -> Alike:
    """Return what a sweep in one direction cannot tell apart, each as if it alone resisted."""
    label, (resists, reach) = part.sweep.joint.label, _resistance(part)
    way = float(np.sign(np.median(part.sweep.speed[part.sweep.moving])))
    sizes = (CoulombFriction, 'level', resists), (DriveOffset, 'offset', -way * resists)
    return Alike(tuple((kind.name, label) for kind, _, _ in sizes), 'the same sweep back', tuple(
        Candidate(kind.name, label, {name: Number(size, kind.declaration(name).unit,
                                                  size - reach, size + reach)}, False)
        for kind, name, size in sizes) if resists > 0.0 else ())


def _resistance(part: Explained) -> tuple[float, float]:
    """Return the torque that resists a sweep at its mean speed, and how far it is in doubt."""
    friction = [_LOAD, _LOAD + 1]
    speed = float(np.abs(part.sweep.speed[part.sweep.moving]).mean())
    along = np.array([1.0, speed])
    left = part.without(())[part.sweep.moving & part.sweep.held_out]
    return float(along @ part.numbers[friction]), NORMAL_90 * float(left.std())


def _level(part: Explained) -> str:
    """Return how much resists a sweep in one direction, at its mean speed."""
    friction, use = [_LOAD, _LOAD + 1], part.sweep.moving & part.sweep.held_out
    speed = float(np.abs(part.sweep.speed[part.sweep.moving]).mean())
    without, left = (float(np.sqrt(np.mean(part.without(taken)[use] ** 2)))
                     for taken in (friction, ()))
    return (f'{part.sweep.joint.label} moves one way: {_resistance(part)[0]:.3g} N*m at the shaft '
            f'resist at {speed:.3g} rad/s, friction and offset together; the held-out error is '
            f'{left:.2g} N*m with it and {without:.2g} N*m without')


def _unexplained(part: Explained) -> Iterator[Unexplained]:
    """Return the rest of a motor if it is far above white noise."""
    rest = part.without(())[part.sweep.moving]
    power, floor = float(np.mean(rest ** 2)), _floor(part)
    if power > (1.0 + REST ** 2) * floor:
        yield Unexplained('motor', part.sweep.joint.label, 'nothing', None, 1.0 - floor / power)


def _residual(part: Explained) -> Residual:
    """Return what the motor balance misses on held-out stretches, rms at the output."""
    use, ratio = part.sweep.moving & part.sweep.held_out, part.sweep.joint.ratio
    before, after = (ratio * float(np.sqrt(np.mean(part.without(taken)[use] ** 2)))
                     for taken in (_told(part), ()))
    return Residual('motor', part.sweep.joint.label, before, after,
                    ratio * math.sqrt(_floor(part)), 'N*m')


def _told(part: Explained) -> list[int]:
    """Return the columns of what is told: waves, and friction where motion both ways shows it."""
    first = _LOAD if part.sweep.both_ways else _base(part.sweep).shape[1]
    return list(range(first, part.columns.shape[1]))


def _total(parts: Sequence[Explained]) -> TotalGain:
    """Return the gain of friction and waves of all motors together."""
    each = [_gain_without(part, _told(part)) for part in parts if _told(part)]
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
    """Return the arm with the friction that is told and the strongest line of each motor."""
    strongest: dict[str | None, float] = {}
    for found in findings:
        numbers = {name: number.value for name, number in found.parameters.items()}
        if found.effect == MotorCogging.name:
            if numbers['amplitude'] < strongest.get(found.joint, 0.0):
                continue
            strongest[found.joint] = numbers['amplitude']
        arm = arm.with_effect(replace(arm.effect(found.effect, found.joint), **numbers),
                              found.joint)
    return arm
