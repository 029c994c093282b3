"""What casts doubt on an estimate, in words; the numbers are those of `belief.py`."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .laws import belief, slips
from ..samples import coupling
from ..samples.sample_faults import Fault

_COUPLINGS: dict[float, str] = {
    coupling.AT_LINK: 'the motor angle is divided by the gear ratio already',
    coupling.MOTOR_DEGREES: 'the motor angle is in degrees beside a link angle in rad',
    coupling.LINK_DEGREES: 'the link angle is in degrees beside a motor angle in rad',
    coupling.OTHER: 'motor and link do not turn by the gear ratio of the model'}
_FLIPPED = 'one encoder has the other sign'
_SLIPPED = ('the {} encoder slipped: its angle stepped at once by more than any torque moves it; '
            'tare again')
_OF_JOINT = {
    belief.APART: 'torsion and motor torque are too far apart to correct each other; the torque '
                  'is that of the torsion alone',
    belief.MOTOR_ALONE: 'torsion and motor torque are too far apart to correct each other; the '
                        'torque is that of the motor alone',
    belief.CHANGED: 'torsion and motor torque suddenly contradict each other (a slip of an '
                    'encoder, another motor torque or sign of it)',
    belief.SLIPPED + slips.OF_MOTOR: _SLIPPED.format('motor'),
    belief.SLIPPED + slips.OF_LINK: _SLIPPED.format('link'),
    belief.IMPOSSIBLE: 'the torque of the torsion is beyond what the motor can give (zero, '
                       'stiffness, or the sign or constant of the motor torque)'}
_LOST = ('readings jumped and never came back to where they can be; call torque_estimator/reset '
         'once they are right')


def believed(doubt: float) -> bool:
    """Return whether an estimate with this doubt can be believed."""
    return doubt in (belief.BELIEVED, belief.APART, belief.MOTOR_ALONE) or not _known(doubt)


def doubts_in_words(labels: Sequence[str], doubts: Sequence[float]) -> list[str]:
    """Return the doubts (n,) of joints with these labels in sentences, each once."""
    return list(dict.fromkeys(
        words for label, doubt in zip(labels, doubts) if (words := _in_words(label, doubt))))


def doubt_shares(labels: Sequence[str], doubts: NDArray[np.float64]) -> dict[str, float]:
    """Return by each sentence the share of samples (k, n) that it is said of."""
    rows, counts = np.unique(doubts, axis=0, return_counts=True)
    shares: dict[str, float] = {}
    for row, count in zip(rows.tolist(), counts.tolist()):
        for words in doubts_in_words(labels, row):
            shares[words] = shares.get(words, 0.0) + count / len(doubts)
    return shares


def _known(doubt: float) -> bool:
    return bool(_in_words('', doubt))


def _in_words(label: str, doubt: float) -> str:
    if doubt == belief.BELIEVED:
        return ''
    if doubt == belief.LOST:
        return _LOST
    if doubt in _OF_JOINT:
        return f'{label}: {_OF_JOINT[doubt]}'
    if doubt in _FAULTS:
        return _FAULTS[doubt]
    return _coupling_words(label, doubt - belief.COUPLED)


def _coupling_words(label: str, kind: float) -> str:
    words = _COUPLINGS.get(abs(kind), '')
    reasons = [words] if words else []
    reasons += [_FLIPPED] if kind < 0.0 and (words or kind == coupling.FLIPPED) else []
    return f'{label}: {" and ".join(reasons)}' if reasons else ''


_FAULTS = {float(fault): f'readings that no arm can show: {fault.reason}'
           for fault in Fault if fault is not Fault.NONE}
