"""
Readings at the ticks of an even clock, from stamps that say when each was really taken.

At speed a microsecond of jitter is worth more than the noise of a good encoder. But the stamps of
some drivers tell when a sample was handed on, not when it was taken. They are believed where the
readings become smoother by them, and left aside elsewhere.
"""

from dataclasses import replace

from hda_arm_sim.foundation.arrays import Array
import numpy as np

from .measurement import Measurement

# Choices unless told otherwise.
LEAST = 1e-8            # jitter beyond the nanoseconds in which stamps count [s]


def on_grid(measurement: Measurement) -> Measurement:
    """Return the readings at the ticks if the stamps are believed, else as they are."""
    if np.abs(measurement.past).max(initial=0.0) < LEAST:
        return measurement
    rate = np.gradient(measurement.reading, measurement.dt, axis=0)
    reading = measurement.reading - measurement.past[:, None, None] * rate
    believed = _roughness(reading).sum() < _roughness(measurement.reading).sum()
    return replace(measurement, past=np.zeros(0),
                   reading=reading if believed else measurement.reading)


def _roughness(reading: Array) -> Array:
    """Return the logarithms of what readings (k, n, 2) have beyond smooth motion (n, 2)."""
    return np.log(np.maximum(np.diff(reading, 4, axis=0).std(axis=0), 1e-300))
