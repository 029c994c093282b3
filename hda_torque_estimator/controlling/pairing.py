"""Bring together two values of one stamp that come in two streams."""

from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array


MOST_WAITING = 50


class SamplePair(NamedTuple):
    """What belongs to one sample."""

    stamp: int                  # [ns]
    motor_angle: Array          # (n,) shafts [rad]
    joint_torque: Array         # (n,) through the gears [N*m]


class Pairing:
    """Pair motor angles and joint torques; what has no partner is forgotten in time."""

    def __init__(self) -> None:
        """Begin with nothing waiting."""
        self._angles: dict[int, Array] = {}
        self._torques: dict[int, Array] = {}

    def add_angle(self, stamp: int, angle: Array) -> SamplePair | None:
        """Take angles; returns them with the torques of their stamp if those are there."""
        _keep(self._angles, stamp, angle)
        return self._pair(stamp)

    def add_torque(self, stamp: int, torque: Array) -> SamplePair | None:
        """Take torques; returns them with the angles of their stamp if those are there."""
        _keep(self._torques, stamp, torque)
        return self._pair(stamp)

    def clear(self) -> None:
        """Forget what is waiting."""
        self._angles.clear()
        self._torques.clear()

    def _pair(self, stamp: int) -> SamplePair | None:
        if stamp not in self._angles or stamp not in self._torques:
            return None
        pair = SamplePair(stamp, self._angles[stamp], self._torques[stamp])
        for waiting in (self._angles, self._torques):
            for old in [known for known in waiting if known <= stamp]:
                del waiting[old]        # an answer to what is older would come too late
        return pair


def _keep(waiting: dict[int, Array], stamp: int, value: Array) -> None:
    waiting[stamp] = value
    if len(waiting) > MOST_WAITING:
        del waiting[next(iter(waiting))]
