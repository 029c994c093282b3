"""
Learn from the difference of the two ways to a joint's torque what is wrong with each.

The difference does not contain the torque itself, so nothing is assumed of it, and neither delay
nor contact disturbs what is learnt. It is taken in windows that rise and fall by straight lines.
Against such a window the motor's acceleration becomes a difference of three angles. So no reading
has to be differentiated. Equations: docs/estimation.md.
"""

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.compiled import compiled, inlined, Record
from hda_arm_sim.model.encoders import counts_of
import numpy as np

from .agreement import AgreementWindow, expected, hold_against
from .compiled_settings import CompiledSettings
from .fusion_memory import (BEFORE, BEGIN, carry, doubt_zero, ELAPSED, errors_learnt, EXCESS,
                            FREED, gained, LASTS, LEARNT, MISFIT, MOMENTS, RISEN, SAMPLES, SENSE,
                            shift_apart, SINCE, SPAN, STEADY, SUMS, TAUGHT, TIME)
from .learning import fade, renew
from .route_errors import ERRORS, TORSION_ERRORS, ZERO

# Choices unless stated otherwise.
FEWEST = 5              # samples in half a window
SETTLED = 3             # halves in one sense before friction is what it is while sliding
_COUNTS = 8.0           # of the motor encoder that a half must pass
_LEAST_MOTION = 1e-3    # [rad], for encoders without counts
_CORRELATED = 10.0      # windows that share one error of the model
_FITTING = 5.0          # misfit up to which errors are as large as their tolerances say
_GOES_ON = 0.5          # of the last half's speed: below a third a shaft stops inside this one
_HOPELESS = 30.0        # deviations beyond which there is nothing to learn
_DOUBT = 0.1            # variance added to every error per second and misfit beyond that [1/s]


@compiled
def gather(memory: Array, difference: float, effect: Array, dt: float) -> None:
    """Add a sample's difference of the two torques [N*m] and the errors' effects on it."""
    memory[TIME] += dt
    memory[SINCE] += dt
    memory[ELAPSED] += dt
    memory[SAMPLES] += 1.0
    late = memory[ELAPSED] * dt
    memory[SUMS] += difference * dt
    memory[MOMENTS] += difference * late
    for i in range(ERRORS):
        memory[SUMS + 1 + i] += effect[i] * dt
        memory[MOMENTS + 1 + i] += effect[i] * late


@compiled
def restart(memory: Array, motor_angle: float) -> None:
    """Begin a window anew; what was learnt stays."""
    memory[ELAPSED:STEADY + 1] = 0.0
    memory[SUMS:LEARNT] = 0.0
    memory[BEGIN] = motor_angle


@compiled
def close_half(joint: Record, memory: Array, motor_angle: float, settings: CompiledSettings,
               stiffness: float, friction: float) -> None:
    """
    End half a window if its time is up, and learn from the window, (eq:window to misfit).

    `friction` is the most that dry friction opposes now [N*m at the link].
    """
    if memory[ELAPSED] < settings.window or memory[SAMPLES] < FEWEST:
        return
    time, moved = memory[ELAPSED], motor_angle - memory[BEGIN]
    sense = _sense(joint, moved)
    lasts = sense == memory[SENSE]
    steady = sense != 0.0 and lasts
    rests = (sense == 0.0 and lasts and joint.held_share < 1.0
             and memory[TAUGHT] == 0.0)
    memory[STEADY] = memory[STEADY] + 1.0 if steady else 0.0
    memory[SENSE] = sense
    if memory[SPAN] > 0.0:
        window = _window(joint, memory, moved, stiffness, friction, rests)
        hold_against(memory, window)
        if window.settled and _teachable(memory, window):
            mean = 0.5 * (time + memory[SPAN])
            if settings.following > 0.0:
                doubt_zero(memory, mean / settings.following)
            _learn(joint, memory, window, mean, settings.span)
    for i in range(1 + ERRORS):
        memory[RISEN + i] = memory[MOMENTS + i] / time
    memory[SUMS:RISEN] = 0.0
    memory[BEFORE], memory[BEGIN], memory[SPAN] = memory[BEGIN], motor_angle, time
    memory[ELAPSED] = memory[SAMPLES] = 0.0


@inlined
def _sense(joint: Record, moved: float) -> float:
    least = max(_COUNTS * counts_of(joint).motor_step, _LEAST_MOTION)
    return 0.0 if abs(moved) < least else np.sign(moved)


@inlined
def _window(joint: Record, memory: Array, moved: float, stiffness: float,
            friction: float, rests: bool) -> AgreementWindow:
    """Return the window that a half completes in which the shaft has moved so far [rad]."""
    time, span = memory[ELAPSED], memory[SPAN]
    mean, last = 0.5 * (time + span), (memory[BEGIN] - memory[BEFORE]) / span
    effect = np.empty(ERRORS)
    for i in range(ERRORS):
        effect[i] = _hat(memory, 1 + i, time) / mean
    held = (joint.held_share * friction) ** 2 / 3.0 if rests else 0.0
    turning = joint.ratio * joint.motor_inertia * (moved / time - last) / mean
    return AgreementWindow(_hat(memory, 0, time) / mean + turning, effect,
                           _noise(joint, stiffness, mean, memory[SAMPLES]),
                           joint.torsion.deviation ** 2 + joint.motor_deviation ** 2 + held,
                           friction, rests or memory[STEADY] >= SETTLED,
                           rests or abs(moved) / time > _GOES_ON * abs(last), time,
                           mean if rests else LASTS)


@inlined
def _hat(memory: Array, place: int, time: float) -> float:
    """Return an integral over the whole window: the risen half, and this one as it falls."""
    return memory[RISEN + place] + memory[SUMS + place] - memory[MOMENTS + place] / time


@inlined
def _noise(joint: Record, stiffness: float, time: float, samples: float) -> float:
    """Return the variance of a window's difference from counts and noise alone, (eq:misfit)."""
    motor = counts_of(joint).motor_step ** 2 / 12.0 + joint.motor_encoder.noise ** 2
    link = counts_of(joint).link_step ** 2 / 12.0 + joint.link_encoder.noise ** 2
    turned = 6.0 * (joint.ratio * joint.motor_inertia / time ** 2) ** 2 * motor
    return turned + stiffness ** 2 * (motor / joint.ratio ** 2 + link) / samples


@inlined
def _teachable(memory: Array, window: AgreementWindow) -> bool:
    """Return whether errors of a size that is thinkable may be behind a difference."""
    known = expected(memory, window)
    return (memory[EXCESS] == 0.0
            and known.alone ** 2 < _HOPELESS ** 2 * max(known.now, known.before))


@compiled
def _learn(joint: Record, memory: Array, window: AgreementWindow, time: float,
           span: float) -> None:
    """
    Renew errors and covariance from one window, a step of a Kalman filter, (eq:learning, misfit).

    Noise of counts is another in every window, what no law of either way describes lasts. A large
    difference is only as well known as the stiffness that turned a torsion into it.
    """
    learnt, gain, effect = errors_learnt(memory), gained(memory), window.effect
    freed = memory[FREED] * learnt[ZERO]            # a zero that moved does not come back
    fade(learnt, gain, np.exp(-memory[SINCE] / span))
    learnt[ZERO] += freed - memory[FREED] * learnt[ZERO]
    memory[SINCE], memory[TAUGHT] = 0.0, 1.0
    spread = effect + gain @ effect
    likely = effect @ spread
    if not np.isfinite(window.difference * (likely + window.noise)):
        return
    for i in range(ERRORS):
        gain[i, i] += _DOUBT * max(memory[MISFIT] - _FITTING, 0.0) * time
    unshared = _CORRELATED * window.noise + max(window.lasting / time, 1.0) * window.lawless
    steep = (joint.tolerances.stiffness * window.difference) ** 2
    variance = likely + steep + unshared * max(memory[MISFIT], 1.0)
    carry(memory, effect[:TORSION_ERRORS] @ spread[:TORSION_ERRORS] / variance)
    change = renew(learnt, gain, spread, window.difference, variance)
    shift = 0.0
    for i in range(ERRORS):
        memory[MOMENTS] -= memory[MOMENTS + 1 + i] * change[i]
        shift += effect[i] * change[i]
    shift_apart(memory, shift)
