"""
Noise that a loop repeats: its commands follow readings, and so what readings scatter by.

A curve along the rate of a command then has the noise of the balances, where the encoder is
coarse. By how much, the log shows: in high differences of commands and readings no motion is
left, and one follows the other (eq:loop-gains).
"""

from hda_arm_sim.foundation.arrays import Array
import numpy as np

from .balance import Balancer
from ...measurements.measurement import Measurement

# Numerics; choices unless stated otherwise.
_DIFFERENCES = 4        # of samples, in which hardly any motion is left
_REMEMBERED = 4         # readings that a command follows, the newest first


def noisier_commands(balancer: Balancer) -> Array:
    """
    Return commands (k, n) of a loop that read the readings of `noisier` balances [N*m, shaft].

    The loop is that of the log: it must have held its commands from sample to sample.
    """
    made, noisier = (each.measurement.as_recorded() for each in (balancer, balancer.noisier))
    more = noisier.reading - made.reading
    added = np.stack([_lagged(more[:, joint]) @ gains
                      for joint, gains in enumerate(_loop_gains(made))], axis=1)
    command = balancer.measurement.command
    return command + np.repeat(added, balancer.measurement.parts, axis=0)[:len(command)]


def _loop_gains(recorded: Measurement) -> list[Array]:
    """Return for each joint how far its command follows its last readings (8,) [N*m/rad]."""
    gains = []
    for joint in range(len(recorded.labels)):
        known = [(_quick(_lagged(recorded.reading[piece, joint])),
                  _quick(recorded.command[piece, joint])) for piece in recorded.pieces()]
        readings, commands = (np.concatenate(each) for each in zip(*known))
        gains.append(np.linalg.lstsq(readings, commands, rcond=None)[0])
    return gains


def _lagged(readings: Array) -> Array:
    """Return the last readings (k, 2) of both encoders at every sample, in columns (k, 8)."""
    return np.concatenate([np.roll(readings, lag, axis=0) for lag in range(_REMEMBERED)], axis=1)


def _quick(values: Array) -> Array:
    """Return high differences of samples (k, ...) that a whole memory precedes."""
    return np.diff(values[_REMEMBERED:], _DIFFERENCES, axis=0)
