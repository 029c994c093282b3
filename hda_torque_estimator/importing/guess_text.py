"""A guessed column map as YAML: ready to be edited, every guess with its reason beside it."""

from collections.abc import Iterator
import json

from .guess import Guess, NANO, TimeEntry
from .guess_wrench import wrench_columns
from .places import MapEntry
from .units import ANGLE, SPEED, TORQUE

FILL_IN = 'FILL_IN'
WIDTH = 78                      # from which comments stand above their line
MOST_SHOWN = 12
SIDES = ('motor', 'link')
UNITS = {**ANGLE.units, **SPEED.units, **TORQUE.units}


def map_text(guess: Guess, tables: str) -> str:
    """Return the text of a map; what no table can say is FILL_IN, which no import accepts."""
    return '\n'.join([
        f'# Guessed from the names and numbers in {_shown(tables)}.',
        '# Check every line: units, signs, sides.',
        f'# {FILL_IN} marks what only the documents of the arm state. Then:',
        f'#   hda import {_shown(tables)} --map THIS_FILE --out BAG',
        *_time(guess.time), *_joints(guess), *_unused(guess), ''])


def _time(time: TimeEntry) -> Iterator[str]:
    if time.column is None:
        yield _line(f'time: {{rate: {FILL_IN}}}', f'rows per second: {time.reason}')
        return
    zero = ', zero: first' * time.from_first
    what = f'column: {_name(time.column)}' if time.parts is None else (
        'formula: ' + _name(f'`{time.column}` + {NANO} * `{time.parts}`'))
    yield _line(f'time: {{{what}, unit: {time.unit}{zero}}}', time.reason)
    if time.split is not None:
        yield _line(f'split: {_name(time.split)}', 'the time starts again where it changes')


def _joints(guess: Guess) -> Iterator[str]:
    """Yield the joints: one pattern for all where they are numbered alike, else one by one."""
    alike = (guess.ratio is not None or not guess.ratios) and all(
        tuple(pattern.columns) == guess.joints and not entry.units and not entry.signs
        and pattern.is_numbered
        for entry in guess.entries.values() for pattern in entry.patterns)
    names = [f'joint{place}' for place in range(1, len(guess.joints) + 1)]
    if alike and guess.joints in ((0,), tuple(range(1, len(names) + 1))):
        yield f'joints: [{", ".join(names)}]'
        yield 'each:'
        yield from _entries(guess, None, '  ')
        return
    yield 'joints:'
    for name, number in zip(names, guess.joints):
        yield f'  {name}:'
        yield from _entries(guess, number, '    ')


def _entries(guess: Guess, number: int | None, indent: str) -> Iterator[str]:
    """Yield the entries of a joint, or those of all joints."""
    present = {place: entry for place, entry in guess.entries.items()
               if number is None or number in entry.patterns[0].columns}
    ratio = guess.ratio if number is None else guess.ratios.get(number)
    if ratio is not None:
        yield _line(f'{indent}ratio: {ratio:g}', 'motor over link, as the angles move')
    elif any(entry.side for entry in present.values()):
        yield _line(f'{indent}ratio: {FILL_IN}', 'motor over link')
    for side in SIDES:
        mine = {place.partition('.')[2]: entry for place, entry in present.items()
                if place.startswith(side)}
        if mine:
            yield f'{indent}{side}:'
        for quantity, entry in mine.items():
            yield _entry(f'{indent}  {quantity}', entry, number)
    if 'reference' in present:
        yield _entry(f'{indent}reference', present['reference'], number)


def _entry(key: str, entry: MapEntry, number: int | None) -> str:
    names = [_name(pattern.name if number is None else pattern.columns[number])
             for pattern in entry.patterns]
    unit, sign = (entry.unit, entry.sign) if number is None else (
        entry.unit_of(number), entry.sign_of(number))
    known = UNITS.get(unit)
    parts = [f'column: {names[0] if len(names) == 1 else "[" + ", ".join(names) + "]"}',
             f'unit: {unit if known else FILL_IN}']
    parts += [f'{constant.name}: {FILL_IN}' for constant in (known.times, known.over)
              if constant] if known else []
    parts += ['sign: -1'] * (sign < 0) + [f'side: {entry.side}'] * bool(entry.side)
    others = f'; or {", ".join(map(_shown, entry.others[:MOST_SHOWN]))}' if entry.others else ''
    return _line(f'{key}: {{{", ".join(parts)}}}', entry.reason + others)


def _unused(guess: Guess) -> Iterator[str]:
    if not {'motor.effort', 'reference'} & guess.entries.keys():
        yield '# No torque and no current was found. Without one nothing tells friction.'
    if wrench := wrench_columns(guess.unused):
        yield '# To take in where it is force [N] and torque [N*m] on the tip, in the base frame:'
        yield f'# wrench: [{", ".join(map(_name, wrench))}]'
    if guess.unused:
        some = ', '.join(map(_shown, guess.unused[:MOST_SHOWN]))
        more = ', ...' * (len(guess.unused) > MOST_SHOWN)
        yield f'# Without use ({len(guess.unused)}): {some}{more}'


def _line(content: str, why: str) -> str:
    """Return a line with its comment, above it where there is no room behind."""
    if len(content) + len(why) > WIDTH:
        return f'{content[:len(content) - len(content.lstrip())]}# {why}\n{content}'
    return f'{content}  # {why}'


def _name(name: str) -> str:
    """Return the name of a column as YAML."""
    return "'" + name.replace("'", "''") + "'" if name.isprintable() else json.dumps(name)


def _shown(name: str) -> str:
    return name if name.isprintable() else ascii(name)
