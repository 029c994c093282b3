"""
Put tables side by side: many logs have a file for each quantity, with the same rows.

A name that all of them give the same values is one column. One that stands for other values in
another table gets the name of its table in front: 'currents.joint_1'.
"""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .tables import Columns, read_table, TableError


class SideBySide(NamedTuple):
    """Columns by their names, and the names of the tables they come from."""

    columns: Columns
    tables: Mapping[str, str]


def names_of(paths: Sequence[Path]) -> str:
    """Return the names of some tables as they are given to a command."""
    return ' '.join(path.name for path in paths)


def read_tables(paths: Sequence[Path]) -> SideBySide:
    """Return the columns of tables with the same rows; raises TableError."""
    read = [(path, read_table(path)) for path in paths]
    rows = {path: _rows(columns) for path, columns in read}
    if len({*rows.values()}) > 1:
        some = ', '.join(f'{path} has {count}' for path, count in rows.items())
        raise TableError(f'tables side by side need the same rows: {some}')
    owners: dict[str, list[Columns]] = defaultdict(list)
    for _, columns in read:
        for name in columns:
            owners[name].append(columns)
    columns_of: Columns = {}
    tables: dict[str, str] = {}
    for path, columns in read:
        for name, values in columns.items():
            alike = all(_is_same(values, other[name]) for other in owners[name])
            full = name if alike else f'{_stem(path)}.{name}'
            if full in columns_of and not alike:
                raise TableError(f'{path}: two tables of one name hold {name!r}')
            columns_of.setdefault(full, values)
            tables.setdefault(full, _stem(path))
    return SideBySide(columns_of, tables)


def _rows(columns: Columns) -> int:
    return max(map(len, columns.values()), default=0)


def _is_same(one: NDArray[Any], other: NDArray[Any]) -> bool:
    return one is other or np.array_equal(one, other, equal_nan=one.dtype.kind == 'f'
                                          and other.dtype.kind == 'f')


def _stem(path: Path) -> str:
    return path.name.partition('.')[0]
