"""
The smallest size of an effect that a recording could have shown, and whether it is small enough.

It is small enough where a size that is typical of the effect would have been found. Of effects
that raw readings alone show no size is typical: any size will do.
"""

from typing import NamedTuple

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import Effect, effect_named, Scope
from hda_arm_sim.model.typical_sizes import SIZED, typical

from .report import Detectable
from ..fitting.hypotheses import HYPOTHESES

# The larger their number is.
WEAKER = tuple(name for name, sought in HYPOTHESES.items() if sought.weaker)


class Smallest(NamedTuple):
    """
    The smallest size of an effect at one place that shows, in one number of it.

    It is a change of that number, or for the effects of WEAKER the number itself. It is None where
    no size shows that the number may have.
    """

    effect: str
    joint: str | None
    number: str
    size: float | None

    def row(self) -> Detectable:
        """Return what the report states."""
        unit = effect_named(self.effect).declaration(self.number).unit
        return Detectable(self.effect, self.joint, self.size, unit, self.number)

    def is_shown(self, arm: Arm) -> bool:
        """Return whether the effect would have been found at a typical size."""
        if self.size is None or self.effect not in SIZED:
            return self.size is not None
        usual = typical(arm, self.effect, self.joint)
        if self.effect in WEAKER:
            return bool(getattr(usual, self.number) <= self.size)
        return _largest_change(usual, arm.effect(self.effect, self.joint)) >= self.size


def places(arm: Arm, name: str) -> tuple[str | None, ...]:
    """Return where an arm may have an effect: at each joint, or as a whole."""
    return (None,) if effect_named(name).scope is Scope.ARM else arm.labels


def hidden(name: str, joint: str | None) -> Smallest:
    """Return that no size of an effect shows."""
    return Smallest(name, joint, size_numbers(name)[0], None)


def size_numbers(name: str) -> tuple[str, ...]:
    """Return the numbers of an effect that say how large it is: of waves all amplitudes."""
    sought = HYPOTHESES.get(name)
    if sought is None:
        return (effect_named(name).declarations()[0].name,)
    return tuple(sought.free)[:1] or tuple(amplitude for amplitude, _ in sought.waves)


def _largest_change(usual: Effect, present: Effect) -> float:
    return max(abs(getattr(usual, number) - getattr(present, number))
               for number in size_numbers(usual.name))
