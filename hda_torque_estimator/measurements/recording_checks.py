"""
Check what raw data must fulfil before anything is concluded from it, and mend what may be.

A recording in other units, or with a flipped sign, would be explained by wrong causes;
`conventions.py` recognises it.
"""

from dataclasses import dataclass, replace
import math

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
from hda_msgs_json.errors import HdaError
from hda_msgs_json.samples import JointSamples
from hda_msgs_json.topics import motor_name
import numpy as np

from .conventions import disc_slope, signed, wrong_convention
from .measurement import Measurement

# Choices unless stated otherwise.
SHORTEST = 5.0          # recording from which anything can be concluded [s]


class GateError(HdaError):
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
        absent = [name for name in (label, motor) if name not in samples.names]
        if absent == [motor]:
            raise GateError(
                f'{source}: no {motor}, so the motor side of {label} was not recorded; a '
                'diagnosis needs the angle and the torque of the motor')
        if absent:
            raise GateError(
                f'{source}: {", ".join(absent)} missing, it names {", ".join(samples.names)}; '
                'name the joints in the arm file as the recording does')
        check_torque(samples.select([motor]).effort, label, source)
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


def check_duration(seconds: float, least: float, source: str) -> None:
    """Raise GateError for a recording that lasts less than something asks for [s]."""
    if (seconds := round(seconds, 1)) < least:
        raise GateError(f'{source}: {seconds:g} s are too short; record at least {least:g} s, '
                        'better 60 s')


def check_torque(torque: Array, label: str, source: str) -> None:
    """Raise GateError unless some torque (k,) of a joint's motor is known."""
    if not np.isfinite(torque).any():
        raise GateError(f'{source}: no motor torque of {label}; record the commanded torque '
                        f'as the effort of {motor_name(label)}')


def check(measurement: Measurement, arm: Arm, source: str) -> None:
    """Raise GateError for a recording that is too short or has other conventions than the arm."""
    check_duration(measurement.duration, SHORTEST, source)
    for column, joint in enumerate(arm.joints):
        motor, link = measurement.reading[:, column].T
        if wrong := wrong_convention(
                joint, motor, link, signed(arm, motor, measurement.command[:, column]),
                disc_slope(arm, column)):
            raise GateError(f'{source}: {wrong.mended_by_options()}')
