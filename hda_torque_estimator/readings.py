"""
Find the readings of an arm's encoders in joint states, one message or a recording at a time.

A reading is an array (n, READINGS): angles [rad] and velocities [rad/s] of shaft and link of every
joint. Names may stand in any order among others; what a message does not give is NaN.
"""

from collections import Counter
from collections.abc import Sequence

from hda_msgs_json.cdr import JointState
from hda_msgs_json.samples import JointSamples
from hda_msgs_json.topics import motor_name
import numpy as np
from numpy.typing import NDArray

from .estimate import READINGS

Array = NDArray[np.float64]
SIDES = 2


class ReadingError(ValueError):
    """A joint state in which the readings of the arm cannot be found."""


class NamesError(ReadingError):
    """A joint state that does not name both sides of every joint once."""


class LengthsError(ReadingError):
    """A joint state whose arrays do not fit its names."""


def reading_names(labels: Sequence[str]) -> tuple[str, ...]:
    """Return the names that a joint state must have for these joints: shaft and link of each."""
    return tuple(name for label in labels for name in (motor_name(label), label))


def reading_columns(labels: Sequence[str], names: Sequence[str]) -> NDArray[np.intp]:
    """Return where shaft and link of every joint stand in `names` (n, 2); raises NamesError."""
    counts, needed = Counter(names), reading_names(labels)
    if missing := [name for name in needed if not counts[name]]:
        raise NamesError(f'joint states must name {_listed(needed)} in any order; '
                         f'{_listed(missing)} is missing, got {_listed(names)}')
    if twice := [name for name in needed if counts[name] > 1]:
        raise NamesError(f'joint states must name each joint once, got {_listed(twice)} again')
    places = {name: place for place, name in enumerate(names)}
    return np.array([places[name] for name in needed], np.intp).reshape(-1, SIDES)


def readings(labels: Sequence[str], samples: JointSamples) -> Array:
    """Return the reading of every recorded joint state (k, n, READINGS); raises NamesError."""
    columns = reading_columns(labels, samples.names)
    return np.concatenate([samples.position[:, columns], samples.velocity[:, columns]], axis=2)


class ReadingFinder:
    """Find the reading in one message after another; names are looked up when they change."""

    def __init__(self, labels: Sequence[str]) -> None:
        """Prepare for an arm whose joints have these names."""
        self._labels = tuple(labels)
        self._names: tuple[str, ...] | None = None
        self._columns = np.zeros((0, SIDES), np.intp)
        self._reading = np.full((len(self._labels), READINGS), np.nan)

    def __call__(self, state: JointState) -> Array:
        """
        Return the reading (n, READINGS), the same array every time.

        Raises NamesError or LengthsError, and goes on with the next message as if nothing was.
        """
        if state.names is not self._names and state.names != self._names:
            self._columns = reading_columns(self._labels, state.names)
        self._names = state.names
        _check_lengths(state)
        self._reading[:, :SIDES] = state.position[self._columns]
        self._reading[:, SIDES:] = (
            state.velocity[self._columns] if len(state.velocity) else np.nan)
        return self._reading


def _check_lengths(state: JointState) -> None:
    count = len(state.names)
    if len(state.position) != count:
        raise LengthsError(f'joint states must have one position for each of their {count} '
                           f'names, got {len(state.position)}')
    for what, values in (('velocity', state.velocity), ('effort', state.effort)):
        if len(values) not in (0, count):
            raise LengthsError(f'joint states must have one {what} for each of their {count} '
                               f'names, or none, got {len(values)}')


def _listed(names: Sequence[str]) -> str:
    return ', '.join(names[:8]) + ', ...' * (len(names) > 8) if names else 'none'
