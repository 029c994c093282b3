"""Find the values of given joints in JointStates whose names stand in any order among others."""

from collections import Counter
from collections.abc import Sequence

from hda_msgs_json.cdr_layout import JointState
from hda_msgs_json.errors import HdaError
import numpy as np
from numpy.typing import NDArray


class NamesError(HdaError):
    """Raised for a JointState that does not name every joint that is needed, and once."""


class LengthsError(HdaError):
    """Raised for a JointState whose arrays do not fit its names."""


def columns_of(needed: Sequence[str], names: Sequence[str]) -> NDArray[np.intp]:
    """Return where the needed names stand among `names` (k,); raise NamesError."""
    counts = Counter(names)
    if missing := [name for name in needed if not counts[name]]:
        raise NamesError(f'the names must hold {_listed(needed)} in any order; '
                         f'{_listed(missing)} not found in {_listed(names)}')
    if twice := [name for name in needed if counts[name] > 1]:
        raise NamesError(f'the names must hold {_listed(twice)} once, got it {counts[twice[0]]} '
                         f'times in {_listed(names)}')
    places = {name: place for place, name in enumerate(names)}
    return np.array([places[name] for name in needed], np.intp)


class ColumnFinder:
    """Find the same joints in one JointState after another; names are looked up on a change."""

    def __init__(self, needed: Sequence[str], required: str = 'position') -> None:
        """Need these names, and a value for each name in one array of the message."""
        self.needed = tuple(needed)
        self._required = ('position', 'velocity', 'effort').index(required)
        self._names: tuple[str, ...] | None = None
        self._columns = np.zeros(0, np.intp)

    def __call__(self, state: JointState) -> NDArray[np.intp]:
        """Return where the needed names stand (k,); raise NamesError or LengthsError."""
        if state.names is not self._names and state.names != self._names:
            self._columns = columns_of(self.needed, state.names)
        self._names = state.names
        self._check_lengths(state)
        return self._columns

    def _check_lengths(self, state: JointState) -> None:
        count = len(state.names)
        for place, values in enumerate(state.numbers):
            if len(values) != count and (len(values) or place == self._required):
                what = ('position', 'velocity', 'effort')[place]
                rule = '' if place == self._required else ', or none'
                raise LengthsError(f'{what} must have one value for each of the {count} names'
                                   f'{rule}, got {len(values)}')


def _listed(names: Sequence[str]) -> str:
    return ', '.join(names[:8]) + ', ...' * (len(names) > 8) if names else 'nothing'
