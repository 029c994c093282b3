"""
Detect other conventions: a reversed sign, degrees, another ratio, motor at the link.

The motor of a right joint turns `ratio` times as far as its link, the same way. Only torsion and
what is wrong with a disc differ. Slopes are local, so that a slip or an absurd reading spoils
one stretch only. A recording with too little travel shows nothing and is accepted.
"""

import math
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.chain_links import ChainLinks
from hda_arm_sim.model.parts import Joint
from hda_msgs_json.errors import HdaError
from hda_msgs_json.topics import motor_name
import numpy as np
from scipy.ndimage import uniform_filter1d

from ..samples.coupling import (AT_LINK, bend_over, disc_of, kind_of, LINK_DEGREES,
                                MOTOR_DEGREES, RIGHT, TRAVEL, twist_of)
from ..significance import MOSTLY

# Choices unless stated otherwise.
STRETCHES = 9           # of a recording, each with a slope of its own; their median counts
SANE = 1e9              # angle beyond which a reading is no angle [rad]
ENOUGH = 20_000         # samples that show a sign, evenly over a recording (choice)
BRAKING = 0.2           # of the power that goes through a motor, from which it is a brake
SLOWEST = 0.02          # share of the largest speed below which a motor rests
FEWEST = 100            # samples of each way
SMOOTHED = 200          # parts of a recording, over each of which speeds are averaged
WORTHLESS = 1e-9        # of a signal, a share that is rounding (choice)
LEFT = 0.1              # of torsion and motor torque, that no angle explains (choice)
ALIKE = 0.3             # correlation with the acceleration, from which inertia shows the sign
# (null: of 200 windows that have nothing in common, one in ten thousand is above it)


class ConventionError(HdaError):
    """A recording whose angles or torques have another sign, unit or ratio than the arm's."""


class ConventionFault(NamedTuple):
    """What is wrong, in a sentence, and which options of `hda diagnose` mend it."""

    words: str
    options: str = ''

    def mended_on_import(self) -> str:
        """Return the sentence where no option mends it."""
        return self.words + ('; correct it when importing the recording' if self.options else '')

    def mended_by_options(self) -> str:
        """Return the sentence with the options that mend it."""
        return self.words + (f'; say {self.options}' if self.options else '')


def check_conventions(arm: Arm, reading: Array, command: Array, source: str) -> None:
    """
    Raise ConventionError where a recording has other conventions than the arm.

    `reading` (k, n, 2 or more) are angles of shaft and link [rad]. `command` (k, n) the motor
    torques [N*m, shaft], NaN where there are none.
    """
    for column, joint in enumerate(arm.joints):
        motor, link = reading[:, column, 0], reading[:, column, 1]
        torque = signed(arm, motor, command[:, column])
        if wrong := wrong_convention(joint, motor, link, torque, disc_slope(arm, column)):
            raise ConventionError(f'{source}: {wrong.mended_on_import()}')


def signed(arm: Arm, motor: Array, command: Array) -> Array:
    """Return motor torques (k,) whose sign friction can show, NaN where only inertia can."""
    handed_on = isinstance(arm.links, ChainLinks) and speeds_up(motor, command)
    return np.full_like(command, np.nan) if handed_on else command


def disc_slope(arm: Arm, column: int) -> float:
    """Return the slope that the disc of a joint's link encoder may make."""
    return float(disc_of(arm.record().joints[column]))


def wrong_convention(joint: Joint, motor: Array, link: Array, command: Array,
                     disc: float = 0.0) -> ConventionFault | None:
    """
    Return what is wrong with angles [rad] and motor torques [N*m] (k,), None if nothing.

    `disc` is the slope that the disc of the link encoder may make beyond that of any.
    """
    sane = (np.abs(motor) < SANE) & (np.abs(link) < SANE)           # NaN compares false
    motor, link, command = motor[sane], link[sane], command[sane]
    return (wrong_angles(joint, motor, link, disc)
            or wrong_effort(joint, motor, link, command))


def wrong_angles(joint: Joint, motor: Array, link: Array,
                 disc: float = 0.0) -> ConventionFault | None:
    """Return what is wrong with angles (k,) [rad], None if nothing."""
    return wrong_coupling(joint, motor, link, disc) or wrong_step(joint, motor, link)


def wrong_coupling(joint: Joint, motor: Array, link: Array,
                   disc: float = 0.0) -> ConventionFault | None:
    """Return what is wrong with how far shaft and link turn (k,) [rad], None if nothing."""
    slope, span = _local(motor, link, joint.ratio)
    bend = bend_over(_widest(joint), max(span, TRAVEL)) + disc
    code = kind_of(slope, span, joint.ratio, bend)
    return None if code == RIGHT else coupling_sentence(joint, code, slope)


def coupling_sentence(joint: Joint, code: int, slope: float = math.nan) -> ConventionFault:
    """Return a wrong coupling in words, with its slope if that is known."""
    label, motor = joint.label, motor_name(joint.label)
    said = '' if math.isnan(slope) else (f'its motor turns {slope:.5g} times per turn of the link '
                                         f'where the arm file says {joint.ratio:g}: ')
    reasons, options = [], []
    if abs(code) == AT_LINK:
        reasons.append('the motor angle is divided by the ratio already')
        options.append('--motor-at-link')
    if abs(code) in (MOTOR_DEGREES, LINK_DEGREES):
        sides = ('motor', 'link') if abs(code) == MOTOR_DEGREES else ('link', 'motor')
        reasons.append(f'the {sides[0]} angle is in degrees beside a {sides[1]} angle in rad')
        options.append('"unit: deg" on import')
    if code < 0:
        reasons.append('the sign of one encoder is wrong')
        options.append(f'--flip {motor} or --flip {label}')
    if not reasons:
        return ConventionFault(
            f'{label}: {said}the ratio is wrong; correct "ratio" in the arm file')
    return ConventionFault(f'{label}: {said}{" and ".join(reasons)}', ' '.join(options))


def wrong_step(joint: Joint, motor: Array, link: Array) -> ConventionFault | None:
    """Recognise that both angles (k,) are in degrees by the steps in which the motor counts."""
    expected = joint.motor_encoder.step
    changes = np.abs(np.diff(motor))
    changes = changes[changes > 1e-12]
    if expected <= 0.0 or not len(changes) or not _travels(motor, link, joint.ratio):
        return None
    step = float(np.percentile(changes, 1.0))
    if abs(step / math.degrees(expected) - 1.0) >= 0.02:
        return None
    return ConventionFault(f'{motor_name(joint.label)} counts in steps of {step:.3g} where '
                           f'{expected:.3g} rad is right; the angles are in degrees', '--degrees')


def wrong_effort(joint: Joint, motor: Array, link: Array,
                 command: Array) -> ConventionFault | None:
    """Return what is wrong with the sign of motor torques (k,), None if nothing."""
    known = np.isfinite(command[1:]) & np.isfinite(command[:-1])
    speed, torque = np.diff(motor)[known], command[:-1][known]
    largest = joint.torque_limit * 1e3
    if not len(speed) or np.abs(torque).max() > largest or not _travels(motor, link, joint.ratio):
        return None
    moving = np.abs(speed) > SLOWEST * np.percentile(np.abs(speed), 95.0)
    ways = [moving & (speed > 0.0), moving & (speed < 0.0)]
    if min(way.sum() for way in ways) < FEWEST:
        return None             # one way only: a load that goes down drives its motor
    seen = torque[moving], link[:-1][known][moving], speed[moving]
    twists = _twists((motor / joint.ratio - link)[:-1][known][moving], *seen)
    if twists < -MOSTLY:
        return ConventionFault(f'{joint.label}: its gear twists against its motor (correlation '
                               f'{twists:.2f}): the motor torques have the wrong sign; import '
                               'them with the other one')
    if twists <= ALIKE and (_helps(*seen) or all(
            _brakes(torque[way] * speed[way]) for way in ways)):
        return ConventionFault(f'{joint.label}: its motor brakes whenever it turns either '
                               'way: the motor torques have the wrong sign; import them with '
                               'the other one')
    return None


def speeds_up(motor: Array, command: Array) -> bool:
    """
    Return whether torques (k,) speed up the shaft at angles (k,), what follows its sense aside.

    Joints of a chain hand each other energy. So one may brake whenever it turns either way. Yet it
    takes the torque that its own inertia needs.
    """
    known = np.isfinite(command[1:]) & np.isfinite(command[:-1]) & np.isfinite(np.diff(motor))
    speed, torque = np.diff(motor)[known], command[:-1][known]
    if len(speed) < FEWEST:
        return False
    width = max(FEWEST // 10, len(speed) // SMOOTHED)
    even_torque, even_speed = (uniform_filter1d(values, width) for values in (torque, speed))
    others = np.stack([np.ones_like(speed), np.sign(even_speed)], axis=1)
    needs, gives = (values - others @ np.linalg.lstsq(others, values, rcond=None)[0]
                    for values in (np.gradient(even_speed), even_torque))
    size = math.sqrt(float(needs @ needs) * float(gives @ gives))
    return size > 0.0 and float(needs @ gives) > ALIKE * size


def _brakes(power: Array) -> bool:
    return float(power.mean()) < -BRAKING * float(np.abs(power).mean())


def _helps(torque: Array, link: Array, speed: Array) -> bool:
    """
    Return whether friction would help: less torque forwards than backwards at one angle.

    Weight depends on the angle alone, whatever it is, and so does what an encoder does.
    """
    return alike(torque, np.sign(speed), _of_angle(link)) < -MOSTLY


def _twists(torsion: Array, torque: Array, link: Array, speed: Array) -> float:
    """
    Return how a torsion (k,) goes with the motor torque, what goes with angle and speed aside.

    A hand that moves an arm makes its motors brake either way. The gears show which way they bear.
    """
    width = max(FEWEST // 10, len(torque) // SMOOTHED)
    aside = np.column_stack([_of_angle(link), speed, np.sign(speed)])
    first, second, others = (uniform_filter1d(values, width, axis=0)
                             for values in (torsion, torque, aside))
    return alike(first, second, others, LEFT)


def _of_angle(link: Array) -> Array:
    """Return what follows the angle of a link (k,) alone, its encoder's disc too (k, 6)."""
    waves = [part(order * link) for order in (1, 2) for part in (np.sin, np.cos)]
    return np.stack([np.ones_like(link), link, *waves], axis=1)


def alike(first: Array, second: Array, aside: Array, least: float = WORTHLESS) -> float:
    """
    Return the correlation of two signals (k,) without what goes with others (k, p).

    It is 0 where less than a share `least` of either is left.
    """
    few = slice(None, None, max(1, len(first) // ENOUGH))
    both, aside = np.stack([first, second], axis=1)[few], aside[few]
    left = both - aside @ np.linalg.lstsq(aside, both, rcond=None)[0]
    size, whole = np.sqrt((left ** 2).sum(axis=0)), np.sqrt((both ** 2).sum(axis=0))
    if not (size > least * whole).all():
        return 0.0
    return float(left[:, 0] @ left[:, 1] / (size[0] * size[1]))


def _widest(joint: Joint) -> float:
    return float(twist_of(joint.torsion.record(joint.ratio)['valid_torsion']))


def _travels(motor: Array, link: Array, ratio: float) -> bool:
    return len(motor) > 1 and max(float(np.ptp(link)), float(np.ptp(motor)) / ratio) >= TRAVEL


def _local(motor: Array, link: Array, ratio: float) -> tuple[float, float]:
    """Return the median of local slopes of motor over link, and the travel it is known from."""
    parts = [(m, x) for m, x in zip(np.array_split(motor, STRETCHES),
                                    np.array_split(link, STRETCHES)) if _travels(m, x, ratio)]
    parts = parts or [(motor, link)] * _travels(motor, link, ratio)
    if not parts:
        return ratio, 0.0
    found = sorted((_slope(*part), max(np.ptp(part[1]), np.ptp(part[0]) / ratio))
                   for part in parts)
    return found[len(found) // 2][0], float(np.median([span for _, span in found]))


def _slope(motor: Array, link: Array) -> float:
    """Return the slope of motor over link by the motor, whose angle scatters least at the link."""
    link, motor = link - link.mean(), motor - motor.mean()
    both, least = float(link @ motor), 1e-12 * float(motor @ motor)
    return float(motor @ motor) / (math.copysign(max(abs(both), least), both) or 1e-300)
