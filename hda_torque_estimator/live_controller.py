"""
The controller as a node has it: samples and torques in, commands out, and a watchdog over both.

With torque feedback a command answers the sample and the estimated torque of one and the same
stamp, so it does not depend on which of them came first. Steady time is given, never read, and
decides only when to stop.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

from hda_arm_sim.health import Refused
from hda_arm_sim.inputs import EffortReader
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.parameter import Declared, parameter
from hda_msgs_json.cdr import JointStateEncoder
from hda_msgs_json.topics import JOINT_STATES, JOINT_TORQUES, motor_name
import numpy as np
from numpy.typing import NDArray

from .controller import Controller, ControllerSettings
from .estimate import MOTOR_READING
from .gaps import Gaps
from .pairing import Pair, Pairing
from .readings import SIDES
from .reference import hold, reference_from, TrajectoryError
from .sample_reader import not_later, SampleReader
from .watchdog import Watchdog

Array = NDArray[np.float64]


@dataclass(frozen=True)
class WatchSettings(Declared):
    """When the controller gives up."""

    name: ClassVar[str] = 'watchdog'
    sample_timeout: float = parameter(
        0.012, 's', 0.001, 1.0, 'time without a usable sample after which the motors are let go')


class Trajectory(NamedTuple):
    """Points to follow: seconds from now, link angles [rad], rates [rad/s] of all or none."""

    names: Sequence[str]
    times: Sequence[float]
    angles: Sequence[Sequence[float]]
    rates: Sequence[Sequence[float]]


class LiveController:
    """Answer samples with commands while enabled; `stopped` says why it is not."""

    def __init__(self, arm: Arm, settings: ControllerSettings = ControllerSettings(),
                 watch: WatchSettings = WatchSettings(), *, enabled: bool = False) -> None:
        """Prepare for an arm, compiled; with `enabled` it takes over at the first sample."""
        _warm_up(arm)
        self.controller = Controller(arm, settings)
        self.watchdog = Watchdog(watch.sample_timeout)
        self.stopped = ''
        self.gaps = Gaps()
        self.answered = self.limited = 0
        self._limits = np.array([joint.torque_limit for joint in arm.joints])
        self._ratios = np.array([joint.ratio for joint in arm.joints])
        self._read = SampleReader(arm)
        self._read_torque = EffortReader(arm.labels)
        motors = [motor_name(label) for label in arm.labels]
        self._encode = JointStateEncoder(motors, position=False, velocity=False)
        self._pairing = Pairing()
        self._last: Pair | None = None
        self._usable = Watchdog(watch.sample_timeout)
        self._fault = ''
        self._enable_first = enabled

    @property
    def enabled(self) -> bool:
        """Tell whether samples are answered with commands."""
        return self.controller.enabled

    @property
    def stamp(self) -> int:
        """Return the stamp of the last sample, 0 before any [ns]."""
        return 0 if self._last is None else self._last.stamp

    def sample(self, message: bytes, now: float) -> bytes | None:
        """Take a joint state; returns a command if one is due. Raises Refused."""
        try:
            stamp, angle = self._usable_sample(message)
        except Refused as refused:
            self._fault = str(refused)
            raise
        self._usable.feed(now)
        if self.controller.settings.torque_feedback == 0.0:
            return self._answer(Pair(stamp, angle, np.zeros_like(angle)), now)
        return self._answer(self._pairing.add_angle(stamp, angle), now)

    def torque(self, message: bytes, now: float) -> bytes | None:
        """Take the estimated joint torques; returns a command if one is due. Raises Refused."""
        if self.controller.settings.torque_feedback == 0.0:
            return None
        stamp, torque = self._read_torque(message)
        if not np.isfinite(torque).all():
            raise Refused('torque not finite', f'torques must be finite, got {torque.tolist()}')
        return self._answer(self._pairing.add_torque(stamp, torque), now)

    def watch(self, now: float) -> bytes | None:
        """Stop if what must keep coming has not come; returns the last command then, zero."""
        if not self.enabled or not self.watchdog.expired(now):
            return None
        return self._stop(self._why(now))

    def enable(self, now: float) -> None:
        """Take over where the arm is; raises Refused without samples that can be used."""
        if self._last is None or not self.watchdog.alive(now):
            raise Refused('enabled too early', f'not enabled: {self._why(now)}')
        if not self.enabled:
            self._take_over(self._last)

    def disable(self) -> bytes | None:
        """Let the motors go; returns the last command, zero, if one is due."""
        self._enable_first = False
        if not self.enabled:
            return None
        return self._stop('')

    def follow(self, trajectory: Trajectory) -> None:
        """Follow a trajectory that begins with the last sample; raises Refused."""
        now = self.controller.present_reference(self.stamp)
        if now is None or not self.enabled:
            raise Refused('not enabled', 'a target needs an enabled controller; call '
                          'jtf_controller/enable before')
        try:
            reference = reference_from(self.controller.arm, *trajectory, now)
        except TrajectoryError as error:
            raise Refused('target out of bounds', str(error)) from None
        self.controller.follow(reference, self.stamp)

    def watch_for(self, watch: WatchSettings) -> None:
        """Give up after another time from now on."""
        self.watchdog.timeout = self._usable.timeout = watch.sample_timeout

    def _usable_sample(self, message: bytes) -> tuple[int, Array]:
        stamp, reading = self._read(message)
        if not np.isfinite(reading[:, :SIDES]).all():
            raise self._read.not_finite(stamp, reading)
        if self.enabled and stamp <= self.stamp:
            raise not_later(stamp, self.stamp)
        return stamp, reading[:, MOTOR_READING].copy()

    def _answer(self, pair: Pair | None, now: float) -> bytes | None:
        if pair is None:
            return None
        last, self._last = self._last, pair
        self.watchdog.feed(now)
        if self._enable_first:
            self._take_over(pair)
        if not self.enabled:
            return None
        if last is not None and pair.stamp - last.stamp > self.watchdog.timeout * 1e9:
            return self._stop(f'{(pair.stamp - last.stamp) * 1e-9:g} s lie between two stamps of '
                              f'{JOINT_STATES.name}')
        command = self.controller.update(*pair)
        self.answered += 1
        self.gaps.add(pair.stamp)
        self.limited += int((np.abs(command) >= self._limits).any())
        return self._encode(pair.stamp, effort=command.tolist())

    def _take_over(self, pair: Pair) -> None:
        self._enable_first, self.stopped = False, ''
        self.gaps.restart()
        self.controller.enable()
        self.controller.follow(hold(pair.motor_angle / self._ratios), pair.stamp)

    def _stop(self, why: str) -> bytes:
        self.stopped = why
        self.controller.stop()
        self._pairing.clear()
        return self._encode(self.stamp, effort=self.controller.command.tolist())

    def _why(self, now: float) -> str:
        """Return what is missing."""
        within = f'for {self.watchdog.timeout:g} s'
        if self._usable.alive(now):
            return f'no {JOINT_TORQUES.name} of the samples {within}, which torque feedback needs'
        fault = f'; the last one was refused: {self._fault}' if self._fault else ''
        return f'no {JOINT_STATES.name} that can be used {within}{fault}'


def _warm_up(arm: Arm) -> None:
    """Have every compiled function loaded, which may take longer than a sample."""
    scratch, zeros = Controller(arm), np.zeros(len(arm.joints))
    scratch.enable()
    for stamp in (1, 2):
        scratch.update(stamp, zeros, zeros)
