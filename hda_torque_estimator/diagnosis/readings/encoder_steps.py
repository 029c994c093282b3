"""
Find the steps in which the encoders really count, from the changes of their readings.

All changes are whole multiples of the step. The largest angle of which they are is taken. So an
encoder that skips counts, moves fast or has noise of its own still shows its step. Of a scale that
is not even no step divides all changes. But no two levels that it shows are closer than a step.
"""

from collections.abc import Iterator
from dataclasses import replace
import math
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import CoarseQuantisation
import numpy as np
from numpy.typing import NDArray
from scipy.special import xlogy

from .raw_cause import BETWEEN, number, RawCause, WRONG
from ...measurements.measurement import Measurement
from ...significance import HARDLY, IMMATERIAL, NORMAL_MEDIAN, SCORE_BAR

SIDES = ('motor_step', 'link_step')
# Numerics; choices unless stated otherwise.
_SAME = 1e-9            # changes of an angle that rounding may make [rad]
_PARTS = 8              # of the smallest change, one of which is the step
_PASS = 25              # samples within which an arm passes a place once


class Step(NamedTuple):
    """A step [rad], how far off it may be, and how many changes show it."""

    size: float
    reach: float
    changes: int


def coarse_encoders(measurement: Measurement, arm: Arm,
                    seen: NDArray[np.bool_]) -> Iterator[RawCause]:
    """Return the joints whose encoders count in larger steps than stated, by rows `seen`."""
    for column, label in enumerate(arm.labels):
        stated = arm.effect(CoarseQuantisation.name, label)
        effect, steps, score = stated, {}, 0.0
        for side, name in enumerate(SIDES):
            angle = measurement.reading[:, column, side]
            step = true_step(angle, measurement.put_in | ~seen)
            evidence = _coarser(step, getattr(stated, name), angle)
            if step is not None and evidence > SCORE_BAR:
                effect, score = replace(effect, **{name: step.size}), score + evidence
                steps[name] = step
        if steps:
            yield RawCause(effect, label, {name: number(effect, name, step.reach)
                                           for name, step in steps.items()}, score,
                           tuple((column, SIDES.index(name)) for name in steps))


def smallest_step(angle: Array, stated: float, seen: NDArray[np.bool_]) -> float | None:
    """Return the smallest step that rows `seen` of readings (k,) would show, None if none."""
    size = max(BETWEEN * stated, math.sqrt(12.0 * IMMATERIAL) * _noise(angle))
    counts = float(np.abs(np.diff(angle))[seen[1:]].sum()) / max(size, _SAME)
    return size if _evidence(size, stated, int(counts)) > SCORE_BAR else None


def true_step(angle: Array, left_out: NDArray[np.bool_]) -> Step | None:
    """
    Return the step in which readings (k,) count [rad], or None if they do not.

    Readings that are `left_out` (k,) do not count.
    """
    changes = np.abs(np.diff(angle))[~(left_out[1:] | left_out[:-1])]
    changes = changes[changes > _SAME]
    if not len(changes):
        return None
    smallest = float(np.quantile(changes, WRONG, method='lower'))
    for part in range(1, _PARTS + 1):
        counts = changes * part / smallest
        near = np.abs(counts - np.round(counts)) < HARDLY
        if near.mean() > 1.0 - IMMATERIAL:
            return _fitted(changes[near], np.round(counts[near]))
    return _between_levels(angle[~left_out])


def _between_levels(angle: Array) -> Step | None:
    """
    Return the usual step between levels that readings (k,) show, None if they show none.

    Of readings that count finely, gaps are the rarer the wider they are. So of those between a
    distance and twice of it, there are no more than closer ones. And a level is seen again at
    other times as often as its neighbours. Levels of one pass alone are as far apart as it moved.
    """
    levels, first = np.unique(angle, return_index=True)
    last = len(angle) - 1 - np.unique(angle[::-1], return_index=True)[1]
    apart = np.maximum(last[1:], last[:-1]) - np.minimum(first[1:], first[:-1]) > _PASS
    gaps = np.diff(levels)[apart]
    gaps = gaps[gaps > _SAME]
    if not len(gaps):
        return None
    least = float(np.quantile(gaps, WRONG, method='lower'))
    closer, seen_again = int((gaps < least).sum()), int((last - first > _PASS).sum())
    as_far = min(int(((gaps >= least) & (gaps < 2.0 * least)).sum()), seen_again)
    usual = max(0.5 * (closer + as_far), 0.5)
    if as_far < usual or 2.0 * float(xlogy(closer, closer / usual)
                                     + xlogy(as_far, as_far / usual)) < SCORE_BAR:
        return None
    own = gaps[(gaps >= least) & (gaps < BETWEEN * least)]
    return Step(float(own.mean()), float(own.std()), as_far)


def _fitted(changes: Array, counts: Array) -> Step:
    """Return the step of which changes are these multiples."""
    size = float(changes @ counts / (counts @ counts))
    worst = np.abs(changes - counts * size).max() + np.finfo(float).eps * changes.max()
    return Step(size, float(worst / counts.max()), len(changes))


def _coarser(step: Step | None, stated: float, angle: Array) -> float:
    """Return the evidence that a step is larger than stated, and matters; else 0."""
    if step is None or step.size < BETWEEN * stated:
        return 0.0
    if step.size ** 2 / 12.0 < IMMATERIAL * _noise(angle) ** 2:
        return 0.0
    return _evidence(step.size, stated, step.changes)


def _noise(angle: Array) -> float:
    """Return how much readings scatter from sample to sample [rad]."""
    return float(np.median(np.abs(np.diff(angle, 2))) / (NORMAL_MEDIAN * np.sqrt(6.0)))


def _evidence(size: float, stated: float, changes: int) -> float:
    return 2.0 * changes * math.log(size / max(stated, 1e-3 * size))
