"""
The parts of which balances are made, for the last few arms (docs/model.md, eq:balance-parts).

They are what each motor misses, what each gear gives its link, what the links need, and what
sensors show. So each witness of a torque has one. Each is known by the numbers that it depends on.
So another friction costs no run of a spring, another gear none of the links, and another payload
none of either.
Chains with one other link each are run together, because the motion of their links is one.
"""

from collections.abc import Sequence
from functools import partial

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.compiled import Record
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects.catalogue import effects_at, sole_at
from hda_arm_sim.model.effects.place import (BASE, BEARING, BREAKAWAY, BRISTLES, CURRENT_LOOP,
                                             DRAG, DRY_LEVEL, LIMIT, MESH, SHAFT, TURN, WIRE)
from hda_arm_sim.model.link_side import loaded_inertia
from hda_arm_sim.model.mass_matrices import mass_matrices
import numpy as np

from .base_motion import base_acceleration_under, base_direction, stirring
from .bearings import held, opposed
from .fields import key_of, KeysOfArms, places_of
from .gears import Gears
from .kernel_along import centred, deliver, fill_missed
from .low_pass import LowPass
from .needed_torques import fill_needed, fill_needed_with, other_link, Others
from .recent_cache import RecentCache
from .reference_torques import sensed_torques, sensor_key
from .sensed_motion import SensedMotion, sensing
from ...measurements.measurement import Measurement
from ...measurements.motion import DifferentiatedAngle, LINK
from ...measurements.running_clock import arm_during

# Numerics; choices unless stated otherwise.
_KEPT = 4               # of each part
_UNFILTERED = 2         # of what links need, their mass matrices, and their push on the base
_LINKS, _SENSED = 'links', 'sensed'     # names of keys; that of a motor is its joint (layout)
# What each part reads of a joint's record.
_DRIVE = (WIRE, LIMIT, CURRENT_LOOP, SHAFT)
_DRIVES = places_of(*(effect for place in _DRIVE for effect in effects_at(place)))
_MOTORS = places_of('motor_inertia', *(
    effect for place in (*_DRIVE, TURN, DRAG, DRY_LEVEL, BREAKAWAY, MESH, BRISTLES)
    for effect in effects_at(place)))
_BEARINGS = places_of(*effects_at(BEARING))


class Parts:
    """The parts of the balances of one measurement, filtered, for one arm after another."""

    def __init__(self, measurement: Measurement, filtered: LowPass) -> None:
        """Know nothing yet."""
        self._measurement, self._filtered = measurement, filtered
        self._joints = range(len(measurement.labels))
        self.motions = SensedMotion(measurement)
        self._commands, self._carried, self._through, self._missed = (
            [RecentCache[Array](_KEPT) for _ in self._joints] for _ in range(4))
        self._drive_gains = [RecentCache[float](_KEPT) for _ in self._joints]
        self._gears = Gears(measurement, self.motions)
        self._needed, self._sensed_torques, self._borne, self._swung = (
            RecentCache[Array](_KEPT) for _ in range(4))
        self._unfiltered, self._inertias = (
            RecentCache[Array](_UNFILTERED) for _ in range(2))
        self._stirred = RecentCache[tuple[Array, Array]](_UNFILTERED)
        self._ahead: dict[bytes, Array] = {}
        self._keys = KeysOfArms[bytes]()

    def missed(self, arm: Arm) -> Array:
        """Return what the motors miss (m, n) [N*m at the output]."""
        return np.stack([self._missed_by(arm, joint) for joint in self._joints], axis=1)

    def carried(self, arm: Arm) -> Array:
        """Return what gears and cables give the links (m, n) [N*m]."""
        return np.stack([self._carried_by(arm, joint) for joint in self._joints], axis=1)

    def through(self, arm: Arm) -> Array:
        """Return what gears alone carry (m, n): a sensor behind one sees no cables [N*m]."""
        return np.stack([self._through_gear(arm, joint) for joint in self._joints], axis=1)

    def sensed(self, arm: Arm) -> Array:
        """Return what gears carry by their sensors (m, n), 0 where there is none [N*m]."""
        return self._sensed_torques.of(sensor_key(arm), lambda: self._filtered(
            sensed_torques(self._measurement, arm)))

    def needed(self, arm: Arm) -> Array:
        """Return what the links need (m, n), on a base at rest [N*m]."""
        key = self._links_key(arm)
        return self._needed.of(key, lambda: self._ahead.pop(key) if key in self._ahead
                               else self._filtered(self._needed_unfiltered(arm)))

    def borne(self, arm: Arm) -> Array:
        """Return what bearings oppose of links (m, n), or hold of them [N*m]."""
        record = arm.record()
        key = self._links_key(arm) + b''.join(
            self._gears.key(arm, joint) + key_of(record, joint, _BEARINGS)
            for joint in self._joints)
        return self._borne.of(key, lambda: self._filtered(self._bearing(arm)))

    def swung(self, arm: Arm) -> Array:
        """Return what a base that gives way asks of links beside (m, n) [N*m]."""
        key = self._sensed(arm) + bytes(arm.record().body.tobytes())
        return self._swung.of(key, lambda: self._filtered(self._swinging(arm)))

    def run_ahead(self, arm: Arm, others: Sequence[Arm]) -> None:
        """Run links of other arms, of those at once that differ from an arm by one link each."""
        self._ahead.clear()
        sensed = self._sensed(arm)
        found = {self._links_key(other): link for other in others
                 if self._sensed(other) == sensed
                 and (link := other_link(arm, other)) is not None}
        if len(found) > 1:
            rows, bodies = zip(*found.values())
            needed = self._links_with(arm, Others(np.array(rows), np.array(bodies)))
            self._ahead |= {key: self._filtered(one) for key, one in zip(found, needed)}

    def _links_key(self, arm: Arm) -> bytes:
        return self._keys.of(arm, _LINKS, lambda: (
            self._sensed(arm) + _on_a_base_at_rest(arm.record().body)))

    def _sensed(self, arm: Arm) -> bytes:
        return self._keys.of(arm, _SENSED, lambda: sensing(arm, self._joints, [LINK]))

    def command(self, arm: Arm, joint: int) -> Array:
        """Return the mean torque at the shaft of a joint around every sample (k,) [N*m]."""
        return self._commands[joint].of(key_of(arm.record(), joint, _DRIVES),
                                        lambda: self._delivered(arm, joint))

    def drive_gains(self, arm: Arm) -> Array:
        """Return how much the drives give of what changes in their commands (n,)."""
        return np.array([self._drive_gains[joint].of(
            key_of(arm.record(), joint, _DRIVES),
            partial(self._drive_gain, arm, joint)) for joint in self._joints])

    def _drive_gain(self, arm: Arm, joint: int) -> float:
        asked = np.concatenate([centred(self._measurement.command[piece, joint])
                                for piece in self._measurement.pieces()])
        asked = asked - asked.mean()
        power = float(asked @ asked)
        return float(asked @ self.command(arm, joint)) / power if power > 0.0 else 1.0

    def _thin(self, column: Array) -> Array:
        return self._filtered(column[:, None])[:, 0]

    def _missed_by(self, arm: Arm, joint: int) -> Array:
        key = self._keys.of(arm, joint, lambda: (
            self._gears.key(arm, joint) + key_of(arm.record(), joint, _MOTORS)))
        return self._missed[joint].of(key, lambda: self._thin(self._motor(arm, joint)))

    def _carried_by(self, arm: Arm, joint: int) -> Array:
        return self._carried[joint].of(
            self._gears.key(arm, joint),
            lambda: self._thin(self._gears.torques(arm, joint).driving))

    def _through_gear(self, arm: Arm, joint: int) -> Array:
        return self._through[joint].of(
            self._gears.key(arm, joint),
            lambda: self._thin(self._gears.torques(arm, joint).through))

    def _motor(self, arm: Arm, joint: int) -> Array:
        """Run the motor of a joint, under the torques of its gear (k,)."""
        missed, dt = np.empty(len(self._measurement.command)), self._measurement.dt
        moved, joints = self.motions.moved(arm, joint), arm.record().joints
        geared, command = self._gears.torques(arm, joint), self.command(arm, joint)
        for piece in self._measurement.pieces():
            fill_missed(joints, joint, moved.during(piece), geared.during(piece), command[piece],
                        dt, missed[piece])
        return missed

    def _bearing(self, arm: Arm) -> Array:
        """Return what bearings add to what links miss (k, n)."""
        links = self._courses(arm)
        added, holding = opposed(arm, links)
        at = np.flatnonzero(holding.any(axis=1))
        if len(at):
            driving = [self._gears.torques(arm, joint).driving[at] for joint in self._joints]
            missed = self._needed_unfiltered(arm)[at] - np.stack(driving, axis=1)
            inertia = self._inertias.of(self._links_key(arm) + at.tobytes(),
                                        lambda: mass_matrices(arm, links.angle[at]))
            added[at] = held(holding[at], missed + added[at], links.acceleration[at],
                             inertia) - missed
        return added

    def _swinging(self, arm: Arm) -> Array:
        """Let the base swing along the motion of the links (k, n), (eq:balance-base)."""
        direction, dt = base_direction(arm), self._measurement.dt
        push, coupling = self._stirred.of((self._links_key(arm), direction), lambda: stirring(
            arm, self._courses(arm), direction))
        return coupling * np.concatenate([
            base_acceleration_under(arm, push[piece], dt)
            for piece in self._measurement.pieces()])[:, None]

    def _needed_unfiltered(self, arm: Arm) -> Array:
        """Return what the links need (k, n), on a base at rest [N*m]."""
        return self._unfiltered.of(self._links_key(arm), lambda: self._links(arm))

    def _links(self, arm: Arm) -> Array:
        """Run the links (k, n)."""
        measurement, needed = self._measurement, np.empty(self._measurement.command.shape)
        links = self._courses(arm)
        for piece in measurement.pieces():
            record = arm_during(arm, piece, measurement.dt).record()
            fill_needed(record, loaded_inertia(record.body), links.during(piece), measurement.dt,
                        needed[piece])
        return needed

    def _links_with(self, arm: Arm, others: Others) -> Array:
        """Run the links with each of others in the place of one (v, k, n)."""
        measurement, links = self._measurement, self._courses(arm)
        needed = np.empty((len(others.rows), *measurement.command.shape))
        for piece in measurement.pieces():
            record = arm_during(arm, piece, measurement.dt).record()
            fill_needed_with(record, loaded_inertia(record.body), others, links.during(piece),
                             measurement.dt, needed[:, piece])
        return needed

    def _courses(self, arm: Arm) -> DifferentiatedAngle:
        """Return what the links do, (k, n) each."""
        courses = [self.motions.course(arm, joint, LINK) for joint in self._joints]
        return DifferentiatedAngle(*(np.stack(parts, axis=1) for parts in zip(*courses)))

    def _delivered(self, arm: Arm, joint: int) -> Array:
        """Run the drive of a joint (k,)."""
        command, joints = self._measurement.command, arm.record().joints
        delivered = np.empty(len(command))
        for piece in self._measurement.pieces():
            deliver(joints, joint, command[piece], self._measurement.dt, delivered[piece])
            delivered[piece] = centred(delivered[piece])
        return delivered


def _on_a_base_at_rest(body: Record) -> bytes:
    """Return the numbers of links and what they carry, but for those of their base."""
    body = body.copy()
    body[sole_at(BASE).name] = 0.0
    return bytes(body.tobytes())
