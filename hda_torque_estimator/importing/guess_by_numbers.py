"""
Guess by the numbers in columns what their names leave open: units, sides and signs.

Every joint counts for itself: encoders count the other way at one joint and not at the next.
"""

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from .headings import Heading
from .number_clues import (angle_unit, Columns, FEWEST, Floats, is_whole, motor_over_link,
                           numbers, radians, rate_over, SAME, speed_unit, way_of_work)
from .places import (LINK, LINK_POSITION, LINK_VELOCITY, MapEntry, MOTOR, MOTOR_EFFORT,
                     MOTOR_POSITION, MOTOR_VELOCITY, NAMED_MOTORS)

LARGEST_RATIO = 1e4             # what a column map takes
LESS = 0.5                      # of the link's travel, that no motor behind a gear has
ALIKE = 5e-3                    # relative difference of ratios that are one
UNKNOWN_UNIT = '?'              # of an angle behind a gear of which nothing else is known


class Settling:
    """Go through the entries of a map, with the times of the rows [s] if they are known."""

    def __init__(self, columns: Columns, seconds: Floats, entries: dict[str, MapEntry]) -> None:
        """Take what the names say."""
        self.entries = dict(entries)
        self._columns, self._seconds = columns, seconds

    def settle(self) -> dict[int, float]:
        """Complete units, sides and signs; return the gear ratios that can be seen, by joint."""
        self._settle_angles()
        if self._is_no_motor():
            del self.entries[MOTOR_POSITION]
        if self._are_swapped():
            self._swap()
            self._settle_angles()
        for place in (MOTOR_VELOCITY, LINK_VELOCITY):
            if place in self.entries and not self._heading(place).unit:
                self._settle_speed(place)
        self._settle_links()
        ratios = self._settle_sides()
        for place in (MOTOR_VELOCITY, LINK_VELOCITY):
            self._settle_way(place)
        self._settle_effort()
        return ratios

    def fits_speeds(self) -> bool:
        """Return whether some speeds are the rates of their angles at these times."""
        self._settle_angles()
        return any(self._rate_unit(place) is not None for place in (MOTOR_VELOCITY, LINK_VELOCITY))

    def _settle_angles(self) -> None:
        for place in (LINK_POSITION, MOTOR_POSITION):
            if place in self.entries and not self._heading(place).unit:
                self._settle_angle(place)

    def _settle_angle(self, place: str) -> None:
        """State the unit of each angle: counts by their own numbers, all others alike."""
        columns = {n: self._column(place, n) for n in self._joints(place)}
        by_size_of = {n: angle_unit(values) for n, values in columns.items()}
        counting = 'count' in by_size_of.values()
        units = {n: 'count' if unit == 'count' or counting and is_whole(columns[n]) else ''
                 for n, unit in by_size_of.items()}
        by_size = 'deg' if 'deg' in (by_size_of[n] for n in units if not units[n]) else 'rad'
        for n in (n for n in units if not units[n]):
            units[n] = by_size if place == LINK_POSITION else self._as_the_link(n)
        reason = 'unit by its size' + (
            '; no name says that it is an angle' * self._heading(place).silent)
        if place == MOTOR_POSITION and 'count' not in units.values():
            reason = 'unit as the link' if LINK_POSITION in self.entries else (
                self.entries[place].reason)
        if UNKNOWN_UNIT in units.values():
            reason = 'behind a gear the size of an angle does not show its unit'
        self._state(place, 'unit', units, reason=reason)

    def _as_the_link(self, joint: int) -> str:
        """Return the unit of a motor's angle; behind a gear its size says nothing."""
        link = self.entries.get(LINK_POSITION)
        if link is None or joint not in link.patterns[0].columns:
            return 'rad'
        unit = link.unit_of(joint)
        return UNKNOWN_UNIT if unit == 'count' else unit

    def _settle_speed(self, place: str) -> None:
        """State the unit in which speeds are the rates of angles, by the joint that moves most."""
        if found := self._rate_unit(place):
            self._change(place, unit=found, reason='unit by the rate of the angle')

    def _rate_unit(self, place: str) -> str | None:
        """Return the unit in which speeds are the rates of angles, None where they are not."""
        position = place.replace('velocity', 'position')
        if not self.entries.keys() >= {place, position}:
            return None
        joint = max(self._joints(position), key=lambda n: _travel(self._column(position, n)))
        angle = radians(self._column(position, joint), self.entries[position].unit_of(joint))
        speed = self._column(place, joint)
        return (speed_unit(speed, angle, self._seconds)
                or speed_unit(-speed, angle, self._seconds))

    def _settle_sides(self) -> dict[int, float]:
        """State the motor where it moves as far as the link, else return the gear ratios."""
        if LINK_POSITION in self.entries and MOTOR_POSITION not in self.entries:
            self._at_link((MOTOR_EFFORT,), 'as the angles')
            self._move_the_only_angle()
        slopes = self._slopes()
        if not slopes:
            return {}
        self._settle_ways(slopes)
        known = {n: abs(slope) for n, slope in slopes.items() if self._is_in_units(n)}
        if known and abs(float(np.median([*known.values()])) - 1.0) < SAME:
            self._at_link((MOTOR_POSITION, MOTOR_VELOCITY, MOTOR_EFFORT),
                          'moves as far as the link')
            return {}
        return self._rounded({n: slope for n, slope in known.items()
                              if 1.0 < slope < LARGEST_RATIO})

    def _move_the_only_angle(self) -> None:
        """Take the only angle of a joint whose motor has a torque for that of the motor."""
        if MOTOR_EFFORT not in self.entries:
            return
        for one, other in ((LINK_POSITION, MOTOR_POSITION), (LINK_VELOCITY, MOTOR_VELOCITY)):
            if one in self.entries and other not in self.entries:
                self.entries[other] = self.entries.pop(one)
                self._at_link((other,), 'the only angle, of a rigid gear')

    def _is_no_motor(self) -> bool:
        """Return whether a motor that no word names does not follow the link, where that moves."""
        if not self.entries.keys() >= {MOTOR_POSITION, LINK_POSITION} or (
                self._heading(MOTOR_POSITION).words & (MOTOR | NAMED_MOTORS)):
            return False
        moving = any(_travel(self._column(LINK_POSITION, n)) for n in self._joints(MOTOR_POSITION))
        return moving and not self._slopes()

    def _settle_links(self) -> None:
        """State the sign of links that run against their speed, which is the joint's own way."""
        if not self.entries.keys() >= {LINK_POSITION, LINK_VELOCITY}:
            return
        slopes = {n: rate_over(self._column(LINK_VELOCITY, n), self._column(LINK_POSITION, n),
                               self._seconds) or 1.0 for n in self._joints(LINK_POSITION)}
        if against := sorted(n for n, slope in slopes.items() if slope < 0.0):
            self._state(LINK_POSITION, 'sign', {n: -1 if n in against else 1 for n in slopes},
                        reason=f'{self.entries[LINK_POSITION].reason}; it runs against the speed '
                               f'of the joint{_of(against, slopes)}')

    def _settle_ways(self, slopes: Mapping[int, float]) -> None:
        """State the sign of each motor that moves, and say which do not."""
        against = sorted(n for n, slope in slopes.items() if slope < 0.0)
        still = sorted(set(self._joints(MOTOR_POSITION)) - set(slopes))
        reason = self.entries[MOTOR_POSITION].reason
        if against:
            reason += '; it runs against the link' + _of(against, slopes)
        if still:
            reason += f'; its sign is not known{_of(still, ())}, too little moves'
        self._state(MOTOR_POSITION, 'sign',
                    {n: self._sign(LINK_POSITION, n) * (-1 if n in against else 1)
                     for n in self._joints(MOTOR_POSITION)},
                    reason=reason)

    def _settle_way(self, place: str) -> None:
        """Give speeds the sign with which they are the rates of the angles."""
        position = place.replace('velocity', 'position')
        if not self.entries.keys() >= {place, position}:
            return
        signs = {}
        for n in self._joints(place):
            slope = rate_over(self._column(place, n), self._column(position, n), self._seconds)
            signs[n] = self._sign(position, n) * (-1 if (slope or 1.0) < 0.0 else 1)
        self._state(place, 'sign', signs)

    def _settle_effort(self) -> None:
        """State the sign of efforts that take work from the motion which they should drive."""
        position = next((place for place in (MOTOR_POSITION, LINK_POSITION)
                         if place in self.entries), None)
        if MOTOR_EFFORT not in self.entries or position is None:
            return
        joints = self._joints(MOTOR_EFFORT)
        ways = {n: way_of_work(self._column(MOTOR_EFFORT, n),
                               self._sign(position, n) * self._column(position, n))
                for n in joints}
        if against := sorted(n for n, way in ways.items() if way == -1):
            self._state(MOTOR_EFFORT, 'sign', {n: way or 1 for n, way in ways.items()},
                        reason=f'{self.entries[MOTOR_EFFORT].reason}; it takes work from the '
                               f'motion{_of(against, joints)}')

    def _slopes(self) -> dict[int, float]:
        """Return how far each motor moves for one of its link, where both move."""
        if not self.entries.keys() >= {MOTOR_POSITION, LINK_POSITION}:
            return {}
        slopes = {}
        for n in self._joints(MOTOR_POSITION):
            motor, link = (radians(self._column(place, n), self._si(place, n))
                           for place in (MOTOR_POSITION, LINK_POSITION))
            if (slope := motor_over_link(motor, link)) is not None:
                slopes[n] = slope
        return slopes

    def _are_swapped(self) -> bool:
        """Return whether what was taken for the motor moves less than the link."""
        slopes = self._slopes()
        silent = not any(self._heading(place).words & (MOTOR | LINK)
                         for place in (MOTOR_POSITION, LINK_POSITION) if place in self.entries)
        known = [abs(slope) for n, slope in slopes.items() if self._is_in_units(n) or silent and
                 {self._si(MOTOR_POSITION, n), self._si(LINK_POSITION, n)} == {'count'}]
        return bool(known) and float(np.median(known)) < LESS

    def _swap(self) -> None:
        """Take the link for the motor, and the motor for the link."""
        for one, other in ((MOTOR_POSITION, LINK_POSITION), (MOTOR_VELOCITY, LINK_VELOCITY)):
            if self.entries.keys() >= {one, other}:
                self.entries[one], self.entries[other] = self.entries[other], self.entries[one]
        for place, moves in ((MOTOR_POSITION, 'more'), (LINK_POSITION, 'less')):
            self._change(place, reason=f'{self.entries[place].reason}; it moves {moves}')

    def _is_in_units(self, joint: int) -> bool:
        """Return whether the travel of both sides of a joint can be compared."""
        return not {'count', UNKNOWN_UNIT} & {self._si(MOTOR_POSITION, joint),
                                              self._si(LINK_POSITION, joint)}

    def _si(self, place: str, joint: int) -> str:
        return self.entries[place].unit_of(joint)

    def _sign(self, place: str, joint: int) -> int:
        return self.entries[place].sign_of(joint)

    def _rounded(self, ratios: Mapping[int, float]) -> dict[int, float]:
        """Return ratios to a tenth; where they are alike, that of the joint that moves most."""
        if not ratios:
            return {}
        joint = max(ratios, key=lambda n: _travel(self._column(LINK_POSITION, n)))
        if all(abs(ratio / ratios[joint] - 1.0) < ALIKE for ratio in ratios.values()):
            return dict.fromkeys(self._joints(LINK_POSITION), round(ratios[joint], 1))
        return {n: round(ratio, 1) for n, ratio in ratios.items()}

    def _at_link(self, places: Iterable[str], why: str) -> None:
        for place in places:
            if place in self.entries and self._heading(place).kind != 'current':
                self._change(place, side='link',
                             reason=f'{self.entries[place].reason}; at the link side: {why}')

    def _joints(self, place: str) -> tuple[int, ...]:
        """Return the numbers of the joints at a place, 0 for names without number."""
        return tuple(self.entries[place].patterns[0].columns)

    def _column(self, place: str, joint: int) -> Floats:
        columns = self.entries[place].patterns[0].columns
        if joint not in columns:
            return np.full(len(numbers(self._columns, next(iter(columns.values())))), np.nan)
        return numbers(self._columns, columns[joint])

    def _heading(self, place: str) -> Heading:
        return self.entries[place].patterns[0].heading

    def _state(self, place: str, what: str, values: Mapping[int, str] | Mapping[int, int],
               **changes: Any) -> None:
        """State a unit or a sign of every joint: the usual one, and those that are others."""
        usual = Counter(values.values()).most_common(1)[0][0]
        others = {n: value for n, value in values.items() if value != usual}
        self._change(place, **{what: usual, f'{what}s': others}, **changes)

    def _change(self, place: str, **changes: Any) -> None:
        self.entries[place] = replace(self.entries[place], **changes)


def _travel(values: Floats) -> float:
    known = values[np.isfinite(values)]
    return float(np.ptp(known)) if known.size >= FEWEST else 0.0


def _of(joints: Iterable[int], all_of: Iterable[int]) -> str:
    """Return words for some of the joints, none for all of them."""
    some = list(joints)
    return '' if some == sorted(all_of) else f' at {", ".join(map(str, some))}'
