"""
Calibrate the joints of an arm against reference torques, with nothing known of its links.

A joint has two witnesses: its torsion, and its motor. Each is written where it shows something of
recordings that the fit has not seen, with its error there as its deviation. The estimator weighs
them by that. What both then give together is examined on the same recordings, beside other
weights. A joint whose calibration would make its torque worse stays as it was, and so does one
without a witness. The calibration says why.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
import math
from typing import Any, NamedTuple

from hda_arm_sim.model.arm import Arm
import numpy as np

from .calibration import Calibration, LITTLE_TORQUE, one_joint, SPARSE
from .fitting.arm_numbers import (ArmNumber, GAIN, LEVEL, number, of_all_friction, with_numbers,
                                  with_tolerances, ZERO)
from .fitting.by_hand import line_left_out, mean_left_out
from .fitting.examined import as_given, BETTER, Examined, examined, Witnesses
from .fitting.ripple_left import with_ripple
from .fitting.witness_fit import motor_of, torsion_of, WitnessFit
from .passages.encoder_noise import NOISE, with_noise
from .passages.joint_recording import CalibrationError, Measured
from .passages.signs import wrong_signs
from ..estimating.laws.witnesses import FAINT
from ..least_squares.bounds import entered
from ..least_squares.rows import rms
from ..measurements.effort import HELD, MEASURED
from ..samples.readings import knows_motor

# Choices unless stated otherwise.
USEFUL = 0.9            # of what its rows see vary, an error above which a witness shows nothing
BESIDE = 0.9            # of an error, below which a motor beside a torsion, or at rest, counts
MOVES = 0.1             # of the torque's deviation, from which a zero that moves is reported
STIFFNESS, LAG = 'torsion.flexspline_stiffness', 'effort_lag'
_ACTS = {HELD: 'its motor torque acts over the time to its next stamp, as a held command does',
         MEASURED: 'its motor torque acts at its stamp, as a measured current does'}
Progress = Callable[[str], None]


@dataclass(frozen=True)
class JointCalibration:
    """
    What the recordings said about one joint; `kept` is why it stays as it was, '' if it does not.

    Errors [N*m rms] are where the fit has not seen: on recordings left out of it (`held_out`), or
    on stretches of the only one. `before` and `after` are of the torsion, each recording with a
    zero of its own for `before`; `motor` is of the motor. Both are 0 where there is no such
    witness. `together`, `given` and `by_hand` have the common zero: what the estimator errs by,
    what it does with the arm as given, and a straight line. `constant` is the error of the others'
    mean torque, which asks no sensor.
    """

    joint: str
    recordings: tuple[str, ...]
    kept: str = ''
    numbers: tuple[ArmNumber, ...] = ()
    reference: float = 0.0      # deviation of the reference torques [N*m]
    before: float = 0.0
    after: float = 0.0
    motor: float = 0.0
    together: float = 0.0
    about: float = 0.0          # of that, about the mean of each recording
    given: float = 0.0
    by_hand: float = 0.0
    constant: float = 0.0
    leader: str = ''            # the witness that gives the torque alone, '' for both
    zero_moves: float = 0.0     # zero of the link encoder over recordings, one sigma [rad]
    zero_torque: float = 0.0    # what that makes of the torque [N*m]
    offset_moves: float = 0.0   # offset of the motor over recordings, one sigma [N*m motor]
    lag: float = 0.0            # of the references [s]
    held_out: bool = False
    aside: tuple[str, ...] = ()         # why a witness is left aside
    doubtful: tuple[str, ...] = ()      # numbers far from what was known
    known: tuple[ArmNumber, ...] = ()      # the numbers, as well known as if they were independent
    ripple: float = math.inf    # what waves of the motor torque may have at most [N*m motor]

    def lines(self) -> list[str]:
        """Return the report on this joint."""
        if self.kept:
            return [f'{self.joint}: stays as it was: {self.kept}']
        seen = 'on recordings left out of the fit' if self.held_out else 'on the only recording'
        return [f'{self.joint}: {" and ".join(self._errors())} {seen}, of a '
                f'torque that varies by {self.reference:.3g} N*m rms',
                *([SPARSE] if self.reference < LITTLE_TORQUE else []),
                *(f'    {words}' for words in (*self._together(), *self.aside, *self._moving())),
                *(f'    {number}' for number in self.numbers),
                *(f'    {name} is far from what was known: it predicts this torque, but need not '
                  'describe the gear' for name in self.doubtful)]

    def _errors(self) -> list[str]:
        by_torsion = f'error {self.before:.3g} -> {self.after:.3g} N*m rms by the torsion'
        return [*([by_torsion] if self.after > 0.0 else []),
                *([f'{self.motor:.3g} N*m rms by the motor'] if self.motor > 0.0 else [])]

    def _together(self) -> list[str]:
        """Return what the estimator makes of the witnesses, and what a line would."""
        if self.together == 0.0:
            return []
        who = f'; the {self.leader} alone gives the torque' if self.leader else ''
        if 0.0 < self.constant <= self.together:
            who += f'; the mean torque of the others errs by no more ({self.constant:.3g})'
        about = (f' ({self.about:.3g} about the mean of each recording)'
                 if self.held_out and self.about > 0.0 else '')
        return [f'the estimator errs by {self.together:.3g} N*m rms there, zeros included{about}, '
                f'by {self.given:.3g} with the arm as given, a straight line by '
                f'{self.by_hand:.3g}{who}']

    def _moving(self) -> list[str]:
        """Return what moves between recordings, and what the references lag."""
        found = []
        if self.zero_torque > MOVES * self.reference:
            by = ('the motor gives it' if self.motor > 0.0 else
                  'tare, or let the motor give it: --zero-moves')
            found.append(f'its zero moves by {self.zero_moves:.2g} rad from recording to recording'
                         f', which is {self.zero_torque:.3g} N*m: {by}')
        if self.lag != 0.0:
            found.append(f'its reference lags by {1e3 * self.lag:.3g} ms')
        lags = [one.value for one in self.numbers if one.name == LAG]
        return found + [_ACTS[lag] for lag in lags]

    def document(self) -> dict[str, Any]:
        """Return the report for machines."""
        fields = {name: value for name, value in vars(self).items()
                  if name not in ('known', 'ripple')}
        return {**fields, 'recordings': list(self.recordings), 'aside': list(self.aside),
                'doubtful': list(self.doubtful),
                'numbers': [vars(number) for number in self.numbers]}


def calibrate(arm: Arm, recordings: Mapping[str, Sequence[Measured]],
              notify: Progress = lambda text: None, *, zero_moves: bool = False) -> Calibration:
    """
    Return the calibration of every joint that has an entry, from its recordings.

    Where a `zero_moves`, the zero of a torsion is unknown in every other recording, and a motor
    gives it. Raises CalibrationError when no joint can be calibrated.
    """
    joints = []
    for label, measured in recordings.items():
        notify(f'calibrating {label}')
        found = _noisy(one_joint(arm, label), measured, zero_moves)
        joints.append(found)
        if not found.kept:
            source = f'reference torques of {", ".join(found.recordings)}'
            arm = with_numbers(arm, label, found.numbers, source)
    if all(joint.kept for joint in joints):
        raise CalibrationError(f'nothing can be calibrated: {_reasons(joints)}')
    arm = with_tolerances(arm, {joint.joint: joint.known for joint in joints}, wider=True)
    for joint in joints:
        arm = with_ripple(arm, joint.joint, joint.ripple)
    return Calibration(arm, tuple(joints))


def _reasons(joints: Sequence[JointCalibration]) -> str:
    """Return why joints stay as they were, one reason of many joints once."""
    alike: dict[str, list[JointCalibration]] = {}
    for joint in joints:
        alike.setdefault(joint.kept.replace(joint.joint, 'JOINT'), []).append(joint)
    return '; '.join(
        f'{", ".join(joint.joint for joint in group)}: '
        f'{reason if len(group) > 1 else group[0].kept}' for reason, group in alike.items())


def _noisy(arm: Arm, recordings: Sequence[Measured], zero_moves: bool) -> JointCalibration:
    """Return the calibration of a joint, with the noise of its motor encoder at rest."""
    there = with_noise(arm, recordings)
    found = _calibrated(there, recordings, zero_moves)
    if found.kept or there is arm:
        return found
    noise = number(NOISE, there.joints[0].motor_encoder.noise, 0.0)
    return replace(found, numbers=(*found.numbers, noise))


def _calibrated(arm: Arm, recordings: Sequence[Measured], zero_moves: bool, *,
                settled: bool = False) -> JointCalibration:
    label, names = arm.labels[0], tuple(recording.recording for recording in recordings)
    if not recordings:
        return JointCalibration(label, names, 'no recording has its motor angle, its '
                                f'reference/{label}/torque, and its link angle or motor torque')
    recordings = [replace(one.on_time().without_spikes(arm.joints[0].velocity_limit),
                          effort_lag=arm.joints[0].effort_lag) for one in recordings]
    varies = rms(np.concatenate([one.reference - one.reference.mean() for one in recordings]))
    said = JointCalibration(label, names, reference=varies, held_out=len(recordings) > 1)
    if varies == 0.0:
        return replace(said, kept='its reference torque never changes')
    wrong = wrong_signs(arm, recordings)
    if wrong.joint:
        return replace(said, kept=wrong.joint)
    said = replace(said, aside=tuple(words for words in wrong if words))
    heard = Witnesses(None if wrong.torsion else torsion_of(arm, recordings),
                      None if wrong.motor else motor_of(arm, recordings))
    best = _trial(arm, recordings, heard, zero_moves)
    line = line_left_out(arm.joints[0], recordings, best.used.lag if best else 0.0)
    if not wrong.motor and (best is None or best.found.error > line or zero_moves):
        at_rest = motor_of(arm, recordings, resting=True)
        other = (_trial(arm, recordings, heard._replace(motor=at_rest), zero_moves)
                 if at_rest else None)
        if other and (best is None or _earns(other.found, best.found, zero_moves)):
            best = other
    if best is None:
        return replace(said, kept='; '.join((*said.aside, _why(heard, varies))))
    lag = None if settled else _better_lag(arm, recordings, best)
    return (_weighed(said, arm, recordings, best, line) if lag is None
            else _acting(arm, recordings, lag, zero_moves))


def _least(heard: WitnessFit) -> float:
    """Return the error below which a witness shows something [N*m rms]."""
    return min(heard.before, USEFUL * heard.varies)


def _is_no_gear(used: Witnesses) -> bool:
    """Return whether a torsion that needs an unlikely stiffness is worthless beside a motor."""
    torsion, motor = used
    return (torsion is not None and motor is not None and STIFFNESS in torsion.doubtful
            and motor.error ** 2 < FAINT * (motor.error ** 2 + torsion.error ** 2))


class _WitnessChoice(NamedTuple):
    """Some witnesses of a joint, and what the estimator reaches by them."""

    used: Witnesses
    numbers: tuple[ArmNumber, ...]
    known: tuple[ArmNumber, ...]
    found: Examined


def _trial(arm: Arm, recordings: Sequence[Measured], heard: Witnesses,
           zero_moves: bool) -> _WitnessChoice | None:
    """Return what the useful witnesses reach together, None if none is useful."""
    used = Witnesses(*(one if one is not None and one.error < _least(one) else None
                       for one in heard))
    if _is_no_gear(used):
        used = used._replace(torsion=None)
    return _best(arm, recordings, used, zero_moves) if any(used) else None


def _better_lag(arm: Arm, recordings: Sequence[Measured], best: _WitnessChoice) -> float | None:
    """
    Return the lag of motor torques with which the estimator errs less, None if as given.

    A motor torque was measured at its stamp, or it is a command that is held until the next.
    """
    label, given = arm.labels[0], arm.joints[0].effort_lag
    errors = {lag: _tried(entered(arm, label, {LAG: lag}), recordings, best.used).found.error
              for lag in {HELD, MEASURED} - {given} if best.used.motor is not None}
    lag = min(errors, key=lambda one: errors[one], default=given)
    return lag if lag != given and errors[lag] < BETTER * best.found.error else None


def _acting(arm: Arm, recordings: Sequence[Measured], lag: float,
            zero_moves: bool) -> JointCalibration:
    """Return the calibration of a joint whose motor torques lag by so much, (eq:effort-lag)."""
    found = _calibrated(entered(arm, arm.labels[0], {LAG: lag}), recordings, zero_moves,
                        settled=True)
    return found if found.kept else replace(found, numbers=(*found.numbers,
                                                            number(LAG, lag, 0.0)))


def _weighed(said: JointCalibration, arm: Arm, recordings: Sequence[Measured],
             best: _WitnessChoice,
             line: float) -> JointCalibration:
    """Return what is said of a joint whose witnesses weigh what they are worth."""
    used, numbers, known, found = best
    nominal = as_given(arm, _of_both(recordings), used.lag)
    given = rms(nominal.error)
    if found.error > given and found.about > rms(nominal.about):
        return replace(said, kept=f'calibrated, the estimator would be {found.error:.3g} N*m '
                       f'rms off, as given {given:.3g}')
    alone = '' if used.motor is not None or used.torsion is None else 'torsion'
    return _with_torsion(_with_motor(replace(
        said, numbers=(*_as_unsure(arm, recordings, used, numbers), *found.deviations),
        known=known, together=found.error, about=found.about,
        given=given, by_hand=line, constant=mean_left_out(recordings),
        leader=found.leader or alone, lag=used.lag,
        doubtful=tuple(name for one in used if one is not None for name in one.doubtful)),
        used.motor), used.torsion)


def _as_unsure(arm: Arm, recordings: Sequence[Measured], used: Witnesses,
               numbers: Sequence[ArmNumber]) -> tuple[ArmNumber, ...]:
    """
    Return numbers with intervals that hold what no law describes of the motor's torque.

    It is friction, or follows the torque, and nobody knows which.
    """
    if used.motor is None:
        return tuple(numbers)
    size = _size(recordings)
    shares = {LEVEL: arm.joints[0].ratio, GAIN: size}
    return tuple(number(one.name, one.value, math.hypot(
        one.sigma, used.motor.error / shares[one.name])) if one.name in shares else one
        for one in numbers)


def _size(recordings: Sequence[Measured]) -> float:
    """Return how large the references are [N*m rms]."""
    return rms(np.concatenate([one.reference for one in recordings]))


def _best(arm: Arm, recordings: Sequence[Measured], used: Witnesses,
          zero_moves: bool) -> _WitnessChoice:
    """Return both witnesses, or the torsion alone where a motor beside it does not earn that."""
    trial = _tried(arm, recordings, used, zero_moves)
    if (used.torsion is None or used.motor is None or zero_moves
            or knows_motor(arm, arm.joints[0])):
        return trial
    alone = _tried(arm, recordings, used._replace(motor=None))
    return trial if _earns(trial.found, alone.found) else alone


def _earns(found: Examined, than: Examined, zero_moves: bool = False) -> bool:
    """
    Return if one predicts the torque better by a tenth, and its changes not worse by that.

    Who needs the torque more than its changes says that zeros move.
    """
    return found.error < BESIDE * than.error and (
        zero_moves or BESIDE * found.about <= than.about)


def _tried(arm: Arm, recordings: Sequence[Measured], used: Witnesses,
           zero_moves: bool = False) -> _WitnessChoice:
    label, heard = arm.labels[0], [one for one in used if one is not None]
    numbers = tuple(number for one in heard for number in one.numbers)
    known = of_all_friction([number for one in heard for number in one.known],
                            _size(recordings) / arm.joints[0].ratio)
    if zero_moves and used.motor is not None:
        joint = arm.joints[0]
        most = float(joint.torsion.record(joint.ratio)['valid_torsion'])    # of what gears show
        known = tuple(number(ZERO, one.value, most) if one.name == ZERO else one
                      for one in known)
    there = with_tolerances(entered(arm, label, {one.name: one.value for one in numbers}),
                            {label: known}, wider=True)
    if used.motor is not None:
        there = with_ripple(there, label, used.motor.ripple)
    return _WitnessChoice(used, numbers, known, examined(
        there, used, _of_both(recordings), _deviations(arm, recordings, used)))


def _of_both(recordings: Sequence[Measured]) -> Sequence[Measured]:
    """Return the recordings in which weights count: with both witnesses, else all."""
    return [one for one in recordings if one.has_link and one.has_command] or recordings


def _deviations(arm: Arm, recordings: Sequence[Measured], used: Witnesses) -> dict[str, float]:
    """
    Return the deviation of each witness that there is, as given where it shows nothing [N*m].

    A motor that shows nothing, and that nobody knows, stays unknown: its torque is not used.
    """
    torsion, motor = used
    found = {}
    if linked := [one for one in recordings if one.has_link]:
        found['torsion.deviation'] = (torsion.deviation if torsion is not None else rms(
            as_given(arm, linked, 0.0, fused=False).error))
    driven = [one for one in recordings if one.has_command]
    if driven and (motor is not None or knows_motor(arm, arm.joints[0])):
        found['motor_deviation'] = motor.deviation if motor is not None else rms(np.concatenate([
            np.nan_to_num(arm.joints[0].ratio * one.command) - one.reference for one in driven]))
    return found


def _with_torsion(said: JointCalibration, torsion: WitnessFit | None) -> JointCalibration:
    """Return what is said of a joint, with the fit of its torsion."""
    if torsion is None:
        return said
    return replace(said, before=torsion.before, after=torsion.error, zero_moves=torsion.spread,
                   zero_torque=torsion.offset)


def _with_motor(said: JointCalibration, motor: WitnessFit | None) -> JointCalibration:
    """Return what is said of a joint, with the fit of its motor."""
    if motor is None:
        return said
    return replace(said, motor=motor.error, offset_moves=motor.spread, ripple=motor.ripple)


def _why(heard: Witnesses, varies: float) -> str:
    """Return why a joint stays as it was."""
    parts = []
    if heard.torsion is not None:
        parts.append(f'calibrated, it would be {heard.torsion.error:.3g} N*m rms off, as given '
                     f'{heard.torsion.before:.3g}')
    if heard.motor is not None:
        parts.append(f'its motor would be {heard.motor.error:.3g} N*m rms off')
    if not parts:
        return 'neither its torsion nor a motor that turns determines it'
    return f'{", ".join(parts)}, and its torque varies by {varies:.3g}'
