"""The skeleton of an arm in a posture: straight pieces between its joints, in the base frame."""

from collections.abc import Sequence
from math import cos, sin

from hda_arm_sim.foundation.chain import OFFSET, ROTATION
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.chain_links import ChainLinks
import numpy as np

Point = tuple[float, float, float]
Piece = tuple[Point, Point]

SPACING = 0.3       # between the dials of joints whose place is not known: a choice [m]
POINTER = 0.2       # length of the pointer of such a dial: a choice [m]


def stance(arm: Arm, angles: Sequence[float]) -> list[Piece]:
    """
    Return the piece of every joint [m]: from its axis to the next one, the last to the tip.

    `angles` are those of the links [rad]. Without links each joint is a dial in a row.
    """
    if arm.links is None:
        return [_dial(place, angle) for place, angle in enumerate(angles)]
    if isinstance(arm.links, ChainLinks):
        return _of_chain(arm.links, angles)
    pieces: list[Piece] = []
    begin, heading = (0.0, 0.0, 0.0), 0.0
    for length, angle in zip((arm.links.length1, arm.links.length2), angles):
        heading += angle
        end = (begin[0] + length * cos(heading), begin[1] + length * sin(heading), 0.0)
        pieces.append((begin, end))
        begin = end
    return pieces


def _of_chain(links: ChainLinks, angles: Sequence[float]) -> list[Piece]:
    """Return the pieces of a chain: each joint turns about the z axis of its frame."""
    place, turned = np.zeros(3), np.eye(3)
    places = []
    for row, angle in zip(links.parts[1:], (*angles, 0.0)):
        place = place + turned @ row[OFFSET:OFFSET + 3]
        places.append((float(place[0]), float(place[1]), float(place[2])))
        spin = np.array([[cos(angle), -sin(angle), 0.0], [sin(angle), cos(angle), 0.0],
                         [0.0, 0.0, 1.0]])
        turned = turned @ row[ROTATION:ROTATION + 9].reshape(3, 3) @ spin
    return list(zip(places, places[1:]))


def _dial(place: int, angle: float) -> Piece:
    x = place * SPACING
    return (x, 0.0, 0.0), (x + POINTER * cos(angle), POINTER * sin(angle), 0.0)
