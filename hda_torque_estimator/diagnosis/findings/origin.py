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
class OscillatingLoop:
    """A joint whose controller oscillates: most of its command is one quick line."""

    joint: str
    frequency: float        # [Hz]
    share: float            # of what the command varies within 2 s that the line has
    amplitude: float        # of the line, as a share of the motor's largest torque

    def sentence(self) -> str:
        """Return what is wrong with the recording."""
        return (f'the controller of {self.joint} oscillates at {self.frequency:.0f} Hz: that is '
                f'{100.0 * self.share:.0f} % of what its command varies within 2 s, and '
                f'{100.0 * self.amplitude:.0f} % of the largest motor torque')

    def step(self) -> str:
        """Return what to do before the arm is recorded again."""
        return (f'lower the gains of the controller of {self.joint} until its swing at '
                f'{self.frequency:.0f} Hz is gone, and record again: beside it causes look alike')


@dataclass(frozen=True)
class RecordingFacts:
    """What was diagnosed; several recordings are `bags`, one after another."""

    duration: float
    samples: int
    rate: float
    training: tuple[tuple[float, float], ...]
    held_out: tuple[tuple[float, float], ...]
    bags: tuple[RecordingPart, ...] = ()
    oscillating: tuple[OscillatingLoop, ...] = ()

    @property
    def remarks(self) -> tuple[str, ...]:
        """Return sentences on what is wrong with the recording."""
        return tuple(loop.sentence() for loop in self.oscillating)


class Origin(NamedTuple):
    """Where a diagnosis comes from: the file of the arm, the version, the recordings' names."""

    arm_file: str = ''
    version: str = ''
    sources: Sequence[str] = ()
