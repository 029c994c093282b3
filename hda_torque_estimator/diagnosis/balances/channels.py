"""
Which columns the balances of a joint have: A of every joint, then B, then C if there is any.

C is of sensors beside links (eq:balance-third). Of joints without one its columns hold nothing.
"""

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ...measurements.measurement import Measurement


Kind = TypeVar('Kind', bound=np.generic)


def sides(measurement: Measurement) -> int:
    """Return for how many balances joints have a column: A and B, or C as well."""
    return 3 if measurement.thrice_witnessed.any() else 2


def of_sides(measurement: Measurement, *parts: NDArray[Kind]) -> NDArray[Kind]:
    """Return what is known of A, B and C of joints (n,) each as that of all columns (c,)."""
    return np.concatenate(parts[:sides(measurement)])


def channels_of(measurement: Measurement, place: int) -> list[int]:
    """Return the columns of balances that one joint has."""
    joints, held = len(measurement.labels), 2 + int(measurement.thrice_witnessed[place])
    return [side * joints + place for side in range(held)]


def noisy_by_torques(measurement: Measurement) -> NDArray[np.bool_]:
    """Return which balances (c,) have noise of commands or of sensors beside links."""
    none = np.zeros(len(measurement.labels), bool)
    return of_sides(measurement, ~none, none, measurement.thrice_witnessed)
