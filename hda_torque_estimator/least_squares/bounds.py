"""What numbers an arm file takes: their declarations by name, and numbers put into an arm."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from hda_arm_sim.foundation.parameter import Declaration, Declared
from hda_arm_sim.model.arm import Arm, Placed
from hda_arm_sim.model.effects import Effect, effect_named
from hda_arm_sim.model.parts import Encoder, Joint
from hda_arm_sim.model.torsion import TorsionLaw

# The numbers of the joint itself have no owner: `motor_deviation`.
PARTS: dict[str, type[Declared]] = {'': Joint, 'torsion': TorsionLaw, 'link_encoder': Encoder,
                                    'motor_encoder': Encoder}
# Choices unless stated otherwise.
APART = 1.01            # least ratio of two knees, which must differ


def declaration(name: str) -> Declaration:
    """Return the declaration of a number such as `torsion.knee_1`; raises ParameterError."""
    owner, _, field = name.rpartition('.')
    kind: type[Declared] = PARTS[owner] if owner in PARTS else effect_named(owner)
    return kind.declaration(field)


def bounded(kind: type[Declared], numbers: Mapping[str, float]) -> dict[str, float]:
    """
    Return numbers of a kind by name, each at the nearest value that the arm file takes.

    A search may try what no arm can be; it is then at the bound, and the report says so.
    """
    found = {}
    for name, value in numbers.items():
        rule = kind.declaration(name)
        found[name] = min(max(float(value), rule.low), rule.high)
    if 'knee_2' in found:
        found['knee_1'] = min(found['knee_1'], found['knee_2'] / APART)
    return found


class Placing:
    """An arm with other numbers in the making: it is made and checked once, when all stand."""

    def __init__(self, arm: Arm) -> None:
        """Begin with an arm."""
        self._given = arm
        self._joints = {joint.label: joint for joint in arm.joints}
        self._effects = {(one.effect.name, one.joint): one for one in arm.effects}

    def place(self, effect: Effect, label: str | None) -> None:
        """Put an effect in the place of any other of its name."""
        place = effect.name, label
        self._effects.pop(place, None)
        self._effects[place] = Placed(effect, label)

    def alter(self, label: str, change: Callable[[Joint], Joint]) -> None:
        """Put what becomes of a joint in its place."""
        self._joints[label] = change(self._joints[label])

    def enter(self, label: str, numbers: Mapping[str, float]) -> None:
        """Put numbers such as `torsion.knee_1` in the place of those of a joint."""
        fields: dict[str, dict[str, Any]] = {}
        for name, value in numbers.items():
            owner, _, field = name.rpartition('.')
            fields.setdefault(owner, {})[field] = value
        self._given.joint(label)                # raises ArmError where there is none
        joint = self._joints[label]
        own = fields.pop('', {})
        parts = {owner: replace(getattr(joint, owner), **fields.pop(owner))
                 for owner in PARTS if owner in fields}
        for owner, values in fields.items():
            placed = self._effects.get((owner, label))
            self.place(replace(placed.effect if placed else joint.nominal(effect_named(owner)),
                               **values), label)
        if own or parts:
            self._joints[label] = replace(joint, **own, **parts)

    def arm(self) -> Arm:
        """Return the arm as it stands now; raises ArmError for one that cannot be."""
        return replace(self._given, joints=tuple(self._joints.values()),
                       effects=tuple(self._effects.values()))


def entered(arm: Arm, label: str, numbers: Mapping[str, float]) -> Arm:
    """Return an arm with numbers such as `torsion.knee_1` in the place of those of a joint."""
    made = Placing(arm)
    made.enter(label, numbers)
    return made.arm()
