"""
The estimator's state as messages, at a steady rate that the stamps of the samples decide.

The node and the offline command choose the same samples and write the same texts.
"""

from collections.abc import Sequence
from functools import lru_cache
import json
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.chain_links import ChainLinks
from hda_msgs_json.messages import assembled, EstimatorState
from hda_msgs_json.samples import TextSamples
import numpy as np
from numpy.typing import NDArray

from .belief_words import believed, doubts_in_words
from .estimates import Estimates
from .laws import layout
from .laws.contact import contact_name

STATE_RATE = 50.0               # default [Hz]

JOINT_NUMBERS = {
    'torsion': layout.TORSION, 'kinematic_torsion': layout.KINEMATIC_TORSION,
    'torque': layout.TORQUE, 'torque_std': layout.TORQUE_DEVIATION,
    'external_torque': layout.EXTERNAL_TORQUE,
    'external_torque_std': layout.EXTERNAL_DEVIATION,
    'motor_share': layout.MOTOR_SHARE}
"""Which result of a joint each field of the message holds, in the order of the message."""
TIP_NUMBERS = (layout.BASE_X, layout.BASE_Y,
               *range(layout.BASE_COVARIANCE, layout.BASE_COVARIANCE + 4))
CHAIN_TIP_NUMBERS = (*range(layout.BASE_WRENCH, layout.BASE_WRENCH + 3), *(
    layout.WRENCH_COVARIANCE + 6 * row + column for row in range(3) for column in range(3)))
FELT = 3.0                      # deviations of one joint's external torque that it feels (choice)


_HIDDEN = {False: 'tip: the force along the last link cannot be observed in this posture',
           True: 'tip: a part of the wrench cannot be observed in this pose'}


class Pacer:
    """Choose samples at a steady rate: the first one in every period of the stamps."""

    def __init__(self, rate: float) -> None:
        """Choose at most `rate` samples per second [Hz]."""
        self.period = max(1, round(1e9 / rate))
        self._last: int | None = None

    def due(self, stamp: int) -> bool:
        """Return whether a sample is chosen, by its stamp [ns]."""
        before, self._last = self._last, stamp // self.period
        return self._last != before


def due_rows(stamps: NDArray[np.int64], rate: float,
             before: int | None = None) -> NDArray[np.intp]:
    """Return the samples that a `Pacer` of this rate [Hz] chooses after a stamp `before` [ns]."""
    period = Pacer(rate).period
    periods = stamps // period
    last = periods[:1] - 1 if before is None else np.array([before // period])
    return np.flatnonzero(np.diff(periods, prepend=last))


class StateWriter:
    """
    Write the states of an arm as the texts of their messages.

    One sample and a recording take the same way, so that they give the same texts.
    """

    def __init__(self, arm: Arm) -> None:
        """Prepare the text around the numbers."""
        each = _list_of(len(arm.joints))
        self._in_space = isinstance(arm.links, ChainLinks)
        self._tip = CHAIN_TIP_NUMBERS if self._in_space else TIP_NUMBERS
        axes = 3 if self._in_space else 2
        texts = dict.fromkeys(JOINT_NUMBERS, each) | {
            'stamp': '%d', 'names': json.dumps(arm.labels, separators=(',', ':')).replace(
                '%', '%%'),
            'valid': '%s', 'flags': '%s', 'tip_force': _list_of(axes),
            'tip_force_covariance': _list_of(axes ** 2), 'singular': '%s', 'conditioning': '%s',
            'contact_deviations': '%s', 'payload': '%s', 'payload_std': '%s', 'contact': '%s',
            'torsion_zero': each, 'contact_beyond': '%s'}
        self._form = assembled(EstimatorState, texts)
        self._labels = arm.labels

    def __call__(self, stamp: int, joints: Array, tip: Array, *, taring: bool = False) -> str:
        """Return the state after one sample from its results (n, RESULTS) and (TIP_RESULTS,)."""
        return self.texts([stamp], joints[np.newaxis], tip[np.newaxis], taring=taring)[0]

    def texts(self, stamps: Sequence[int], joints: Array, tip: Array, *,
              taring: bool = False) -> list[str]:
        """Return the states after samples: stamps (k,), (k, n, RESULTS) and (k, TIP_RESULTS)."""
        beyond = (joints[:, :, layout.BEYOND_RANGE] > 0.0).tolist()
        singular = (tip[:, layout.SINGULAR] > 0.0).tolist()
        level = [contact_name(value) for value in tip[:, layout.CONTACT_LEVEL].tolist()]
        doubts = joints[:, :, layout.DOUBT].tolist()
        hides = _HIDDEN[self._in_space]
        verdicts = [_verdict(self._labels, tuple(too_far), tuple(doubted), hides * hidden, taring)
                    for too_far, doubted, hidden in zip(beyond, doubts, singular)]
        count = range(len(self._labels))
        of_joints = (joints[:, j, index] for index in JOINT_NUMBERS.values() for j in count)
        columns = (stamps, *map(_words, of_joints), [verdict.valid for verdict in verdicts],
                   [verdict.flags for verdict in verdicts],
                   *(_words(tip[:, index]) for index in self._tip),
                   [_truth(hidden) for hidden in singular],
                   _words(tip[:, layout.CONDITIONING]),
                   *(_words(tip[:, index]) for index in (
                       layout.CONTACT_DEVIATIONS, layout.MASS, layout.MASS_DEVIATION)),
                   map(json.dumps, level),
                   *(_words(joints[:, j, layout.ZERO_TAKEN]) for j in count),
                   map(json.dumps, touched_beyond(self._labels, joints, tip)))
        return [self._form % row for row in zip(*columns)]


def state_samples(arm: Arm, estimates: Estimates, rate: float = STATE_RATE,
                  before: int | None = None) -> TextSamples:
    """Return the states of a recording at a rate [Hz], after a sample at `before` [ns]."""
    rows = due_rows(estimates.stamps, rate, before)
    stamps = estimates.stamps[rows]
    texts = StateWriter(arm).texts(stamps.tolist(), estimates.joints[rows], estimates.tip[rows],
                                   taring=estimates.taring)
    return TextSamples(stamps, tuple(texts))


def touched_beyond(labels: Sequence[str], joints: Array, tip: Array) -> list[str]:
    """Return the outermost joint that feels a contact at each sample (k,), '' for none."""
    torque, deviation = joints[:, :, layout.EXTERNAL_TORQUE], joints[:, :, (
        layout.EXTERNAL_DEVIATION)]
    feels = np.abs(torque) > FELT * deviation
    feels &= (tip[:, layout.CONTACT_LEVEL] > 0.0)[:, np.newaxis]
    last = len(labels) - 1 - np.argmax(feels[:, ::-1], axis=1)
    return [labels[place] if feels[row, place] else '' for row, place in enumerate(last.tolist())]


def _list_of(count: int) -> str:
    return f'[{",".join(["%s"] * count)}]'


def _words(values: Array) -> list[str]:
    """Return numbers as JSON has them, null for those that are unknown or overflowed."""
    words = list(map(repr, values.tolist()))
    for at in np.flatnonzero(~np.isfinite(values)).tolist():
        words[at] = 'null'
    return words


def _truth(value: bool) -> str:
    return 'true' if value else 'false'


class _Verdict(NamedTuple):
    """Say as JSON which joints are valid, and what is remarkable."""

    valid: str
    flags: str


@lru_cache
def _verdict(labels: tuple[str, ...], beyond: tuple[bool, ...], doubts: tuple[float, ...],
             hidden: str, taring: bool) -> _Verdict:
    flags = doubts_in_words(labels, doubts)
    flags += [f'{label}: the torque exceeds the valid range of the torsion law'
              for label, too_far in zip(labels, beyond) if too_far]
    if hidden:
        flags.append(hidden)
    if taring:
        flags.append('a tare is under way')
    valid = ','.join(_truth(not too_far and believed(doubt))
                     for too_far, doubt in zip(beyond, doubts))
    return _Verdict(f'[{valid}]', json.dumps(flags, separators=(',', ':')))
