"""Effects between motor and link: what the torsion is not (docs/model.md#effects)."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from .effect import Effect, KnownBy, Site
from .hypothesis import Hypothesis, TORQUE_LOOPS, Typical, Unmeasured, wave
from .place import (GEAR, LOADED_GEAR, LOOP, Place, PLAY, Signal, SLIDERS, TRANSMISSION, Turned,
                    Twisted)
from .words import CHECK_MESH, Words
from ...foundation.compiled import compiled, Record
from ...foundation.parameter import parameter


@compiled
def transmission_error(own: Record, at: Turned) -> Signal:
    """Return e(theta_m), (eq:kinematic-error) [rad at the output]."""
    error = 0.0 * at.motor_angle
    if own.amplitude_1 != 0.0:
        error = error + own.amplitude_1 * np.sin(at.motor_angle + own.phase_1)
    if own.amplitude_2 != 0.0:
        error = error + own.amplitude_2 * np.sin(2.0 * at.motor_angle + own.phase_2)
    if own.amplitude_4 != 0.0:
        error = error + own.amplitude_4 * np.sin(4.0 * at.motor_angle + own.phase_4)
    if own.amplitude_a != 0.0:
        error = error + own.amplitude_a * np.sin(own.order_a * at.motor_angle + own.phase_a)
    if own.amplitude_b != 0.0:
        error = error + own.amplitude_b * np.sin(own.order_b * at.motor_angle + own.phase_b)
    if own.amplitude_c != 0.0:
        error = error + own.amplitude_c * np.sin(own.order_c * at.motor_angle + own.phase_c)
    if own.amplitude_d != 0.0:
        error = error + own.amplitude_d * np.sin(own.order_d * at.motor_angle + own.phase_d)
    return error


@compiled
def transmission_slope(own: Record, at: Turned) -> Signal:
    """Return e'(theta_m), (eq:kinematic-slope): how the error changes the gear ratio [rad/rad]."""
    turn = 0.5 * np.pi                  # a quarter of a wave: cosines in the place of sines
    slope = 0.0 * at.motor_angle
    if own.amplitude_1 != 0.0:
        slope = slope + own.amplitude_1 * np.sin(at.motor_angle + (own.phase_1 + turn))
    if own.amplitude_2 != 0.0:
        slope = slope + 2.0 * own.amplitude_2 * np.sin(
            2.0 * at.motor_angle + (own.phase_2 + turn))
    if own.amplitude_4 != 0.0:
        slope = slope + 4.0 * own.amplitude_4 * np.sin(
            4.0 * at.motor_angle + (own.phase_4 + turn))
    if own.order_a * own.amplitude_a != 0.0:
        slope = slope + own.order_a * own.amplitude_a * np.sin(
            own.order_a * at.motor_angle + (own.phase_a + turn))
    if own.order_b * own.amplitude_b != 0.0:
        slope = slope + own.order_b * own.amplitude_b * np.sin(
            own.order_b * at.motor_angle + (own.phase_b + turn))
    if own.order_c * own.amplitude_c != 0.0:
        slope = slope + own.order_c * own.amplitude_c * np.sin(
            own.order_c * at.motor_angle + (own.phase_c + turn))
    if own.order_d * own.amplitude_d != 0.0:
        slope = slope + own.order_d * own.amplitude_d * np.sin(
            own.order_d * at.motor_angle + (own.phase_d + turn))
    return slope


@compiled
def loaded_error(own: Record, at: Turned) -> Signal:
    """Return what each N*m adds to the torsion, (eq:loaded-error) [rad/(N*m) at the output]."""
    return own.amplitude * np.sin(own.order * at.motor_angle + own.phase)


@compiled
def loaded_error_slope(own: Record, at: Turned) -> Signal:
    """Return how that changes with the shaft angle, (eq:loaded-lever) [rad/(N*m) per rad]."""
    return own.order * own.amplitude * np.cos(own.order * at.motor_angle + own.phase)


@compiled
def played_torsion(own: Record, at: Twisted) -> Signal:
    """Return the torsion left to the spring after the play, (eq:play) [rad]."""
    return at.torsion - np.minimum(np.maximum(at.torsion, -own.half_width), own.half_width)


@compiled
def played_rate(own: Record, at: Twisted) -> Signal:
    """Return the rate of what is left to the spring, none within the play, (eq:play) [rad/s]."""
    return at.torsion_rate * (np.abs(at.torsion) >= own.half_width)


@compiled
def slid(own: Record, stretch: Signal, change: Signal, place: int) -> Signal:
    """Return the stretch of one friction element after the torsion changed, (eq:sliders) [rad]."""
    reach = own.width * (2.0 * place + 1.0) / SLIDERS
    return np.minimum(np.maximum(stretch + change, -reach), reach)


@compiled
def hysteresis_torque(own: Record, at: Twisted) -> Signal:
    """Return the torque of the hysteresis, (eq:hysteresis) [N*m at the output]."""
    return own.level * at.state


@compiled
def sticking_stiffness(own: Record, at: Twisted) -> Signal:
    """Return the stiffness of all elements while none slides, (eq:hysteresis) [N*m/rad]."""
    return own.level / own.width


@compiled
def damping_torque(own: Record, at: Twisted) -> Signal:
    """Return the torque of the torsion's damping, (eq:damping) [N*m at the output]."""
    return own.coefficient * at.torsion_rate


@compiled
def damping_of(own: Record, at: Twisted) -> Signal:
    """Return the torque per rate of the torsion, (eq:damping) [N*m*s/rad]."""
    return own.coefficient


@dataclass(frozen=True)
class KinematicError(Effect):
    """
    Transmission error at wave-generator orders; it bends torsion and ratio, (eq:kinematic-error).

    Four more waves have orders of their own, whole ones and others. That of the teeth is
    2 (N + 1) / N per motor turn, one per turn of the link is 1 / N.
    """

    name: ClassVar[str] = 'kinematic_error'
    cause: ClassVar[str] = 'transmission error of the gear at wave-generator orders'
    site: ClassVar[Site] = Site.TORSION
    place: ClassVar[Place] = TRANSMISSION
    acts: ClassVar[tuple[str, ...]] = (
        'amplitude_1', 'amplitude_2', 'amplitude_4', 'amplitude_a', 'amplitude_b', 'amplitude_c',
        'amplitude_d')
    law = staticmethod(transmission_error)
    law_slope = staticmethod(transmission_slope)
    # (source: further orders of half of the first)
    hypothesis: ClassVar[Hypothesis | None] = Hypothesis(
        varies=('motor_angle',), reach=0.3,
        waves={**wave(1, 2e-05), **wave(2, 2e-05), **wave(4, 2e-05)},
        alike=('motor_encoder_eccentricity', 'torque_ripple'),
        experiment='constant speed off the resonance at two loads')
    typical: ClassVar[Typical | None] = Typical(
        {'amplitude_2': 8e-05, 'amplitude_4': 2e-05},
        {'phase_2': 0.5, 'phase_4': 1.0})
    # a quarter of the worst gears (source: Tuttle and Seering 1996, and Ghorbel et al. 2001)
    unmeasured: ClassVar[Unmeasured | None] = Unmeasured({'amplitude': 3e-4})
    known_by: ClassVar[KnownBy | None] = KnownBy(
        'kinematic_error', ('amplitude_1', 'amplitude_2', 'amplitude_4'),
        'the kinematic map is out of date: {size:.1e} rad of {order} more')
    words: ClassVar[Words] = Words(
        'has a gear with a transmission error of {size}', 'wave_generator',
        'Check how wave generator and circular spline are centred.',
        ('amplitude_1', 'amplitude_2', 'amplitude_4', 'amplitude_a', 'amplitude_b',
         'amplitude_c', 'amplitude_d'))
    amplitude_1: float = parameter(0.0, 'rad', 0.0, 0.05, 'once per motor turn, output side')
    phase_1: float = parameter(0.0, 'rad', -7.0, 7.0, 'its phase')
    amplitude_2: float = parameter(0.0, 'rad', 0.0, 0.05, 'twice per motor turn, output side')
    phase_2: float = parameter(0.0, 'rad', -7.0, 7.0, 'its phase')
    amplitude_4: float = parameter(0.0, 'rad', 0.0, 0.05, 'four per motor turn, output side')
    phase_4: float = parameter(0.0, 'rad', -7.0, 7.0, 'its phase')
    order_a: float = parameter(3.0, '1/turn', 0.0, 100.0, 'of one more wave, per motor turn')
    amplitude_a: float = parameter(0.0, 'rad', 0.0, 0.05, 'of that wave, output side')
    phase_a: float = parameter(0.0, 'rad', -7.0, 7.0, 'its phase')
    order_b: float = parameter(6.0, '1/turn', 0.0, 100.0, 'of another wave, per motor turn')
    amplitude_b: float = parameter(0.0, 'rad', 0.0, 0.05, 'of that wave, output side')
    phase_b: float = parameter(0.0, 'rad', -7.0, 7.0, 'its phase')
    order_c: float = parameter(8.0, '1/turn', 0.0, 100.0, 'of another wave, per motor turn')
    amplitude_c: float = parameter(0.0, 'rad', 0.0, 0.05, 'of that wave, output side')
    phase_c: float = parameter(0.0, 'rad', -7.0, 7.0, 'its phase')
    order_d: float = parameter(2.02, '1/turn', 0.0, 100.0, 'of another wave, per motor turn')
    amplitude_d: float = parameter(0.0, 'rad', 0.0, 0.05, 'of that wave, output side')
    phase_d: float = parameter(0.0, 'rad', -7.0, 7.0, 'its phase')


@dataclass(frozen=True)
class LoadedKinematicError(Effect):
    """Transmission error that grows with torque as the flexspline ovalises (eq:loaded-error)."""

    name: ClassVar[str] = 'loaded_kinematic_error'
    cause: ClassVar[str] = 'transmission error of the gear that grows with its torque'
    site: ClassVar[Site] = Site.TORSION
    place: ClassVar[Place] = LOADED_GEAR
    acts: ClassVar[tuple[str, ...]] = ('amplitude',)
    law = staticmethod(loaded_error)
    law_slope = staticmethod(loaded_error_slope)
    # (source: a wave that follows the torque with its sign, not its size)
    hypothesis: ClassVar[Hypothesis | None] = Hypothesis(
        varies=('joint_torque', 'load_sense'), reach=0.3,
        waves={('amplitude', 'phase'): 5e-07}, alike=('kinematic_error',),
        experiment='constant speed off the resonance, unloaded and at half the rated torque')
    typical: ClassVar[Typical | None] = Typical({'amplitude': 3e-06}, {'phase': 0.5})
    words: ClassVar[Words] = Words(
        'has a transmission error that grows by {size} of torque', 'flexspline', CHECK_MESH,
        ('amplitude',))
    amplitude: float = parameter(
        0.0, 'rad/(N*m)', 0.0, 1e-3, 'by which the wave grows with torque, output side')
    order: float = parameter(2.0, '1/turn', 0.0, 100.0, 'of the wave, per motor turn')
    phase: float = parameter(0.0, 'rad', -7.0, 7.0, 'its phase')


@dataclass(frozen=True)
class Backlash(Effect):
    """Play at the output flange: a dead zone of the torsion, (eq:play)."""

    name: ClassVar[str] = 'backlash'
    cause: ClassVar[str] = 'play between gear and load at the output flange'
    site: ClassVar[Site] = Site.TORSION
    place: ClassVar[Place] = PLAY
    acts: ClassVar[tuple[str, ...]] = ('half_width',)
    law = staticmethod(played_torsion)
    law_rate = staticmethod(played_rate)
    # (measured: a play with rounded walls left 0.007 of its power to one with sharp ones)
    hypothesis: ClassVar[Hypothesis | None] = Hypothesis(
        varies=('joint_torque',), reach=0.02,
        free={'half_width': 2e-05}, grid={'half_width': (5e-05, 0.00015)},
        alike=('wave_generator_compliance', 'torsional_hysteresis'), form_share=0.08,
        experiment=TORQUE_LOOPS, doubts={'half_width': (0.1, 'half_width')})
    typical: ClassVar[Typical | None] = Typical({'half_width': 8e-05})
    words: ClassVar[Words] = Words(
        'has {size} of play', 'flange',
        'Hold the motor, rock the link by hand, and feel or dial the play; '
        'tighten the screws and the key of the output flange.', ('half_width',), 2.0)
    half_width: float = parameter(0.0, 'rad', 0.0, 0.01, 'half of the play, output side')


@dataclass(frozen=True)
class TorsionalHysteresis(Effect):
    """Rate-independent loop of torque over torsion (Maxwell slip), (eq:sliders, hysteresis)."""

    name: ClassVar[str] = 'torsional_hysteresis'
    cause: ClassVar[str] = 'rate-independent hysteresis of the flexspline'
    site: ClassVar[Site] = Site.TORSION
    place: ClassVar[Place] = LOOP
    acts: ClassVar[tuple[str, ...]] = ('level',)
    law = staticmethod(hysteresis_torque)
    law_after = staticmethod(slid)
    law_stiffness = staticmethod(sticking_stiffness)
    # (measured: a curve explained up to 0.15 of the gain of a loop that was named rightly;
    # beside a free stiffness others do 0.001 to 0.13 of it, 0.02 to 0.5 at a fifth of the path)
    hypothesis: ClassVar[Hypothesis | None] = Hypothesis(
        varies=('torsion_path',), path='width', reach=0.3,
        free={'level': 0.3, 'width': 2e-05}, grid={'width': (3e-05, 0.0001, 0.0003)},
        alike=('backlash', 'clock_skew', 'structural_damping'), form_share=0.2, form_error=0.12,
        experiment=TORQUE_LOOPS)
    typical: ClassVar[Typical | None] = Typical({'level': 0.8}, {'width': 0.0002})
    # a loop of half an arcmin, of a joint of the usual torque
    unmeasured: ClassVar[Unmeasured | None] = Unmeasured(
        {'level': 1.5, 'width': 0.7}, {'width': 1.5e-4})
    words: ClassVar[Words] = Words(
        'has a torsion with a hysteresis of {size}', 'flexspline',
        'Load the joint slowly both ways with its motor held; check the screws of the flexspline.',
        ('level',))
    level: float = parameter(0.0, 'N*m', 0.0, 1e3, 'saturated torque of the loop, output side')
    width: float = parameter(
        1e-4, 'rad', 1e-6, 0.01, 'torsion at which half of the friction elements slide')


@dataclass(frozen=True)
class StructuralDamping(Effect):
    """Damping of the torsion, proportional to its rate, (eq:damping)."""

    name: ClassVar[str] = 'structural_damping'
    cause: ClassVar[str] = 'damping of the torsion differs'
    site: ClassVar[Site] = Site.TORSION
    place: ClassVar[Place] = GEAR
    stated: ClassVar[Mapping[str, str]] = {'coefficient': 'torsion.damping'}
    law = staticmethod(damping_torque)
    law_damping = staticmethod(damping_of)
    # (source: one that grows with the size of the torque is 0.4 to 0.6 off a constant one)
    hypothesis: ClassVar[Hypothesis | None] = Hypothesis(
        varies=('joint_torque',), reach=0.6,
        free={'coefficient': 2.0}, alike=('torsional_hysteresis', 'clock_skew'),
        experiment='excite the resonance, 15 to 50 Hz')
    typical: ClassVar[Typical | None] = Typical({'coefficient': 15.0})
    unmeasured: ClassVar[Unmeasured | None] = Unmeasured(
        {'coefficient': 0.5}, {'coefficient': 4.0})
    tolerance: ClassVar[tuple[str, str] | None] = ('coefficient', 'damping')
    words: ClassVar[Words] = Words(
        'has a gear that damps torsion by {size}, not as stated', 'flexspline', CHECK_MESH,
        ('coefficient',))
    coefficient: float = parameter(0.0, 'N*m*s/rad', 0.0, 1e4, 'D, output side')
