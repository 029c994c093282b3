"""Several recordings of an arm as one measurement, on one clock."""

from collections.abc import Sequence
from dataclasses import replace

from hda_arm_sim.foundation.arrays import Array
import numpy as np
from scipy.interpolate import CubicSpline

from .measurement import Measurement
from .sample_grid import interpolated


def joined(recordings: Sequence[Measurement], grain: int = 1) -> Measurement:
    """
    Return recordings of one arm and one rate as one measurement.

    If there are several, each is cut to a multiple of `grain` samples.
    """
    if len(recordings) == 1:
        return recordings[0]
    lengths = [len(one.command) // grain * grain for one in recordings]
    begins = np.cumsum([0, *lengths[:-1]]).tolist()
    return Measurement(
        recordings[0].labels, recordings[0].dt,
        np.concatenate([one.reading[:length] for one, length in zip(recordings, lengths)]),
        np.concatenate([one.command[:length] for one, length in zip(recordings, lengths)]),
        _running([one.absent for one in recordings], lengths), tuple(begins),
        _past(recordings, lengths), recordings[0].parts, held=_held(recordings),
        reference=_references(recordings, lengths),
        blind=_running([one.blind for one in recordings], lengths))


def _held(recordings: Sequence[Measurement]) -> bool | None:
    """Return what is known of the commands of all, None where they differ."""
    ways = {one.held for one in recordings}
    return ways.pop() if len(ways) == 1 else None


def _past(recordings: Sequence[Measurement], lengths: Sequence[int]) -> Array:
    """Return how far all are past their ticks, 0 where nothing is known; empty if nowhere."""
    if not any(len(one.past) for one in recordings):
        return np.zeros(0)
    return np.concatenate([one.past[:length] if len(one.past) else np.zeros(length)
                           for one, length in zip(recordings, lengths)])


def _references(recordings: Sequence[Measurement], lengths: Sequence[int]) -> Array:
    """Return the reference torques of all, NaN where a recording has none; empty if nowhere."""
    if not any(one.reference.size for one in recordings):
        return np.zeros((0, 0))
    return np.concatenate([one.reference[:length] if one.reference.size else
                           np.full((length, len(one.labels)), np.nan)
                           for one, length in zip(recordings, lengths)])


def resampled(measurement: Measurement, dt: float) -> Measurement:
    """
    Return a measurement with another period, as it is where less than a sample apart at the end.

    Angles go along splines; a command is the mean of those in force. Nothing is known any more
    about when each sample was taken.
    """
    count = len(measurement.command)
    if abs(dt / measurement.dt - 1.0) * count < 1.0:
        return replace(measurement, dt=dt)
    time = measurement.time
    grid = dt * np.arange(int(time[-1] / dt) + 1)
    asked = measurement.dt * np.arange(count + 1)
    whole = np.concatenate([np.zeros((1, measurement.command.shape[1])),
                            np.cumsum(measurement.command, axis=0)]) * measurement.dt
    edges = np.append(grid, grid[-1] + dt)
    given = np.stack([np.interp(edges, asked, column) for column in whole.T], axis=1)
    absent = {min(round(place * measurement.dt / dt), len(grid) - 1)
              for place in measurement.absent}
    return Measurement(measurement.labels, dt, CubicSpline(time, measurement.reading)(grid),
                       np.diff(given, axis=0) / dt, tuple(sorted(absent)),
                       reference=interpolated(grid, time, measurement.reference))


def _running(places: Sequence[Sequence[int]], lengths: Sequence[int]) -> tuple[int, ...]:
    """Return samples of recordings, counted from the first of all."""
    begins = np.cumsum([0, *lengths[:-1]]).tolist()
    return tuple(begin + place for some, length, begin in zip(places, lengths, begins)
                 for place in some if place < length)
