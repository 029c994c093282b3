"""
Several recordings on one running clock: what belongs to one of them only.

An arm is the same in all its recordings, but something touches it in one of them; the onset of a
contact counts on the running clock.
"""

from dataclasses import replace

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import ExternalContact


def arm_during(arm: Arm, piece: slice, dt: float) -> Arm:
    """Return the arm as the recording of these samples has it, its time from zero [s]."""
    contact = arm.effect(ExternalContact.name)
    begin, end = piece.start * dt, piece.stop * dt
    if begin == 0.0 or not isinstance(contact, ExternalContact) or contact.is_neutral():
        return arm
    if not begin <= contact.onset < end:
        return arm.without(ExternalContact.name)
    return arm.with_effect(replace(contact, onset=contact.onset - begin))
