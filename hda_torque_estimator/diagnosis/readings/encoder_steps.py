"""
Find the steps in which the encoders really count, from the changes of their readings.

All changes are whole multiples of the step. The largest angle of which they are is taken. So an
encoder that skips counts, moves fast or has noise of its own still shows its step.
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

from .raw_cause import number, RawCause, SHARE
from ...measurements.measurement import Measurement
from ...significance import NORMAL_MEDIAN, SCORE_BAR

SIDES = ('motor_step', 'link_step')
# Choices unless told otherwise.
_SAME = 1e-9            # changes of an angle that rounding may make [rad]
_COARSER = 1.5          # steps, in those stated, from which an encoder is coarser
_NEAR = 0.05            # of a step, how far a change may be from a whole multiple
_WHOLE = 0.98           # share of changes that must be whole multiples
_PARTS = 8              # of the smallest change, one of which is the step


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
    size = max(_COARSER * stated, math.sqrt(12.0 * SHARE) * _noise(angle))
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
    smallest = float(np.quantile(changes, 1e-3, method='lower'))
    for part in range(1, _PARTS + 1):
        counts = changes * part / smallest
        near = np.abs(counts - np.round(counts)) < _NEAR
        if near.mean() > _WHOLE:
            return _fitted(changes[near], np.round(counts[near]))
    return None


def _fitted(changes: Array, counts: Array) -> Step:
    """Return the step of which changes are these multiples."""
    size = float(changes @ counts / (counts @ counts))
    worst = np.abs(changes - counts * size).max() + np.finfo(float).eps * changes.max()
    return Step(size, float(worst / counts.max()), len(changes))


def _coarser(step: Step | None, stated: float, angle: Array) -> float:
    """Return the evidence that a step is larger than stated, and matters; else 0."""
    if step is None or step.size < _COARSER * stated:
        return 0.0
    if step.size ** 2 / 12.0 < SHARE * _noise(angle) ** 2:
        return 0.0
    return _evidence(step.size, stated, step.changes)


def _noise(angle: Array) -> float:
    """Return how much readings scatter from sample to sample [rad]."""
    return float(np.median(np.abs(np.diff(angle, 2))) / (NORMAL_MEDIAN * np.sqrt(6.0)))


def _evidence(size: float, stated: float, changes: int) -> float:
    return 2.0 * changes * math.log(size / max(stated, 1e-3 * size))
