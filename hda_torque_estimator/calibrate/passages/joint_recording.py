"""One joint in one recording with a reference torque: all that a calibration reads of it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

from hda_msgs_json.errors import HdaError
from hda_msgs_json.samples import JointSamples, WrenchSamples
from hda_msgs_json.topics import motor_name
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import convolve1d
from scipy.signal import savgol_filter

from .thinning import row_means, samples_of_row
from ...measurements.effort import acting, HELD
from ...measurements.even_stamps import evened
from ...samples.readings import LINK_RATE, LINK_READING, MOTOR_RATE, MOTOR_READING, READINGS, SIDES

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

# Choices unless stated otherwise.
FEWEST = 20         # samples of a joint, fewer say nothing about any parameter
BRIEFEST = 0.1      # time that they last, less cannot be differentiated [s]
BURST = 0.25        # of the mean time between samples, below which stamps come in bursts
SMOOTHED = 0.05     # time over which a motor is differentiated: stamps of hosts are uneven [s]
FEWEST_BESIDE = 3   # samples that derivatives see on either side at low rates
DEGREE = 3          # of the polynomials that are differentiated


class CalibrationError(HdaError):
    """Recordings from which nothing can be calibrated."""


class ShaftMotion(NamedTuple):
    """How a shaft turned, without delay, k samples."""

    rate: Floats                    # (k,) [rad/s]
    acceleration: Floats            # (k,) [rad/s^2]
    reach: int                      # samples that derivatives see on either side

    def alike(self, torque: Floats) -> Floats:
        """
        Return a torque (k,) as the acceleration is seen: averaged with the same weight.

        The acceleration is that of a parabola fitted to 2 r + 1 samples. It equals that of their
        mean with the weight (1 - x^2)^2, x from -1 to 1. What stands beside it needs the same
        weight. Else what swings faster than the window looks like a lag.
        """
        x = np.arange(-self.reach, self.reach + 1) / (self.reach + 1)
        weight = (1.0 - x ** 2) ** 2
        return np.asarray(convolve1d(torque, weight / weight.sum(), mode='nearest'))


@dataclass(frozen=True, eq=False)
class Measured:
    """One joint in one recording, k samples."""

    recording: str
    stamps: NDArray[np.int64]       # (k,) [ns]
    readings: Floats                # (k, 1, READINGS), NaN for the link where it has no encoder
    command: Floats                 # (k,) motor torque as recorded, NaN unknown [N*m]
    reference: Floats               # (k,) [N*m]
    effort_lag: float = HELD        # samples by which the motor torque acts later

    def varies(self) -> float:
        """Return the deviation of the reference torque from its mean [N*m rms]."""
        return float(self.reference.std())

    @property
    def has_link(self) -> bool:
        """Return whether the angle of the link is known."""
        return bool(np.isfinite(self.readings[:, 0, LINK_READING]).all())

    @property
    def has_command(self) -> bool:
        """Return whether the motor torque is known, for most of the recording."""
        return bool(np.isfinite(self.command).mean() > 0.5)

    @property
    def acting(self) -> Floats:
        """Return the motor torque that acts about each sample (k,), NaN unknown [N*m]."""
        return acting(self.command, self.effort_lag)

    @property
    def time(self) -> Floats:
        """Return the times since the first sample (k,) [s]."""
        return np.asarray((self.stamps - self.stamps[0]) * 1e-9)

    @cached_property
    def dt(self) -> float:
        """Return the usual time between samples [s]; of stamps in bursts it is no less."""
        time = self.time
        return max(float(np.median(np.diff(time))), BURST * float(time[-1]) / (len(time) - 1))

    @property
    def every(self) -> int:
        """Return how many samples make a row."""
        return samples_of_row(self.dt)

    def on_time(self) -> 'Measured':
        """Return the recording with even stamps, if those that it has come in bursts."""
        between = np.diff(self.time)
        if float(np.median(between)) >= BURST * float(between.mean()):
            return self
        return replace(self, stamps=evened(self.stamps))

    def without_spikes(self, velocity_limit: float) -> 'Measured':
        """
        Return the recording without single motor angles that the shaft cannot have reached.

        Each is further from both neighbours, the same way, than the limit [rad/s] takes it.
        """
        steps = np.diff(self.readings[:, 0, MOTOR_READING])
        farthest = velocity_limit * np.maximum(np.diff(self.time), self.dt)
        fast, way = np.abs(steps) > farthest, np.sign(steps)
        kept = np.ones(len(self.stamps), bool)
        kept[1:-1] = ~(fast[:-1] & fast[1:]) | (way[:-1] == way[1:])
        return replace(self, stamps=self.stamps[kept], readings=self.readings[kept],
                       command=self.command[kept], reference=self.reference[kept])

    def with_link(self, ratio: float) -> 'Measured':
        """Return the recording with the link angle of a rigid gear in the place of none."""
        readings = self.readings.copy()
        for link, motor in ((LINK_READING, MOTOR_READING), (LINK_RATE, MOTOR_RATE)):
            readings[:, 0, link] = readings[:, 0, motor] / ratio
        return replace(self, readings=readings)

    def thinned(self, values: Floats) -> Floats:
        """Return the means of values (k, ...) over the samples of each row."""
        return row_means(values, self.dt)

    def later(self, lag: float) -> Floats:
        """Return the reference at a time after each sample [N*m]; at the end it stays."""
        return np.interp(self.time + lag, self.time, self.reference)

    def turning(self) -> ShaftMotion:
        """Return how the shaft turned, by local polynomials on an even grid."""
        grid = self.time[0] + self.dt * np.arange(1 + round(self.time[-1] / self.dt))
        angle = np.interp(grid, self.time, self.readings[:, 0, MOTOR_READING])
        beside = max(FEWEST_BESIDE, round(0.5 * SMOOTHED / self.dt))
        rate, acceleration = (np.interp(self.time, grid, savgol_filter(
            angle, 2 * beside + 1, DEGREE, order, self.dt)) for order in (1, 2))
        return ShaftMotion(rate, acceleration, beside)


def measured(recording: str, joint: str, states: JointSamples,
             reference: WrenchSamples) -> Measured | None:
    """
    Return a joint where its motor's angle and its reference torque are known, None if nowhere.

    A joint may lack its link encoder or its motor torque, not both. The reference may come at any
    rate: it is interpolated between its stamps, never beyond them.
    """
    found, command = _readings(joint, states), _column(states.effort, states, motor_name(joint))
    if not np.isfinite(found[:, 0, MOTOR_READING]).any() or len(reference) < 2:
        return None
    has_link = bool(np.isfinite(found[:, 0, LINK_READING]).any())
    torque = np.interp(states.stamps, reference.stamps, reference.torque[:, 2], np.nan, np.nan)
    later = np.diff(states.stamps, prepend=np.iinfo(np.int64).min // 2) > 0
    known = np.isfinite(found[:, 0, :SIDES if has_link else 1]).all(axis=1)
    used = known & np.isfinite(torque) & later
    if used.sum() < FEWEST or not (has_link or np.isfinite(command[used]).any()):
        return None
    if np.ptp(states.stamps[used]) * 1e-9 < BRIEFEST:
        return None
    return Measured(recording, states.stamps[used], found[used], command[used], torque[used])


def _readings(joint: str, states: JointSamples) -> Floats:
    """Return the readings (k, 1, READINGS) of a joint, NaN where it has no such encoder."""
    found = np.full((len(states.stamps), 1, READINGS), np.nan)
    for side, name in enumerate((motor_name(joint), joint)):
        found[:, 0, side] = _column(states.position, states, name)
        found[:, 0, SIDES + side] = _column(states.velocity, states, name)
    return found


def _column(values: Floats, states: JointSamples, name: str) -> Floats:
    names: Sequence[str] = states.names
    return values[:, names.index(name)] if name in names else np.full(len(values), np.nan)
