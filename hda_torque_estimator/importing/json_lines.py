"""JSON lines as columns: each line one row, nested names dotted, the numbers of lists counted."""

from collections.abc import Iterable, Iterator
import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

THINNEST = 16
"""More places than this many times the values are a broken table, and would not fit in memory."""
FEW = 1_000_000
"""So many places are never too many."""


def json_columns(lines: Iterable[str], most: int) -> dict[str, NDArray[Any]]:
    """
    Return at most so many columns (n,) of JSON objects, one in each line that is not empty.

    A row without a value holds NaN, or an empty text. Raises ValueError where a line is none.
    """
    rows: list[dict[str, Any]] = []
    names: dict[str, None] = {}
    values = 0
    for number, line in enumerate(lines, start=1):
        if not line.strip():
            continue
        rows.append(dict(_flat('', _object(line, number))))
        names.update(dict.fromkeys(rows[-1]))
        values += len(rows[-1])
        if len(names) > most or len(names) * len(rows) > max(FEW, THINNEST * values):
            raise ValueError(f'its rows have too many different names: {len(names)} after '
                             f'line {number}')
    return {name: _column([row.get(name) for row in rows]) for name in names}


def _object(line: str, number: int) -> dict[str, Any]:
    try:
        found = json.loads(line)
    except ValueError as error:
        raise ValueError(f'line {number} is not JSON: {error}') from None
    if not isinstance(found, dict):
        raise ValueError(f'line {number} must be an object {{"name": value, ..}}')
    return found


def _flat(prefix: str, value: Any) -> Iterator[tuple[str, Any]]:
    """Yield every value in an object by its name."""
    entries = value.items() if isinstance(value, dict) else (
        (str(place), one) for place, one in enumerate(value, start=1))
    for name, one in entries:
        if isinstance(one, dict):
            yield from _flat(f'{prefix}{name}.', one)
        elif isinstance(one, list):
            yield from _flat(f'{prefix}{name}_', one)
        else:
            yield f'{prefix}{name}', one


def _column(values: list[Any]) -> NDArray[Any]:
    if any(isinstance(value, str) for value in values):
        return np.array(['' if value is None else str(value) for value in values])
    if all(isinstance(value, int) and abs(value) < 2 ** 63 for value in values):
        return np.array(values, np.int64)
    return np.array([np.nan if value is None else float(value) for value in values])
