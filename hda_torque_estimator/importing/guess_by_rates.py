"""
Guess the joints of a table without names: speeds are columns that are the rates of others.

Angles of all joints stand side by side, and so do their speeds. Torques look like nothing else, so
they are left to whoever knows the table.
"""

from collections import Counter
from collections.abc import Sequence
from itertools import takewhile

from .headings import Heading
from .number_clues import angle_unit, Columns, Floats, numbers, radians, speed_unit
from .places import LINK_POSITION, LINK_VELOCITY, MapEntry, Pattern


def entries_by_rates(headings: Sequence[Heading], columns: Columns,
                     seconds: Floats) -> dict[str, MapEntry]:
    """Return angles and speeds of a table whose times [s] are known, nothing where none show."""
    pairs = _pairs([heading.column for heading in headings], columns, seconds)
    if not pairs:
        return {}
    stride = Counter(speed - angle for angle, speed, _ in pairs).most_common(1)[0][0]
    paired = [pair for pair in pairs if pair[1] - pair[0] == stride]
    block = [pair for place, pair in takewhile(
        lambda each: each[1][0] == paired[0][0] + each[0], enumerate(paired))]
    angles = [headings[angle] for angle, _, _ in block]
    speeds = [headings[speed] for _, speed, _ in block]
    return {
        LINK_POSITION: MapEntry((_pattern(angles),),
                                angle_unit(numbers(columns, angles[0].column)),
                                f'{speeds[0].column} is its rate'),
        LINK_VELOCITY: MapEntry((_pattern(speeds),), block[0][2],
                                f'the rate of {angles[0].column}')}


def _pairs(names: Sequence[str], columns: Columns,
           seconds: Floats) -> list[tuple[int, int, str]]:
    """Return places of angles and of what is their rate, with its unit; each stands once."""
    found: list[tuple[int, int, str]] = []
    for place, name in enumerate(names):
        values = numbers(columns, name)
        angle = radians(values, angle_unit(values))
        taken = {one for pair in found for one in pair[:2]}
        for other in range(place + 1, len(names)):
            if not {place, other} & taken and (unit := speed_unit(
                    numbers(columns, names[other]), angle, seconds)):
                found.append((place, other, unit))
                break
    return found


def _pattern(headings: Sequence[Heading]) -> Pattern:
    return Pattern(headings[0], {n: heading.column for n, heading in enumerate(headings, start=1)})
