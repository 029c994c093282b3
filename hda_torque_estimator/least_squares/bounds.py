"""What numbers an arm file takes: their declarations by name, and numbers put into an arm."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from hda_arm_sim.foundation.parameter import Declaration, Declared
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import effect_named
from hda_arm_sim.model.parts import Encoder, Joint
from hda_arm_sim.model.torsion import TorsionLaw

# The numbers of the joint itself have no owner: `motor_deviation`.
PARTS: dict[str, type[Declared]] = {'': Joint, 'torsion': TorsionLaw, 'link_encoder': Encoder}
# Choices unless told otherwise.
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


def entered(arm: Arm, label: str, numbers: Mapping[str, float]) -> Arm:
    """Return an arm with numbers such as `torsion.knee_1` in the place of those of a joint."""
    fields: dict[str, dict[str, Any]] = {}
    for name, value in numbers.items():
        owner, _, field = name.rpartition('.')
        fields.setdefault(owner, {})[field] = value
    joint = arm.joint(label)
    for owner, values in fields.items():
        if not owner:
            joint = replace(joint, **values)
        elif owner in PARTS:
            joint = replace(joint, **{owner: replace(getattr(joint, owner), **values)})
        else:
            arm = arm.with_effect(replace(arm.effect(owner, label), **values), label)
    joints = tuple(joint if old.label == label else old for old in arm.joints)
    return replace(arm, joints=joints)
