"""From the friction that a motor shows to findings: numbers, how sure, and what looks alike."""

from collections.abc import Iterator
import math
from typing import Any, NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import Effect, effect_named
from hda_arm_sim.model.effects.catalogue import known_as
from hda_arm_sim.model.effects.place import DRY_LEVEL
import numpy as np

from .motor_fit import Explained, gain_without, METRIC, placebo_of
from .motor_friction import FrictionCause
from .posterior import Posterior
from ..findings.certainty import NAMED, ODDS
from ..findings.report import Alike, Candidate, Evidence, Finding, FittedNumber, OwnGain
from ..fitting.hypotheses import HYPOTHESES
from ...significance import NORMAL_90


class Alternative(NamedTuple):
    """Another cause that a set may hold in the place of one, and the probability of either."""

    name: str
    either: float


def friction_findings(part: Explained, arm: Arm) -> Iterator[Finding]:
    """
    Yield the friction causes of a motor, none where all together lose on held-out stretches.

    One of several that are wrong may gain there by what it takes from the others.
    """
    if part.friction is None:
        return
    numbers = range(len(part.friction.causes))
    every = [place for number in numbers for place in part.rubbing(number)]
    if not every or not gain_without(part, every).removed() > 0.0:
        return
    for number in numbers:
        found = _finding(part, number, arm)
        if found is not None:
            yield found


def _finding(part: Explained, number: int, arm: Arm) -> Finding | None:
    """Return a friction cause of a motor as a finding, None where it has no size of its own."""
    assert part.friction is not None
    found, label = part.friction.causes[number], part.sweep.joint.label
    parameters = _numbers(part, found, arm)
    if parameters is None:
        return None
    places, kind = part.rubbing(number), effect_named(found.name)
    rival = rival_of(part.friction.posterior, found)
    evidence = Evidence(2.0 * found.lead, 2.0 * math.log(ODDS),
                        rival.name if rival else None, math.exp(min(found.lead, 700.0)))
    gain = gain_without(part, places).gain().beside(placebo_of(part, places), METRIC)
    return Finding(found.name, label, kind.site.value, kind.cause, parameters, evidence, gain,
                   found.probability)


def is_sure(finding: Finding) -> bool:
    """Return whether a friction cause is named: it is sure, and gains more than its placebo."""
    gain = finding.gain
    return finding.probability >= NAMED and (
        not isinstance(gain, OwnGain) or gain.removed > gain.placebo)


def friction_pairs(part: Explained, arm: Arm) -> Iterator[Alike]:
    """Yield the causes that are not sure, each with what it may be taken for, if that is sure."""
    assert part.friction is not None
    label = part.sweep.joint.label
    for found in part.friction.causes:
        rival = rival_of(part.friction.posterior, found)
        numbers = _numbers(part, found, arm)
        if found.probability >= NAMED or rival is None or numbers is None or rival.either < NAMED:
            continue
        yield Alike(((found.name, label), (rival.name, label)),
                    HYPOTHESES[found.name].experiment, (
                        Candidate(found.name, label, numbers, True, found.probability),),
                    rival.either, found.probability / rival.either)


def rival_of(posterior: Posterior, found: FrictionCause) -> Alternative | None:
    """Return the named cause that most likely acts where a cause does not, None without one."""
    beside = posterior.names(posterior.sets[0])
    others = [cause.name for cause in posterior.causes if cause.named
              and cause.name not in beside]
    if not others:
        return None
    best = max(others, key=lambda name: posterior.either(found.name, name))
    return Alternative(best, posterior.either(found.name, best))


def _numbers(part: Explained, found: FrictionCause, arm: Arm) -> dict[str, FittedNumber] | None:
    """Return the numbers of a cause with 90 % intervals, those of a grid as chosen."""
    law, label = found.law, part.sweep.joint.label
    kind, stated = type(law.effect), arm.effect(found.name, label)
    spread = NORMAL_90 * np.sqrt(np.maximum(np.diag(found.covariance), 0.0))
    values, unit, size = found.numbers, law.unit, law.numbers[0]
    if kind.place is DRY_LEVEL and size != 'level':
        level = _dry_level(part, arm)
        if level <= 0.0:
            return None                     # a share of a dry friction that is not there
        unit = unit / level
    value, reach = float(values[0]), float(spread[0])
    if len(law.numbers) > 1:
        value, reach = float(np.hypot(*values)), float(spread.mean())
    else:
        value += getattr(stated, size) / unit
    found_numbers = {size: _within(kind, size, unit * value, unit * reach)}
    if len(law.numbers) > 1:
        turned = float(np.arctan2(values[1], values[0]))
        found_numbers['phase'] = _within(kind, 'phase', turned, reach / max(value, 1e-300))
    chosen = {rule.name: getattr(law.effect, rule.name) for rule in kind.declarations()
              if rule.name not in law.numbers}
    return {**{name: FittedNumber(each, kind.declaration(name).unit, each, each)
               for name, each in chosen.items()}, **found_numbers}


def _within(kind: type[Effect], name: str, value: float, reach: float) -> FittedNumber:
    """Return a number with its interval, within the declared bounds."""
    rule = kind.declaration(name)
    inside: Array = np.clip([value, value - reach, value + reach], rule.low, rule.high)
    return FittedNumber(float(inside[0]), rule.unit, float(inside[1]), float(inside[2]))


def _dry_level(part: Explained, arm: Arm) -> float:
    """Return the dry friction of a motor: as the arm's file states it, and what was found."""
    assert part.friction is not None
    dry: Any = arm.effect(known_as('dry_friction').name, part.sweep.joint.label)
    found = [float(cause.numbers[0]) * cause.law.unit for cause in part.friction.causes
             if cause.name == dry.name]
    return float(dry.level) + sum(found)
