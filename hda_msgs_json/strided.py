"""Structures that lie anywhere in a buffer of bytes, read and written many at once."""

import numpy as np
from numpy.typing import NDArray

Bytes = NDArray[np.uint8]
Indices = NDArray[np.int64]


def structures(buffer: Bytes, starts: Indices, kind: np.dtype[np.void]) -> NDArray[np.void]:
    """Return the structures at these offsets, all within the buffer; a view if they lie evenly."""
    if not len(starts):
        return np.empty(0, kind)
    steps = np.diff(starts)
    if len(steps) and steps[0] > 0 and (steps == steps[0]).all():
        return np.ndarray(len(starts), kind, buffer.data, int(starts[0]), (int(steps[0]),))
    return _anywhere(buffer, kind.itemsize)[starts].view(kind)


def place(buffer: Bytes, starts: Indices, rows: Bytes) -> None:
    """Copy rows of bytes (n, size) to these offsets."""
    if rows.size:
        size = rows.shape[1]
        _anywhere(buffer, size)[starts] = np.ascontiguousarray(rows).view(f'V{size}')[:, 0]


def _anywhere(buffer: Bytes, size: int) -> NDArray[np.void]:
    """Return what starts at each offset; so many bytes at once are copied as one."""
    return np.ndarray(len(buffer) - size + 1, f'V{size}', buffer.data, 0, (1,))
