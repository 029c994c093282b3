"""Read tables from files: CSV (plain or compressed), other text, Parquet, MAT and NPZ."""

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
import csv
import gzip
from itertools import islice
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

from .json_lines import json_columns
from .mat73 import is_hdf5, read_mat73
from .own_process import in_own_process
from .text_tables import form_of, table_lines, TableFormat, without_brackets

Columns = dict[str, NDArray[Any]]
Table = TypeVar('Table', Columns, list[str])
MOST_COLUMNS = 10_000
LONGEST_LINE = 1 << 20           # characters of one of the lines that are looked at first
HEAD = 64                        # so many of them

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

    A matrix (n, k) or (k, n) in a MAT or NPZ file gives the columns NAME_1 to NAME_k. A struct
    or a record array gives STRUCT.FIELD.
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
    with opened(path, 'rt', encoding='utf-8-sig', newline='') as stream:
        head = list(islice(iter(lambda: stream.readline(LONGEST_LINE), ''), HEAD))
    _check_lengths(head)
    form = form_of(head)
    try:
        return _arrow_table(path, form)
    except pa.ArrowInvalid:             # perhaps a logger was killed while it wrote
        return _arrow_table(path, form, last_cut_off=True)


def _read_text(path: Path) -> Columns:
    with path.open(encoding='utf-8-sig') as stream:
        lines = stream.read().splitlines()
    _check_lengths(lines[:HEAD])
    yarp = path.suffix.lower() == '.log'
    if yarp:
        lines = [without_brackets(line) for line in lines]
    form = form_of(lines[:HEAD], yarp=yarp)
    body = '\n'.join(table_lines(lines, form)).encode()
    return _arrow_table(pa.BufferReader(body), form._replace(skipped=0))


def _check_lengths(lines: Sequence[str]) -> None:
    for number, line in enumerate(lines, start=1):
        if len(line) >= LONGEST_LINE:
            raise TableError(f'its line {number} has {LONGEST_LINE} characters or more')


def _arrow_table(source: Path | pa.BufferReader, form: TableFormat, *,
                 last_cut_off: bool = False) -> Columns:
    """Return the columns below the names that were found in a text, or all but a last row."""
    names = _bounded(form.names)
    if twice := sorted(name for name, count in Counter(names).items() if count > 1):
        raise TableError(f'more than one column has the name {twice[0]!r}')
    if not names:
        raise TableError('it has no columns')
    short: list[pyarrow.csv.InvalidRow] = []

    def left_out(row: pyarrow.csv.InvalidRow) -> str:
        short.append(row)
        return 'skip' if len(short) == 1 else 'error'

    # A thread of the reader that lets go of a function of ours at exit can end the process.
    table = pyarrow.csv.read_csv(
        source, pyarrow.csv.ReadOptions(column_names=names, skip_rows=form.skipped,
                                        use_threads=not last_cut_off),   # threads know no numbers
        pyarrow.csv.ParseOptions(delimiter=form.mark,
                                 invalid_row_handler=left_out if last_cut_off else None),
        pyarrow.csv.ConvertOptions(decimal_point=form.decimal_point))
    if short and (short[0].number != form.skipped + table.num_rows + 1
                  or short[0].actual_columns > len(names)):
        raise TableError(f'its line {short[0].number} has {short[0].actual_columns} columns, not '
                         f'{len(names)}')
    return _arrow_columns(table)


def _read_json_lines(path: Path) -> Columns:
    with path.open(encoding='utf-8-sig') as lines:
        return json_columns(lines, MOST_COLUMNS)


def _read_parquet(path: Path) -> Columns:
    return _arrow_columns(pyarrow.parquet.read_table(path))


def _arrow_columns(table: pa.Table) -> Columns:
    return {name.strip(): table.column(name).to_numpy() for name in table.column_names}


def _read_mat(path: Path) -> Columns:
    if is_hdf5(path):                                   # version 7.3
        return _channels(in_own_process(read_mat73, path))
    variables = in_own_process(loadmat, path, simplify_cells=True)  # damaged files crash it
    return _channels({name: variables[name] for name in variables if name[:2] != '__'})


def _read_npz(path: Path) -> Columns:
    with np.load(path, allow_pickle=False) as arrays:
        return _channels({name: arrays[name] for name in arrays.files})


def _channels(variables: dict[str, Any]) -> Columns:
    """
    Return every column in nested variables; a matrix has its channels in columns or in rows.

    They are in rows where the longest vector is as long as a row. Where neither side has its
    length, they are in rows that are longer than columns.
    """
    arrays = dict(_flat('', variables))
    length = max((len(array) for array in arrays.values() if array.ndim == 1), default=0)
    found: Columns = {}
    for name, array in arrays.items():
        if array.ndim == 1:
            found[name] = array
            continue
        rows, columns = array.shape
        in_rows = rows != length and (columns == length or columns > rows)
        found.update((f'{name}_{place}', channel) for place, channel in enumerate(
            array if in_rows else array.T, start=1))
    return found


def _flat(prefix: str, variables: dict[str, Any]) -> Iterator[tuple[str, NDArray[Any]]]:
    """Yield vectors and matrices in nested variables; scalars and texts are left out."""
    for name, value in variables.items():
        if isinstance(value, dict):
            yield from _flat(f'{prefix}{name}.', value)
            continue
        array = np.asarray(value)
        if array.dtype.names:
            yield from _flat(f'{prefix}{name}.', {f: array[f] for f in array.dtype.names})
        elif array.ndim and (flat := array.squeeze()).ndim < 2:
            yield prefix + name, flat.ravel()
        elif array.ndim and flat.ndim == 2:             # (k, 1, n) of a yarp telemetry too
            yield prefix + name, flat


READERS: dict[str, Callable[[Path], Columns]] = {
    '.csv': _read_csv,
    '.csv.gz': _read_csv,
    **dict.fromkeys(('.txt', '.dat', '.tsv', '.log'), _read_text),
    **dict.fromkeys(('.jsonl', '.ndjson'), _read_json_lines),
    '.parquet': _read_parquet,
    '.mat': _read_mat,
    '.npz': _read_npz,
}
