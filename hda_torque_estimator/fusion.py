"""
Learn from the difference of the two ways to a joint's torque what is wrong with each (F4-F7).

The difference does not contain the torque itself, so nothing is assumed of it, and neither delay
nor contact disturbs what is learnt. It is taken in windows that rise and fall by straight lines:
integrated against such a window, the motor's acceleration becomes a difference of three angles,
and no reading has to be differentiated. Equations: docs/estimation.md.
"""

from hda_arm_sim.model.compiled import compiled, inlined
import numpy as np

from .learning import fade, renew
from .route_errors import ERRORS

# Memory, per joint.
(LAST_COMMAND,                          # in force since the last sample [N*m motor]
 TIME,                                  # since the first sample [s]
 ELAPSED, SAMPLES,                      # in the present half of the window [s]
 BEGIN, BEFORE, SPAN,                   # shaft where this and the last half began, its time
 SENSE, STEADY,                         # of the motion, and how many halves it has lasted
 SINCE,                                 # the errors were renewed [s]
 MISFIT, DIFFERENCE,                    # squared differences over expected ones; mean difference
 ) = range(12)
_SUMS = 12                              # over the present half: value and effects
_MOMENTS = _SUMS + 1 + ERRORS           # the same, weighed by the time in it
_RISEN = _MOMENTS + 1 + ERRORS          # of the last half, weighed by its rising edge
LEARNT = _RISEN + 1 + ERRORS            # errors (ERRORS,) in units of their sigma
_GAINED = LEARNT + ERRORS               # their covariance less the identity, by rows
MEMORY = _GAINED + ERRORS * ERRORS

_FEWEST = 5             # samples in half a window
_SETTLED = 3            # halves in one sense before friction is what it is while sliding
_COUNTS = 8.0           # of the motor encoder that a half must pass
_LEAST_MOTION = 1e-3    # [rad], for encoders without counts
_CORRELATED = 10.0      # windows that share one error of the model
_LASTING = 100.0        # windows that share what no law of the torsion tells
_WORST = 1e4            # misfit that a single window may show
_PATIENCE = 1.0         # over which misfits are averaged [s]
_FITTING = 5.0          # misfit up to which errors are as large as their tolerances say
_DOUBT = 0.1            # variance added to every error per second and misfit beyond that [1/s]


@inlined
def errors_learnt(memory):                                          # type: ignore[no-untyped-def]
    """Return the errors found so far (ERRORS,), in units of their sigma."""
    return memory[LEARNT:_GAINED]


@inlined
def gained(memory):                                                 # type: ignore[no-untyped-def]
    """Return the covariance of the errors less the identity (ERRORS, ERRORS)."""
    return memory[_GAINED:MEMORY].reshape((ERRORS, ERRORS))


@compiled
def effect_variance(memory, effect, count):                         # type: ignore[no-untyped-def]
    """Return the variance of the first errors' joint effect, as known now and before, (F7)."""
    gain, before, now = gained(memory), 0.0, 0.0
    for i in range(count):
        before += effect[i] * effect[i]
        across = 0.0                                # the covariance is symmetric
        for k in range(i):
            across += gain[i, k] * effect[k]
        now += effect[i] * (2.0 * across + gain[i, i] * effect[i])
    return max(before + now, 0.0), before


@compiled
def gather(                                                         # type: ignore[no-untyped-def]
        memory, difference, effect, dt):
    """Add a sample's difference of the two torques [N*m] and the errors' effects on it."""
    memory[TIME] += dt
    memory[SINCE] += dt
    memory[ELAPSED] += dt
    memory[SAMPLES] += 1.0
    late = memory[ELAPSED] * dt
    memory[_SUMS] += difference * dt
    memory[_MOMENTS] += difference * late
    for i in range(ERRORS):
        memory[_SUMS + 1 + i] += effect[i] * dt
        memory[_MOMENTS + 1 + i] += effect[i] * late


@compiled
def restart(memory, motor_angle, command):                          # type: ignore[no-untyped-def]
    """Begin a window anew; what was learnt stays."""
    memory[LAST_COMMAND] = command
    memory[ELAPSED:STEADY + 1] = 0.0
    memory[_SUMS:LEARNT] = 0.0
    memory[BEGIN] = motor_angle


@compiled
def close_half(                                                     # type: ignore[no-untyped-def]
        joint, memory, motor_angle, window, stiffness, span):
    """
    End half a window if its time is up, and learn from the window that it completes, (F4-F6).

    `window` is the least time of a half [s], `span` the time in which what was learnt fades [s].
    """
    if memory[ELAPSED] < window or memory[SAMPLES] < _FEWEST:
        return
    time, moved = memory[ELAPSED], motor_angle - memory[BEGIN]
    sense = _sense(joint, moved)
    steady = sense != 0.0 and sense == memory[SENSE]
    memory[STEADY] = memory[STEADY] + 1.0 if steady else 0.0
    memory[SENSE] = sense
    if memory[STEADY] >= _SETTLED and memory[SPAN] > 0.0:
        mean = 0.5 * (time + memory[SPAN])
        speeding = (moved / time - (memory[BEGIN] - memory[BEFORE]) / memory[SPAN]) / mean
        effect = np.empty(ERRORS)
        for i in range(ERRORS):
            effect[i] = _hat(memory, 1 + i, time) / mean
        difference = (_hat(memory, 0, time) / mean
                      + joint.ratio * joint.motor_inertia * speeding)
        noise = _noise(joint, stiffness, mean, memory[SAMPLES])
        _learn(memory, difference, effect, noise, joint.torsion.deviation ** 2, mean, span)
    for i in range(1 + ERRORS):
        memory[_RISEN + i] = memory[_MOMENTS + i] / time
    memory[_SUMS:_RISEN] = 0.0
    memory[BEFORE], memory[BEGIN], memory[SPAN] = memory[BEGIN], motor_angle, time
    memory[ELAPSED] = memory[SAMPLES] = 0.0


@inlined
def _sense(joint, moved):                                           # type: ignore[no-untyped-def]
    least = max(_COUNTS * joint.coarse_quantisation.motor_step, _LEAST_MOTION)
    return 0.0 if abs(moved) < least else np.sign(moved)


@inlined
def _hat(memory, place, time):                                      # type: ignore[no-untyped-def]
    """Return an integral over the whole window: the risen half, and this one as it falls."""
    return memory[_RISEN + place] + memory[_SUMS + place] - memory[_MOMENTS + place] / time


@inlined
def _noise(joint, stiffness, time, samples):                        # type: ignore[no-untyped-def]
    """Return the variance of a window's difference from counts and noise alone, (F6)."""
    motor = joint.coarse_quantisation.motor_step ** 2 / 12.0 + joint.motor_encoder.noise ** 2
    link = joint.coarse_quantisation.link_step ** 2 / 12.0 + joint.link_encoder.noise ** 2
    turned = 6.0 * (joint.ratio * joint.motor_inertia / time ** 2) ** 2 * motor
    return turned + stiffness ** 2 * (motor / joint.ratio ** 2 + link) / samples


@compiled
def _learn(                                                         # type: ignore[no-untyped-def]
        memory, difference, effect, noise, lawless, time, span):
    """
    Renew errors and covariance from one window, a step of a Kalman filter, (F5-F6).

    `noise` and `lawless` are variances of what is none of the errors: that of counts is another
    in every window, what no law of the torsion tells lasts [N^2*m^2].
    """
    learnt, gain = errors_learnt(memory), gained(memory)
    fade(learnt, gain, np.exp(-memory[SINCE] / span))
    memory[SINCE] = 0.0
    spread = effect + gain @ effect
    expected = effect @ spread
    likely = expected + noise + lawless
    if not np.isfinite(difference * likely):
        return
    share = 1.0 - np.exp(-time / _PATIENCE)
    memory[MISFIT] += share * (min(difference ** 2 / likely, _WORST) - memory[MISFIT])
    memory[DIFFERENCE] += share * (difference - memory[DIFFERENCE])
    for i in range(ERRORS):
        gain[i, i] += _DOUBT * max(memory[MISFIT] - _FITTING, 0.0) * time
    variance = expected + (_CORRELATED * noise + _LASTING * lawless) * max(memory[MISFIT], 1.0)
    change = renew(learnt, gain, spread, difference, variance)
    for i in range(ERRORS):
        memory[_MOMENTS] -= memory[_MOMENTS + 1 + i] * change[i]
