"""
What a recording could have shown: the smallest size of every effect, and when that is too little.

Silence means little where an effect that was asked about could not have been seen, or too many
could not: such a recording abstains.
"""

from collections.abc import Iterator, Sequence
import math

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import (ClockJitter, CoarseQuantisation, DroppedSamples,
                                       EncoderInterpolationError)

from .detectable import smallest_in_balances
from ..findings.smallest import hidden, places, Smallest, WEAKER
from ..fitting.fit import Fit, Fitter
from ..fitting.hypotheses import HYPOTHESES
from ..judging.search import SearchResult
from ..readings.encoder_steps import SIDES, smallest_step
from ..readings.late_stamps import smallest_jitter, stamp_slips
from ..readings.line_error import LINK, smallest_wave
from ..readings.lost_samples import slips_of, smallest_rate
from ..readings.raw_readings import RawReadings
from ...least_squares.term import Place
from ...measurements.measurement import Measurement
from ...measurements.running_clock import inside, Spans
from ...significance import MOSTLY

# Numerics; choices unless stated otherwise.
_LISTED = 6             # effects that a sentence names
_PLAN = 'hda plan --show EFFECT finds a motion that shows one'


def smallest_sizes(fitter: Fitter, found: SearchResult, fit: Fit, raw: RawReadings,
                   training: Spans,
                   names: Sequence[str]) -> tuple[Smallest, ...]:
    """Return the smallest sizes of effects, in the order of their names, by place."""
    smallest = list(smallest_in_balances(fitter, found, fit,
                                         [name for name in names if name in HYPOTHESES]))
    smallest += _in_readings(raw.measurement.as_recorded(), raw.arm, training)
    return tuple(one for name in names for one in smallest if one.effect == name)


def nothing_seen(arm: Arm, names: Sequence[str]) -> tuple[Smallest, ...]:
    """Return what a recording in which nothing moves shows: none of these effects."""
    return tuple(hidden(name, place) for name in names for place in places(arm, name))


def shows_too_little(sizes: Sequence[Smallest], arm: Arm, about: Sequence[Place]) -> bool:
    """Return if silence says nothing about the effects asked about, or else about too many."""
    if about:
        return bool(_missed(sizes, arm, about))
    return len(_unseen(sizes, arm)) > MOSTLY * len({one.effect for one in sizes})


def remarks(sizes: Sequence[Smallest], arm: Arm, about: Sequence[Place],
            rate: float | None = None) -> tuple[str, ...]:
    """
    Return sentences on what the recording could not have shown.

    A `rate` [Hz] is to blame where it is given: the same motion, sampled so, would have.
    """
    lines = [f'asked about {one.effect} at {one.joint or "the arm"}: {_limit(one)}'
             for one in _missed(sizes, arm, about)]
    unseen = _unseen(sizes, arm)
    if unseen:
        rest = f' and {len(unseen) - _LISTED} more' if len(unseen) > _LISTED else ''
        lines.append(f'{len(unseen)} of {len({one.effect for one in sizes})} effects could not '
                     f'have been seen at a typical size ({", ".join(unseen[:_LISTED])}{rest}); '
                     + (_PLAN if rate is None else f'the rate is to blame: the same motion at '
                        f'{rate:g} samples per second would have shown enough'))
    return tuple(lines)


def asked(arm: Arm, words: Sequence[str]) -> tuple[Place, ...]:
    """
    Return the effects and places of words, each EFFECT for all places or EFFECT@JOINT.

    Raises ParameterError or ArmError for effects and joints that do not exist.
    """
    about: list[Place] = []
    for word in words:
        name, at, joint = word.partition('@')
        about += [(name, place) for place in ((joint,) if at else places(arm, name))]
    for name, place in about:
        arm.effect(name, place)
    return tuple(about)


def _missed(sizes: Sequence[Smallest], arm: Arm, about: Sequence[Place]) -> list[Smallest]:
    """Return which effects that were asked about could not have been seen."""
    known = {(one.effect, one.joint): one for one in sizes}
    wanted = [known.get(place) or hidden(*place) for place in about]
    return [one for one in wanted if not one.is_shown(arm)]


def _unseen(sizes: Sequence[Smallest], arm: Arm) -> list[str]:
    """Return the effects that could not have been seen at any place, by name."""
    shown = {one.effect for one in sizes if one.is_shown(arm)}
    return list(dict.fromkeys(one.effect for one in sizes if one.effect not in shown))


def _limit(one: Smallest) -> str:
    """Return what of an effect could have been seen."""
    row = one.row()
    if row.smallest_detectable is None:
        return 'this motion cannot show it at any size'
    side = 'above' if one.effect in WEAKER else 'below'
    return (f'this motion cannot show {one.number} {side} {row.smallest_detectable:.3g} '
            f'{row.unit}'.rstrip())


def _in_readings(measurement: Measurement, arm: Arm, training: Spans) -> Iterator[Smallest]:
    """Yield the smallest sizes of effects that raw readings show."""
    seen = inside(measurement.time, training)
    for column, label in enumerate(arm.labels):
        angles, stated = measurement.reading[:, column], arm.effect(CoarseQuantisation.name, label)
        steps = [Smallest(stated.name, label, number, smallest_step(angles[:, side], size, seen))
                 for side, (number, size) in enumerate(zip(SIDES, stated.values()))]
        yield min(steps, key=lambda one: math.inf if one.size is None else one.size)
        yield Smallest(EncoderInterpolationError.name, label, 'amplitude', smallest_wave(
            angles[:, LINK], measurement.dt, seen, stated.values()[LINK]))
    yield Smallest(DroppedSamples.name, None, 'rate',
                   smallest_rate(slips_of(measurement, arm), seen))
    yield Smallest(ClockJitter.name, None, 'jitter',
                   smallest_jitter(stamp_slips(measurement), seen, arm))
