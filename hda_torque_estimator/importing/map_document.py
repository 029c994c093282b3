"""
Read a column map from its document, as YAML gives it; docs/importing.md describes the keys.

    time: {column: t, unit: ms}       or    time: {rate: 1000.0}
    split: run                        one bag for each value of this column
    wrench: [fx, fy, fz, tx, ty, tz]  force and torque on the tip, in the base frame
    each: {...}                       what all joints share; {n} is 1, 2, .., {joint} the name
    joints: [joint1, joint2]          or    joints: {joint1: {...}, joint2: {...}}
"""

from collections.abc import Callable, Collection, Mapping
from typing import cast, NamedTuple

from hda_arm_sim.foundation.parameter import Declaration

from .column_map import Column, ColumnMap, ColumnMapError, JointColumns, Side, Winding, Zero
from .formula import Formula, read_formula
from .units import (
    ANGLE, CONSTANTS, OF_VOLTAGE, Quantity, SHORT, SPEED, TIME, TORQUE, Unit, VOLTAGES)

MAP_KEYS = ('time', 'split', 'wrench', 'each', 'joints')
JOINT_KEYS = ('ratio', 'motor', 'link', 'reference')
SIDES: dict[str, dict[str, Quantity]] = {
    'motor': {'position': ANGLE, 'velocity': SPEED, 'effort': TORQUE},
    'link': {'position': ANGLE, 'velocity': SPEED},
}
AXES = 6
EVEN = 'even'
SHAPING = ('column', 'unit', 'zero')
COLUMN_KEYS = (*SHAPING, 'formula', 'sign', 'side', *(constant.name for constant in CONSTANTS),
               *SHORT)
RATIO = Declaration('ratio', float('nan'), '', 1.0, 1e4, 'gear ratio, motor over link')
RATE = Declaration('rate', float('nan'), 'Hz', 1e-3, 1e6, 'rows per second')
ZERO = Declaration('zero', 0.0, '', -1e18, 1e18, "reading at zero, in the column's unit")

Document = Mapping[str, object]


class _Joint(NamedTuple):
    """The place of a joint in the map, and what its entries need to know."""

    entry: str
    name: str
    number: int
    ratio: float | None

    def in_table(self, column: str) -> str:
        return column.replace('{n}', str(self.number)).replace('{joint}', self.name)


def read_column_map(document: object) -> ColumnMap:
    """Return the map that a document describes; raises ColumnMapError or ParameterError."""
    entries = _mapping('the column map', document, MAP_KEYS)
    if 'time' not in entries or 'joints' not in entries:
        raise ColumnMapError("the column map needs 'time' and 'joints', "
                             f'got {_listed(entries) or "nothing"}')
    time = _time(entries['time'])
    split = Column('split', (_name('split', entries['split']),)) if 'split' in entries else None
    wrench = _wrench(entries['wrench']) if 'wrench' in entries else ()
    return ColumnMap(_joints(entries['joints'], entries.get('each', {})), time, split, wrench,
                     _even(entries['time']))


def _time(entry: object) -> Column | float:
    if isinstance(entry, Mapping) and 'rate' in entry:
        _mapping('time', entry, ('rate',))
        return RATE.checked('time', entry['rate'])
    given = _shorthand('time', entry, (*SHAPING, 'formula', EVEN))
    formula = _formula('time', given, str)
    names = [_name('time', given.get('column'))] if formula is None else formula.names.values()
    column = Column('time', tuple(names), _unit('time', given, TIME).factor,
                    _zero('time', given), formula)
    if column.zero == 'mean':
        raise ColumnMapError("time.zero must be a number or 'first', got 'mean'")
    return column


def _even(entry: object) -> bool:
    """Return whether stamps of a host are to become even."""
    even = entry.get(EVEN, False) if isinstance(entry, Mapping) else False
    if not isinstance(even, bool):
        raise ColumnMapError(f'time.{EVEN} must be true or false, got {even!r}')
    return even


def _wrench(given: object) -> tuple[Column, ...]:
    keys = _shorthand('wrench', given, ('column', 'zero', 'sign'))
    names = keys.get('column')
    if not isinstance(names, list) or len(names) != AXES:
        raise ColumnMapError('wrench.column must list six columns, force x, y, z [N] and torque '
                             f'x, y, z [N*m], got {names!r}')
    return tuple(Column('wrench', (_name('wrench.column', name),), _sign('wrench', keys),
                        _zero('wrench', keys)) for name in names)


def _joints(entry: object, each: object) -> tuple[JointColumns, ...]:
    if not isinstance(entry, (list, Mapping)) or not entry:
        raise ColumnMapError(f'joints must be a list or a mapping of joint names, got {entry!r}')
    shared = _mapping('each', each, JOINT_KEYS)
    own = entry if isinstance(entry, Mapping) else dict.fromkeys(
        _name(f'joints[{place}]', name) for place, name in enumerate(entry))
    if len(own) != len(entry):
        raise ColumnMapError(f'joints must have different names, got {_listed(entry)}')
    return tuple(_joint(str(name), number, shared, own[name] or {})
                 for number, name in enumerate(own, start=1))


def _joint(name: str, number: int, shared: Document, own: object) -> JointColumns:
    entry = f'joints.{name}'
    given = _merged(entry, shared, _mapping(entry, own, JOINT_KEYS))
    ratio = RATIO.checked(entry, given['ratio']) if 'ratio' in given else None
    joint = _Joint(entry, name, number, ratio)
    reference = given.get('reference')
    columns = JointColumns(
        name, _side(joint, 'motor', given), _side(joint, 'link', given),
        None if reference is None else _column(joint, 'reference', reference, TORQUE, 'link'))
    if not columns.columns():
        raise ColumnMapError(f'{entry} names no column: give at least one of '
                             f'{_listed(JOINT_KEYS[1:])} here or under each')
    return columns


def _merged(entry: str, shared: Document, own: Document) -> Document:
    """Return what a joint holds: its own entries before the shared ones, column by column."""
    sides = {side: {**_mapping(f'each.{side}', shared.get(side) or {}, quantities),
                    **_mapping(f'{entry}.{side}', own.get(side) or {}, quantities)}
             for side, quantities in SIDES.items()}
    return {**shared, **own, **sides}


def _side(joint: _Joint, side: str, given: Document) -> Side:
    columns = cast(Document, given[side])
    return Side(**{name: _column(joint, f'{side}.{name}', columns[name], quantity, side)
                   for name, quantity in SIDES[side].items() if name in columns})


def _column(joint: _Joint, place: str, given: object, quantity: Quantity, side: str) -> Column:
    """Return the column at a place, brought to the given side of the gear."""
    entry = f'{joint.entry}.{place}'
    keys = _spelled_out(entry, _shorthand(entry, given, COLUMN_KEYS))
    formula = _formula(entry, keys, joint.in_table)
    named = keys.get('column') if formula is None else list(formula.names.values())
    names = named if isinstance(named, list) and named else [named]
    unit = _unit(entry, keys, quantity)
    if unit.is_voltage and keys.get('side', 'motor') != 'motor':
        raise ColumnMapError(f'{entry} is a voltage, so it is stated at the motor')
    factor = unit.factor * _constants(entry, keys, unit) * _sign(entry, keys)
    return Column(
        entry, tuple(joint.in_table(_name(f'{entry}.column', name)) for name in names),
        factor * _across_gear(joint, entry, keys, quantity, side), _zero(entry, keys), formula,
        _winding(entry, keys) if unit.is_voltage else None)


def _formula(entry: str, keys: Document, in_table: Callable[[str], str]) -> Formula | None:
    """Return the formula of an entry with the names of the table, None where it has a column."""
    if 'formula' not in keys:
        return None
    if 'column' in keys:
        raise ColumnMapError(f'{entry} has both a column and a formula; give one of them')
    given = keys['formula']
    return read_formula(entry, in_table(given) if isinstance(given, str) else given)


def _unit(entry: str, keys: Document, quantity: Quantity) -> Unit:
    units = {**quantity.units, **(VOLTAGES if entry.endswith('.motor.effort') else {})}
    name = keys.get('unit', next(iter(units)))
    if not isinstance(name, str) or name not in units:
        raise ColumnMapError(f'{entry}.unit must be a unit of {quantity.name}, one of '
                             f'{_listed(units)}, got {name!r}')
    return units[name]


def _constants(entry: str, keys: Document, unit: Unit) -> float:
    needed = [constant for constant in CONSTANTS
              if constant in (unit.times, unit.over, *OF_VOLTAGE * unit.is_voltage)]
    if missing := [constant for constant in needed if constant.name not in keys]:
        raise ColumnMapError(f'{entry} has the unit {keys["unit"]!r}, so it needs ' + ' and '.join(
            f'{constant.name} [{constant.unit}] ({constant.meaning})' for constant in missing))
    for constant in CONSTANTS:
        if constant not in needed and constant.name in keys:
            raise ColumnMapError(f'{entry}.{constant.name} has no use: the unit of this entry is '
                                 f'{keys.get("unit", "the default")!r}')
    times = unit.times.checked(entry, keys[unit.times.name]) if unit.times else 1.0
    return times / (unit.over.checked(entry, keys[unit.over.name]) if unit.over else 1.0)


def _winding(entry: str, keys: Document) -> Winding:
    """Return what makes a torque of a voltage; raises ParameterError."""
    return Winding(*(constant.checked(entry, keys[constant.name]) for constant in OF_VOLTAGE))


def _spelled_out(entry: str, keys: Document) -> Document:
    """Return keys with the short names of constants in full; raises ColumnMapError for both."""
    if twice := [short for short, name in SHORT.items() if short in keys and name in keys]:
        raise ColumnMapError(f'{entry} has both {twice[0]} and {SHORT[twice[0]]}; give one')
    return {SHORT.get(key, key): value for key, value in keys.items()}


def _sign(entry: str, keys: Document) -> float:
    sign = keys.get('sign', 1)
    if isinstance(sign, bool) or sign not in (1, -1):
        raise ColumnMapError(f'{entry}.sign must be 1 or -1, got {sign!r}')
    return float(sign)


def _across_gear(joint: _Joint, entry: str, keys: Document, quantity: Quantity,
                 side: str) -> float:
    stated = keys.get('side', side)
    if not isinstance(stated, str) or stated not in SIDES:
        raise ColumnMapError(f"{entry}.side must be 'motor' or 'link', got {stated!r}")
    if stated == side:
        return 1.0
    if joint.ratio is None:
        raise ColumnMapError(f'{entry} is stated at the {stated} side, so {joint.entry}.ratio is '
                             'needed to bring it to the other')
    power = quantity.power_of_ratio if side == 'motor' else -quantity.power_of_ratio
    return joint.ratio ** power


def _zero(entry: str, keys: Document) -> Zero:
    zero = keys.get('zero', 0.0)
    if zero in ('first', 'mean'):
        return cast(Zero, zero)
    if isinstance(zero, str):
        raise ColumnMapError(f"{entry}.zero must be a number, 'first' or 'mean', got {zero!r}")
    return ZERO.checked(entry, zero)


def _shorthand(entry: str, given: object, allowed: Collection[str]) -> Document:
    """Return the keys of a column's entry; a name or a list of names stands for its column."""
    if isinstance(given, (str, list)):
        return {'column': given}
    return _mapping(entry, given, allowed)


def _mapping(entry: str, given: object, allowed: Collection[str]) -> Document:
    if not isinstance(given, Mapping):
        raise ColumnMapError(f'{entry} must hold some of {_listed(allowed)}, got {given!r}')
    for key in given:
        if key not in allowed:
            raise ColumnMapError(f'{entry} has an unknown key {key!r}; it may hold '
                                 f'{_listed(allowed)}')
    return given


def _name(entry: str, given: object) -> str:
    if not isinstance(given, str) or not given:
        raise ColumnMapError(f'{entry} must be a name, got {given!r}')
    return given


def _listed(names: Collection[object]) -> str:
    return ', '.join(repr(name) for name in names)
