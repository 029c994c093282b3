"""Settle by the numbers in the columns what their names leave open: units, sides and signs."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from .headings import Heading
from .places import (Entry, LINK_POSITION, LINK_VELOCITY, MOTOR_EFFORT, MOTOR_POSITION,
                     MOTOR_VELOCITY)
from .sightings import (angle_unit, Columns, FEWEST, Floats, motor_over_link, numbers, radians,
                        SAME, speed_unit)

LARGEST_RATIO = 1e4             # what a column map takes


class Settling:
    """Go through the entries of a map, with the times of the rows [s] if they are known."""

    def __init__(self, columns: Columns, seconds: Floats, entries: dict[str, Entry]) -> None:
        """Take what the names say."""
        self.entries = dict(entries)
        self._columns, self._seconds = columns, seconds

    def settle(self) -> float | None:
        """Complete units and sides; return the gear ratio if it can be seen."""
        for place in (LINK_POSITION, MOTOR_POSITION):
            if place in self.entries and not self._heading(place).unit:
                self._settle_angle(place)
        for place in (MOTOR_VELOCITY, LINK_VELOCITY):
            if place in self.entries and not self._heading(place).unit:
                self._settle_speed(place)
        return self._settle_sides()

    def _settle_angle(self, place: str) -> None:
        unit = angle_unit(self._column(place, self._moving(place)))
        if place == LINK_POSITION or unit == 'count':
            self._change(place, unit=unit, reason='unit by its size')
        elif LINK_POSITION in self.entries and self.entries[LINK_POSITION].unit != 'count':
            # Behind a gear the size of an angle says nothing.
            self._change(place, unit=self.entries[LINK_POSITION].unit, reason='unit as the link')

    def _settle_speed(self, place: str) -> None:
        position = place.replace('velocity', 'position')
        if position not in self.entries:
            return
        joint = self._moving(position)
        angle = radians(self._column(position, joint), self.entries[position].unit)
        if unit := speed_unit(self._column(place, joint), angle, self._seconds):
            self._change(place, unit=unit, reason='unit by the rate of the angle')

    def _settle_sides(self) -> float | None:
        """State the motor where it moves as far as the link, else see the gear ratio."""
        if LINK_POSITION in self.entries and MOTOR_POSITION not in self.entries:
            self._at_link((MOTOR_EFFORT,), 'as the angles')
        if not self.entries.keys() >= {MOTOR_POSITION, LINK_POSITION}:
            return None
        joint = self._moving(LINK_POSITION)
        motor, link = (radians(self._column(place, joint), self.entries[place].unit)
                       for place in (MOTOR_POSITION, LINK_POSITION))
        slope = motor_over_link(motor, link)
        if slope is None or 'count' in (self.entries[MOTOR_POSITION].unit,
                                        self.entries[LINK_POSITION].unit):
            return None
        if slope < 0.0:
            reason = f'{self.entries[MOTOR_POSITION].reason}; it runs against the link'
            self._change(MOTOR_POSITION, sign=-1, reason=reason)
        if abs(abs(slope) - 1.0) < SAME:
            self._at_link((MOTOR_POSITION, MOTOR_VELOCITY, MOTOR_EFFORT),
                          'moves as far as the link')
            return None
        return round(abs(slope), 1) if 1.0 < abs(slope) < LARGEST_RATIO else None

    def _at_link(self, places: Iterable[str], why: str) -> None:
        for place in places:
            if place in self.entries and self._heading(place).kind != 'current':
                self._change(place, side='link',
                             reason=f'{self.entries[place].reason}; at the link side: {why}')

    def _moving(self, place: str) -> int:
        """Return the number of the joint that moves most, 0 for names without number."""
        columns = self.entries[place].patterns[0].columns
        return max(columns, key=lambda n: _travel(numbers(self._columns, columns[n])))

    def _column(self, place: str, joint: int) -> Floats:
        columns = self.entries[place].patterns[0].columns
        if joint not in columns:
            return np.full(len(numbers(self._columns, next(iter(columns.values())))), np.nan)
        return numbers(self._columns, columns[joint])

    def _heading(self, place: str) -> Heading:
        return self.entries[place].patterns[0].heading

    def _change(self, place: str, **changes: object) -> None:
        self.entries[place] = replace(self.entries[place], **changes)   # type: ignore[arg-type]


def _travel(values: Floats) -> float:
    known = values[np.isfinite(values)]
    return float(np.ptp(known)) if known.size >= FEWEST else 0.0
