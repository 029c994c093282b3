"""Put samples of joint states, which jitter or were lost, on the even grid of a measurement."""

from collections.abc import Mapping
from typing import Any

from hda_arm_sim.foundation.arrays import Array
from hda_msgs_json.errors import HdaError
from hda_msgs_json.samples import JointSamples, WrenchSamples
from hda_msgs_json.topics import motor_name
import numpy as np
from numpy.typing import NDArray

from .measurement import Measurement
from ..samples.readings import readings

# Choices unless stated otherwise.
FINEST = 1e-6           # period of a grid: no encoder is read more often [s]
_SINGLE = 0.75          # share by which an interval of one period may differ from the usual one
_STEEPER = 4.0            # deviations by which a line is steeper than jitter makes it
_FIRST = 8              # half of the intervals in the first stretch that sets the period
EMPTIEST = 4.0          # places of a grid for each sample: beyond, most would be made up


class StampsError(HdaError):
    """Stamps from which no even grid can be made."""


def measurement_from(labels: tuple[str, ...], samples: JointSamples,
                     source: str = 'the recording',
                     references: Mapping[str, WrenchSamples] | None = None) -> Measurement:
    """
    Return the joint states on the even grid of their usual period.

    The `references` of some joints, torques about z, are interpolated between their own stamps
    and never beyond them.

    Stamps that jitter by less than half a period only show by how much a sample was past its tick.
    One so late that the next shares its tick belongs to the tick before, if that has none.
    Where samples are missing, angles are joined by straight lines and commands held. Raises
    StampsError, naming the source, for stamps that are on no such grid.
    """
    reading = readings(labels, samples)[:, :, :2]
    command = samples.select([motor_name(label) for label in labels]).effort
    keep = np.isfinite(reading).all(axis=(1, 2)) & np.isfinite(command).all(axis=1)
    latest = np.maximum.accumulate(samples.stamps)
    keep &= np.diff(latest, prepend=latest[:1] - 1) > 0
    reference = _referring(labels, samples.stamps[keep], references or {})
    stamps = samples.stamps[keep]
    _check_count(stamps, samples.stamps, source)
    since = (stamps - stamps[0]) * 1e-9
    dt = _period(since)
    _check_grid(since, dt, source)
    ticks = np.round(since / dt).astype(np.int64)
    order = np.arange(len(ticks))
    ticks = np.minimum.accumulate((ticks - order)[::-1])[::-1] + order  # stamps are never early
    ticks = np.maximum(ticks, order)
    past = since - dt * ticks
    if ticks[-1] == len(ticks) - 1:
        return Measurement(labels, dt, np.ascontiguousarray(reading[keep]), command[keep],
                           past=past, reference=reference)
    grid = np.arange(ticks[-1] + 1)
    flat = reading[keep].reshape(len(ticks), -1)
    full = np.stack([np.interp(grid, ticks, column) for column in flat.T], axis=1)
    held = np.searchsorted(ticks, grid, side='right') - 1
    absent = np.setdiff1d(grid, ticks)
    return Measurement(labels, dt, full.reshape(len(grid), *reading.shape[1:]),
                       command[keep][held], tuple(absent.tolist()),
                       past=np.interp(grid, ticks, past),
                       reference=interpolated(grid, ticks, reference))


def interpolated(grid: NDArray[np.floating[Any]], time: Array, reference: Array) -> Array:
    """Return reference torques (k, n) of some times at those of a grid; empty ones stay empty."""
    if not reference.size:
        return reference
    return np.stack([np.interp(grid, time, column) for column in reference.T], axis=1)


def _referring(labels: tuple[str, ...], stamps: NDArray[np.int64],
               references: Mapping[str, WrenchSamples]) -> Array:
    """Return the reference torques at some stamps (k, n), NaN where unknown; empty of none."""
    if not references:
        return np.zeros((0, 0))
    found = np.full((len(stamps), len(labels)), np.nan)
    for joint, label in enumerate(labels):
        known = references.get(label)
        if known is not None and len(known) > 1:
            found[:, joint] = np.interp(stamps, known.stamps, known.torque[:, 2], np.nan, np.nan)
    return found


def _check_count(kept: NDArray[np.int64], stamps: NDArray[np.int64], source: str) -> None:
    """Raise StampsError where there are no two samples, or most stamps are of another time."""
    growing = np.diff(np.maximum.accumulate(stamps), prepend=stamps[:1] - 1) > 0
    if len(stamps) > 1 and 2 * growing.sum() < len(stamps):
        raise StampsError(f'{source}: only {growing.sum()} of {len(stamps)} stamps are later than '
                          'all before them; record the time of each sample in its header')
    if len(kept) < 2:
        raise StampsError(f'{source} is too short: it has {len(kept)} samples of all angles and '
                          'motor torques')


def _check_grid(since: Array, dt: float, source: str) -> None:
    """Raise StampsError for a grid that no encoder is read at, or that is nearly empty."""
    if dt < FINEST:
        raise StampsError(f'{source}: its stamps are {dt:.3g} s apart, at least {FINEST:g} s is '
                          'right; record the time of each sample in its header [ns]')
    if since[-1] > EMPTIEST * dt * len(since):
        at = int(np.argmax(np.diff(since)))
        before, after = since[at:at + 2]
        raise StampsError(f'{source}: its {len(since)} samples of {dt:.3g} s are spread over '
                          f'{since[-1]:.4g} s; the stamps jump by {after - before:.4g} s after '
                          f'{before:.4g} s: cut the recording there')


def _period(since: Array) -> float:
    """
    Return the even period of stamps that jitter about it, some of them missing [s].

    The mean of usual intervals would be wrong by whole samples in the end. So it counts those in a
    stretch of twice the length each time, and lays a line through their stamps. That of a short
    stretch shows less than the mean: it counts where the two differ by more than jitter makes.
    """
    steps = np.diff(since)
    usual = np.median(steps)
    single = steps[np.abs(steps - usual) < _SINGLE * usual]
    period, jitter = float(np.mean(single)), float(np.std(single)) / np.sqrt(2.0)
    reach = min(_FIRST, len(steps))
    while reach < len(since) - 1:
        reach = min(2 * reach, len(since) - 1)
        stretch = since[:reach + 1]
        phase = np.angle(np.exp(2.0j * np.pi * stretch / period).mean()) / (2.0 * np.pi)
        counts = np.round(stretch / period - phase)
        away = counts - counts.mean()
        slope = float(away @ stretch) / max(float(away @ away), 1.0)
        if slope > 0.0 and abs(slope - period) > _STEEPER * jitter / np.sqrt(away @ away):
            period = slope                  # not that of stamps that come in one burst
    return float(since[-1]) / max(round(float(since[-1]) / period), 1)
