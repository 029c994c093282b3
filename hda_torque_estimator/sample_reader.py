"""Read samples of an arm from the bytes of joint states; what is wrong becomes a refusal."""

from hda_arm_sim.health import Refused
from hda_arm_sim.inputs import refusal, UNREADABLE
from hda_arm_sim.model.arm import Arm
from hda_msgs_json.cdr import JointStateDecoder
import numpy as np
from numpy.typing import NDArray

from .readings import reading_names, ReadingFinder, SIDES

Array = NDArray[np.float64]


class SampleReader:
    """Read one message after another."""

    def __init__(self, arm: Arm) -> None:
        """Prepare for the joints of an arm."""
        self._names = np.array(reading_names(arm.labels))
        self._decode, self._find = JointStateDecoder(), ReadingFinder(arm.labels)

    def __call__(self, message: bytes) -> tuple[int, Array]:
        """Return the stamp [ns] and the reading (n, READINGS), the same array always."""
        try:
            state = self._decode(message)
            return state.stamp_ns, self._find(state)
        except UNREADABLE as error:
            raise refusal(error) from None

    def not_finite(self, stamp: int, reading: Array) -> Refused:
        """Return the refusal of a reading with angles that are not finite."""
        angles = reading[:, :SIDES].ravel()
        bad = ~np.isfinite(angles)
        return Refused('angle not finite', f'every angle must be finite, got {angles[bad][0]} for '
                       f'{", ".join(self._names[bad])} at {seconds(stamp)}')


def not_later(stamp: int, last: int, remedy: str = '') -> Refused:
    """Return the refusal of a stamp that is not later than the last one."""
    return Refused('stamp not later', f'a stamp must be later than the last one, {seconds(last)}, '
                   f'got {seconds(stamp)}{remedy}')


def seconds(stamp: int) -> str:
    """Return a stamp [ns] as people read it."""
    return f'{stamp // 10**9}.{stamp % 10**9:09d} s'
