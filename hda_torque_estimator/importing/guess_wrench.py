"""Six columns of a table that may be a wrench by their names: force and torque along x, y, z."""

from collections.abc import Sequence
import re

_FORCES = ('f', 'force', 'kraft', 'forza', 'fuerza')
_TORQUES = ('t', 'm', 'torque', 'moment', 'momento')
_AXIS = re.compile(rf'(?<![a-z])({"|".join((*_FORCES, *_TORQUES))})[ ._-]?([xyz])(?![a-z])',
                   re.IGNORECASE)
_ORDER = tuple((kind, axis) for kind in ('force', 'torque') for axis in 'xyz')


def wrench_columns(names: Sequence[str]) -> tuple[str, ...]:
    """Return the columns of force and torque as a map lists them; none unless all are clear."""
    found: dict[tuple[str, str], list[str]] = {place: [] for place in _ORDER}
    for name in names:
        for word, axis in _AXIS.findall(name):
            kind = 'force' if word.lower() in _FORCES else 'torque'
            found[kind, axis.lower()].append(name)
    if any(len(columns) != 1 for columns in found.values()):
        return ()
    return tuple(column for (column,) in found.values())
