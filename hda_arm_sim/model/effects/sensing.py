"""What the encoders show that is not so, and in which steps (docs/model.md#effects)."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from .effect import Effect, KnownBy, Site
from .hypothesis import Hypothesis, Typical, Unmeasured, wave
from .place import (Counted, COUNTS, LINK_READING, MOTOR_READING, Place, Read, Signal,
                    TILTED_READING)
from .words import CHECK_ENCODER, Words
from ...foundation.compiled import compiled, Record
from ...foundation.parameter import parameter


@compiled
def quantised(angle: Signal, step: float) -> Signal:
    """Return the angle in whole steps, (eq:count); a step of zero is a perfect encoder [rad]."""
    return np.floor(angle / step + 0.5) * step if step > 0.0 else angle + 0.0


@compiled
def quantised_sides(own: Record, at: Counted) -> tuple[Signal, Signal]:
    """Return both angles in whole steps, shaft and link, (eq:count) [rad]."""
    return quantised(at.motor_angle, own.motor_step), quantised(at.link_angle, own.link_step)


@compiled
def link_runout(own: Record, at: Read) -> Signal:
    """Return what a link encoder off its axis adds to the angle, (eq:link-disc) [rad]."""
    return (own.amplitude_1 * np.sin(at.angle + own.phase_1)
            + own.amplitude_2 * np.sin(2.0 * at.angle + own.phase_2))


@compiled
def link_runout_slope(own: Record, at: Read) -> Signal:
    """Return how (eq:link-disc) changes with the angle [rad/rad]."""
    turn = 0.5 * np.pi                  # a quarter of a wave: cosines in the place of sines
    return (own.amplitude_1 * np.sin(at.angle + (own.phase_1 + turn))
            + 2.0 * own.amplitude_2 * np.sin(2.0 * at.angle + (own.phase_2 + turn)))


@compiled
def motor_runout(own: Record, at: Read) -> Signal:
    """Return what the disc of a motor encoder adds to the angle, (eq:motor-disc) [rad]."""
    return (own.amplitude * np.sin(own.order * at.angle + own.phase)
            + own.amplitude_2 * np.sin(2.0 * own.order * at.angle + own.phase_2))


@compiled
def motor_runout_slope(own: Record, at: Read) -> Signal:
    """Return how (eq:motor-disc) changes with the angle [rad/rad]."""
    turn = 0.5 * np.pi                  # a quarter of a wave: cosines in the place of sines
    return own.order * (
        own.amplitude * np.sin(own.order * at.angle + (own.phase + turn))
        + 2.0 * own.amplitude_2 * np.sin(2.0 * own.order * at.angle + (own.phase_2 + turn)))


@compiled
def scale_excess(own: Record, at: Read) -> Signal:
    """Return what a wrong scale adds to the angle, (eq:scale) [rad]."""
    return own.error * at.angle


@compiled
def scale_slope(own: Record, at: Read) -> Signal:
    """Return how (eq:scale) changes with the angle [rad/rad]."""
    return own.error + 0.0 * at.angle


@compiled
def interpolation_wave(own: Record, at: Read) -> Signal:
    """Return what interpolation between lines adds to the angle, (eq:interpolation) [rad]."""
    return own.amplitude * np.sin(own.lines * at.angle + own.phase)


@compiled
def tilted_reading(own: Record, at: Read) -> Signal:
    """Return what a tilting moment takes from the link angle shown, (eq:crosstalk) [rad]."""
    return -(own.coefficient * at.tilt_moment)


@dataclass(frozen=True)
class CoarseQuantisation(Effect):
    """Encoder step of each side, (eq:count); zero is a perfect encoder."""

    name: ClassVar[str] = 'coarse_quantisation'
    cause: ClassVar[str] = 'an encoder counts in larger steps than stated'
    site: ClassVar[Site] = Site.SENSING
    place: ClassVar[Place] = COUNTS
    stated: ClassVar[Mapping[str, str]] = {
        'motor_step': 'motor_encoder.step', 'link_step': 'link_encoder.step'}
    law = staticmethod(quantised_sides)
    words: ClassVar[Words] = Words(
        'has an encoder that counts in steps of {size}', 'link_encoder',
        'Read resolution and bits of the encoder in the settings of the drive.',
        ('motor_step', 'link_step'))
    motor_step: float = parameter(0.0, 'rad', 0.0, 0.1, 'step of the motor encoder, shaft')
    link_step: float = parameter(0.0, 'rad', 0.0, 0.1, 'step of the link encoder')


@dataclass(frozen=True)
class LinkEncoderEccentricity(Effect):
    """Disc of the link encoder off its axis (order 1) or not round (order 2), (eq:link-disc)."""

    name: ClassVar[str] = 'link_encoder_eccentricity'
    cause: ClassVar[str] = 'the disc of the link encoder sits off its axis or out of round'
    site: ClassVar[Site] = Site.TORSION
    place: ClassVar[Place] = LINK_READING
    acts: ClassVar[tuple[str, ...]] = ('amplitude_1', 'amplitude_2')
    law = staticmethod(link_runout)
    law_slope = staticmethod(link_runout_slope)
    hypothesis: ClassVar[Hypothesis | None] = Hypothesis(
        waves={**wave(1, 5e-05), **wave(2, 5e-05)}, alike=('encoder_scale_error',), bends=True,
        experiment='a slow full turn of the link both ways')
    typical: ClassVar[Typical | None] = Typical(
        {'amplitude_1': 0.0002, 'amplitude_2': 6e-05},
        {'phase_1': 0.5, 'phase_2': 1.0})
    unmeasured: ClassVar[Unmeasured | None] = Unmeasured({'amplitude': 3e-4})   # 4 um of 25 mm
    known_by: ClassVar[KnownBy | None] = KnownBy(
        'eccentricity', ('amplitude_1', 'amplitude_2'),
        'the disc of the link encoder moved: {size:.1e} rad of {order} more')
    words: ClassVar[Words] = Words(
        'has a link encoder that is wrong by {size} along its turn', 'link_encoder', CHECK_ENCODER,
        ('amplitude_1', 'amplitude_2'))
    amplitude_1: float = parameter(0.0, 'rad', 0.0, 0.05, 'once per link turn')
    phase_1: float = parameter(0.0, 'rad', -7.0, 7.0, 'its phase')
    amplitude_2: float = parameter(0.0, 'rad', 0.0, 0.05, 'twice per link turn')
    phase_2: float = parameter(0.0, 'rad', -7.0, 7.0, 'its phase')


@dataclass(frozen=True)
class MotorEncoderEccentricity(Effect):
    """Disc of the motor encoder off its axis, and oval, (eq:motor-disc)."""

    name: ClassVar[str] = 'motor_encoder_eccentricity'
    cause: ClassVar[str] = 'the disc of the motor encoder sits off its axis'
    site: ClassVar[Site] = Site.TORSION
    place: ClassVar[Place] = MOTOR_READING
    acts: ClassVar[tuple[str, ...]] = ('amplitude', 'amplitude_2')
    law = staticmethod(motor_runout)
    law_slope = staticmethod(motor_runout_slope)
    # (source: waves of more orders, as those of the gear)
    hypothesis: ClassVar[Hypothesis | None] = Hypothesis(
        varies=('orders',), reach=0.3,
        waves={('amplitude', 'phase'): 0.002, ('amplitude_2', 'phase_2'): 0.002},
        alike=('kinematic_error',),
        experiment='constant speed off the resonance at two loads')
    typical: ClassVar[Typical | None] = Typical({'amplitude': 0.01}, {'phase': 0.5})
    words: ClassVar[Words] = Words(
        'has a motor encoder that is wrong by {size} along its turn', 'motor_encoder',
        CHECK_ENCODER, ('amplitude',))
    amplitude: float = parameter(0.0, 'rad', 0.0, 0.2, 'of the wave, at the shaft')
    phase: float = parameter(0.0, 'rad', -7.0, 7.0, 'its phase')
    order: float = parameter(1.0, '1/turn', 1.0, 4.0, 'waves per motor turn: 2 of an oval disc')
    amplitude_2: float = parameter(0.0, 'rad', 0.0, 0.2, 'of a second wave, twice as often')
    phase_2: float = parameter(0.0, 'rad', -7.0, 7.0, 'its phase')


@dataclass(frozen=True)
class EncoderScaleError(Effect):
    """Link angle in a wrong scale: counts, a scale that grew, a gear ratio, (eq:scale)."""

    name: ClassVar[str] = 'encoder_scale_error'
    cause: ClassVar[str] = 'encoder counts and gear ratio do not fit: torsion grows with the angle'
    site: ClassVar[Site] = Site.TORSION
    place: ClassVar[Place] = LINK_READING
    acts: ClassVar[tuple[str, ...]] = ('error',)
    law = staticmethod(scale_excess)
    law_slope = staticmethod(scale_slope)
    hypothesis: ClassVar[Hypothesis | None] = Hypothesis(
        varies=('time',), free={'error': 5e-05}, alike=('link_encoder_eccentricity',),
        experiment='a slow full turn of the link both ways')
    typical: ClassVar[Typical | None] = Typical({'error': 0.0003})
    words: ClassVar[Words] = Words(
        'has a link encoder that counts {size} too much', 'link_encoder',
        'Check counts per turn and gear ratio in the settings of the drive.', ('error',),
        less='has a link encoder that counts {size} too little')
    error: float = parameter(0.0, '', -0.2, 0.2, 'relative excess of the link encoder')


@dataclass(frozen=True)
class EncoderInterpolationError(Effect):
    """Error of the link encoder that repeats with every line of its scale, (eq:interpolation)."""

    name: ClassVar[str] = 'encoder_interpolation_error'
    cause: ClassVar[str] = 'the link encoder interpolates its lines unevenly'
    site: ClassVar[Site] = Site.SENSING
    place: ClassVar[Place] = LINK_READING
    acts: ClassVar[tuple[str, ...]] = ('amplitude',)
    law = staticmethod(interpolation_wave)
    words: ClassVar[Words] = Words(
        'has a link encoder that is wrong by {size} at each of its lines', 'link_encoder',
        CHECK_ENCODER, ('amplitude',))
    amplitude: float = parameter(0.0, 'rad', 0.0, 1e-3, 'error of the link angle')
    lines: float = parameter(20000.0, '1/turn', 2.0, 1e6, 'lines of the link encoder per turn')
    phase: float = parameter(0.0, 'rad', -7.0, 7.0, 'its phase')


@dataclass(frozen=True)
class BearingCrosstalk(Effect):
    """Tilt of a link bearing under the links, read as torsion, (eq:tilting, crosstalk)."""

    name: ClassVar[str] = 'bearing_crosstalk'
    cause: ClassVar[str] = 'tilting of the bearing under the weight is read as torsion'
    site: ClassVar[Site] = Site.TORSION
    place: ClassVar[Place] = TILTED_READING
    acts: ClassVar[tuple[str, ...]] = ('coefficient',)
    law = staticmethod(tilted_reading)
    hypothesis: ClassVar[Hypothesis | None] = Hypothesis(
        free={'coefficient': 1e-06}, alike=('link_encoder_eccentricity',),
        experiment='the same posture with and without a payload')
    typical: ClassVar[Typical | None] = Typical({'coefficient': 1e-05})
    words: ClassVar[Words] = Words(
        'shows {size} of tilting moment as torsion', 'bearing',
        'Check preload and play of the link bearing.', ('coefficient',))
    coefficient: float = parameter(
        0.0, 'rad/(N*m)', -1e-3, 1e-3, 'torsion shown per tilting moment')
