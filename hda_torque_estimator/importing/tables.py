"""Read tables from files: CSV (plain or compressed), Parquet, MAT and NPZ."""

from collections import Counter
from collections.abc import Callable, Iterator
import csv
import gzip
from pathlib import Path
import struct
import tokenize
from typing import Any, TypeVar
import zipfile
import zlib

from hda_msgs_json.errors import HdaError
import numpy as np
from numpy.typing import NDArray
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet
from scipy.io import loadmat
from scipy.io.matlab import MatReadError

from .own_process import in_own_process

Columns = dict[str, NDArray[Any]]
Table = TypeVar('Table', Columns, list[str])
DELIMITERS = ',;\t|'
MOST_COLUMNS = 10_000
LONGEST_HEADER = 1 << 20         # characters of the line with the names

# What the libraries raise on files that are cut off, damaged or of another kind.
UNREADABLE = (
    pa.ArrowException, zipfile.BadZipFile, zlib.error, struct.error, csv.Error,
    tokenize.TokenError, MatReadError, ArithmeticError, AssertionError, AttributeError, EOFError,
    LookupError, MemoryError, NameError, OSError, RuntimeError, SyntaxError, TypeError, ValueError)


class TableError(HdaError):
    """A table that cannot be read."""


def read_table(path: Path) -> Columns:
    """
    Return the columns of a table (n,) by their names; raises TableError.

    A matrix (n, k) in a MAT or NPZ file gives the columns NAME_1 to NAME_k, a struct or a record
    array STRUCT.FIELD.
    """
    kind = next((kind for kind in READERS if path.name.lower().endswith(kind)), None)
    if kind is None:
        raise TableError(f'{path} is not a table that can be read: its name must end in one of '
                         f'{", ".join(READERS)}')
    if not path.is_file():
        raise TableError(f'{path} does not exist, or is not a file')
    try:
        return _bounded(READERS[kind](path))
    except UNREADABLE as problem:
        reason = ' '.join(str(problem).split()) or type(problem).__name__
        raise TableError(f'{path} cannot be read as {kind}: {reason}') from problem


def _bounded(columns: Table) -> Table:
    """Return columns or their names; raises TableError for more than any robot has."""
    if len(columns) > MOST_COLUMNS:
        raise TableError(f'it has {len(columns)} columns, at most {MOST_COLUMNS} are read; rows '
                         'and columns may be exchanged')
    return columns


def _read_csv(path: Path) -> Columns:
    opened = gzip.open if path.name.endswith('.gz') else open
    with opened(path, 'rt', encoding='utf-8-sig', newline='') as lines:
        header = lines.readline(LONGEST_HEADER)
    if len(header) == LONGEST_HEADER:
        raise TableError(f'its first line has {LONGEST_HEADER} characters or more')
    delimiter = max(DELIMITERS, key=header.count)
    names = next(csv.reader([header], delimiter=delimiter), [])
    _bounded(names)
    if twice := sorted(name for name, count in Counter(names).items() if count > 1):
        raise TableError(f'more than one column has the name {twice[0]!r}')
    return _arrow_columns(pyarrow.csv.read_csv(
        path, parse_options=pyarrow.csv.ParseOptions(delimiter=delimiter)))


def _read_parquet(path: Path) -> Columns:
    return _arrow_columns(pyarrow.parquet.read_table(path))


def _arrow_columns(table: pa.Table) -> Columns:
    return {name.strip(): table.column(name).to_numpy() for name in table.column_names}


def _read_mat(path: Path) -> Columns:
    variables = in_own_process(loadmat, path, simplify_cells=True)  # damaged files crash it
    return dict(_flat('', {name: variables[name] for name in variables if name[:2] != '__'}))


def _read_npz(path: Path) -> Columns:
    with np.load(path, allow_pickle=False) as arrays:
        return dict(_flat('', {name: arrays[name] for name in arrays.files}))


def _flat(prefix: str, variables: dict[str, Any]) -> Iterator[tuple[str, NDArray[Any]]]:
    """Yield every column in nested variables; what is no column (a scalar, a text) is left out."""
    for name, value in variables.items():
        if isinstance(value, dict):
            yield from _flat(f'{prefix}{name}.', value)
            continue
        array = np.asarray(value)
        if array.dtype.names:
            yield from _flat(f'{prefix}{name}.', {f: array[f] for f in array.dtype.names})
        elif array.ndim == 1 or (array.ndim == 2 and 1 in array.shape):
            yield prefix + name, array.ravel()
        elif array.ndim == 2:
            for place, column in enumerate(array.T, start=1):
                yield f'{prefix}{name}_{place}', column


READERS: dict[str, Callable[[Path], Columns]] = {
    '.csv': _read_csv,
    '.csv.gz': _read_csv,
    '.parquet': _read_parquet,
    '.mat': _read_mat,
    '.npz': _read_npz,
}
