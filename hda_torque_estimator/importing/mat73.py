"""MAT files of version 7.3, which are HDF5: their numbers by name, and nothing else."""

from pathlib import Path
from typing import Any

import h5py
import numpy as np

OWN = '#'               # begins the names that MATLAB keeps for itself
NOT_NUMBERS = (b'char', b'cell', b'function_handle')
STEEPEST = 1000         # an array that claims to grow more than so many times is a bomb
SMALL = 16 << 20        # bytes that any array may have
DEEPEST = 16            # structs in structs (choice)


def is_hdf5(path: Path) -> bool:
    """Return whether a file is HDF5; MATLAB puts 512 bytes of its own before it."""
    return bool(h5py.is_hdf5(path))


def read_mat73(path: Path) -> dict[str, Any]:
    """
    Return the arrays of a file by name, structs as dictionaries; channels stand as in MATLAB.

    Raises OSError or ValueError for what cannot be read. Links that lead elsewhere are left out.
    """
    most = max(SMALL, STEEPEST * path.stat().st_size)
    with h5py.File(path, 'r') as file:
        return _group(file, most, DEEPEST)


def _group(group: h5py.Group, most: int, depth: int) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name in group:
        if name.startswith(OWN) or not isinstance(group.get(name, getlink=True), h5py.HardLink):
            continue
        item = group[name]
        if isinstance(item, h5py.Group) and depth:
            found[name] = _group(item, most, depth - 1)
        elif isinstance(item, h5py.Dataset) and _is_numbers(item):
            if item.nbytes > most:
                raise ValueError(f'{name} claims to have {item.nbytes} bytes')
            found[name] = np.asarray(item[()]).T        # MATLAB counts down the columns
    return found


def _is_numbers(dataset: h5py.Dataset) -> bool:
    return (dataset.dtype.kind in 'biuf' and not dataset.is_virtual and not dataset.external
            and dataset.attrs.get('MATLAB_class') not in NOT_NUMBERS
            and 'MATLAB_empty' not in dataset.attrs)
