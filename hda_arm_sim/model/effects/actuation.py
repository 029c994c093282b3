"""Between the commanded motor torque and the one that turns the shaft (docs/model.md#effects)."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from .effect import Effect, KnownBy, Site
from .hypothesis import Hypothesis, NO_OTHER_FORM, SCALE, Typical, Unmeasured, wave
from .place import (Commanded, CURRENT_LOOP, Delivered, LIMIT, MOTOR_INERTIA, Place, SHAFT, Signal,
                    Stated, TURN, Turned, WIRE)
from .words import CHECK_DRIVE, Words
from ...foundation.compiled import compiled, Record
from ...foundation.parameter import parameter


@compiled
def ripple_torque(own: Record, at: Turned) -> Signal:
    """Return the torque of the ripple at the shaft, (eq:ripple) [N*m motor]."""
    return (own.amplitude_2 * np.sin(2.0 * at.motor_angle + own.phase_2)
            + own.amplitude_4 * np.sin(4.0 * at.motor_angle + own.phase_4))


@compiled
def cogging_torque(own: Record, at: Turned) -> Signal:
    """Return the torque of the cogging at the shaft, (eq:cogging) [N*m motor]."""
    return own.amplitude * np.sin(own.order * at.motor_angle + own.phase)


@compiled
def scaled_torque(own: Record, at: Delivered) -> Signal:
    """Return the torque that a motor gives for its command, (eq:torque-constant) [N*m motor]."""
    return (1.0 + own.error) * at.torque


@compiled
def biased_torque(own: Record, at: Delivered) -> Signal:
    """Return a torque with the bias of the drive, (eq:offset) [N*m motor]."""
    return at.torque + own.offset


@compiled
def clipped_torque(own: Record, at: Commanded) -> Signal:
    """Return the torque that the drive's limit leaves, (eq:saturation) [N*m motor]."""
    return ((1.0 - own.softness) * np.minimum(np.maximum(at.command, -own.limit), own.limit)
            + own.softness * own.limit * np.tanh(at.command / own.limit))


@compiled
def lagging_torque(own: Record, at: Commanded) -> Signal:
    """
    Return the torque some time [s] after it was `state`, (eq:lag) [N*m motor].

    The command goes along a line from `last_command` to `command` in that time, or stands still.
    """
    pace = (at.command - at.last_command) / at.elapsed
    return (at.command - own.time_constant * pace
            + (at.state - at.last_command + own.time_constant * pace)
            * np.exp(-at.elapsed / own.time_constant))


@compiled
def late_torque(delay: float, at: Commanded) -> Signal:
    """Return which of two held commands acts some time [s] after the later one, (eq:delay)."""
    late = 1.0 * (at.elapsed < delay)
    return late * at.last_command + (1.0 - late) * at.command


@compiled
def delayed_torque(own: Record, at: Commanded) -> Signal:
    """Return the torque behind the whole delay, (eq:delay) [N*m motor]."""
    return late_torque(own.delay, at)


@compiled
def heavier_rotor(own: Record, at: Stated) -> Signal:
    """Return the inertia of rotor and wave generator, (eq:motor-inertia) [kg*m^2 motor]."""
    return at.nominal * (1.0 + own.error)


def off_centre(ripple: 'TorqueRipple') -> tuple['MotorCogging', ...]:
    """Return what such a ripple does once a turn where the wave generator is off its centre."""
    largest = MotorCogging.declaration('amplitude').high
    size = min(float(np.hypot(ripple.amplitude_2, ripple.amplitude_4)), largest)
    return tuple(MotorCogging(amplitude=size, order=1.0, phase=phase)
                 for phase in (0.0, 0.5 * np.pi))           # which make one of any phase


@dataclass(frozen=True)
class TorqueRipple(Effect):
    """Torque that varies along the turn of the wave generator, orders 2 and 4, (eq:ripple)."""

    name: ClassVar[str] = 'torque_ripple'
    cause: ClassVar[str] = 'torque ripple of the wave generator, twice and four times per turn'
    site: ClassVar[Site] = Site.MOTOR
    place: ClassVar[Place] = TURN
    acts: ClassVar[tuple[str, ...]] = ('amplitude_2', 'amplitude_4')
    law = staticmethod(ripple_torque)
    # (source: ripples that grow with the torque, or of several orders, once a turn among them)
    hypothesis: ClassVar[Hypothesis | None] = Hypothesis(
        varies=('joint_torque', 'load_sense', 'motor_torque', 'motor_angle'), reach=0.3,
        beside=off_centre,
        waves={**wave(2, 0.005), **wave(4, 0.005)}, alike=('motor_cogging', 'kinematic_error'),
        experiment='the same slow speed at two loads')
    typical: ClassVar[Typical | None] = Typical(
        {'amplitude_2': 0.008, 'amplitude_4': 0.002},
        {'phase_2': 0.5, 'phase_4': 1.0})
    known_by: ClassVar[KnownBy | None] = KnownBy(
        'torque_ripple', ('amplitude_2', 'amplitude_4'),
        'the motor ripples: {size:.1e} N*m of {order} more than known')
    words: ClassVar[Words] = Words(
        'has a torque ripple of {size} at its motor, twice or four times per motor turn',
        'wave_generator', 'Check how the wave generator is centred on the motor shaft.',
        ('amplitude_2', 'amplitude_4'))
    amplitude_2: float = parameter(0.0, 'N*m', 0.0, 1.0, 'twice per motor turn, motor side')
    phase_2: float = parameter(0.0, 'rad', -7.0, 7.0, 'its phase')
    amplitude_4: float = parameter(0.0, 'N*m', 0.0, 1.0, 'four per motor turn, motor side')
    phase_4: float = parameter(0.0, 'rad', -7.0, 7.0, 'its phase')


@dataclass(frozen=True)
class MotorCogging(Effect):
    """Torque of the motor's magnets on its slots, (eq:cogging)."""

    name: ClassVar[str] = 'motor_cogging'
    cause: ClassVar[str] = 'cogging of the motor at a slot or pole order'
    site: ClassVar[Site] = Site.MOTOR
    place: ClassVar[Place] = TURN
    acts: ClassVar[tuple[str, ...]] = ('amplitude',)
    law = staticmethod(cogging_torque)
    # (source: a second order of half of the first)
    hypothesis: ClassVar[Hypothesis | None] = Hypothesis(
        varies=('motor_angle', 'motor_waves'), reach=0.3,
        waves={('amplitude', 'phase'): 0.005},
        grid={'order': (1.0, 6.0, 7.0, 8.0, 12.0, 14.0, 21.0, 24.0, 28.0, 42.0)},
        stands={'order': 14.0},
        alike=('torque_ripple',), experiment='one motor turn at 2 rad/s')
    typical: ClassVar[Typical | None] = Typical(
        {'amplitude': 0.008},
        {'order': 14.0, 'phase': 0.5})
    words: ClassVar[Words] = Words(
        'has {size} of cogging at its motor, {order} times per motor turn', 'motor',
        'Turn the motor uncoupled, or compare with a spare one.', ('amplitude',))
    amplitude: float = parameter(0.0, 'N*m', 0.0, 1.0, 'cogging torque, motor side')
    order: float = parameter(14.0, '1/turn', 1.0, 1e3, 'waves per motor turn')
    phase: float = parameter(0.0, 'rad', -7.0, 7.0, 'phase at motor angle 0')


@dataclass(frozen=True)
class TorqueConstantError(Effect):
    """A motor that gives more or less torque than commanded, (eq:torque-constant)."""

    name: ClassVar[str] = 'torque_constant_error'
    cause: ClassVar[str] = 'the motor gives more or less torque than commanded'
    site: ClassVar[Site] = Site.MOTOR
    place: ClassVar[Place] = SHAFT
    law = staticmethod(scaled_torque)
    hypothesis: ClassVar[Hypothesis | None] = Hypothesis(
        varies=('joint_torque', 'load_sense', 'time'),
        free={'error': 0.02}, alike=('link_inertia_error', 'stiffness_error'), scales=True,
        experiment=SCALE)
    typical: ClassVar[Typical | None] = Typical({'error': 0.06})
    unmeasured: ClassVar[Unmeasured | None] = Unmeasured({'error': 0.3})    # that nobody states
    tolerance: ClassVar[tuple[str, str] | None] = ('error', 'torque_constant')
    known_by: ClassVar[KnownBy | None] = KnownBy(
        'torque_constant', ('error',),
        'the motor gives {percent:+.0f} % of its torque more')
    words: ClassVar[Words] = Words(
        'gives {size} more torque than its motor is commanded', 'motor', CHECK_DRIVE, ('error',),
        less='gives {size} less torque than its motor is commanded')
    error: float = parameter(0.0, '', -0.9, 2.0, 'relative error of torque per command')


@dataclass(frozen=True)
class DriveOffset(Effect):
    """A constant torque of the drive that nobody commanded, (eq:offset)."""

    name: ClassVar[str] = 'drive_offset'
    cause: ClassVar[str] = 'the drive adds a constant torque'
    site: ClassVar[Site] = Site.MOTOR
    place: ClassVar[Place] = SHAFT
    law = staticmethod(biased_torque)
    hypothesis: ClassVar[Hypothesis | None] = Hypothesis(
        varies=('time',),
        free={'offset': 0.005}, alike=('asymmetric_friction',), twin='asymmetric_friction',
        experiment='a dwell at zero command, and a return run')
    typical: ClassVar[Typical | None] = Typical({'offset': 0.007})
    known_by: ClassVar[KnownBy | None] = KnownBy(
        'drive_offset', ('offset',),
        'the drive is off by {size:.1e} N*m')
    words: ClassVar[Words] = Words(
        'has a drive that adds {size} at its motor', 'drive',
        'Zero the current sensors of the drive at standstill.', ('offset',),
        less='has a drive that takes {size} away at its motor')
    offset: float = parameter(0.0, 'N*m', -5.0, 5.0, 'torque at zero command, motor side')


@dataclass(frozen=True)
class CurrentLoopLag(Effect):
    """First-order lag from the commanded to the delivered torque, (eq:lag)."""

    name: ClassVar[str] = 'current_loop_lag'
    cause: ClassVar[str] = 'the current loop lags behind the commanded torque'
    site: ClassVar[Site] = Site.MOTOR
    place: ClassVar[Place] = CURRENT_LOOP
    acts: ClassVar[tuple[str, ...]] = ('time_constant',)
    law = staticmethod(lagging_torque)
    # (measured: above 30 Hz the noise that the command repeats spoke for a delay in any case;
    # source of its reach: lags of second order)
    hypothesis: ClassVar[Hypothesis | None] = Hypothesis(
        varies=('rate',), reach=0.3, free={'time_constant': 0.001},
        grid={'time_constant': (0.001, 0.004)},
        alike=('command_delay',), form_error=0.02, form=NO_OTHER_FORM, form_share=0.002,
        clear=4.0, below=30.0, experiment='a small multi-sine from 1 to 60 Hz')
    typical: ClassVar[Typical | None] = Typical({}, {'time_constant': 0.004})
    words: ClassVar[Words] = Words(
        'has a torque that lags {size} behind its command', 'drive', CHECK_DRIVE,
        ('time_constant',))
    time_constant: float = parameter(0.0, 's', 0.0, 0.1, 'of the current loop')


@dataclass(frozen=True)
class CommandDelay(Effect):
    """Dead time between a command and its torque, whole samples or not, (eq:delay)."""

    name: ClassVar[str] = 'command_delay'
    cause: ClassVar[str] = 'a dead time passes before a commanded torque acts'
    site: ClassVar[Site] = Site.MOTOR
    place: ClassVar[Place] = WIRE
    acts: ClassVar[tuple[str, ...]] = ('delay',)
    law = staticmethod(delayed_torque)
    law_after = staticmethod(late_torque)
    # (measured: above 30 Hz the noise that the command repeats spoke for a delay in any case)
    hypothesis: ClassVar[Hypothesis | None] = Hypothesis(
        free={'delay': 0.001}, grid={'delay': (0.001, 0.004)}, alike=('current_loop_lag',),
        form_error=0.02, form=NO_OTHER_FORM, form_share=0.002, clear=4.0, below=30.0,
        experiment='a small multi-sine from 1 to 60 Hz')
    typical: ClassVar[Typical | None] = Typical({'delay': 0.0033})
    words: ClassVar[Words] = Words(
        'has a torque that comes {size} after its command', 'drive',
        'Check the cycle time of bus and drive.', ('delay',))
    delay: float = parameter(0.0, 's', 0.0, 0.02, 'from the command to its torque')


@dataclass(frozen=True)
class TorqueSaturation(Effect):
    """A drive that clips the torque below the commanded one, or levels it, (eq:saturation)."""

    name: ClassVar[str] = 'torque_saturation'
    cause: ClassVar[str] = 'the drive clips the torque below the commanded one'
    site: ClassVar[Site] = Site.MOTOR
    place: ClassVar[Place] = LIMIT
    stated: ClassVar[Mapping[str, str]] = {'limit': 'torque_limit'}
    law = staticmethod(clipped_torque)
    hypothesis: ClassVar[Hypothesis | None] = Hypothesis(
        varies=('motor_velocity',),
        free={'limit': 0.02}, weaker=True,
        grid={('softness',): ((0.0,), (1.0,)), 'limit': (0.05, 0.1, 0.15, 0.2)},
        stands={'softness': 0.0},
        alike=('torque_constant_error',), experiment='a motion that asks for the largest torque')
    typical: ClassVar[Typical | None] = Typical({}, {'limit': 0.15})
    words: ClassVar[Words] = Words(
        'has a drive that gives {size} at most', 'drive',
        'Read the current limit of the drive and its supply voltage.', ('limit',))
    limit: float = parameter(1e4, 'N*m', 1e-6, 1e4, 'largest torque delivered, motor side')
    softness: float = parameter(0.0, '', 0.0, 1.0, 'share that levels off; 0 clips at the limit')


@dataclass(frozen=True)
class MotorInertiaError(Effect):
    """Rotor and wave generator heavier or lighter than stated, (eq:motor-inertia)."""

    name: ClassVar[str] = 'motor_inertia_error'
    cause: ClassVar[str] = 'the inertia of rotor and wave generator differs'
    site: ClassVar[Site] = Site.MOTOR
    place: ClassVar[Place] = MOTOR_INERTIA
    law = staticmethod(heavier_rotor)
    hypothesis: ClassVar[Hypothesis | None] = Hypothesis(
        free={'error': 0.05}, alike=('torque_constant_error', 'link_inertia_error'), scales=True,
        experiment='fast small motions: the motor hardly moves the link')
    tolerance: ClassVar[tuple[str, str] | None] = ('error', 'motor_inertia')
    typical: ClassVar[Typical | None] = Typical({'error': 0.1})
    unmeasured: ClassVar[Unmeasured | None] = Unmeasured({'error': 0.5})
    words: ClassVar[Words] = Words(
        'has a rotor inertia that is {size} larger than stated', 'motor',
        'Compare the data sheets of motor, brake and wave generator.', ('error',),
        less='has a rotor inertia that is {size} smaller than stated')
    error: float = parameter(0.0, '', -0.9, 5.0, 'relative error of the motor inertia')
