"""
Motions as tables that people, spreadsheets and robots read: CSV with names and units.

A row holds a time, the link angles, and their rates. Between rows the angle is the cubic that
has both at either end. So a table at 200 Hz gives the motion at any rate.
"""

from collections.abc import Sequence
import csv
from pathlib import Path

from hda_msgs_json.outputs import whole_file
import numpy as np

from .foundation.arrays import Array
from .motions import Motion, MotionError

RATE = 200.0            # rows in a second of a table that is written [Hz]


def write_motion(path: Path, made: Motion, labels: Sequence[str], *, force: bool = False) -> None:
    """Write a motion, thinned to about RATE, without its force; raises OutputError."""
    every = max(1, round(1.0 / (RATE * float(made.time[1] - made.time[0]))))
    rows = np.column_stack([made.time, made.angle, made.rate])[::every]
    with whole_file(path, force=force) as file:
        file.write(','.join(_header(labels)) + '\n')
        np.savetxt(file, rows, fmt='%.9g', delimiter=',')


def read_motion(path: Path, labels: Sequence[str], dt: float,
                duration: float | None = None) -> Motion:
    """
    Return the motion of a table for joints of these names, sampled every dt [s].

    It lasts as long as the table, or shorter where a duration [s] is given. Raises MotionError.
    """
    table = _table(path, labels)
    given = float(table[-1, 0] - table[0, 0])
    if duration is not None and not 0.0 < duration <= given + 0.5 * dt:
        raise MotionError(f'{path} lasts {given:g} s, got a duration of {duration:g} s')
    time: Array = dt * np.arange(round((duration or given) / dt) + 1, dtype=np.float64)
    angle, rate = _between(table, len(labels), np.minimum(time, given))
    return Motion(time, angle, rate, np.zeros((len(time), 2)))


def _header(labels: Sequence[str]) -> list[str]:
    return ['time [s]', *(f'{label} angle [rad]' for label in labels),
            *(f'{label} rate [rad/s]' for label in labels)]


def _table(path: Path, labels: Sequence[str]) -> Array:
    """Return the columns of a table in the order of the header (k, 1 + 2 n)."""
    if not path.is_file():
        raise MotionError(f'{path} does not exist, or is not a file')
    try:
        with path.open(encoding='utf-8-sig', newline='') as file:
            lines = [line for line in csv.reader(file) if line]
    except OSError as error:
        raise MotionError(f'{path} cannot be read: {error.strerror}') from None
    except (UnicodeDecodeError, csv.Error):
        raise MotionError(f'{path} is no table of a motion: it is not CSV in UTF-8') from None
    names = [name.strip() for name in lines[0]] if lines else []
    absent = [name for name in _header(labels) if name not in names]
    if absent:
        raise MotionError(f'{path} has no column {absent[0]!r}; a motion of this arm has '
                          f'{", ".join(_header(labels))}')
    table = _numbers(path, lines[1:], len(names))[:, [names.index(n) for n in _header(labels)]]
    if len(table) < 2 or not (np.diff(table[:, 0]) > 0.0).all():
        raise MotionError(f'{path}: its times must grow from row to row, over at least two rows')
    return table


def _numbers(path: Path, lines: list[list[str]], width: int) -> Array:
    rows = np.empty((len(lines), width))
    for number, line in enumerate(lines, 2):
        try:
            rows[number - 2] = np.array(line, float).reshape(width)
        except ValueError:
            raise MotionError(f'{path}, row {number}: expected {width} numbers, got '
                              f'{",".join(line)[:60]!r}') from None
    if not np.isfinite(rows).all():
        row = int(np.argmin(np.isfinite(rows).all(axis=1)))
        raise MotionError(f'{path}, row {row + 2}: every number must be finite')
    return rows


def _between(table: Array, joints: int, since: Array) -> tuple[Array, Array]:
    """Return angles and rates (m, n) at some times since the first row."""
    from scipy.interpolate import CubicHermiteSpline    # a third of a second few need to wait
    curve = CubicHermiteSpline(table[:, 0] - table[0, 0], table[:, 1:1 + joints],
                               table[:, 1 + joints:])
    return curve(since), curve.derivative()(since)
