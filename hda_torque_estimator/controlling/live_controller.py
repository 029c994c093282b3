"""
The controller as a node has it: samples and torques in, commands out, and a watchdog over both.

With torque feedback a command answers the sample and the estimated torque of one and the same
stamp. So it does not depend on which of them came first. Steady time is given, never read, and
decides only when to stop.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.parameter import Declared, parameter, ParameterError
from hda_arm_sim.health import Refused
from hda_arm_sim.inputs import EffortReader
from hda_arm_sim.model.arm import Arm
from hda_msgs_json.cdr import JointStateEncoder
from hda_msgs_json.topics import JOINT_STATES, JOINT_TORQUES, motor_name
import numpy as np

from .controller import Controller, ControllerSettings
from .loop_stability import is_stable, stable_range
from .pairing import Pairing, SamplePair
from .reference import hold, LARGEST_STEP, reference_from, TrajectoryError
from .target_check import Checked
from .watchdog import Watchdog
from ..samples.gaps import Gaps
from ..samples.readings import MOTOR_READING, SIDES
from ..samples.sample_faults import Fault
from ..samples.sample_reader import not_later, SampleReader
from ..samples.sample_watch import SampleWatch

NOMINAL_PERIOD = 1e-3   # of samples until their stamps show it [s]
BEYOND = 10.0           # of the torque for which a gear's law is valid: no estimate of this arm


@dataclass(frozen=True)
class WatchSettings(Declared):
    """When the controller gives up."""

    name: ClassVar[str] = 'watchdog'
    sample_timeout: float = parameter(
        0.012, 's', 0.001, 1.0, 'time without a usable sample after which the motors are let go')


class TargetPoints(NamedTuple):
    """Points to follow: seconds from now, link angles [rad], rates [rad/s] of all or none."""

    names: Sequence[str]
    times: Sequence[float]
    angles: Sequence[Sequence[float]]
    rates: Sequence[Sequence[float]]


class LiveController:
    """Answer samples with commands while enabled; `stopped` says why it is not."""

    def __init__(self, arm: Arm, settings: ControllerSettings = ControllerSettings(),
                 watch: WatchSettings = WatchSettings(), *, enabled: bool = False,
                 allow_unstable_gain: bool = False) -> None:
        """
        Prepare for an arm, compiled; with `enabled` it takes over at the first sample.

        Raises ParameterError for torque feedback that this arm does not bear, unless allowed.
        """
        _warm_up(arm)
        self.controller = Controller(arm, settings)
        self.gaps = Gaps()
        self._any_gain = allow_unstable_gain
        self.watchdog = Watchdog(watch.sample_timeout)
        self.stopped = ''
        self.answered = self.limited = 0
        self._limits = np.array([joint.torque_limit for joint in arm.joints])
        self._ratios = np.array([joint.ratio for joint in arm.joints])
        self._read = SampleReader(arm)
        self._samples = SampleWatch(arm, apart=LARGEST_STEP)
        self._largest = np.array([BEYOND * joint.torsion.valid_torque for joint in arm.joints])
        self._read_torque = EffortReader(arm.labels)
        motors = [motor_name(label) for label in arm.labels]
        self._encode = JointStateEncoder(motors, position=False, velocity=False)
        self._pairing = Pairing()
        self._last: SamplePair | None = None
        self._usable = Watchdog(watch.sample_timeout)
        self._fault = ''
        self._doubt = Watchdog(watch.sample_timeout)    # fed by samples that cannot be
        self._enable_first, self._in_doubt = enabled, False
        self.check_gain(settings)

    @property
    def unsettled(self) -> bool:
        """Return whether it is enabled, and the last message was refused: it may stop soon."""
        return self.enabled and self._in_doubt

    @property
    def enabled(self) -> bool:
        """Return whether samples are answered with commands."""
        return self.controller.enabled

    @property
    def stamp(self) -> int:
        """Return the stamp of the last sample, 0 before any [ns]."""
        return 0 if self._last is None else self._last.stamp

    def sample(self, message: bytes, now: float) -> bytes | None:
        """
        Take a joint state; returns a command if one is due. Raises Refused.

        A sample that this arm cannot have gives zero torque at once, as the last command.
        """
        try:
            stamp, reading = self._read(message)
            fault = self._judged(stamp, np.ascontiguousarray(reading[:, :SIDES]), now)
        except Refused as refused:
            self._fault, self._in_doubt = str(refused), True
            raise
        self._in_doubt = False
        if fault:
            return self._stop(fault)
        self._usable.feed(now)
        angle = reading[:, MOTOR_READING].copy()
        if self.controller.settings.torque_feedback == 0.0:
            return self._answer(SamplePair(stamp, angle, np.zeros_like(angle)), now)
        return self._answer(self._pairing.add_angle(stamp, angle), now)

    def torque(self, message: bytes, now: float) -> bytes | None:
        """Take the estimated joint torques; returns a command if one is due. Raises Refused."""
        if self.controller.settings.torque_feedback == 0.0:
            return None
        stamp, torque = self._read_torque(message)
        if not np.isfinite(torque).all():
            raise Refused('torque not finite', f'torques must be finite, got {torque.tolist()}')
        if (np.abs(torque) > self._largest).any():
            return self._impossible_torque(torque)
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
        if self._doubt.alive(now):
            raise Refused('enabled too early', f'not enabled: {self._fault}')
        try:
            self.check_gain(self.controller.settings)
        except ParameterError as error:
            raise Refused('gain not stable', f'not enabled: {error}') from None
        if not self.enabled:
            self._take_over(self._last)

    def check_gain(self, settings: ControllerSettings) -> None:
        """Raise ParameterError for a K_J that this arm does not bear at its rate."""
        arm, period = self.controller.arm, self._samples.period or NOMINAL_PERIOD
        if settings.torque_feedback == 0.0 or self._any_gain or arm.links is None:
            return
        if not is_stable(arm, settings, period):
            raise ParameterError(
                f'torque_feedback must be {stable_range(arm, settings, period)} for this arm at '
                f'{1.0 / period:.0f} Hz with these gains, got {settings.torque_feedback:g}; '
                'allow_unstable_gain:=true takes it all the same')

    def disable(self) -> bytes | None:
        """Let the motors go; returns the last command, zero, if one is due."""
        self._enable_first = False
        if not self.enabled:
            return None
        return self._stop('')

    def follow(self, trajectory: TargetPoints) -> None:
        """Follow a trajectory that begins with the last sample; raises Refused."""
        now = self.present()
        try:
            self.controller.follow(
                reference_from(self.controller.arm, *trajectory, now), self.stamp)
        except TrajectoryError as error:
            raise Refused('target out of bounds', str(error)) from None

    def follow_checked(self, checked: Checked) -> None:
        """Follow a way that was checked elsewhere; raises Refused."""
        now = self.present()
        try:
            self.controller.follow(checked.joining(self.controller.arm, now), self.stamp)
        except TrajectoryError as error:
            raise Refused('target out of bounds', str(error)) from None

    def present(self) -> Array:
        """Return the present reference (n, 2) [rad, rad/s]; raises Refused without one."""
        now = self.controller.present_reference(self.stamp)
        if now is None or not self.enabled:
            raise Refused('not enabled', 'a target needs an enabled controller; call '
                          'jtf_controller/enable before')
        return now

    def watch_for(self, watch: WatchSettings) -> None:
        """Give up after another time from now on."""
        for each in (self.watchdog, self._usable, self._doubt):
            each.wait_for(watch.sample_timeout)

    def _judged(self, stamp: int, angles: Array, now: float) -> str:
        """Return why to stop at a sample, nothing if it can be used; raises Refused."""
        last = self._samples.stamp
        fault = self._samples.look(stamp, angles)
        if fault and not self.enabled and fault is not Fault.NOT_FINITE:
            if not fault.of_stamps:
                self._fault = self._samples.sentence
                self._doubt.feed(now)
            self._samples.begin()               # another run of the arm, or other zeros
            fault = self._samples.look(stamp, angles)
        if fault is Fault.NOT_FINITE:
            raise self._read.not_finite(stamp, angles)
        if fault is Fault.NOT_LATER:
            raise not_later(stamp, last)
        if fault and not self.enabled:
            raise Refused(fault.reason, self._samples.sentence)
        return self._samples.sentence

    def _impossible_torque(self, torque: Array) -> bytes | None:
        joint = int(np.argmax(np.abs(torque) / self._largest))
        sentence = (f'the torque of {self.controller.arm.labels[joint]} must lie within '
                    f'+-{self._largest[joint]:g} N*m, got {torque[joint]:g} N*m')
        if not self.enabled:
            raise Refused('torque impossible', sentence)
        return self._stop(sentence)

    def _answer(self, pair: SamplePair | None, now: float) -> bytes | None:
        if pair is None:
            return None
        last, self._last = self._last, pair
        self.watchdog.feed(now)
        if self._enable_first and not self._doubt.alive(now):
            self._take_over(pair)
        if not self.enabled:
            return None
        if last is not None and pair.stamp - last.stamp > self.watchdog.timeout * 1e9:
            return self._stop(f'{(pair.stamp - last.stamp) * 1e-9:g} s lie between two stamps of '
                              f'{JOINT_STATES.name}')
        command = self.controller.update(*pair)
        if not np.isfinite(command).all():
            return self._stop(f'the law gives {command.tolist()} N*m, which must be finite')
        self.answered += 1
        self.gaps.add(pair.stamp)
        self.limited += int((np.abs(command) >= self._limits).any())
        return self._encode(pair.stamp, effort=command.tolist())

    def _take_over(self, pair: SamplePair) -> None:
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
    SampleWatch(arm).look(1, np.zeros((len(arm.joints), SIDES)))
    scratch, zeros = Controller(arm), np.zeros(len(arm.joints))
    reference_from(arm, arm.labels, [1.0], [zeros.tolist()], [], np.zeros((len(zeros), 2)))
    scratch.enable()
    for stamp in (1, 2):
        scratch.update(stamp, zeros, zeros)
