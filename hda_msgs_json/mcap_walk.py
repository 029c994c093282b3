"""Where the records of a stretch of an MCAP file start."""

import struct

from hda_msgs_json.strided import Indices, structures
import numpy as np
from numpy.typing import NDArray

RECORD_HEAD = struct.Struct('<BQ')
HEAD = np.dtype([('opcode', 'u1'), ('length', '<u8')])
FEWEST_PROBED = 64
LONGEST_CYCLE = 16
MOST_GAPS = 256


def record_starts(content: bytes, hints: Indices | None = None) -> tuple[Indices, int]:
    """
    Return where the complete records start, and where the last of them ends.

    Records must be followed one by one, but much can be checked at once. These are hints, in
    ascending order, of where records start, and periods in the sizes of the records. Wrong hints
    cost time. No record has the opcode 0: where one seems to, there are none any more.
    """
    if hints is not None and len(hints) and (hinted := _hinted(content, hints)) is not None:
        found, at = hinted
    else:
        found, at = [], 0
    probed = FEWEST_PROBED
    while True:
        starts, at = _follow(content, at, probed)
        found.append(np.array(starts, np.int64))
        if len(starts) < probed:
            return np.concatenate(found), at
        cycle = _cycle(np.diff(found[-1][-2 * LONGEST_CYCLE:], append=at))
        repeated = _repeat(content, at, cycle)
        probed = FEWEST_PROBED if len(repeated) > probed else 2 * probed
        found.append(repeated)
        at += len(repeated) // max(len(cycle), 1) * int(cycle.sum())


def _hinted(content: bytes, hints: Indices) -> tuple[list[Indices], int] | None:
    """Return the starts up to the last hint and where its record ends, or None if one is wrong."""
    if hints[0] < 0 or hints[-1] > len(content) - RECORD_HEAD.size:
        return None
    heads = structures(np.frombuffer(content, np.uint8), hints, HEAD)
    lengths = heads['length']
    if (lengths > len(content)).any() or not heads['opcode'].all():
        return None
    stops = hints + RECORD_HEAD.size + lengths.astype(np.int64)
    runs = np.append(np.flatnonzero(stops[:-1] != hints[1:]), len(hints) - 1)
    if len(runs) > MOST_GAPS or stops[-1] > len(content):
        return None
    found: list[Indices] = []
    at = first = 0
    for last in runs.tolist():
        while at < hints[first]:
            between, at = _follow(content, at, 1)
            found.append(np.array(between, np.int64))
            if not between:
                return None
        if at != hints[first]:
            return None
        found.append(hints[first:last + 1])
        at, first = int(stops[last]), last + 1
    return found, at


def _follow(content: bytes, at: int, most: int) -> tuple[list[int], int]:
    """Return the starts of the next records, and where the last of them ends."""
    starts: list[int] = []
    last = len(content) - RECORD_HEAD.size
    while at <= last and len(starts) < most:
        opcode, length = RECORD_HEAD.unpack_from(content, at)
        stop = at + RECORD_HEAD.size + length
        if stop > len(content) or not opcode:
            break
        starts.append(at)
        at = stop
    return starts, at


def _cycle(sizes: Indices) -> Indices:
    """Return the shortest run of sizes that repeats itself, or nothing."""
    for period in range(1, LONGEST_CYCLE + 1):
        if np.array_equal(sizes[period:], sizes[:-period]):
            return sizes[-period:]
    return sizes[:0]


def _repeat(content: bytes, at: int, cycle: Indices) -> Indices:
    """Return the starts of the records that follow as long as their sizes repeat a cycle."""
    stride = int(cycle.sum())
    count = (len(content) - at) // stride if stride else 0
    if not count:
        return cycle[:0]
    offsets = np.cumsum(cycle) - cycle
    same = np.ones(count, bool)
    for offset, size in zip(offsets.tolist(), cycle.tolist()):
        heads: NDArray[np.void] = np.ndarray(count, HEAD, content, at + offset, (stride,))
        same &= (heads['length'] == size - RECORD_HEAD.size) & (heads['opcode'] != 0)
    count = count if same.all() else int(same.argmin())
    return np.asarray((at + stride * np.arange(count)[:, np.newaxis] + offsets).ravel(), np.int64)
