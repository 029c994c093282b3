"""
The simulated arm as a driver would present it: samples out, commands and pushes in.

Time is that of the samples: it advances by exactly one period, and nothing here reads a clock.
A host may stamp them later.
"""

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np

from .foundation.arrays import Array
from .foundation.parameter import Declared, parameter
from .health import Refused
from .model.arm import Arm
from .motions import home_of
from .plant import Plant
from .simulate import checked, on_tip
from .stamping import Stamper
from .start import start_of

LONGEST_HOLD = 50_000_000       # time for which a command stays in force [ns]
MOST_UNANSWERED = 4             # samples without a command, after which the arm's time may stand
FIRST_STAMP = 1_000_000_000     # of simulated time: a bag that starts at 0 looks empty [ns]


@dataclass(frozen=True)
class SimulationSettings(Declared):
    """How the arm is simulated; nothing here is a property of the arm."""

    name: ClassVar[str] = 'arm_sim'
    rate: float = parameter(1000.0, 'Hz', 10.0, 20000.0, 'samples per second of its time')
    truth_rate: float = parameter(
        20000.0, 'Hz', 0.1, 20000.0, 'what is true is published at most so often')
    speed: float = parameter(
        1.0, '', 0.001, 1000.0, 'its time over real time; other than 1 publishes /clock')
    seed: float = parameter(0.0, '', 0.0, 2.0 ** 32, 'whole number that the noise starts from')
    patience: float = parameter(
        0.0, 's', 0.0, 60.0, 'real time for which its time stands while a command is late')

    @property
    def period(self) -> int:
        """Return the time from stamp to stamp [ns]."""
        return round(1e9 / self.rate)

    @property
    def truth_divisor(self) -> int:
        """Return of how many samples one is published with what is true."""
        return max(1, round(self.rate / self.truth_rate))


class DriverSample(NamedTuple):
    """One sample of the arm: what its driver shows, and what is true."""

    stamp: int                  # as the driver states it [ns]
    taken: int                  # when it was taken [ns]
    reading: Array              # (n, 4) angles and velocities of shaft and link
    motor_torque: Array         # (n,) in force from the stamp until the next, shaft [N*m]
    joint_torque: Array         # (n,) true, through the gear [N*m]
    tip_force: Array            # (2,) on the tip, base frame [N]; (6,) on a chain, with moments


class LiveArm:
    """An arm that is sampled and advanced in turn, under the last command and push."""

    def __init__(self, arm: Arm, settings: SimulationSettings, first_stamp: int) -> None:
        """Start at rest in the posture where motions start; raises ArmError without links."""
        self.arm, self.settings = checked(arm), settings
        self._stamper = Stamper(arm, int(settings.seed))
        self.begin(first_stamp)
        self._limits = np.array([joint.torque_limit for joint in arm.joints])
        self.axes = on_tip(arm, np.zeros((1, 2))).shape[1]      # components of what acts on it
        self.saturated = 0              # commands beyond the limit of a motor
        self.expired = 0                # times that commands stopped coming
        self.reset()

    def begin(self, stamp: int) -> None:
        """Take the next sample at this time [ns]."""
        self.stamp = self._stated = stamp

    def reset(self) -> None:
        """
        Start again from rest without push; time goes on.

        Until the first command a chain is held, as by its brakes.
        """
        home = start_of(self.arm, home_of(self.arm))
        self._plant = Plant(self.arm, home.state, self.settings.period * 1e-9,
                            int(self.settings.seed))
        self._command = home.command
        self._commanded: int | None = None
        self._force = np.zeros(self.axes)

    def command(self, stamp: int, torque: Array) -> None:
        """
        Put motor torques (n,) [N*m, shaft] in force that answer the sample of `stamp` [ns].

        Raises Refused for torques that are not finite and for a stamp that no sample had lately.
        """
        if not np.isfinite(torque).all():
            raise Refused('effort not finite', f'efforts must be finite, got {torque.tolist()}')
        if not 0 <= max(self.stamp, self._stated) - stamp <= LONGEST_HOLD:
            raise Refused('stamp out of time', 'the stamp must be copied from a sample of the '
                          f'last {LONGEST_HOLD * 1e-9:g} s, got {stamp * 1e-9:.3f} s at '
                          f'{self.stamp * 1e-9:.3f} s')
        limited = np.clip(torque, -self._limits, self._limits)
        self.saturated += int((limited != torque).any())
        self._command, self._commanded = limited, stamp

    @property
    def ahead(self) -> bool:
        """Return whether commands come, and the last one answers a sample of long ago."""
        return (self._commanded is not None
                and self.stamp - self._commanded > MOST_UNANSWERED * self.settings.period)

    def push(self, force: Array) -> None:
        """
        Hold on the tip until the next: a force (2,) [N], or a wrench (6,) on a chain [N, N*m].

        Both are in the base frame. Raises Refused.
        """
        if self.axes > 2:           # of a moment that was left out a tool may say NaN
            force = np.concatenate([force[:3], np.nan_to_num(force[3:], nan=0.0, posinf=np.inf)])
        if not np.isfinite(force).all():
            raise Refused('force not finite', f'the force must be finite, got {force.tolist()}')
        self._force = on_tip(self.arm, force[np.newaxis])[0]

    def sample(self) -> DriverSample:
        """Return the sample now; its reading and its truth are the same arrays always."""
        if self._commanded is not None and self.stamp - self._commanded > LONGEST_HOLD:
            self._command, self._commanded = np.zeros_like(self._limits), None
            self.expired += 1
        reading = self._plant.sample()
        if self._stamper.acts:
            self._stated = int(self._stamper(np.array([self.stamp]))[0])
        else:
            self._stated = self.stamp
        return DriverSample(self._stated, self.stamp, reading, self._command,
                            self._plant.joint_torque, self._force)

    def advance(self) -> None:
        """Move the arm on to the next sample."""
        self._plant.advance(self._command, self._force)
        self.stamp += self.settings.period
