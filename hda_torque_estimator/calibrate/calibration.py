"""
Calibrate the joints of an arm from recordings with reference torques.

A joint is calibrated where that lowers its error on recordings that the fit has not seen. Every
other joint stays as it was, and the calibration says why.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from hda_arm_sim.model.arm import Arm

from .fitting.arm_numbers import doubtful, Number, numbers, rest, with_numbers, zero
from .fitting.fit import applied, Balanced, balanced, Fit, fit, rms
from .fitting.terms import OPTIONAL, Term, TERMS
from .passages.measured import CalibrationError, Measured
from ..estimating.estimator import Estimator

# Choices unless told otherwise.
HARDLY = 1.0            # deviation of a torque that tells little about a gear [N*m]
# (measured: for a joint of a real arm a true term made 0.52 N*m to 0.29)
CLEARLY = 0.9           # of the error on recordings left out, below which an optional term counts
SPARSE = '    its torque hardly varies: the numbers rest on little, as their intervals say'


@dataclass(frozen=True)
class JointCalibration:
    """
    What the recordings said about one joint; `kept` is why it stays as it was, '' if it does not.

    Errors [N*m rms] are about the mean of each recording. They are of the arm as given, and of the
    calibrated one. Its recordings are those left out of the fit (`held_out`), or the only one
    there is.
    """

    joint: str
    recordings: tuple[str, ...]
    kept: str = ''
    numbers: tuple[Number, ...] = ()
    reference: float = 0.0      # deviation of the reference torques [N*m]
    before: float = 0.0
    after: float = 0.0
    held_out: bool = False
    doubtful: tuple[str, ...] = ()      # numbers far from what was known

    def lines(self) -> list[str]:
        """Return the report on this joint."""
        if self.kept:
            return [f'{self.joint}: stays as it was: {self.kept}']
        seen = 'on recordings left out of the fit' if self.held_out else 'on the only recording'
        return [f'{self.joint}: error {self.before:.3g} -> {self.after:.3g} N*m rms {seen}, of a '
                f'torque that varies by {self.reference:.3g} N*m rms',
                *([SPARSE] if self.reference < HARDLY else []),
                *(f'    {number}' for number in self.numbers),
                *(f'    {name} is far from what was known: it predicts this torque, but need not '
                  'describe the gear' for name in self.doubtful)]

    def document(self) -> dict[str, Any]:
        """Return the report for machines."""
        return {**vars(self), 'recordings': list(self.recordings),
                'doubtful': list(self.doubtful),
                'numbers': [vars(number) for number in self.numbers]}


class Finding(Protocol):
    """What was found about one joint, however it was found."""

    def lines(self) -> list[str]:
        """Return the report on the joint for people."""

    def document(self) -> dict[str, Any]:
        """Return the report on the joint for machines."""


@dataclass(frozen=True)
class Calibration:
    """The new arm and what was found about each of its joints."""

    arm: Arm
    joints: tuple[Finding, ...]

    def text(self) -> str:
        """Return the report for people."""
        return '\n'.join([line for joint in self.joints for line in joint.lines()] + [
            'Everything else is nominal.'])

    def report(self) -> dict[str, Any]:
        """Return the report for machines."""
        return {'joints': [joint.document() for joint in self.joints]}


def calibrate(arm: Arm, recordings: Mapping[str, Sequence[Measured]]) -> Calibration:
    """
    Return the calibration of every joint that has an entry, from its recordings.

    Raises CalibrationError when no joint can be calibrated.
    """
    joints = []
    for label, measured in recordings.items():
        found = _calibrated(one_joint(arm, label), measured)
        joints.append(found)
        if not found.kept:
            source = f'reference torques of {", ".join(found.recordings)}'
            arm = with_numbers(arm, label, found.numbers, source)
    if all(joint.kept for joint in joints):
        raise CalibrationError('nothing can be calibrated: ' + '; '.join(
            f'{joint.joint}: {joint.kept}' for joint in joints))
    return Calibration(arm, tuple(joints))


def one_joint(arm: Arm, label: str) -> Arm:
    """Return the arm that is one joint of another, with the effects of that joint."""
    return Arm((arm.joint(label),), None, effects=tuple(
        placed for placed in arm.effects if placed.joint == label), tolerances=arm.tolerances)


def _calibrated(arm: Arm, recordings: Sequence[Measured]) -> JointCalibration:
    label, names = arm.labels[0], tuple(recording.recording for recording in recordings)
    if not recordings:
        return JointCalibration(label, names, 'no recording has both its angles and its '
                                f'reference/{label}/torque')
    deviation = rms([Balanced(r.reference - r.reference.mean(), 0.0) for r in recordings])
    if deviation == 0.0:
        return JointCalibration(label, names, 'its reference torque never changes')
    before = rms([balanced(Estimator(arm), recording) for recording in recordings])
    terms, found, after = _found(arm, deviation, recordings)
    kept = '' if after < min(before, deviation) else (
        f'calibrated, it would be {after:.3g} N*m rms off, as given {before:.3g}, and its torque '
        f'varies by {deviation:.3g}')
    found_numbers = (*numbers(terms, found), zero(arm, found), rest(after, len(recordings)))
    return JointCalibration(label, names, kept, found_numbers, deviation, before, after,
                            len(recordings) > 1, doubtful(terms, found))


def _found(arm: Arm, deviation: float,
           recordings: Sequence[Measured]) -> tuple[list[Term], Fit, float]:
    """Return the terms that count, their fit, and its error on recordings left out of it."""
    terms = [term(arm, deviation) for term in TERMS]
    if len(recordings) == 1:
        found = fit(arm, terms, recordings)
        return terms, found, rms(found.balanced)
    error = _held_out(arm, terms, recordings)
    for optional in OPTIONAL:
        more = [*terms, optional(arm, deviation)]
        with_it = _held_out(arm, more, recordings)
        if with_it < CLEARLY * error:
            terms, error = more, with_it
    return terms, fit(arm, terms, recordings), error


def _held_out(arm: Arm, terms: Sequence[Term], recordings: Sequence[Measured]) -> float:
    """Return the error on every recording, each by a fit to all others [N*m rms]."""
    parts = []
    for index, left_out in enumerate(recordings):
        seen = [*recordings[:index], *recordings[index + 1:]]
        found = applied(arm, terms, fit(arm, terms, seen).values)
        parts.append(balanced(Estimator(found), left_out))
    return rms(parts)
