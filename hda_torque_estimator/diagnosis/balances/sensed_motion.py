"""
The motion behind one measurement, for arms that sense it differently.

Another encoder error changes the angle behind one encoder, so only that is differentiated anew.
Angles that differ by a constant, as another zero makes them, have the same derivatives.
"""

from collections.abc import Sequence
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effect_loops import any_acts
from hda_arm_sim.model.effects.catalogue import effects_at
from hda_arm_sim.model.effects.place import (CLOCK, LINK_READING, MOTOR_READING, Place,
                                             TILTED_READING)
import numpy as np

from .fields import key_of, places_of
from .recent_cache import RecentCache
from ...measurements.measurement import Measurement
from ...measurements.motion import (angle_behind, course_of, DifferentiatedAngle, lateness, LINK,
                                    MeasuredMotion, motion_of, MOTOR, SHORT)

# Numerics; choices unless stated otherwise.
_KEPT = 4               # courses of each encoder
_WHOLE = 2              # motions of all joints
_ROUNDING = 1e-15       # of an angle, to which a difference from another one is constant
# What stands between the angle of a shaft, or of a link, and its reading.
_SHOWN: dict[int, tuple[Place, ...]] = {
    MOTOR: (MOTOR_READING,), LINK: (LINK_READING, TILTED_READING, CLOCK)}
_ENCODERS = {MOTOR: ('motor_encoder',), LINK: ('motor_encoder', 'link_encoder')}
_BEHIND = {
    side: places_of(*_ENCODERS[side], *(effect for place in _SHOWN[side]
                                        for effect in effects_at(place))) for side in _SHOWN}


class JointMotion(NamedTuple):
    """What the two sides of one joint did."""

    motor: DifferentiatedAngle
    link: DifferentiatedAngle

    def during(self, piece: slice) -> 'JointMotion':
        """Return what they did in some of their samples."""
        return JointMotion(self.motor.during(piece), self.link.during(piece))


class _Differentiated(NamedTuple):
    """An angle, how late it was read, and what came of it."""

    angle: Array
    late: float
    course: DifferentiatedAngle


class SensedMotion:
    """The motion behind one measurement, for one arm after another."""

    def __init__(self, measurement: Measurement) -> None:
        """Know nothing yet."""
        self._measurement = measurement
        sides = [(joint, side) for joint in range(len(measurement.labels))
                 for side in (MOTOR, LINK)]
        self._courses: dict[tuple[int, int], RecentCache[DifferentiatedAngle]] = {
            place: RecentCache(_KEPT) for place in sides}
        self._differentiated: dict[tuple[int, int], list[_Differentiated]] = {
            place: [] for place in sides}
        self._motions: RecentCache[MeasuredMotion] = RecentCache(_WHOLE)

    def of(self, arm: Arm) -> MeasuredMotion:
        """Return the motion of all joints."""
        return self._motions.of(sensing(arm, range(len(arm.joints))), lambda: MeasuredMotion(*map(
            np.concatenate, zip(*(motion_of(one, arm, SHORT)
                                  for one in self._measurement.recordings())))))

    def moved(self, arm: Arm, joint: int) -> JointMotion:
        """Return what both sides of a joint did."""
        return JointMotion(self.course(arm, joint, MOTOR), self.course(arm, joint, LINK))

    def course(self, arm: Arm, joint: int, side: int) -> DifferentiatedAngle:
        """Return what one side of a joint did."""
        return self._courses[joint, side].of(sensing(arm, [joint], [side]),
                                             lambda: self._found(arm, joint, side))

    def _found(self, arm: Arm, joint: int, side: int) -> DifferentiatedAngle:
        """Return a course that is not known, from one of the same shape if there is such."""
        angle = angle_behind(self._measurement.reading, arm, joint, side)
        late, before = lateness(arm, joint, side), self._differentiated[joint, side]
        least = _ROUNDING * np.abs(angle).max() if before else 0.0
        for known in before:
            away = angle[[0, -1]] - known.angle[[0, -1]]    # as most differ by more there already
            if late == known.late and abs(away[1] - away[0]) <= least and (
                    np.ptp(angle - known.angle) <= least):
                return known.course.shifted(float(away[0]))
        course = self._derived(angle, late)
        before[:] = [_Differentiated(angle, late, course), *before[:_KEPT - 1]]
        return course

    def _derived(self, angle: Array, late: float) -> DifferentiatedAngle:
        """Return the course of an angle (k,), of every recording on its own."""
        parts = [course_of(angle[piece, None], np.array([late]), SHORT, self._measurement.dt)
                 for piece in self._measurement.pieces()]
        return DifferentiatedAngle(*(np.concatenate(part)[:, 0] for part in zip(*parts)))


def sensing(arm: Arm, joints: Sequence[int], sides: Sequence[int] = (MOTOR, LINK)) -> bytes:
    """Return all that the courses of sides of some joints depend on."""
    record = arm.record()
    key = b''.join(key_of(record, joint, _BEHIND[side]) for joint in joints for side in sides)
    tilts = LINK in sides and any(any_acts(record.joints[joint], TILTED_READING)
                                  for joint in joints)
    return key + record.body.tobytes() if tilts else key
