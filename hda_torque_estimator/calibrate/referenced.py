"""
Calibrate the joints of an arm against reference torques, with nothing known of its links.

A joint has two witnesses: its torsion, and its motor. Each is written where it tells more than the
arm file did on recordings that the fit has not seen. A motor beside a torsion must earn its place
as a term does: it must tell clearly more. Every other joint stays as it was, and the calibration
says why. A torsion that stays as it was beside a motor gets what it is off by as its deviation. So
the motor leads.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
import math
from typing import Any

from hda_arm_sim.model.arm import Arm
import numpy as np

from .calibration import Calibration, HARDLY, one_joint, SPARSE
from .fitting.arm_numbers import Number, number, rest, with_numbers, with_tolerances
from .fitting.witness_fit import earns_its_place, Heard, motor_of, torsion_of
from .passages.joint_recording import CalibrationError, Measured
from ..least_squares.rows import rms

# Choices unless told otherwise.
USEFUL = 0.9            # of what its rows see vary, an error above which a witness tells nothing
MOVES = 0.1             # of the torque's deviation, from which a zero that moves is told
FEWEST_ROWS = 50        # in which a motor slides
Progress = Callable[[str], None]


@dataclass(frozen=True)
class JointCalibration:
    """
    What the recordings said about one joint; `kept` is why it stays as it was, '' if it does not.

    Errors [N*m rms] are where the fit has not seen: on recordings left out of it (`held_out`), or
    on stretches of the only one. `before` and `after` are of the torsion, each recording with a
    zero of its own for `before`; `motor` is of the motor. Both are 0 where there is no such
    witness.
    """

    joint: str
    recordings: tuple[str, ...]
    kept: str = ''
    numbers: tuple[Number, ...] = ()
    reference: float = 0.0      # deviation of the reference torques [N*m]
    before: float = 0.0
    after: float = 0.0
    motor: float = 0.0
    zero_moves: float = 0.0     # zero of the link encoder over recordings, one sigma [rad]
    zero_torque: float = 0.0    # what that makes of the torque [N*m]
    offset_moves: float = 0.0   # offset of the motor over recordings, one sigma [N*m motor]
    lag: float = 0.0            # of the references [s]
    held_out: bool = False
    doubtful: tuple[str, ...] = ()      # numbers far from what was known
    known: tuple[Number, ...] = ()      # the numbers, as well known as if they were independent

    def lines(self) -> list[str]:
        """Return the report on this joint."""
        if self.kept:
            return [f'{self.joint}: stays as it was: {self.kept}']
        seen = 'on recordings left out of the fit' if self.held_out else 'on the only recording'
        return [f'{self.joint}: {" and ".join(self._errors())} {seen}, of a '
                f'torque that varies by {self.reference:.3g} N*m rms',
                *([SPARSE] if self.reference < HARDLY else []),
                *(f'    {words}' for words in self._moving()),
                *(f'    {number}' for number in self.numbers),
                *(f'    {name} is far from what was known: it predicts this torque, but need not '
                  'describe the gear' for name in self.doubtful)]

    def _errors(self) -> list[str]:
        by_torsion = f'error {self.before:.3g} -> {self.after:.3g} N*m rms by the torsion'
        return [*([by_torsion] if self.after > 0.0 else []),
                *([f'{self.motor:.3g} N*m rms by the motor'] if self.motor > 0.0 else [])]

    def _moving(self) -> list[str]:
        """Return what moves between recordings, and what the references lag."""
        found = []
        if self.zero_torque > MOVES * self.reference:
            found.append(f'its zero moves by {self.zero_moves:.2g} rad from recording to recording'
                         f', which is {self.zero_torque:.3g} N*m: tare, or let the motor tell it')
        if self.lag != 0.0:
            found.append(f'its reference lags by {1e3 * self.lag:.3g} ms')
        return found

    def document(self) -> dict[str, Any]:
        """Return the report for machines."""
        told = {name: value for name, value in vars(self).items() if name != 'known'}
        return {**told, 'recordings': list(self.recordings),
                'doubtful': list(self.doubtful),
                'numbers': [vars(number) for number in self.numbers]}


def calibrate(arm: Arm, recordings: Mapping[str, Sequence[Measured]],
              tell: Progress = lambda text: None) -> Calibration:
    """
    Return the calibration of every joint that has an entry, from its recordings.

    Raises CalibrationError when no joint can be calibrated.
    """
    joints = []
    for label, measured in recordings.items():
        tell(f'calibrating {label}')
        found = _calibrated(one_joint(arm, label), measured)
        joints.append(found)
        if not found.kept:
            source = f'reference torques of {", ".join(found.recordings)}'
            arm = with_numbers(arm, label, found.numbers, source)
    if all(joint.kept for joint in joints):
        raise CalibrationError('nothing can be calibrated: ' + '; '.join(
            f'{joint.joint}: {joint.kept}' for joint in joints))
    return Calibration(with_tolerances(arm, {
        joint.joint: joint.known for joint in joints}, wider=True), tuple(joints))


def _calibrated(arm: Arm, recordings: Sequence[Measured]) -> JointCalibration:
    label, names = arm.labels[0], tuple(recording.recording for recording in recordings)
    if not recordings:
        return JointCalibration(label, names, 'no recording has its motor angle, its '
                                f'reference/{label}/torque, and its link angle or motor torque')
    varies = rms(np.concatenate([one.reference - one.reference.mean() for one in recordings]))
    if varies == 0.0:
        return JointCalibration(label, names, 'its reference torque never changes')
    torsion = _torsion(arm, [one for one in recordings if one.has_link])
    motor = _motor(arm, [one for one in recordings if one.has_command])
    said = JointCalibration(label, names, reference=varies, held_out=len(recordings) > 1)
    told = torsion is not None and torsion.error < min(torsion.before, USEFUL * torsion.varies)
    if motor is not None and _is_worth(motor, torsion if told else None):
        size = rms(np.concatenate([one.reference for one in recordings]))
        said = _with_motor(said, motor, {'coulomb_friction.level': arm.joints[0].ratio,
                                         'torque_constant_error.error': size})
    if torsion is not None and told:
        said = _with_torsion(said, torsion, len(recordings))
    elif torsion is not None and said.numbers:
        said = replace(said, numbers=(rest(torsion.given, len(recordings)), *said.numbers))
    return said if said.numbers else replace(said, kept=_why(torsion, motor, varies))


def _is_worth(motor: Heard, torsion: Heard | None) -> bool:
    """Tell whether a motor is written, beside a torsion that is, or alone."""
    if torsion is not None and not earns_its_place(motor.whole_error, torsion.whole_error):
        return False
    return motor.error < USEFUL * motor.varies and not motor.is_odd


def _torsion(arm: Arm, recordings: Sequence[Measured]) -> Heard | None:
    return torsion_of(arm, recordings) if recordings else None


def _motor(arm: Arm, recordings: Sequence[Measured]) -> Heard | None:
    return motor_of(arm, recordings) if recordings else None


def _with_torsion(said: JointCalibration, torsion: Heard, parts: int) -> JointCalibration:
    """Return what is said of a joint, with the numbers of its torsion first."""
    return replace(
        said, numbers=(*torsion.numbers, rest(torsion.error, parts), *said.numbers),
        known=(*torsion.known, *said.known),
        before=torsion.before, after=torsion.error, zero_moves=torsion.spread,
        zero_torque=torsion.offset, lag=torsion.lag, doubtful=torsion.doubtful)


def _with_motor(said: JointCalibration, motor: Heard,
                shares: Mapping[str, float]) -> JointCalibration:
    """
    Return what is said of a joint, with the numbers of its motor.

    What no law tells of the motor's torque is friction, or follows the torque, and nobody knows
    which. So numbers of either kind are as unsure as that makes them: `shares` are the torques
    [N*m] that one of each number makes.
    """
    told, known = (tuple(number(one.name, one.value, math.hypot(
        one.sigma, motor.error / shares[one.name] if one.name in shares else 0.0))
        for one in found) for found in (motor.numbers, motor.known))
    return replace(said, numbers=told, known=known, motor=motor.error, offset_moves=motor.spread,
                   lag=motor.lag)


def _why(torsion: Heard | None, motor: Heard | None, varies: float) -> str:
    """Return why a joint stays as it was."""
    parts = []
    if torsion is not None:
        parts.append(f'calibrated, it would be {torsion.error:.3g} N*m rms off, as given '
                     f'{torsion.before:.3g}')
    if motor is not None:
        parts.append(f'its motor would be {motor.error:.3g} N*m rms off')
    return f'{", ".join(parts)}, and its torque varies by {varies:.3g}'
