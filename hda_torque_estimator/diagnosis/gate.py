"""
What raw data must fulfil before anything is concluded from it, and what mends it.

A recording in other units, or with a flipped sign, would be explained by wrong causes; it is
recognised by the ratio of the two encoders' travel and by the steps in which they count.
"""

from dataclasses import dataclass, replace
import math

from hda_arm_sim.model.arm import Arm
from hda_msgs_json.samples import JointSamples
from hda_msgs_json.topics import motor_name
import numpy as np
from numpy.typing import NDArray

from .measurement import Measurement

Array = NDArray[np.float64]
SHORTEST = 5.0          # recording from which anything can be concluded [s]
_TRAVEL = 0.02          # link travel from which the ratio of the encoders is known [rad]


class GateError(ValueError):
    """A recording on which no diagnosis may be built."""


@dataclass(frozen=True)
class Mending:
    """What the user says about the recording's conventions."""

    degrees: bool = False               # all angles are in degrees
    motor_at_link: bool = False         # motor angles are divided by the gear ratio
    flipped: tuple[str, ...] = ()       # names whose angle (and torque) has the other sign


def check_names(samples: JointSamples, arm: Arm, source: str) -> None:
    """Raise GateError unless both sides of every joint and the motor torques are there."""
    for label in arm.labels:
        motor = motor_name(label)
        if motor not in samples.names or label not in samples.names:
            absent = [name for name in (label, motor) if name not in samples.names]
            raise GateError(
                f'{source}: {", ".join(absent)} missing, it names {", ".join(samples.names)}; '
                'name the joints in the arm file as the recording does')
        if not np.isfinite(samples.select([motor]).effort).any():
            raise GateError(f'{source}: no motor torque of {label}; record the commanded torque '
                            f'as the effort of {motor}')
        for name in (label, motor):
            if not np.isfinite(samples.select([name]).position).any():
                raise GateError(f'{source}: no angle of {name}; both encoders are needed')


def mended(samples: JointSamples, arm: Arm, mending: Mending, source: str) -> JointSamples:
    """Return samples in rad, both angles positive the same way, motors at the shaft."""
    if unknown := [name for name in mending.flipped if name not in samples.names]:
        raise GateError(f'{source}: --flip {unknown[0]} names nothing here; it names '
                        f'{", ".join(samples.names)}')
    unit = math.pi / 180.0 if mending.degrees else 1.0
    ratios = {motor_name(joint.label): joint.ratio for joint in arm.joints}
    turns = np.array([ratios.get(name, 1.0) if mending.motor_at_link else 1.0
                      for name in samples.names])
    signs = np.array([-1.0 if name in mending.flipped else 1.0 for name in samples.names])
    return replace(samples, position=samples.position * (unit * turns * signs),
                   velocity=samples.velocity * (unit * turns * signs),
                   effort=samples.effort * signs)


def check(measurement: Measurement, arm: Arm, source: str) -> None:
    """Raise GateError for a recording that is too short or in other units than it should be."""
    if measurement.duration < SHORTEST:
        raise GateError(f'{source}: {measurement.duration:.2g} s are too short; record at least '
                        f'{SHORTEST:g} s, better 60 s')
    for column, joint in enumerate(arm.joints):
        motor, link = measurement.reading[:, column].T
        if np.ptp(link) < _TRAVEL and np.ptp(motor) < _TRAVEL * joint.ratio:
            continue
        _check_ratio(_slope(link, motor), joint.ratio, joint.label, source)
        _check_step(motor, joint.motor_encoder.step, motor_name(joint.label), source)


def _slope(link: Array, motor: Array) -> float:
    """Return how far the motor turns for each rad of the link."""
    link, motor = link - link.mean(), motor - motor.mean()
    return float(link @ motor) / max(float(link @ link), 1e-300)


def _check_ratio(slope: float, ratio: float, label: str, source: str) -> None:
    if abs(slope / ratio - 1.0) < 0.1:
        return
    causes: tuple[tuple[float, str], ...] = (
        (-ratio, f'a flipped sign: say --flip {motor_name(label)} or --flip {label}'),
        (1.0, 'a motor angle that is divided by the ratio already: say --motor-at-link'),
        (-1.0, 'a motor angle divided by the ratio, with a flipped sign: say --motor-at-link '
               f'--flip {motor_name(label)}'),
        (ratio * 180.0 / math.pi, 'a motor angle in degrees beside a link angle in rad: convert '
                                  'one of them on import (unit: deg)'),
        (ratio * math.pi / 180.0, 'a link angle in degrees beside a motor angle in rad: convert '
                                  'one of them on import (unit: deg)'))
    for expected, cause in causes:
        if abs(slope / expected - 1.0) < 0.1:
            raise GateError(f'{source}: the motor of {label} turns {slope:.4g} for 1 of the link '
                            f'where the gear ratio is {ratio:g}; that is {cause}')
    raise GateError(f'{source}: the motor of {label} turns {slope:.4g} for 1 of the link where '
                    f'the gear ratio is {ratio:g}; correct "ratio" in the arm file')


def _check_step(angle: Array, expected: float, name: str, source: str) -> None:
    """Recognise degrees by the steps in which an encoder counts."""
    changes = np.abs(np.diff(angle))
    changes = changes[changes > 1e-12]
    if expected <= 0.0 or not len(changes):
        return
    step = float(np.percentile(changes, 1.0))
    whole = step / (expected * 180.0 / math.pi)
    if abs(whole - 1.0) < 0.02:
        raise GateError(f'{source}: {name} counts in steps of {step:.3g} where {expected:.3g} rad '
                        'is right; the angles are in degrees: say --degrees')
