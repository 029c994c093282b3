"""Read the names of columns: which quantity of which joint they state, where, and in what unit."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
import re
from typing import Literal

Kind = Literal['position', 'velocity', 'torque', 'current', 'time']

WORD = re.compile(r'[A-Z]+(?=[A-Z][a-z])|[A-Z]?[a-z]+|[A-Z]+|\d+')
BRACKETED = re.compile(r'^(.*?)\s*[\[(]\s*([^\])]+?)\s*[\])]\s*$')
OTHERS = frozenset({
    'V', 'mV', 'W', 'C', '°C', 'degC', 'K', '%', 'mm', 'm/s', 'm/s^2', 'm/s2', 'Hz', 'kHz', 'g',
    'kg', 'bar', 'ohm', 'rad/s^2', 'rad/s2', 'deg/s^2', '[m', '[N'})
"""Units in brackets of what no joint's angle, speed or torque is in."""
MOVES: tuple[Kind, ...] = ('position', 'velocity')       # their units are mixed up in names

SIDED = re.compile(r'(motor|mot|rotor|shaft|link|load|joint)(.+)')
SIDES_ALONE = frozenset({'motor', 'mot', 'rotor', 'link', 'load', 'joint'})
"""Words that, with a number alone, name an angle, as in 'mot_3'; a 'load' may be a torque."""
NAMELESS = frozenset({'column', 'col', 'x', 'var', 'data', 'value', 'axis', 'j'})
"""Words that, with a number alone, name nothing."""
SHORTEST = 4                    # letters of a plural that is no short name, such as 'pos'
COUNTED = ('inc', 'incs', 'count', 'counts', 'cnt', 'tick', 'ticks')

KINDS: dict[str, Kind] = {
    **dict.fromkeys(('torque', 'tau', 'trq', 'effort', 'moment',
                     'drehmoment', 'couple', 'coppia'), 'torque'),
    **dict.fromkeys(('current', 'cur', 'curr', 'iq', 'amps', 'i',
                     'strom', 'courant', 'corrente', 'corriente'), 'current'),
    **dict.fromkeys(('velocity', 'vel', 'speed', 'omega', 'rate', 'dq', 'qd', 'qdot', 'dtheta',
                     'thetad', 'thetadot',
                     'geschwindigkeit', 'drehzahl', 'vitesse', 'velocita', 'velocidad'),
                    'velocity'),
    **dict.fromkeys(('position', 'pos', 'angle', 'ang', 'theta', 'phi', 'q', 'enc', 'encoder',
                     'winkel', 'posizione', 'angolo', 'posicion', 'angulo'), 'position'),
    **dict.fromkeys(('time', 't', 'timestamp', 'stamp', 'clock',
                     'zeit', 'temps', 'tempo', 'tiempo'), 'time')}
"""
What a word says of its column; of several words the first kind in this order counts.

Tables with decimal commas have words of German, French, Italian and Spanish.
"""

UNITS: dict[Kind, dict[str, tuple[str, ...]]] = {
    'position': {'rad': ('rad', 'radian', 'radians'), 'deg': ('deg', 'degree', 'degrees'),
                 'turn': ('turn', 'turns', 'rev', 'revs'),
                 'count': ('count', 'counts', 'cnt', 'cnts', 'tick', 'ticks', 'inc', 'incs')},
    'velocity': {'rad/s': ('rad s', 'rad per s', 'rads', 'radps', 'rad sec'),
                 'deg/s': ('deg s', 'deg per s', 'degs', 'degps', 'deg sec'), 'rpm': ('rpm',),
                 'turn/s': ('turn s', 'rev s', 'turns s', 'rps', 'hz'),
                 'count/s': ('count s', 'counts s', 'ticks s', 'cnt s')},
    'torque': {'mN*m': ('m nm', 'mnm', 'm n m'), 'N*m': ('nm', 'n m')},
    'current': {'mA': ('m a', 'ma', 'milliamps'), 'A': ('a', 'amp', 'amps', 'ampere')},
    'time': {'ms': ('ms', 'msec', 'milliseconds'), 'us': ('us', 'usec', 'microseconds'),
             'ns': ('ns', 'nsec', 'nsecs', 'nanosec', 'nanoseconds'),
             's': ('s', 'sec', 'secs', 'seconds')}}
"""How each unit of a column map is spelled at the end of a name, in words."""


@dataclass(frozen=True)
class Heading:
    """
    What a name says of its column.

    `pattern` has '{n}' where the name has the number of the joint; names without number have none.
    A name is `silent` if no word of it states the quantity, as in 'joint_3'.
    """

    column: str
    pattern: str
    words: frozenset[str]
    number: int | None
    kind: Kind | None
    unit: str | None
    silent: bool = False


def read_heading(column: str, about: str = '') -> Heading:
    """
    Return what the name of a column says.

    Where it states no quantity, that in the name of its table counts, `about`.
    """
    found = BRACKETED.match(column)
    name, bracketed = (found[1], found[2]) if found else (column, '')
    spelled = [word.lower() for word in WORD.findall(name) if not word.isdigit()]
    parts = [part for word in spelled for part in _parted(word)]
    ending = [word.lower() for word in WORD.findall(bracketed)] or parts
    kind = _kind({*parts, *map(_singular, parts)})
    if bracketed:
        kind = _of_unit(bracketed, column[len(name):].lstrip()[:1], ending, kind)
    unit, length = _unit(ending, kind)
    if unit and kind is None:
        kind = next(kind for kind, units in UNITS.items() if unit in units)
    if ending is parts:
        parts = parts[:len(parts) - length]
    words = [_singular(part) for part in parts]
    number, pattern = _numbered(column, name)
    silent = False
    if kind is None and number is not None and not bracketed:
        if SIDES_ALONE.union(NAMELESS).issuperset(words):
            kind = _of_table(about)
        silent = kind is None
        if silent and words and SIDES_ALONE.issuperset(words):
            kind = 'position'
    return Heading(column, pattern, frozenset(words), number, kind, unit, silent)


def _of_unit(bracketed: str, bracket: str, words: Sequence[str], kind: Kind | None) -> Kind | None:
    """Return the quantity whose unit stands in brackets; it counts more than words do."""
    kinds = [of for of in UNITS if any(' '.join(words) in spellings
                                       for spellings in UNITS[of].values())]
    if bracketed in OTHERS or bracket + bracketed in OTHERS:
        return kind if kind in kinds else None
    # A lower-case letter alone may be a mark, as in 'sensor (a)'.
    if not kinds or kind in kinds or len(bracketed) == 1 and bracketed not in ('A', 's'):
        return kind
    return kind if kind in MOVES and kinds[0] in MOVES else kinds[0]


def _of_table(about: str) -> Kind | None:
    """Return the one quantity that the name of a table states, None for none or several."""
    words = {word.lower() for word in WORD.findall(about)}
    kinds = {kind for word, kind in KINDS.items() if len(word) > 1 and kind != 'time'
             and word in {*words, *map(_singular, words)}}
    return kinds.pop() if len(kinds) == 1 else None


def _parted(word: str) -> tuple[str, ...]:
    """Return the side and the rest of a word that names both, such as 'motorpos'."""
    found = SIDED.match(word)
    return (found[1], found[2]) if found and found[2] in {*KINDS, *COUNTED} else (word,)


def _singular(word: str) -> str:
    """Return the singular of a word that looks like a plural."""
    if len(word) < SHORTEST or word.endswith(('ss', 'us', 'is')):
        return word
    return f'{word[:-3]}y' if word.endswith('ies') else word.removesuffix('s')


def _kind(words: Collection[str]) -> Kind | None:
    return next((kind for word, kind in KINDS.items() if word in words), None)


def _unit(words: Sequence[str], kind: Kind | None) -> tuple[str | None, int]:
    """Return the unit that the last words spell, of the kind if that is known, and how many."""
    for units in [UNITS[kind]] if kind else UNITS.values():
        for unit, spellings in units.items():
            for spelling in spellings:
                parts = spelling.split()
                # A letter alone is a unit beside a word that says what it is a unit of.
                if list(words[-len(parts):]) == parts and (kind or len(spelling) > 1):
                    return unit, len(parts)
    return None, 0


def _numbered(column: str, name: str) -> tuple[int | None, str]:
    """Return the number of the joint, the last one in the name, and the name with a gap for it."""
    numbers = list(re.finditer(r'\d+', name))
    if not numbers or '{' in column:
        return None, column
    last = numbers[-1]
    return int(last[0]), column[:last.start()] + '{n}' + column[last.end():]
