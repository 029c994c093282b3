"""
Whether something unknown leads the links: motors do nothing, and yet torque goes through gears.

Then the links' equation of motion holds a force that nobody measured, and determines nothing. The
two sides of the gears still do: what twists a gear must move its motor (eq:balance-led).
"""

from hda_arm_sim.model.arm import Arm
import numpy as np

from .coordinates import torques_of
from ...measurements.measurement import Measurement

# Choices unless stated otherwise.
# (source: a motor that moves its link gives all of that torque, and friction beside it)
_NOTHING = 0.05         # share of the torque through a gear below which its motor does nothing
_ENOUGH = 5000          # samples that suffice, evenly over a recording


def is_led(measurement: Measurement, arm: Arm) -> bool:
    """Return whether the motors of a recording do nothing while torque goes through the gears."""
    every = max(1, len(measurement.command) // _ENOUGH)
    angle, command = measurement.reading[::every], measurement.command[::every]
    torque = torques_of(arm, angle[:, :, 0], angle[:, :, 1])
    given = arm.record().joints['ratio'] * command
    return bool((np.sqrt(np.mean(given ** 2, axis=0)) < _NOTHING * np.std(torque, axis=0)).all())


def why_led(measurement: Measurement, arm: Arm) -> str:
    """Return why nobody knows what loads the links of a recording, empty where it is known."""
    if arm.links is None:
        return 'the arm file has no model of its links'
    if is_led(measurement, arm):
        return 'the motors do nothing while the arm moves: it is led by a hand or a load'
    return ''
