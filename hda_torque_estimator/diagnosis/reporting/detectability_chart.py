"""The chart of detectability: by site, the smallest size of each effect over its typical size."""

from collections.abc import Sequence
from dataclasses import dataclass
import math

from hda_arm_sim.model.effects import EFFECTS

from ..findings.report import Detectable
from ..findings.smallest import WEAKER
from ...pages.wording import spoken

# Numerics; choices unless stated otherwise.
_DECADES = 3.0          # shown on both sides of the typical size
_BY_NAME = {effect.name: effect for effect in EFFECTS}


@dataclass(frozen=True)
class Dot:
    """The smallest size of an effect at a joint; `place` is in [0, 1], None if it never shows."""

    joint: str | None
    place: float | None
    seen: bool                      # below the size at which it is worth finding


@dataclass(frozen=True)
class Row:
    """An effect and a dot for each joint."""

    effect: str
    dots: tuple[Dot, ...]


def by_site(sizes: Sequence[Detectable]) -> dict[str, list[Row]]:
    """Return a row for every effect under its site, in the order of the catalogue."""
    found: dict[str, list[Row]] = {}
    for effect in EFFECTS:
        own = [one for one in sizes if one.effect == effect.name]
        if own:
            found.setdefault(effect.site.value, []).append(
                Row(spoken(effect.name), tuple(map(_dot, own))))
    return found


def _dot(size: Detectable) -> Dot:
    if size.smallest_detectable is None:
        return Dot(size.joint, None, False)
    usual = _usual(size)
    if not usual or size.smallest_detectable <= 0.0:
        return Dot(size.joint, 0.5, True)
    decades = math.log10(size.smallest_detectable / usual)
    if size.effect in WEAKER:
        decades = -decades
    place = min(max(0.5 + 0.5 * decades / _DECADES, 0.0), 1.0)
    return Dot(size.joint, place, decades < 0.0)


def _usual(size: Detectable) -> float:
    """Return the typical size of an effect in the same unit, 0 where it has none."""
    kind = _BY_NAME[size.effect]
    if kind.typical is None:
        return 0.0
    units = {rule.name: rule.unit for rule in kind.declarations()}
    return max((abs(value) for name, value in {**kind.typical.more, **kind.typical.shape}.items()
                if units[name] == size.unit or (not units[name] and size.unit == '1')),
               default=0.0)
