"""
A measurement of the same motion with about as much noise again (eq:fair).

What the noise of readings, of commands that a log has not kept, and of torques makes of balances
depends on the arm. So it is added to what was measured, and the balances are made again.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
import numpy as np

from ...measurements.measurement import Measurement
from ...measurements.upsampling import between

# Numerics; choices: seeds of noise, each another.
_READINGS, _SENSORS, _COMMANDS = 0, 1, 2


@dataclass(frozen=True, eq=False)
class TorqueResponse:
    """What a recording has more where torques are noisy: the motion and the loop answer them."""

    reading: Array          # (k, n, 2) angles of shaft and link [rad]
    command: Array          # (k, n) [N*m, shaft]
    reference: Array        # (k, n) of sensors [N*m], empty where nothing is known of any

    def added_to(self, made: Measurement) -> Measurement:
        """Return a measurement along the same motion with this noise beside its own."""
        more = replace(made, reading=made.reading + self.reading,
                       command=made.command + self.command)
        return more if not made.reference.size else replace(
            more, reference=made.reference + self.reference)


class KnownNoise(NamedTuple):
    """What is known of the noise of balances."""

    shared: Array | None = None     # (n,) of that of the second ones, how much the third have
    of_torques: TorqueResponse | None = None


def noisier_readings(made: Measurement) -> Measurement:
    """Return a measurement whose readings have as much noise again, and whose sensors have."""
    parts = made.parts
    more = replace(made, reading=_noisier(made.reading, made.reading_noise(), parts, _READINGS))
    if not made.referenced.any():
        return more
    return replace(more, reference=_noisier(
        made.reference, made.reference_noise(), parts, _SENSORS))


def less_known_commands(made: Measurement) -> Measurement | None:
    """Return one whose commands are known as badly again, None where a log has kept them all."""
    noise = made.command_noise()
    if not noise.any():
        return None
    return replace(made, command=_noisier(made.command, noise, made.parts, _COMMANDS))


def _noisier(values: Array, noise: Array, parts: int, seed: int) -> Array:
    """Return values (k, ...) with white noise of recorded samples, and its spline between."""
    random = np.random.default_rng(seed).standard_normal(values[::parts].shape)
    return values + between(noise * random, parts)
