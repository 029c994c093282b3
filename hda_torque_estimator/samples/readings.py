"""
Find the readings of an arm's encoders in joint states, one message or a recording at a time.

A reading is an array (n, READINGS): angles [rad] and velocities [rad/s] of shaft and link of every
joint. Names may stand in any order among others; what a message does not give is NaN.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects.catalogue import known_as
from hda_arm_sim.model.parts import Joint
from hda_msgs_json.cdr import JointState
from hda_msgs_json.columns import ColumnFinder, columns_of
from hda_msgs_json.samples import JointSamples
from hda_msgs_json.topics import motor_name
import numpy as np

SIDES = 2

# A reading, per joint: angles [rad] and velocities [rad/s] of shaft and link, NaN if not given.
MOTOR_READING, LINK_READING, MOTOR_RATE, LINK_RATE = range(4)
READINGS = 4
NOTHING = 1e3           # deviation of a torsion without a torque, the largest there is [N*m]


def motor_commands(labels: Sequence[str], samples: JointSamples) -> Array:
    """Return the motor torque in force from every recorded joint state on (k, n) [N*m]."""
    columns = columns_of([motor_name(label) for label in labels], samples.names)
    return samples.effort[:, columns]


def reading_names(labels: Sequence[str]) -> tuple[str, ...]:
    """Return the names that a joint state must have for these joints: shaft and link of each."""
    return tuple(name for label in labels for name in (motor_name(label), label))


def readings(labels: Sequence[str], samples: JointSamples) -> Array:
    """Return the reading of every recorded joint state (k, n, READINGS); raises NamesError."""
    columns = columns_of(reading_names(labels), samples.names).reshape(-1, SIDES)
    return np.concatenate([samples.position[:, columns], samples.velocity[:, columns]], axis=2)


def with_links_of(arm: Arm, samples: JointSamples) -> tuple[JointSamples, tuple[str, ...]]:
    """
    Return joint states with all link angles that motors can stand in for, and these joints.

    They are joints without a link encoder, whose motor has a torque. Their angle is what a rigid
    gear would make of the motor's. It shows nothing of a torque: see `by_motor`. A motor of which
    nothing is known shows none either: see `knows_motor`.
    """
    ratios = {joint.label: joint.ratio for joint in arm.joints}
    alone = tuple(label for label in ratios
                  if not np.isfinite(column_of(samples.position, samples, label)).any()
                  and np.isfinite(column_of(samples.effort, samples, motor_name(label))).any())
    if not alone:
        return samples, ()
    kept = samples.select([name for name in samples.names if name not in alone])
    position, velocity = (np.column_stack([values, *(
        column_of(values, kept, motor_name(label)) / ratios[label] for label in alone)])
        for values in (kept.position, kept.velocity))
    effort = np.column_stack([kept.effort, np.full((len(kept.stamps), len(alone)), np.nan)])
    return replace(kept, names=(*kept.names, *alone), position=position, velocity=velocity,
                   effort=effort), alone


def by_motor(arm: Arm, labels: Sequence[str]) -> Arm:
    """Return the arm whose torsion shows nothing of these joints, so that their motors do."""
    return replace(arm, joints=tuple(
        replace(joint, torsion=replace(joint.torsion, deviation=NOTHING))
        if joint.label in labels else joint for joint in arm.joints))


def unknown_motors(arm: Arm, labels: Sequence[str]) -> tuple[str, ...]:
    """Return those of some joints whose motors tell no torque."""
    return tuple(joint.label for joint in arm.joints
                 if joint.label in labels and not knows_motor(arm, joint))


def knows_motor(arm: Arm, joint: Joint) -> bool:
    """Return whether anything is known of what a motor's torque becomes at the gear."""
    known: Any = arm.effect(known_as('dry_friction').name, joint.label)
    return joint.motor_deviation > 0.0 or known.level > 0.0


def column_of(values: Array, samples: JointSamples, name: str) -> Array:
    """Return the `values` (k, n) of a name (k,), NaN where the samples do not name it."""
    names: Sequence[str] = samples.names
    return values[:, names.index(name)] if name in names else np.full(len(values), np.nan)


class ReadingFinder:
    """Find the reading in one message after another."""

    def __init__(self, labels: Sequence[str]) -> None:
        """Prepare for an arm whose joints have these names."""
        self._find = ColumnFinder(reading_names(labels))
        self._reading = np.full((len(labels), READINGS), np.nan)

    def __call__(self, state: JointState) -> Array:
        """
        Return the reading (n, READINGS), the same array every time.

        Raises NamesError or LengthsError, and goes on with the next message as if nothing was.
        """
        columns = self._find(state).reshape(-1, SIDES)
        self._reading[:, :SIDES] = state.position[columns]
        self._reading[:, SIDES:] = state.velocity[columns] if len(state.velocity) else np.nan
        return self._reading
