"""What the arrays of the project are called: numbers and masks, of any shape."""

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]
Mask: TypeAlias = NDArray[np.bool_]


def fixed(values: Sequence[float]) -> Array:
    """Return an array (k,) of these values that is to be read only."""
    made = np.array(values, float)
    made.setflags(write=False)
    return made
