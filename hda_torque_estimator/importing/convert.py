"""Turn the columns of a table into the messages of bags, as a column map says."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from hda_msgs_json.nearest import nearest
from hda_msgs_json.samples import JointSamples, Stamps, WrenchSamples
from hda_msgs_json.topics import BASE_FRAME, link_frame, motor_name
import numpy as np
from numpy.typing import NDArray

from .column_map import Column, ColumnMap, ColumnMapError, JointColumns, Side, Winding
from ..measurements.even_stamps import evened

Columns = Mapping[str, NDArray[Any]]
Floats = NDArray[np.float64]

LATEST = 2 ** 31                            # [s], what the stamp of a message can hold
NANOSECONDS = 1e9
SUGGESTIONS = 4                             # columns that a message names (choice)
NEAR = 0.5                                  # like names of columns often are (choice)


@dataclass(frozen=True, eq=False)
class Imported:
    """One recording: the value that split it off, joint states, reference torques and wrench."""

    label: str
    joint_states: JointSamples
    references: dict[str, WrenchSamples]    # by the name of the joint
    wrench: WrenchSamples | None = None     # on the tip


def convert(column_map: ColumnMap, columns: Columns) -> tuple[Imported, ...]:
    """
    Return the recordings of a table, in the order in which they start.

    Raises ColumnMapError when the map names a column that the table does not have, or one whose
    content cannot be what the map says.
    """
    _check_columns(column_map, columns)
    groups = _groups(column_map, columns)
    return tuple(_recording(column_map, label, rows, columns) for label, rows in groups.items())


def _check_columns(column_map: ColumnMap, columns: Columns) -> None:
    used = [(column.entry, name) for column in column_map.columns() for name in column.names]
    for entry, name in used:
        if name not in columns:
            raise ColumnMapError(f'{entry} names the column {name!r}, which the table does not '
                                 f'have; {_nearest(name, columns)}')
    lengths = {name: len(columns[name]) for _, name in used}
    if len(set(lengths.values())) > 1:
        shortest, longest = (pick(lengths, key=lengths.__getitem__) for pick in (min, max))
        raise ColumnMapError(f'columns must be equally long, got {lengths[shortest]} rows in '
                             f'{shortest!r} and {lengths[longest]} in {longest!r}')
    if not all(lengths.values()):
        raise ColumnMapError('the table has no rows')


def _nearest(name: str, columns: Columns) -> str:
    if near := nearest(name, columns, most=SUGGESTIONS, near=NEAR):
        return f'the nearest it has: {", ".join(map(repr, near))}'
    some = ', '.join(repr(other) for other in list(columns)[:SUGGESTIONS])
    return f'it has {len(columns)} columns: {some}{", ..." * (len(columns) > SUGGESTIONS)}'


def _groups(column_map: ColumnMap, columns: Columns) -> dict[str, NDArray[np.intp]]:
    """Return the rows of every recording by its label; one recording where nothing splits."""
    if column_map.split is None:
        return {'': np.arange(len(columns[column_map.columns()[0].names[0]]))}
    name = column_map.split.names[0]
    values, first, group = np.unique(columns[name], return_index=True, return_inverse=True)
    if values.dtype.kind == 'f' and not np.isfinite(values).all():
        raise ColumnMapError(f'split: the column {name!r} must have a value in every row, '
                             f'got {values[~np.isfinite(values)][0]} in one')
    return {_label(values[k]): np.flatnonzero(group == k) for k in np.argsort(first)}


def _label(value: object) -> str:
    if isinstance(value, (float, np.floating)) and float(value).is_integer():
        return str(int(value))
    return str(value)


def _recording(column_map: ColumnMap, label: str, rows: NDArray[np.intp],
               columns: Columns) -> Imported:
    """Return one recording; its rows are those of the table."""
    stamps = _stamps(column_map, rows, columns)
    references = {
        joint.name: _reference(joint, joint.reference, stamps, rows, columns)
        for joint in column_map.joints if joint.reference is not None}
    return Imported(label, _joint_states(column_map, stamps, rows, columns), references,
                    _wrench(column_map.wrench, stamps, rows, columns))


def _stamps(column_map: ColumnMap, rows: NDArray[np.intp], columns: Columns) -> Stamps:
    time = column_map.time
    if isinstance(time, float):
        return np.rint(np.arange(len(rows)) * (NANOSECONDS / time)).astype(np.int64)
    raw = _raw(time, rows, columns)
    zero = raw[0] if time.zero == 'first' else time.zero
    elapsed = raw - zero if zero else raw
    _check_range(time, elapsed * time.factor, rows)
    per_unit = time.factor * NANOSECONDS
    if elapsed.dtype.kind == 'i':                       # whole numbers give exact nanoseconds
        stamps = (elapsed * round(per_unit)).astype(np.int64)
    else:
        stamps = np.rint(elapsed * per_unit).astype(np.int64)
    stamps = evened(stamps) if column_map.even else stamps
    _check_growth(time, stamps, rows)
    return stamps


def _check_range(time: Column, seconds: Floats, rows: NDArray[np.intp]) -> None:
    outside = np.flatnonzero(~((seconds >= 0.0) & (seconds < LATEST)))
    if outside.size:
        raise ColumnMapError(
            f'time: the column {time.names[0]!r} must lie in [0, {LATEST}) s, got '
            f'{seconds[outside[0]]:g} s in row {rows[outside[0]] + 1}; check its unit, '
            'or set zero: first')


def _check_growth(time: Column, stamps: Stamps, rows: NDArray[np.intp]) -> None:
    back = np.flatnonzero(np.diff(stamps) <= 0) + 1
    if back.size:
        later, before = stamps[back[0]] / NANOSECONDS, stamps[back[0] - 1] / NANOSECONDS
        raise ColumnMapError(
            f'time: the column {time.names[0]!r} must grow from row to row of a recording, got '
            f'{later:.9g} s in row {rows[back[0]] + 1} after {before:.9g} s; '
            'several recordings in one table need split')


def _joint_states(column_map: ColumnMap, stamps: Stamps, rows: NDArray[np.intp],
                  columns: Columns) -> JointSamples:
    sides: dict[str, Side] = {}
    for joint in column_map.joints:
        sides[joint.name] = joint.link
        sides[motor_name(joint.name)] = joint.motor
    present = {name: side for name, side in sides.items() if side.columns()}

    def table(quantity: str) -> Floats:
        values = np.full((len(rows), len(present)), np.nan)
        for place, side in enumerate(present.values()):
            values[:, place] = _values(getattr(side, quantity), rows, columns)
        return values

    position, velocity, effort = table('position'), table('velocity'), table('effort')
    for place, side in enumerate(present.values()):
        if side.effort is not None and side.effort.winding is not None:
            speed = _speed(side, stamps, position[:, place], velocity[:, place])
            effort[:, place] = _torque(side.effort.winding, effort[:, place], speed)
    return JointSamples(stamps, tuple(present), position, velocity, effort)


def _speed(side: Side, stamps: Stamps, position: Floats, velocity: Floats) -> Floats:
    """Return the speed of a shaft (n,) [rad/s]; raises ColumnMapError where nothing states it."""
    if side.velocity is not None:
        return velocity
    if side.position is None or len(stamps) < 2:
        entry = side.effort.entry if side.effort else ''
        raise ColumnMapError(f'{entry} is a voltage, so the position or velocity of the motor is '
                             'needed for its back EMF')
    return np.gradient(position, stamps / NANOSECONDS)


def _torque(winding: Winding, voltage: Floats, speed: Floats) -> Floats:
    """Return the torque of a motor (n,) [N*m] from its voltage [V] and speed [rad/s]."""
    kt = winding.torque_constant
    return kt * (voltage - kt * speed) / winding.resistance


def _wrench(axes: tuple[Column, ...], stamps: Stamps, rows: NDArray[np.intp],
            columns: Columns) -> WrenchSamples | None:
    """Return the wrench on the tip in the base frame, None where the table has none."""
    if not axes:
        return None
    values = np.column_stack([_values(axis, rows, columns) for axis in axes])
    return WrenchSamples(stamps, BASE_FRAME, values[:, :3], values[:, 3:])


def _reference(joint: JointColumns, reference: Column, stamps: Stamps, rows: NDArray[np.intp],
               columns: Columns) -> WrenchSamples:
    torque = np.zeros((len(rows), 3))
    torque[:, 2] = _values(reference, rows, columns)
    return WrenchSamples(stamps, link_frame(joint.name), np.zeros((len(rows), 3)), torque)


def _values(column: Column | None, rows: NDArray[np.intp], columns: Columns) -> Floats | float:
    """Return the quantity in the unit and at the side of the bag (n,), NaN where it is absent."""
    if column is None:
        return np.nan
    raw = _raw(column, rows, columns)
    return column.factor * (raw - _zero(column, raw))


def _raw(column: Column, rows: NDArray[np.intp], columns: Columns) -> NDArray[Any]:
    """Return the mean or the formula of columns (n,), in the unit of the table."""
    each = {name: _numbers(column, name, rows, columns) for name in column.names}
    if column.formula is None:
        return each[column.names[0]] if len(each) == 1 else np.mean([*each.values()], axis=0)
    return column.formula({name: values.astype(np.float64) for name, values in each.items()})


def _zero(column: Column, raw: Floats) -> float:
    if isinstance(column.zero, float):
        return column.zero
    known = raw[np.isfinite(raw)]
    if not known.size:
        raise ColumnMapError(f'{column.entry}.zero is {column.zero!r}, but the column has no '
                             'number in this recording')
    return float(known[0] if column.zero == 'first' else known.mean())


def _numbers(column: Column, name: str, rows: NDArray[np.intp],
             columns: Columns) -> NDArray[Any]:
    values = columns[name][rows]
    if values.dtype.kind not in 'iufb':
        raise ColumnMapError(f'{column.entry} needs numbers in the column {name!r}, '
                             f'got {str(values[0])!r} in row {rows[0] + 1}')
    return values.astype(np.int64) if values.dtype.kind in 'iub' else values.astype(np.float64)
