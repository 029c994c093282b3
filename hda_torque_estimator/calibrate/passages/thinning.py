"""Rows of a fit: the means of some samples, as errors of neighbours are much alike."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

# Choices unless stated otherwise.
THIN = 0.008        # time over which errors are averaged to one row [s]


def samples_of_row(dt: float) -> int:
    """Return how many samples make a row, at a time dt between them [s]."""
    return max(1, round(THIN / dt))


def row_means(values: Floats, dt: float) -> Floats:
    """Return the means of values (k, ...) over the samples of each row."""
    every = samples_of_row(dt)
    rows = len(values) // every
    return values[:rows * every].reshape(rows, every, *values.shape[1:]).mean(axis=1)
