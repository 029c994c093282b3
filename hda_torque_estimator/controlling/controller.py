"""PD control on the motor side with joint torque feedback, safe by construction."""

from dataclasses import dataclass, replace
from typing import ClassVar

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.parameter import Declared, parameter
from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.chain_links import ChainLinks
from hda_arm_sim.model.link_side import loaded_inertia
import numpy as np

from . import control
from .control import CompiledControlSettings
from .reference import hold, Reference


@dataclass(frozen=True)
class ControllerSettings(Declared):
    """Gains and limits; the gains act at the motor shaft on all joints alike."""

    name: ClassVar[str] = 'controller'
    position_gain: float = parameter(
        0.3, 'N*m/rad', 0.0, 1e3, 'K_P, motor torque per shaft angle')
    velocity_gain: float = parameter(
        0.012, 'N*m*s/rad', 0.0, 1e2, 'K_D, motor torque per shaft speed')
    torque_feedback: float = parameter(
        0.0, '', -2.0, 0.99, 'K_J: -1 follows a push, between 0 and 1 rejects it')
    gravity_compensation: float = parameter(
        1.0, '', 0.0, 1.0, 'share of the weight of links in space that the motors hold')
    velocity_bandwidth: float = parameter(
        150.0, 'Hz', 0.1, 1e4, 'low-pass of the shaft speed')
    rate_limit: float = parameter(
        100.0, 'N*m/s', 1e-3, 1e6, 'fastest change of a motor torque')
    handover_time: float = parameter(
        0.2, 's', 1e-3, 10.0, 'time in which the law is phased in after enabling')


QUICKEST = 0.25         # of a rotor's speed that K_D may take in 1 ms (choice: 36 deg of lag)


def bearable(arm: Arm, settings: ControllerSettings) -> ControllerSettings:
    """
    Return settings with gains that the lightest rotor of an arm bears at 1 kHz or above.

    Above its resonance a rotor turns alone. A loop of 2.5 ms turns its phase by 36 deg where
    K_D / J is 250 rad/s. These 2.5 ms are a sample and a half, and the low-pass of the speed.
    """
    lightest = float(min(arm.record().joints['motor_inertia']))
    share = min(1.0, QUICKEST * lightest / 1e-3 / settings.velocity_gain)
    return replace(settings, position_gain=share * settings.position_gain,
                   velocity_gain=share * settings.velocity_gain)


def compiled_settings(arm: Arm, settings: ControllerSettings) -> CompiledControlSettings:
    """Return what the compiled step reads of the settings and of the arm's limits."""
    share = settings.gravity_compensation if isinstance(arm.links, ChainLinks) else 0.0
    return CompiledControlSettings(
        settings.position_gain, settings.velocity_gain, settings.torque_feedback, share,
        settings.velocity_bandwidth, settings.rate_limit, settings.handover_time,
        np.array([joint.torque_limit for joint in arm.joints]))


class Controller:
    """
    The controller with its memory: commands zero torque until enabled.

    Time is the samples' own; nothing here reads a clock.
    """

    def __init__(self, arm: Arm, settings: ControllerSettings = ControllerSettings()) -> None:
        """Prepare for an arm; disabled, without a reference."""
        self.arm, self.settings = arm, settings
        self._body = control.ControlledArm(arm.record(), loaded_inertia(arm.record().body))
        self._ratios = np.array([joint.ratio for joint in arm.joints])
        self._compiled = compiled_settings(arm, settings)
        self._memory = np.zeros((len(arm.joints), control.MEMORY))
        self._last: int | None = None
        self._reference: Reference | None = None
        self._begin = 0
        self.enabled = False
        self.command = np.zeros(len(arm.joints))

    def tune(self, settings: ControllerSettings) -> None:
        """Use other settings from the next sample on; the torque's rate limit still holds."""
        self.settings = settings
        self._compiled = compiled_settings(self.arm, settings)

    def enable(self) -> None:
        """
        Take over at the next sample: hold the arm where it is then, without a step.

        It begins at zero torque, or with a chain at what its weight needs there.
        """
        if not self.enabled:
            self._last = self._reference = None
            self._memory[:] = 0.0
            self.enabled = True

    def stop(self) -> None:
        """Command zero torque at once, until enabled again."""
        self.enabled = False
        self.command[:] = 0.0

    def follow(self, reference: Reference, begin: int) -> None:
        """Follow a reference that starts at the stamp `begin` [ns]."""
        self._reference, self._begin = reference, begin

    def present_reference(self, stamp: int) -> Array | None:
        """Return link angles and rates (n, 2) asked for at a stamp, None before a sample."""
        if self._reference is None:
            return None
        return self._reference.at((stamp - self._begin) * 1e-9)

    def update(self, stamp: int, motor_angle: Array, joint_torque: Array) -> Array:
        """
        Return the motor torques (n,) [N*m] that answer a sample.

        `motor_angle` (n,) are shaft angles [rad], `joint_torque` (n,) estimates at the same stamp
        [N*m]. A sample that is not finite, or not later than the last one, must not be given.
        """
        if not self.enabled:
            return self.command
        if self._reference is None:
            self._reference, self._begin = hold(motor_angle / self._ratios), stamp
        dt = 0.0 if self._last is None else (stamp - self._last) * 1e-9
        reference = self._reference.at((stamp - self._begin) * 1e-9)
        torque = joint_torque if self.settings.torque_feedback else np.zeros_like(joint_torque)
        control.step(self._body, self._compiled, self._memory,
                     control.Asked(reference, motor_angle, torque, dt), self.command)
        self._last = stamp
        return self.command
