"""What a log keeps of a recording: fewer samples, the host's stamps, and velocities or none."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .recording import TruthRecord

Array = NDArray[np.float64]


class Logger(NamedTuple):
    """How a log is kept: every n-th sample, stamps that jitter by so much, and velocities."""

    every: int = 1
    jitter: float = 0.0         # one sigma of the host's stamps [s]
    velocities: bool = False


class Log(NamedTuple):
    """A log (k, ...): stamps [ns], readings (k, n, 4), motor torques (k, n) [N*m], the truth."""

    stamps: NDArray[np.int64]
    reading: Array              # motor and link angle, their rates or NaN [rad, rad/s]
    command: Array
    joint_torque: Array         # true, through the gears [N*m]
    external: Array             # true, of hands and pushes about the joints [N*m]


def kept(seen: TruthRecord, logger: Logger, joints: int, rng: np.random.Generator) -> Log:
    """Return the log of a recording, of the joints that the arm has."""
    rates = _differences(seen) if logger.velocities else np.full((*seen.command.shape, 2), np.nan)
    reading = np.concatenate([np.stack([seen.motor_angle, seen.link_angle], axis=2), rates],
                             axis=2)
    rows, columns = slice(None, None, logger.every), slice(0, joints)
    stamps = seen.stamps[rows]
    if logger.jitter > 0.0:
        late = logger.jitter * np.abs(rng.standard_normal(len(stamps)))
        stamps = np.maximum.accumulate(stamps + np.rint(1e9 * late).astype(np.int64)
                                       ) + np.arange(len(stamps))
    return Log(stamps, reading[rows, columns], seen.command[rows, columns],
               seen.joint_torque[rows, columns], seen.external[rows, columns])


def _differences(seen: TruthRecord) -> Array:
    """Return the rates (k, 2, 2) of a driver: differences of readings, one sample old."""
    angles = np.stack([seen.motor_angle, seen.link_angle], axis=2)
    spans = np.maximum(np.diff(seen.stamps), 1) * 1e-9
    rates = np.zeros_like(angles)
    rates[1:] = np.diff(angles, axis=0) / spans[:, None, None]
    return rates
