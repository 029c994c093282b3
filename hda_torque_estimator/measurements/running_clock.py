"""
Several recordings on one running clock: which stretches are held out, what belongs to one alone.

An arm is the same in all its recordings, but something touches it in one of them. The onset of a
contact counts on the running clock.
"""

from dataclasses import replace
from typing import Any

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import EFFECTS
import numpy as np
from numpy.typing import NDArray

from .measurement import Measurement

Spans = tuple[tuple[float, float], ...]
# Choices unless stated otherwise.
_BLOCK = 2.0            # stretches that are trained on, and held out in turn [s]
_HELD = 3               # of so many stretches one is held out
_ENOUGH = 3             # recordings of which the last is held out whole
# What touches the arm in one recording.
_PASSING = tuple(kind.name for kind in EFFECTS if kind.hypothesis and kind.hypothesis.passing)


def arm_during(arm: Arm, piece: slice, dt: float) -> Arm:
    """Return the arm as the recording of these samples has it, its time from zero [s]."""
    begin, end = piece.start * dt, piece.stop * dt
    for name in _PASSING:
        passing: Any = arm.effect(name)
        if passing.is_neutral():
            continue
        if not (begin <= passing.onset or begin == 0.0) or passing.onset >= end:
            arm = arm.without(name)
        else:
            arm = arm.with_effect(replace(passing, onset=passing.onset - begin))
    return arm


def inside(time: NDArray[np.float64], spans: Spans) -> NDArray[np.bool_]:
    """Return which times (k,) lie in stretches [s]."""
    rows = np.zeros(len(time), bool)
    for begin, end in spans:
        rows |= (time >= begin) & (time < end)
    return rows


def split(measurement: Measurement) -> tuple[Spans, Spans]:
    """Return the stretches of the running clock that fits see, and those that they do not [s]."""
    training: list[tuple[float, float]] = []
    held_out: list[tuple[float, float]] = []
    pieces = measurement.pieces()
    for place, piece in enumerate(pieces, 1):
        begin, last = piece.start * measurement.dt, (piece.stop - 1) * measurement.dt
        seen, unseen = stretches(last - begin)
        if place == len(pieces) >= _ENOUGH:
            seen, unseen = (), ((0.0, last - begin),)
        training += [(begin + first, begin + end) for first, end in seen]
        held_out += [(begin + first, begin + end) for first, end in unseen]
    return tuple(training), tuple(held_out)


def stretches(duration: float) -> tuple[Spans, Spans]:
    """Return the stretches of one recording that fits see, and those that they do not [s]."""
    ends = np.append(np.arange(0.0, duration, _BLOCK), duration)
    spans = [(float(begin), float(end)) for begin, end in zip(ends[:-1], ends[1:])]
    held = spans[_HELD - 1::_HELD]
    return tuple(span for span in spans if span not in held), tuple(held)


def within(spans: Spans, piece: slice, dt: float) -> Spans:
    """Return the parts of spans that lie in a recording, in its own time [s]."""
    begin, end = piece.start * dt, piece.stop * dt
    return tuple((max(first, begin) - begin, min(last, end) - begin)
                 for first, last in spans if first < end and last > begin)
