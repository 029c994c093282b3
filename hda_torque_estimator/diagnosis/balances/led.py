"""
Whether something unknown leads the links: motors do nothing, and yet torque goes through gears.

Then the links' equation of motion holds a force that nobody measured, and determines nothing. The
two sides of the gears still do: what twists a gear must move its motor (eq:balance-led).
"""

import math

from hda_arm_sim.model.arm import Arm
import numpy as np

from .coordinates import torques_of
from ...measurements.measurement import Measurement
from ...significance import DEVIATIONS, HARDLY

# Numerics; choices unless stated otherwise.
_ENOUGH = 5000          # samples that suffice, evenly over a recording


def is_led(measurement: Measurement, arm: Arm) -> bool:
    """
    Return whether motors do nothing while torque goes through the gears, or turns their shafts.

    What noise of the readings makes of a stiff gear goes through none. Behind coarse encoders that
    is all that shows. But a shaft that turns rubs, and something must turn it.
    """
    every = max(1, len(measurement.command) // _ENOUGH)
    angle, command = measurement.reading[::every], measurement.command[::every]
    noise = measurement.reading_noise() * np.random.default_rng(0).standard_normal(angle.shape)
    torque, noisier = (torques_of(arm, each[:, :, 0], each[:, :, 1])
                       for each in (angle, angle + noise))
    through = np.var(torque, axis=0) - np.var(noisier - torque, axis=0)
    ratio, step = arm.record().joints['ratio'], np.abs(np.diff(angle[:, :, 0], axis=0))
    turned = step > math.sqrt(2.0) * DEVIATIONS * measurement.reading_noise()[:, 0]
    dry = np.array([joint.dry_friction for joint in arm.joints])
    rubbed = (ratio * dry) ** 2 * turned.mean(axis=0)
    given = np.mean((ratio * command) ** 2, axis=0)
    return bool((given < HARDLY ** 2 * np.maximum(through, rubbed)).all())


def held_against(measurement: Measurement) -> tuple[str, ...]:
    """Return what the gears of led links are held against, nothing where it is as ever."""
    sensed = [label for label, one in zip(measurement.labels, measurement.held_against) if one]
    alone = [label for label in measurement.labels if label not in sensed]
    if not sensed:
        return ()
    said = [f'{", ".join(sensed)}: motor and torsion are held against the reference torque, whose '
            'own zero, gain and lag are tolerated; an offset of the drive may be taken for its '
            'zero']
    if alone:
        said.append(f'{", ".join(alone)}: the motor is held against the torsion alone')
    return tuple(said)


def third_witnesses(measurement: Measurement) -> tuple[str, ...]:
    """Return what is known of joints with a reference torque beside their links, if any."""
    third = [label for label, one in zip(measurement.labels, measurement.thrice_witnessed) if one]
    if not third:
        return ()
    return (f'{", ".join(third)}: the reference torque is a third witness beside motor, torsion '
            'and links, whose own zero, gain and lag are tolerated',)


def why_led(measurement: Measurement, arm: Arm) -> str:
    """Return why nobody knows what loads the links of a recording, empty where it is known."""
    if arm.links is None:
        return 'the arm file has no model of its links'
    if is_led(measurement, arm):
        return 'the motors do nothing while the arm moves: it is led by a hand or a load'
    return ''
