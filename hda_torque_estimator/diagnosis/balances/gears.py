"""
What gears do along a measured motion, for the last few arms (docs/model.md, eq:balance-parts).

They twist, the torsion loads their spring, and beside that act hysteresis, damping and cables.
Each of these is known by the numbers that it depends on. So another damping costs no iteration of
the spring, and another stiffness no wave of the transmission.
"""

from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.compiled import compiled, inlined, Record
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects.catalogue import effects_at
from hda_arm_sim.model.effects.place import (GEAR, LINK_TORQUE, LOADED_GEAR, LOOP, PLAY,
                                             TRANSMISSION)
from hda_arm_sim.model.kernel import (gear_torque, growth, loop_state, loops, played_torsion,
                                      REGISTERS, slide, spring_torque, STATE, torque_against,
                                      twist)
from hda_arm_sim.model.link_side import link_torque
from hda_arm_sim.model.torsion_table import tabled_torque, torque_table
import numpy as np

from .fields import key_of, KeysOfArms, places_of
from .recent_cache import RecentCache
from .sensed_motion import JointMotion, SensedMotion, sensing
from ...measurements.measurement import Measurement

# Numerics; choices unless stated otherwise.
_KEPT = 4               # of what each gear does
# What each of its runs reads of a joint's record.
_TWISTS = places_of('ratio', *effects_at(TRANSMISSION))
_SPRINGS = places_of('torsion', *effects_at(LOADED_GEAR), *effects_at(PLAY))
_BESIDE = places_of(*(effect for place in (LOOP, GEAR, LINK_TORQUE)
                      for effect in effects_at(place)))


class Twist(NamedTuple):
    """How the gear of one joint is twisted over time, (k,) each."""

    torsion: Array              # [rad]
    rate: Array                 # [rad/s]
    ratio: Array                # in force, output over shaft

    def during(self, piece: slice) -> 'Twist':
        """Return the twist in some of its samples."""
        return Twist(self.torsion[piece], self.rate[piece], self.ratio[piece])


class Geared(NamedTuple):
    """Torques of the gear of one joint over time, (k,) each."""

    through: Array              # on the link [N*m]
    against: Array              # of that on the shaft [N*m motor]
    driving: Array              # all on the link that is not of links, cables beside it [N*m]

    def during(self, piece: slice) -> 'Geared':
        """Return the torques in some of their samples."""
        return Geared(self.through[piece], self.against[piece], self.driving[piece])


class _Keys(NamedTuple):
    """What twist, spring and all torques of a gear depend on."""

    twist: bytes
    spring: bytes
    whole: bytes


class Gears:
    """The gears along one measured motion, for one arm after another."""

    def __init__(self, measurement: Measurement, motions: SensedMotion) -> None:
        """Know nothing yet."""
        self._motions, self._pieces = motions, measurement.pieces()
        self._shape = len(measurement.command)
        joints = range(len(measurement.labels))
        self._twists = [RecentCache[Twist](_KEPT) for _ in joints]
        self._springs = [RecentCache[Array](_KEPT) for _ in joints]
        self._torques = [RecentCache[Geared](_KEPT) for _ in joints]
        self._keys = KeysOfArms[_Keys]()

    def key(self, arm: Arm, joint: int) -> bytes:
        """Return all that the torques of a gear depend on."""
        return self._keys_of(arm, joint).whole

    def torques(self, arm: Arm, joint: int) -> Geared:
        """Return the torques of a joint's gear."""
        return self._torques[joint].of(self.key(arm, joint), lambda: self._geared(arm, joint))

    def _keys_of(self, arm: Arm, joint: int) -> _Keys:
        """Return what a joint's parts depend on."""
        return self._keys.of(arm, joint, lambda: self._made_keys(arm, joint))

    def _made_keys(self, arm: Arm, joint: int) -> _Keys:
        record = arm.record()
        twist = sensing(arm, [joint]) + key_of(record, joint, _TWISTS)
        spring = twist + key_of(record, joint, _SPRINGS)
        return _Keys(twist, spring, spring + key_of(record, joint, _BESIDE))

    def _twist(self, arm: Arm, joint: int) -> Twist:
        return self._twists[joint].of(self._keys_of(arm, joint).twist,
                                      lambda: self._twisted(arm, joint))

    def _spring(self, arm: Arm, joint: int) -> Array:
        return self._springs[joint].of(self._keys_of(arm, joint).spring,
                                       lambda: self._sprung(arm, joint))

    def _twisted(self, arm: Arm, joint: int) -> Twist:
        made = Twist(*np.empty((3, self._shape)))
        _fill_twist(arm.record().joints, joint, self._motions.moved(arm, joint), made)
        return made

    def _sprung(self, arm: Arm, joint: int) -> Array:
        """Run the spring of a gear (k,); each recording begins without a guess of its torque."""
        made, torsion = np.empty(self._shape), self._twist(arm, joint).torsion
        motor = self._motions.moved(arm, joint).motor.angle
        for piece in self._pieces:
            _fill_spring(arm.record().joints, joint, motor[piece], torsion[piece], made[piece])
        return made

    def _geared(self, arm: Arm, joint: int) -> Geared:
        """Run what acts beside the spring, which may remember."""
        made, twisted = Geared(*np.empty((3, self._shape))), self._twist(arm, joint)
        moved, spring = self._motions.moved(arm, joint), self._spring(arm, joint)
        for piece in self._pieces:
            _fill_torques(arm.record().joints, joint, moved.during(piece), twisted.during(piece),
                          spring[piece], made.during(piece))
        return made


@compiled
def _fill_twist(joints: Record, j: int, moved: JointMotion, twisted: Twist) -> None:
    """Fill how a gear is twisted."""
    joint = joints[j]
    torsion, rate, ratio = twisted
    for k in range(torsion.shape[0]):
        torsion[k], rate[k], ratio[k] = twist(
            joint, moved.motor.angle[k], moved.motor.velocity[k], moved.link.angle[k],
            moved.link.velocity[k])


@compiled
def _fill_spring(joints: Record, j: int, angle: Array, torsion: Array, spring: Array) -> None:
    """Fill the torque of a gear's spring (k,) at angles of its shaft [N*m]."""
    joint, largest, grows = joints[j], 0.0, False
    for k in range(spring.shape[0]):
        spring[k] = played_torsion(joint, torsion[k])
        largest = max(largest, abs(spring[k]))
        grows = grows or growth(joint, angle[k])[0] != 0.0
    if grows:
        _fill_growing_spring(joint, angle, torsion, spring)
    elif largest > 0.0:
        law = joint.torsion
        table = torque_table(law, joint.ratio, min(largest, law.valid_torsion))
        for k in range(spring.shape[0]):
            spring[k] = tabled_torque(law, joint.ratio, table, spring[k])


@inlined
def _fill_growing_spring(joint: Record, angle: Array, torsion: Array, spring: Array) -> None:
    """Fill the torque of a spring whose compliance varies along a turn (k,), by iteration."""
    w = np.zeros((1, REGISTERS))
    for k in range(spring.shape[0]):
        spring[k] = spring_torque(joint, torsion[k], growth(joint, angle[k])[0], w, 0)


@compiled
def _fill_torques(joints: Record, j: int, moved: JointMotion, twisted: Twist, spring: Array,
                  geared: Geared) -> None:
    """Fill the torques of a gear with those of its spring (k,)."""
    joint, w = joints[j], np.zeros((1, REGISTERS))
    through, against, driving = geared
    remembers, loop = loops(joint), 0.0
    for k in range(spring.shape[0]):
        torsion = twisted.torsion[k]
        if remembers:
            loop = loop_state(joint, w, 0, STATE, torsion)
            slide(joint, w, 0, torsion)
        through[k] = gear_torque(joint, spring[k], torsion, twisted.rate[k], loop)
        against[k] = torque_against(twisted.ratio[k], through[k],
                                    growth(joint, moved.motor.angle[k])[1], spring[k])
        driving[k] = through[k] + link_torque(joint, moved.link.angle[k])
