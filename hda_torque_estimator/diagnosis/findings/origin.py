"""Where a diagnosis comes from: recordings, the file of the arm and the version."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple


@dataclass(frozen=True)
class RecordingPart:
    """One of several recordings, on their running clock [s]."""

    bag: str
    begin: float
    duration: float


@dataclass(frozen=True)
class RecordingFacts:
    """What was diagnosed; several recordings are `bags`, one after another."""

    duration: float
    samples: int
    rate: float
    training: tuple[tuple[float, float], ...]
    held_out: tuple[tuple[float, float], ...]
    bags: tuple[RecordingPart, ...] = ()


class Origin(NamedTuple):
    """Where a diagnosis comes from: the file of the arm, the version, the recordings' names."""

    arm_file: str = ''
    version: str = ''
    sources: Sequence[str] = ()
