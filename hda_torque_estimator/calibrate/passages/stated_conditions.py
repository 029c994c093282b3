"""What the user states of a recording: how the base stood and what hung at the tip."""

from collections.abc import Sequence
from dataclasses import replace
import math
from pathlib import Path
from typing import Any, NamedTuple

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects.catalogue import sole_at
from hda_arm_sim.model.effects.place import LOAD

from .joint_recording import CalibrationError

# Choices unless stated otherwise.
STEEPEST = 90.0         # tilt that may be stated [degrees]
HEAVIEST = 100.0        # payload that may be stated [kg]


class StatedConditions(NamedTuple):
    """What is known of one recording beyond the arm file, None where nothing is stated."""

    tilt: tuple[float, float] | None = None     # of the base and its downhill direction [rad]
    payload: float | None = None                # point mass at the tip [kg]

    def on(self, arm: Arm) -> Arm:
        """Return the arm as it stood in the recording."""
        if self.tilt is not None:
            arm = replace(arm, base=replace(arm.base, tilt=self.tilt[0], direction=self.tilt[1]))
        if self.payload is not None:
            carried: Any = arm.effect(sole_at(LOAD).name)
            arm = arm.with_effect(type(carried)(mass=self.payload))
        return arm

    def sentence(self) -> str:
        """Return what is stated in words, '' for nothing."""
        words = []
        if self.tilt is not None:
            words.append(f'a tilt of {math.degrees(self.tilt[0]):g} degrees')
        if self.payload is not None:
            words.append(f'a payload of {self.payload:g} kg')
        return ' and '.join(words)


def stated(bags: Sequence[Path], tilts: Sequence[Sequence[str]],
           payloads: Sequence[Sequence[str]]) -> list[StatedConditions]:
    """
    Return what is stated of each bag: tilts (bag, degrees, direction), payloads (bag, kg).

    Raises CalibrationError naming what cannot be meant.
    """
    found = [StatedConditions() for _ in bags]
    for bag, degrees, direction in tilts:
        angle = _number('--tilt', degrees, STEEPEST)
        towards = _number('--tilt direction', direction, 360.0, -360.0)
        place = _place(bags, bag, '--tilt')
        found[place] = found[place]._replace(tilt=(math.radians(angle), math.radians(towards)))
    for bag, mass in payloads:
        place = _place(bags, bag, '--payload')
        found[place] = found[place]._replace(payload=_number('--payload', mass, HEAVIEST))
    return found


def _place(bags: Sequence[Path], asked: str, option: str) -> int:
    """Return which of the bags is meant, by its path or its name."""
    places = [place for place, bag in enumerate(bags) if asked in (str(bag), bag.name)]
    if len(places) != 1:
        raise CalibrationError(f'{option} names {asked!r}, which must be one of the bags: '
                               f'{", ".join(bag.name for bag in bags)}')
    return places[0]


def _number(what: str, text: str, high: float, low: float = 0.0) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not low <= value <= high:
        raise CalibrationError(f'{what} must be a number in [{low:g}, {high:g}], got {text!r}')
    return value
