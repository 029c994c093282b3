"""Sizes at which effects are worth finding: those of a drive that is neither new nor broken."""

from .arm import Arm
from .effects import Effect, effect_named, EFFECTS
from .effects.hypothesis import Typical
from .effects.place import BEARING, GEAR, LINK_TORQUE, LOOP

_LIMIT, _RATIO = 0.3, 100.0     # motor torque [N*m] and gear ratio of the axis that sizes are for
_BEHIND_GEAR = (LOOP, GEAR, BEARING, LINK_TORQUE)
SIZED = tuple(effect.name for effect in EFFECTS if effect.typical is not None)


def typical(arm: Arm, name: str, joint: str | None) -> Effect:
    """
    Return an effect of SIZED on an arm at a typical size, on top of what the arm has of it.

    Torques grow with what the joint's motor can give. Raises ArmError for a wrong place.
    """
    present, kind = arm.effect(name, joint), effect_named(name)
    usual, values = kind.typical or Typical({}), {}
    for numbers, on_top in ((usual.more, True), (usual.shape, False)):
        for number, size in numbers.items():
            rule, scaled = kind.declaration(number), scaled_size(arm, kind, joint, number, size)
            wanted = getattr(present, number) + scaled if on_top else scaled
            values[number] = min(max(wanted, rule.low), rule.high)
    kept = {rule.name: getattr(present, rule.name) for rule in kind.declarations()}
    return kind(**{**kept, **values})


def scaled_size(arm: Arm, kind: type[Effect], joint: str | None, number: str,
                size: float) -> float:
    """Return a size of an effect's number as it is at a joint: torques grow with the motor's."""
    is_torque = kind.declaration(number).unit.startswith('N*m')
    return size * _strength(arm, kind, joint) if is_torque else size


def _strength(arm: Arm, kind: type[Effect], joint: str | None) -> float:
    """Return how strong a joint is beside the one that sizes are stated for."""
    if joint is None:
        return 1.0
    axis = arm.joint(joint)
    gear = axis.ratio / _RATIO if kind.place in _BEHIND_GEAR else 1.0
    return axis.torque_limit / _LIMIT * gear
