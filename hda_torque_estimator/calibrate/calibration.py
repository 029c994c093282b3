"""What a calibration says: the new arm, and what was found about each of its joints."""

from dataclasses import dataclass, replace
from typing import Any, Protocol

from hda_arm_sim.model.arm import Arm

# Choices unless stated otherwise.
LITTLE_TORQUE = 1.0     # deviation of a torque that says little about a gear [N*m]
SPARSE = '    its torque hardly varies: the numbers rest on little, as their intervals say'


class JointReport(Protocol):
    """What was found about one joint, however it was found."""

    def lines(self) -> list[str]:
        """Return the report on the joint for people."""

    def document(self) -> dict[str, Any]:
        """Return the report on the joint for machines."""


@dataclass(frozen=True)
class Calibration:
    """The new arm and what was found about each of its joints."""

    arm: Arm
    joints: tuple[JointReport, ...]

    def text(self) -> str:
        """Return the report for people."""
        return '\n'.join([line for joint in self.joints for line in joint.lines()] + [
            'Everything else is nominal.'])

    def report(self) -> dict[str, Any]:
        """Return the report for machines."""
        return {'joints': [joint.document() for joint in self.joints]}


def one_joint(arm: Arm, label: str) -> Arm:
    """Return the arm that is one joint of another, with the effects of that joint."""
    return Arm((replace(arm.joint(label), tolerances=None),), None, effects=tuple(
        placed for placed in arm.effects if placed.joint == label),
        tolerances=arm.tolerances_of(label))
