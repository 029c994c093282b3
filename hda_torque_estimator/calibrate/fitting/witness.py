"""
A witness of a joint's torque, held against references: its rows, and what its torque would be.

Both encoders bear witness by the torsion, a motor by its torque less friction and inertia. Each
has a zero, which may be another one in every recording.
"""

from collections.abc import Sequence
from typing import NamedTuple, Protocol

from hda_arm_sim.model.arm import Arm
import numpy as np
from numpy.typing import NDArray

from ..passages.joint_recording import Measured
from ...least_squares.rows import FOLDS

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]
# Choices unless stated otherwise.
STRETCH = 3.0           # longest block of rows whose errors follow each other [s]
FEWEST_BLOCKS = 12      # of all recordings: a spread over fewer means little
LAGS = 16               # of which references are known: most fits have one


class Blocks(NamedTuple):
    """Which rows (m,) belong together."""

    recording: Ints
    stretch: Ints           # of some seconds
    fold: Ints              # left out together: a recording, or a fifth of the only one


class Witness(Protocol):
    """The rows of one witness over all recordings of a joint."""

    blocks: Blocks
    dt: float               # longest usual time between samples [s]
    usual_zero: float       # by how much its zero may move before anything is known [unit]

    def torque(self, arm: Arm, zeros: Floats) -> Floats:
        """Return the torque of the rows (m,) [N*m] with zeros moved by these (r,) [unit]."""

    def reference(self, lag: float) -> Floats:
        """Return the reference of the rows (m,) [N*m], which lags by so much [s]."""


def blocks_of(recordings: Sequence[Measured], used: Sequence[Flags]) -> Blocks:
    """Return the blocks of rows of recordings, of which those `used` (rows,) count."""
    seconds = sum(float(one.time[-1]) for one in recordings)
    length = min(STRETCH, seconds / FEWEST_BLOCKS)
    owner, stretch, first = [], [], 0
    for place, (one, rows) in enumerate(zip(recordings, used)):
        numbers = first + (np.arange(len(rows)) * one.every * one.dt / length).astype(np.int64)
        stretch.append(numbers[rows])
        owner.append(np.full(int(rows.sum()), place))
        first = int(numbers[-1]) + 1
    of, parts = np.concatenate(owner), np.concatenate(stretch)
    only = len(recordings) == 1
    fold = np.minimum(np.arange(len(of)) * FOLDS // max(len(of), 1), FOLDS - 1) if only else of
    return Blocks(of, parts, fold)


def per_recording(zeros: Sequence[float] | Floats,
                  recordings: Sequence[Measured]) -> list[float]:
    """Return the zero of every recording, 0 where none may move."""
    return [float(zero) for zero in zeros] if len(zeros) else [0.0] * len(recordings)
