"""What recordings must show before a joint can be calibrated from them; a sentence if not."""

from collections.abc import Sequence
import math

from hda_arm_sim.model.arm import Arm
import numpy as np
from numpy.typing import NDArray

from .joint_recording import CalibrationError
from .passage import Passage
from ...measurements.conventions import disc_slope, wrong_convention
from ...significance import MOSTLY

Floats = NDArray[np.float64]
# Choices unless stated otherwise.
SHORTEST = 10.0         # of usable samples [s]
TURN = 2.0 * math.pi    # of the motor, the least travel each way [rad]
FEWEST_LOADS = 1.0      # between the small and the large torques [N*m]
SMALL, LARGE = 5.0, 95.0        # percentiles of the torque
APART = 0.10            # by which two torques of one joint may differ in scale
LEAST_TORQUE = 0.5      # deviation from which the scale of a sensor is observable [N*m]
LARGE_TORQUE = 2.0      # deviation from which errors of the model do not pass for a scale [N*m]


def check(arm: Arm, label: str, passages: Sequence[Passage]) -> None:
    """Raise CalibrationError where passages cannot calibrate a joint."""
    joint = arm.joint(label)
    seconds = sum(passage.dt * passage.usable.sum() for passage in passages)
    if seconds < SHORTEST:
        raise CalibrationError(f'{label}: the recordings are too short: {seconds:.1f} s can be '
                               f'used, at least {SHORTEST:g} s are needed')
    _check_travel(label, passages)
    _check_conventions(arm, label, passages)
    _check_loads(label, passages)
    _check_sign(label, joint.ratio, passages)


def _joined(passages: Sequence[Passage], columns: Sequence[Floats]) -> Floats:
    """Return values of all usable samples, one passage after another."""
    return np.concatenate([column[passage.usable]
                           for passage, column in zip(passages, columns)])


def _check_travel(label: str, passages: Sequence[Passage]) -> None:
    """Check that the motor turns both ways."""
    forwards = backwards = 0.0
    for passage in passages:
        steps = np.where(passage.usable, passage.motor_rate, 0.0) * passage.dt
        forwards += float(steps[steps > 0.0].sum())
        backwards -= float(steps[steps < 0.0].sum())
    if max(forwards, backwards) < TURN:
        raise CalibrationError(
            f'{label} stands still: its motor travels {(forwards + backwards) / TURN:.2g} turns, '
            'at least one turn each way is needed')
    if min(forwards, backwards) < TURN:
        way = 'forwards' if forwards > backwards else 'backwards'
        raise CalibrationError(
            f'{label} turns one way only, {way}: friction and hysteresis take the same way for '
            'torsion; at least one motor turn each way is needed')


def _check_conventions(arm: Arm, label: str, passages: Sequence[Passage]) -> None:
    """Check signs, units and ratio of each passage."""
    joint, disc = arm.joint(label), disc_slope(arm, arm.labels.index(label))
    for passage in passages:
        motor, link = passage.readings[passage.usable, 0, :2].T
        if wrong := wrong_convention(joint, motor, link, passage.command[passage.usable], disc):
            raise CalibrationError(wrong.mended_on_import())


def _check_loads(label: str, passages: Sequence[Passage]) -> None:
    """Check that the torque takes at least two levels."""
    torque = _joined(passages, [passage.reference for passage in passages])
    small, large = np.percentile(torque, [SMALL, LARGE]) + 0.0      # no negative zero
    if large - small < FEWEST_LOADS:
        raise CalibrationError(
            f'{label} bears one load only: its torque stays between {small:.2g} and {large:.2g} '
            f'N*m; add a recording with another tilt, payload or tip force, so that torques are '
            f'at least {FEWEST_LOADS:g} N*m apart')


def _check_sign(label: str, ratio: float, passages: Sequence[Passage]) -> None:
    """Check that torsion and torque go the same way, apart from what goes with angle and speed."""
    torsion = np.concatenate([passage.readings[passage.usable, 0, 0] / ratio
                              - passage.readings[passage.usable, 0, 1] for passage in passages])
    torque = _joined(passages, [passage.reference for passage in passages])
    rest = np.stack([torsion, torque], axis=1)
    other = _turning(passages)
    rest -= other @ np.linalg.lstsq(other, rest, rcond=None)[0]
    torsion, torque = rest.T
    alike = float(torsion @ torque / math.sqrt(max(float(
        (torsion @ torsion) * (torque @ torque)), 1e-300)))
    if alike < -MOSTLY and torque.std() > LEAST_TORQUE:
        raise CalibrationError(
            f'{label}: the torque falls where the torsion grows (correlation {alike:.2f}): the '
            'sign of the reference, the tilt or the tip force is wrong')


def _turning(passages: Sequence[Passage]) -> Floats:
    """Return what shows as torsion while a joint turns (k, 10): a level, skew and waves."""
    motor = np.concatenate([passage.readings[passage.usable, 0, 0] for passage in passages])
    link = _joined(passages, [passage.link_angle for passage in passages])
    rate = _joined(passages, [passage.link_rate for passage in passages])
    waves = [part(angle) for angle in (link, 2.0 * link, motor, 2.0 * motor)
             for part in (np.sin, np.cos)]
    return np.stack([np.ones_like(link), rate, *waves], axis=1)


def check_alike(label: str, recording: str, sensed: Floats, known: Floats) -> None:
    """Raise CalibrationError where two torques of one joint (k,) contradict each other."""
    good = np.isfinite(sensed)
    first, second = sensed[good] - sensed[good].mean(), known[good] - known[good].mean()
    if not good.any() or min(first.std(), second.std()) < LEAST_TORQUE:
        return
    scale = float(first @ second / (second @ second))
    if abs(scale - 1.0) > APART:
        raise CalibrationError(
            f'{label} in {recording}: the references contradict each other: its sensor shows '
            f'{scale:.2f} times the torque of the known loads')


def check_of_one_piece(label: str, errors: Sequence[tuple[str, Floats, Floats]]) -> None:
    """
    Raise CalibrationError where recordings (name, errors (k,), torques (k,)) have other scales.

    One law fits all of them, unless the loads that were stated for some are wrong.
    """
    scales = {name: float((torque - torque.mean()) @ error / (torque - torque.mean()).var()
                          / len(torque))
              for name, error, torque in errors if torque.std() > LARGE_TORQUE}
    if len(scales) < 2:
        return
    least, most = (pick(scales, key=lambda one: scales[one]) for pick in (min, max))
    if scales[most] - scales[least] > APART:
        raise CalibrationError(
            f'{label}: the recordings contradict each other: {most} asks for '
            f'{100.0 * (scales[most] - scales[least]):.0f} % less torque than {least}; check '
            'their stated tilts, payloads and forces')
