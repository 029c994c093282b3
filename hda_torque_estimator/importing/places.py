"""
Which columns belong to which place of a column map, by their names.

Every pattern of names (`motor_pos_{n}`) is weighed for every place, the best pair is taken, then
the best of what is left.
"""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field

from .headings import Heading

MOTOR = frozenset({'motor', 'mot', 'm', 'shaft', 'rotor', 'input', 'hs',
                   'antrieb', 'moteur', 'motore'})
LINK = frozenset({'link', 'l', 'load', 'output', 'out', 'arm', 'ls', 'joint', 'secondary',
                  'abtrieb', 'gelenk', 'bras', 'giunto', 'braccio', 'brazo'})
SENSOR = frozenset({'sensor', 'sens', 'sensed', 'jts', 'ext', 'transducer', 'cell', 'gauge'})
COMMAND = frozenset({'cmd', 'command', 'commanded', 'set', 'setpoint', 'des', 'desired', 'target',
                     'ref', 'reference', 'goal'})
TARGET = frozenset({'target', 'ref', 'reference', 'goal'})
NEVER = frozenset({'temp', 'temperature', 'volt', 'voltage', 'power', 'error', 'err', 'std', 'var',
                   'flag', 'status', 'id', 'acc', 'accel', 'acceleration', 'brake', 'supply',
                   'enable', 'enabled', 'limit', 'latency',
                   'ee', 'eef', 'tcp', 'tool', 'flange', 'cartesian', 'quat', 'quaternion',
                   'inertia', 'computed', 'cmptd', 'model', 'est', 'estimated', 'predicted'})
ENCODER = frozenset({'enc', 'encoder'})
NAMED_MOTORS = ENCODER | {'theta', 'dtheta', 'thetadot'}       # as in papers, beside q
MOTOR_POSITION, MOTOR_VELOCITY, MOTOR_EFFORT = 'motor.position', 'motor.velocity', 'motor.effort'
LINK_POSITION, LINK_VELOCITY, REFERENCE = 'link.position', 'link.velocity', 'reference'
PLACES = (MOTOR_POSITION, MOTOR_VELOCITY, MOTOR_EFFORT, LINK_POSITION, LINK_VELOCITY, REFERENCE)


UNITS = {'position': 'rad', 'velocity': 'rad/s', 'torque': 'N*m', 'current': 'A'}
"""What a column of each kind is in unless it says something else."""


@dataclass(frozen=True)
class Pattern:
    """Columns whose names differ in the number of the joint only."""

    heading: Heading                        # of the first of them
    columns: Mapping[int, str]              # by number; 0 where names have none

    @property
    def name(self) -> str:
        """Return the name with '{n}' for the number."""
        return self.heading.pattern

    @property
    def is_numbered(self) -> bool:
        """Return whether the names have the numbers of the joints."""
        return all(number in (0, _number_in(name, self.name))
                   for number, name in self.columns.items())


@dataclass(frozen=True)
class MapEntry:
    """What is guessed for one place of the map, and why."""

    patterns: tuple[Pattern, ...]
    unit: str
    reason: str
    others: tuple[str, ...] = ()            # patterns that the place might mean as well
    side: str | None = None                 # where it is not the place's own
    sign: int = 1
    units: Mapping[int, str] = field(default_factory=dict)      # of joints that have another
    signs: Mapping[int, int] = field(default_factory=dict)

    def unit_of(self, joint: int) -> str:
        """Return the unit of a joint's column."""
        return self.units.get(joint, self.unit)

    def sign_of(self, joint: int) -> int:
        """Return the sign of a joint's column."""
        return self.signs.get(joint, self.sign)


def _number_in(name: str, pattern: str) -> int | None:
    before, _, after = pattern.partition('{n}')
    digits = name.removeprefix(before).removesuffix(after)
    return int(digits) if digits.isdecimal() else None


def weight(heading: Heading, place: str) -> float:
    """Return how likely a column of this name belongs to a place, 0 where it does not."""
    words, kind = heading.words, heading.kind
    quantity = place.rpartition('.')[2]
    if words & NEVER or kind in (None, 'time'):
        return 0.0
    motor, link = bool(words & MOTOR), bool(words & LINK) and not words & MOTOR
    if quantity in ('position', 'velocity'):
        if kind != quantity or words & COMMAND:
            return 0.0
        if motor or link:
            return 3.0 + 0.1 * bool(words & ENCODER) if motor == place.startswith('motor') else 0.0
        if place.startswith('link'):
            return 2.0 if words & {'q', 'dq', 'qd', 'qdot'} else 1.0
        return 0.9 if words & NAMED_MOTORS else 0.5
    if place == REFERENCE:
        measured = kind == 'torque' and not words & COMMAND
        return (3.0 if words & SENSOR else 1.2 if link else 0.0) if measured else 0.0
    if kind not in ('torque', 'current') or words & SENSOR or (
            kind == 'current' and words & COMMAND):
        return 0.0
    asked = 0.4 * bool(words & TARGET) or 0.1 * bool(words & COMMAND)   # measured is better
    return (2.0 if kind == 'torque' else 1.0) + motor - 0.7 * link - asked


def patterns_of(headings: Iterable[Heading]) -> list[Pattern]:
    """Return the columns of joints by their patterns; numbered ones alone if there are any."""
    found: dict[str, dict[int, str]] = {}
    first: dict[str, Heading] = {}
    for heading in headings:
        if any(weight(heading, place) for place in PLACES):
            first.setdefault(heading.pattern, heading)
            found.setdefault(heading.pattern, {})[heading.number or 0] = heading.column
    numbered = any(heading.number is not None for heading in first.values())
    return [Pattern(heading, dict(sorted(found[name].items())))
            for name, heading in first.items() if not numbered or heading.number is not None]


def entries_by_name(patterns: list[Pattern]) -> dict[str, MapEntry]:
    """Return the best pattern for every place, none for two."""
    weighed = sorted(((weight(pattern.heading, place), len(pattern.columns), -order, place)
                      for place in PLACES for order, pattern in enumerate(patterns)), reverse=True)
    taken: dict[str, Pattern] = {}
    for worth, _, order, place in weighed:
        pattern = patterns[-order]
        if worth > 0.0 and place not in taken and pattern not in taken.values():
            taken[place] = pattern
    return {place: _entry(place, taken[place], patterns, taken.values())
            for place in PLACES if place in taken}


def _entry(place: str, pattern: Pattern, patterns: list[Pattern],
           taken: Collection[Pattern]) -> MapEntry:
    heading = pattern.heading
    alike = [other for other in patterns if _redundant(other, pattern)]
    left = [other for other in patterns if other not in alike and other not in taken
            and weight(other.heading, place)]
    others = sorted(left, key=lambda other: -weight(other.heading, place))
    unit = heading.unit or UNITS[str(heading.kind)]
    reason = 'unit by its name' if heading.unit else 'the unit is not stated'
    return MapEntry((pattern, *alike), unit, reason, tuple(other.name for other in others))


def _redundant(other: Pattern, pattern: Pattern) -> bool:
    """Return whether patterns name two like sensors: 'sensor_a' and 'sensor_b'."""
    one, two = other.heading.words, pattern.heading.words
    letters = one ^ two
    return (len(letters) == 2 and all(len(word) == 1 for word in letters) and bool(one & SENSOR)
            and set(other.columns) == set(pattern.columns) and letters != {'m', 'l'})
