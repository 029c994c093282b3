"""What can be wrong with a sample of an arm, each fault in one sentence."""

from collections.abc import Sequence
from enum import IntEnum
from typing import NamedTuple

from hda_msgs_json.topics import motor_name


class Fault(IntEnum):
    """What is wrong with a sample; compiled code knows these numbers."""

    NONE = 0
    NOT_FINITE = 1
    NOT_LATER = 2
    CLOCK_BACK = 3
    BEYOND_ANGLE = 4
    JUMP = 5
    TURN = 6
    FROZEN = 7
    APART = 8
    SPEED = 9
    TWO_PUBLISHERS = 10

    @property
    def believed(self) -> bool:
        """Return whether the watch takes the angles of such a sample for the last known ones."""
        return self in (Fault.NONE, Fault.FROZEN, Fault.SPEED)

    @property
    def of_stamps(self) -> bool:
        """Return whether it is only the stamp that is wrong."""
        return self in (Fault.NOT_LATER, Fault.CLOCK_BACK)

    @property
    def reason(self) -> str:
        """Return the fault in a few words, to count it by."""
        return _REASONS[self]


class FaultDetails(NamedTuple):
    """Where a fault is, what was got and what would be right; units are those of the fault."""

    joint: int
    side: int                   # 0 the shaft, 1 the link
    got: float
    right: float
    seconds: float              # over which it was seen


_REASONS = {
    Fault.NONE: '', Fault.NOT_FINITE: 'angle not finite', Fault.NOT_LATER: 'stamp not later',
    Fault.CLOCK_BACK: 'clock went back', Fault.BEYOND_ANGLE: 'angle beyond its limit',
    Fault.JUMP: 'angle jumped', Fault.TURN: 'angle jumped by a turn', Fault.FROZEN:
    'reading frozen', Fault.APART: 'motor and link disagree', Fault.SPEED: 'velocity impossible',
    Fault.TWO_PUBLISHERS: 'two publishers'}

_SENTENCES = {
    Fault.NOT_FINITE: 'the angle of {name} must be finite, got {got:g}',
    Fault.NOT_LATER: 'a stamp must be later than the last one, got one {got:g} s later',
    Fault.CLOCK_BACK: 'stamps must grow, got one {back:g} s before the last one',
    Fault.BEYOND_ANGLE: '{name} must stay within +-{right:g} rad, got {got:g} rad',
    Fault.JUMP: '{name} can turn by at most {right:.3g} rad in {seconds:g} s, got {got:.3g} rad',
    Fault.TURN: '{name} jumped by a whole number of turns: it can turn by at most {right:.3g} rad '
                'in {seconds:g} s, got {got:.4g} rad; angles must run on over a turn',
    Fault.FROZEN: '{name} moved by {got:.3g} rad per sample and then repeated one angle for '
                  '{seconds:g} s; {right:g} s at most are usual',
    Fault.APART: '{label}: motor angle / ratio and link angle moved apart by {got:.3g} rad; '
                 'torsion explains at most {right:.3g} rad (a reading that slipped, is of another '
                 'joint, or has a wrong sign or unit)',
    Fault.SPEED: 'the velocity of {name} does not fit its angle: {got:.3g} rad over {seconds:g} s '
                 'by velocity, {right:.3g} rad at most by angle',
    Fault.TWO_PUBLISHERS: 'samples of two publishers come in turn: {name} is {got:.4g} rad in one '
                          'and {right:.4g} rad in the other; let one publish joint_states',
}
_BY_STAMP = ('samples of two publishers come in turn: every second stamp is {got:g} s later than '
             'the one before, which is before it; let one publish joint_states')


def sentence(fault: Fault, details: FaultDetails, labels: Sequence[str]) -> str:
    """Return what is wrong, where, what was got and what would be right."""
    label = labels[details.joint]
    stamps = fault is Fault.TWO_PUBLISHERS and details.seconds < 0.0
    return (_BY_STAMP if stamps else _SENTENCES[fault]).format(
        name=label if details.side else motor_name(label), label=label, got=details.got,
        back=-details.got, right=details.right, seconds=details.seconds)
