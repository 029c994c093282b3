"""Read samples of an arm from the bytes of joint states; what is wrong becomes a refusal."""

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.health import Refused
from hda_arm_sim.inputs import refusal, UNREADABLE
from hda_arm_sim.model.arm import Arm
from hda_msgs_json.cdr import DOUBLE, JointStateDecoder, STAMP
from hda_msgs_json.cdr_fields import NANOSECONDS
from hda_msgs_json.cdr_layout import Layout, read_joint_state, STAMP_AT
from hda_msgs_json.columns import columns_of
import numpy as np

from .readings import reading_names, ReadingFinder, READINGS, SIDES


class SampleReader:
    """
    Read one message after another.

    Where the numbers of the arm lie is found once for all messages of one layout.
    """

    def __init__(self, arm: Arm) -> None:
        """Prepare for the joints of an arm."""
        self._names = np.array(reading_names(arm.labels))
        self._decode, self._find = JointStateDecoder(), ReadingFinder(arm.labels)
        self._layout: Layout | None = None
        self._start = self._count = 0                   # of a stretch with all numbers needed
        self._places = np.zeros((0, SIDES), np.intp)    # in that stretch
        self._filled = self._reading = np.zeros((0, READINGS))
        self.command = np.full(len(arm.joints), np.nan)         # of the last message [N*m]
        self._efforts = np.zeros(0, np.intp)                    # where they lie in the stretch

    def __call__(self, message: bytes) -> tuple[int, Array]:
        """
        Return the stamp [ns] and the reading (n, READINGS), the same array always.

        The torques of the motors stand in `command` then, NaN where there are none.
        """
        layout = self._layout
        if layout is None or not layout.fits(message):
            return self._learn(message)
        seconds, nanoseconds = STAMP.unpack_from(message, STAMP_AT)
        numbers = np.frombuffer(message, DOUBLE, self._count, self._start)
        self._filled[:] = numbers[self._places]
        if len(self._efforts):
            self.command[:] = numbers[self._efforts]
        return seconds * NANOSECONDS + nanoseconds, self._reading

    def _learn(self, message: bytes) -> tuple[int, Array]:
        """Read a message with all checks, and take its layout for that of the next ones."""
        try:
            state = self._decode(message)
            self._reading = self._find(state)
        except UNREADABLE as error:
            raise refusal(error) from None
        self._layout = read_joint_state(message)[1]
        position, velocity, effort = self._layout.doubles
        columns = columns_of(self._names.tolist(), state.names).reshape(-1, SIDES)
        self._start, end = position.start, position.stop
        self._places, self._filled = columns, self._reading[:, :SIDES]
        if velocity.count:
            further = (velocity.start - position.start) // DOUBLE.itemsize
            self._places, end = np.hstack([columns, columns + further]), velocity.stop
            self._filled = self._reading
        self._efforts, self.command[:] = columns[:0, 0], np.nan
        if effort.count:
            further = (effort.start - position.start) // DOUBLE.itemsize
            self._efforts, end = columns[:, 0] + further, effort.stop
            self.command[:] = state.effort[columns[:, 0]]
        self._count = (end - self._start) // DOUBLE.itemsize
        return state.stamp_ns, self._reading

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
