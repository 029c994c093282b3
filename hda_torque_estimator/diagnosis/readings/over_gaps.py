"""
Curves through good samples, over those that are wrong.

A cubic through the nearest good readings on both sides says what a reading should have been. What
it leaves in gaps of the same length elsewhere, where nothing is wrong, says how well.
"""

from typing import NamedTuple, TypeAlias

from hda_arm_sim.foundation.arrays import Array, Mask
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_closing

from ..balances.balance import BANDWIDTH
from ...significance import MATERIAL, NORMAL_MEDIAN

# Numerics; choices unless stated otherwise.
REACH = 4               # good neighbours on each side through which a curve is laid
_DEGREE = 3             # of the curve
_READINGS = 40_000      # that are asked, about as many, what a curve is off by

Places: TypeAlias = NDArray[np.intp]            # of samples


class Curves(NamedTuple):
    """What readings (q, n, 2) should be by others, and what is known of that."""

    reading: Array
    change: Array           # from one sample to the next
    gain: Array             # (q,) deviation of a reading from its curve, over that of a reading


def laid(reading: Array, good: Mask, at: Places) -> Curves:
    """
    Return the curves at some samples (q,) of readings (k, n, 2), through others that are good.

    They are the nearest ones, as many on both sides where there are as many.
    """
    near, weights, which = _through(good, at)
    gain = np.sqrt(1.0 + (weights[:, 0] ** 2).sum(axis=1))
    curve, change = np.einsum('qdi,qinc->dqnc', weights[which], reading[near])
    return Curves(curve, change, gain[which])


def _through(good: Mask, at: Places) -> tuple[Places, Array, Places]:
    """Return samples (q, c) of curves, kinds of weights (w, 2, c), and which each has (q,)."""
    known, order = np.flatnonzero(good), np.arange(2 * REACH)
    first = np.clip(np.searchsorted(known, at) - REACH, 0, len(known) - 2 * REACH - 1)
    itself = good[at][:, None] & (order >= REACH)
    near = known[first[:, None] + order + itself]
    patterns, which = np.unique(near - at[:, None], axis=0, return_inverse=True)
    return near, _weights(patterns), which.reshape(-1)


def _weights(places: Places) -> Array:
    """Return weights (q, 2, c) of readings at places (q, c) about a sample: angle and change."""
    far = np.abs(places).max(axis=1, keepdims=True)
    powers = (places / far)[:, :, None] ** np.arange(_DEGREE + 1)
    weights = np.linalg.pinv(powers)[:, :2]
    weights[:, 1] /= far
    return np.asarray(weights)


def _through_neighbours() -> Array:
    """Return weights (2 reach + 1,) of the curve through all neighbours, at the sample between."""
    places = np.arange(-REACH, REACH + 1)
    weights = np.zeros(len(places))
    weights[places != 0] = _weights(places[None, places != 0])[0, 0]
    return weights


KERNEL = _through_neighbours()
GAIN = float(np.sqrt(1.0 + KERNEL @ KERNEL))    # of noise, in what it leaves of readings


def blind_gaps(readings: Array, wrong: Mask, clean: Mask, scatter: Array, dt: float) -> Mask:
    """
    Return the gaps (k,) in readings (k, n, 2) in which nobody knows how the arm moved.

    How far a curve is off over the same gap shows where samples are `clean`. It is too far where
    balances would show that beside noise (eq:blind-gap). `scatter` (n, 2) is what curves through
    all neighbours leave of clean readings [rad].
    """
    blind, known = np.zeros(len(readings), bool), dict[bytes, bool]()
    before = np.concatenate([[0], np.cumsum(~clean)])
    alone = KERNEL - (np.arange(2 * REACH + 1) == REACH)
    noise = np.maximum(_usual_sum(readings, before, alone), scatter) / GAIN
    most = MATERIAL * noise * 1.5 * np.sqrt(0.4 / (BANDWIDTH * dt))
    for gap in _gaps(wrong):
        kernel = _kernel_of(wrong, gap)
        key = kernel.tobytes()
        if key not in known:
            known[key] = not bool((_usual_sum(readings, before, kernel) <= most).all())
        blind[gap] = known[key]
    return blind


def _gaps(wrong: Mask) -> list[slice]:
    """Return the wrong samples (k,), in one gap where too few are good in between for a curve."""
    return runs_of(binary_closing(np.pad(wrong, REACH), np.ones(REACH, bool))[REACH:-REACH])


def runs_of(marked: Mask) -> list[slice]:
    """Return where samples (k,) are marked without a break."""
    edges = np.flatnonzero(np.diff(marked.astype(np.int8), prepend=0, append=0)).tolist()
    return [slice(begin, end) for begin, end in zip(edges[::2], edges[1::2])]


def _kernel_of(wrong: Mask, gap: slice) -> Array:
    """Return the weights of readings about a gap that sum up what its curve is off by."""
    places = gap.start + np.flatnonzero(wrong[gap])
    near, weights, which = _through(~wrong, places)
    first = min(int(near.min()), int(places[0]))
    kernel = np.zeros(max(int(near.max()), int(places[-1])) - first + 1)
    np.add.at(kernel, near - first, weights[which, 0])
    np.add.at(kernel, places - first, -1.0)
    return kernel


def _usual_sum(readings: Array, before: Places, kernel: Array) -> Array:
    """
    Return the usual size (n, 2) of what a kernel sums up of readings that are clean.

    `before` (k + 1,) counts those that are not. It is infinite where there are no such stretches.
    """
    span = len(kernel)
    starts = np.flatnonzero(before[span:] == before[:-span])
    if not len(starts):
        return np.full(readings.shape[1:], np.inf)
    starts = starts[::max(1, len(starts) * span // _READINGS)]
    sums = np.einsum('i,qinc->qnc', kernel, readings[starts[:, None] + np.arange(span)])
    return np.asarray(np.median(np.abs(sums), axis=0) / NORMAL_MEDIAN)
