"""Between the commanded motor torque and the one that turns the shaft (docs/model.md, 54-61)."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from .effect import Effect, Site
from ..compiled import compiled
from ..parameter import parameter


@compiled
def ripple_torque(                                                  # type: ignore[no-untyped-def]
        motor_angle, amplitude_2, phase_2, amplitude_4, phase_4):
    """Return the torque of the ripple at the shaft, (54) [N*m motor]."""
    return (amplitude_2 * np.sin(2.0 * motor_angle + phase_2)
            + amplitude_4 * np.sin(4.0 * motor_angle + phase_4))


@compiled
def cogging_torque(motor_angle, amplitude, order, phase):           # type: ignore[no-untyped-def]
    """Return the torque of the cogging at the shaft, (55) [N*m motor]."""
    return amplitude * np.sin(order * motor_angle + phase)


@compiled
def scaled_torque(command, error):                                  # type: ignore[no-untyped-def]
    """Return the torque that a motor gives for a commanded one, (56) [N*m motor]."""
    return (1.0 + error) * command


@compiled
def biased_torque(command, offset):                                 # type: ignore[no-untyped-def]
    """Return a torque with the bias of the drive, (57) [N*m motor]."""
    return command + offset


@compiled
def clipped_torque(command, limit):                                 # type: ignore[no-untyped-def]
    """Return the torque that the drive's limit leaves, (60) [N*m motor]."""
    return np.minimum(np.maximum(command, -limit), limit)


@compiled
def lagging_torque(                                                 # type: ignore[no-untyped-def]
        command, last_command, state, elapsed, time_constant):
    """
    Return the torque some time [s] after it was `state`, (58) [N*m motor].

    The command goes along a line from `last_command` to `command` in that time, or stands still.
    """
    pace = (command - last_command) / elapsed
    return (command - time_constant * pace
            + (state - last_command + time_constant * pace) * np.exp(-elapsed / time_constant))


@compiled
def delayed_torque(command, last_command, elapsed, delay):          # type: ignore[no-untyped-def]
    """Return which of two held commands acts some time [s] after the later one came, (59)."""
    late = 1.0 * (elapsed < delay)
    return late * last_command + (1.0 - late) * command


@compiled
def heavier_rotor(nominal, error):                                  # type: ignore[no-untyped-def]
    """Return the inertia of rotor and wave generator, (61) [kg*m^2 motor]."""
    return nominal * (1.0 + error)


@dataclass(frozen=True)
class TorqueRipple(Effect):
    """Torque that varies along the turn of the wave generator, orders 2 and 4, (54)."""

    name: ClassVar[str] = 'torque_ripple'
    cause: ClassVar[str] = 'torque ripple of the wave generator, twice and four times per turn'
    site: ClassVar[Site] = Site.MOTOR
    law = staticmethod(ripple_torque)
    amplitude_2: float = parameter(0.0, 'N*m', 0.0, 1.0, 'twice per motor turn, motor side')
    phase_2: float = parameter(0.0, 'rad', -7.0, 7.0, 'its phase')
    amplitude_4: float = parameter(0.0, 'N*m', 0.0, 1.0, 'four per motor turn, motor side')
    phase_4: float = parameter(0.0, 'rad', -7.0, 7.0, 'its phase')


@dataclass(frozen=True)
class MotorCogging(Effect):
    """Torque of the motor's magnets on its slots, (55)."""

    name: ClassVar[str] = 'motor_cogging'
    cause: ClassVar[str] = 'cogging of the motor at a slot or pole order'
    site: ClassVar[Site] = Site.MOTOR
    law = staticmethod(cogging_torque)
    amplitude: float = parameter(0.0, 'N*m', 0.0, 1.0, 'cogging torque, motor side')
    order: float = parameter(14.0, '1/turn', 1.0, 1e3, 'waves per motor turn')
    phase: float = parameter(0.0, 'rad', -7.0, 7.0, 'phase at motor angle 0')


@dataclass(frozen=True)
class TorqueConstantError(Effect):
    """A motor that gives more or less torque than commanded, (56)."""

    name: ClassVar[str] = 'torque_constant_error'
    cause: ClassVar[str] = 'the motor gives more or less torque than commanded'
    site: ClassVar[Site] = Site.MOTOR
    law = staticmethod(scaled_torque)
    error: float = parameter(0.0, '', -0.9, 2.0, 'relative error of torque per command')


@dataclass(frozen=True)
class DriveOffset(Effect):
    """A constant torque of the drive that nobody commanded, (57)."""

    name: ClassVar[str] = 'drive_offset'
    cause: ClassVar[str] = 'the drive adds a constant torque'
    site: ClassVar[Site] = Site.MOTOR
    law = staticmethod(biased_torque)
    offset: float = parameter(0.0, 'N*m', -5.0, 5.0, 'torque at zero command, motor side')


@dataclass(frozen=True)
class CurrentLoopLag(Effect):
    """First-order lag from the commanded to the delivered torque, (58)."""

    name: ClassVar[str] = 'current_loop_lag'
    cause: ClassVar[str] = 'the current loop lags behind the commanded torque'
    site: ClassVar[Site] = Site.MOTOR
    law = staticmethod(lagging_torque)
    time_constant: float = parameter(0.0, 's', 0.0, 0.1, 'of the current loop')


@dataclass(frozen=True)
class CommandDelay(Effect):
    """Dead time between a command and its torque, whole samples or not, (59)."""

    name: ClassVar[str] = 'command_delay'
    cause: ClassVar[str] = 'a dead time passes before a commanded torque acts'
    site: ClassVar[Site] = Site.MOTOR
    law = staticmethod(delayed_torque)
    delay: float = parameter(0.0, 's', 0.0, 0.02, 'from the command to its torque')


@dataclass(frozen=True)
class TorqueSaturation(Effect):
    """A drive that clips the torque below the commanded one, (60)."""

    name: ClassVar[str] = 'torque_saturation'
    cause: ClassVar[str] = 'the drive clips the torque below the commanded one'
    site: ClassVar[Site] = Site.MOTOR
    law = staticmethod(clipped_torque)
    limit: float = parameter(1e4, 'N*m', 1e-6, 1e4, 'largest torque delivered, motor side')


@dataclass(frozen=True)
class MotorInertiaError(Effect):
    """Rotor and wave generator heavier or lighter than stated, (61)."""

    name: ClassVar[str] = 'motor_inertia_error'
    cause: ClassVar[str] = 'the inertia of rotor and wave generator differs'
    site: ClassVar[Site] = Site.MOTOR
    law = staticmethod(heavier_rotor)
    error: float = parameter(0.0, '', -0.9, 5.0, 'relative error of the motor inertia')
