"""
Torques of gears as sensors have them, a witness beside or instead of links (eq:balance-reference).

A sensor has errors of its own: its zero, its gain, how late it is, and how it smooths. They
belong to the recording, so they are tolerances of a fit and never a cause.
"""

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.parts import SensorErrors
import numpy as np

from ...measurements.measurement import Measurement, without_gaps


def sensed_torques(measurement: Measurement, arm: Arm) -> Array:
    """Return what the gears carry by their sensors (k, n), 0 where there is none [N*m]."""
    torque = np.zeros(measurement.command.shape)
    for place in np.flatnonzero(measurement.referenced):
        for piece in measurement.pieces():
            torque[piece, place] = torque_behind(
                without_gaps(measurement.reference[piece, place]), arm.joints[place].sensor,
                measurement.dt)
    return torque


def torque_behind(shown: Array, errors: SensorErrors, dt: float) -> Array:
    """Return the torque (k,) behind what a sensor with these errors shows (k,) [N*m]."""
    if errors.lag:
        time = dt * np.arange(len(shown), dtype=np.float64)
        shown = np.interp(time + errors.lag, time, shown)
    if errors.blur:
        shown = shown - 0.5 * errors.blur * np.gradient(np.gradient(shown, dt), dt)
    return np.asarray((shown - errors.zero) / (1.0 + errors.gain))


def sensor_key(arm: Arm) -> tuple[SensorErrors, ...]:
    """Return all of an arm that the torques by its sensors depend on."""
    return tuple(joint.sensor for joint in arm.joints)
