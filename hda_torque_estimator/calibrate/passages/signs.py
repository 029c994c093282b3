"""Whether the witnesses of a joint and its references have the same sign, and its right ratio."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

from hda_arm_sim.model.arm import Arm
import numpy as np
from numpy.typing import NDArray

from .joint_recording import Measured
from ...measurements.conventions import alike, disc_slope, wrong_angles
from ...samples.readings import LINK_READING, MOTOR_READING
from ...significance import MOSTLY

Floats = NDArray[np.float64]


class SignFaults(NamedTuple):
    """Why a joint, its torsion or its motor cannot be calibrated, '' where it can."""

    joint: str = ''
    torsion: str = ''
    motor: str = ''


def wrong_signs(arm: Arm, recordings: Sequence[Measured]) -> SignFaults:
    """
    Return what is wrong with signs and units of one joint, as references show it.

    A wrong sign of one witness spoils that witness alone. Where both fall as the reference grows,
    it is the reference's.
    """
    for one in recordings:
        motor, link = one.readings[:, 0, (MOTOR_READING, LINK_READING)].T
        if one.has_link and (wrong := wrong_angles(arm.joints[0], motor, link,
                                                   disc_slope(arm, 0))):
            return SignFaults(f'{one.recording}: {wrong.mended_on_import()}')
    torsion, motor = (_correlation(recordings, arm, side) for side in (_torsion, _motor))
    falls = [seen < -MOSTLY for seen in (torsion, motor)]
    if all(falls) or (falls[0] and motor == 0.0):
        return SignFaults(f'its torsion falls where the reference grows (correlation '
                          f'{torsion:.2f}): the sign of the reference is wrong, or that of '
                          'both angles')
    return SignFaults('', 'its torsion falls where reference and motor torque grow (correlation '
                      f'{torsion:.2f}): check the signs of both angles' if falls[0] else '',
                      'its motor torques fall where the reference grows (correlation '
                      f'{motor:.2f}): they have the wrong sign; import them with the other one'
                      if falls[1] else '')


class _Seen(NamedTuple):
    """A signal of a recording, and what else goes with angle and speed (k, p)."""

    signal: Floats
    aside: Floats


def _torsion(one: Measured, arm: Arm) -> _Seen | None:
    """Return the torsion of a recording, beside a disc, waves of the motor, and a skew."""
    if not one.has_link:
        return None
    motor, link = one.readings[:, 0, (MOTOR_READING, LINK_READING)].T
    rate = one.turning().rate
    waves = [part(angle) for angle in (link, 2.0 * link, motor, 2.0 * motor)
             for part in (np.sin, np.cos)]
    return _Seen(motor / arm.joints[0].ratio - link, np.stack([rate, np.sign(rate), *waves], 1))


def _motor(one: Measured, arm: Arm) -> _Seen | None:
    """Return the motor torque of a recording, beside friction."""
    if not one.has_command:
        return None
    rate = one.turning().rate
    return _Seen(np.where(np.isfinite(one.command), one.command, np.nanmean(one.command)),
                 np.stack([rate, np.sign(rate)], axis=1))


def _correlation(recordings: Sequence[Measured], arm: Arm,
                 side: Callable[[Measured, Arm], _Seen | None]) -> float:
    """Return the correlation of a witness with the references, each about its mean, else 0."""
    seen = [(found, one) for one in recordings if (found := side(one, arm)) is not None]
    if not seen:
        return 0.0
    signal, aside, reference = (np.concatenate([
        (rows := one.thinned(values)) - rows.mean(axis=0) for values, one in columns])
        for columns in ([(found.signal, one) for found, one in seen],
                        [(found.aside, one) for found, one in seen],
                        [(one.reference, one) for _, one in seen]))
    return alike(signal, reference, aside)
