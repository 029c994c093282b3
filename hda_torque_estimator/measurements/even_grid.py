"""
Readings at the ticks of an even clock, from stamps that say when each was really taken.

At speed a microsecond of jitter is worth more than the noise of a good encoder. But the stamps of
some drivers state when a sample was handed on, not when it was taken. They are believed where the
readings become smoother by them, and left aside elsewhere.
"""

from dataclasses import replace

from hda_arm_sim.foundation.arrays import Array
import numpy as np

from .measurement import Measurement

# Choices unless stated otherwise.
LEAST = 1e-8            # jitter beyond the nanoseconds in which stamps count [s]


def on_grid(measurement: Measurement) -> Measurement:
    """
    Return the readings at the ticks if the stamps are believed, else as they are.

    What stamps say of the clock stays, for controllers answered readings as they were taken. It
    goes where stamps were made even, or would have made readings rougher than they are: then they
    know nothing of it.
    """
    if np.abs(measurement.past).max(initial=0.0) < LEAST:
        return replace(measurement, past=np.zeros(0))
    stamped = as_stamped(measurement)
    moved = measurement.reading - stamped
    even, recorded = _roughness(stamped), _roughness(measurement.reading)
    if even.sum() < recorded.sum():
        reference = measurement.reference
        return replace(measurement, reading=stamped, reference=_at_ticks(
            measurement, reference) if reference.size else reference)
    known = (_roughness(moved) < recorded).all()
    return measurement if known else replace(measurement, past=np.zeros(0))


def as_stamped(measurement: Measurement) -> Array:
    """Return the readings at the ticks (k, n, 2) [rad], if each was taken when its stamp says."""
    if not len(measurement.past):
        return measurement.reading
    return _at_ticks(measurement, measurement.reading)


def _at_ticks(measurement: Measurement, values: Array) -> Array:
    """Return values (k, ...) at the ticks, which were taken when their stamps say."""
    past = measurement.past.reshape(-1, *[1] * (values.ndim - 1))
    return np.asarray(values - past * np.gradient(values, measurement.dt, axis=0))


def _roughness(reading: Array) -> Array:
    """Return the logarithms of what readings (k, n, 2) have beyond smooth motion (n, 2)."""
    return np.log(np.maximum(np.diff(reading, 4, axis=0).std(axis=0), 1e-300))
