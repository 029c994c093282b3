"""
Find the readings of an arm's encoders in joint states, one message or a recording at a time.

A reading is an array (n, READINGS): angles [rad] and velocities [rad/s] of shaft and link of every
joint. Names may stand in any order among others; what a message does not give is NaN.
"""

from collections.abc import Sequence

from hda_arm_sim.foundation.arrays import Array
from hda_msgs_json.cdr import JointState
from hda_msgs_json.columns import ColumnFinder, columns_of
from hda_msgs_json.samples import JointSamples
from hda_msgs_json.topics import motor_name
import numpy as np

SIDES = 2

# A reading, per joint: angles [rad] and velocities [rad/s] of shaft and link, NaN if not given.
MOTOR_READING, LINK_READING, MOTOR_RATE, LINK_RATE = range(4)
READINGS = 4


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
