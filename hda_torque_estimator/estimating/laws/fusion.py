"""
Learn from the difference of the two ways to a joint's torque what is wrong with each.

The difference does not contain the torque itself, so nothing is assumed of it, and neither delay
nor contact disturbs what is learnt. It is taken in windows that rise and fall by straight lines.
Against such a window the motor's acceleration becomes a difference of three angles. So no reading
has to be differentiated. Equations: docs/estimation.md.
"""

from hda_arm_sim.foundation.compiled import Array, compiled, inlined, Record
import numpy as np

from .learning import fade, renew
from .route_errors import ERRORS, ZERO

# Memory, per joint.
(LAST_COMMAND,                          # in force since the last sample [N*m motor]
 TIME,                                  # since the first sample [s]
 ELAPSED, SAMPLES,                      # in the present half of the window [s]
 BEGIN, BEFORE, SPAN,                   # shaft where this and the last half began, its time
 SENSE, STEADY,                         # of the motion, and how many halves it has lasted
 SINCE,                                 # the errors were renewed [s]
 MISFIT, DIFFERENCE,                    # squared differences over expected ones; mean difference
 LASTING, HEARD,                        # misfit over longer, and for how long [s]
 APART, CHANGED, IMPOSSIBLE,            # time for which the two ways must still agree until they
                                        # correct each other, and are believed, again [s]
 EXCESS,                                # beyond what the motor can give [N*m]
 SLIPPED, SIDE,                         # the same time after a slip, and which side it was
 ) = range(20)
_SUMS = 20                              # over the present half: value and effects (layout)
_MOMENTS = _SUMS + 1 + ERRORS           # the same, weighed by the time in it
_RISEN = _MOMENTS + 1 + ERRORS          # of the last half, weighed by its rising edge
LEARNT = _RISEN + 1 + ERRORS            # errors (ERRORS,) in units of their sigma
_GAINED = LEARNT + ERRORS               # their covariance less the identity, by rows
MEMORY = _GAINED + ERRORS * ERRORS

# Choices unless told otherwise.
_FEWEST = 5             # samples in half a window
_SETTLED = 3            # halves in one sense before friction is what it is while sliding
_COUNTS = 8.0           # of the motor encoder that a half must pass
_LEAST_MOTION = 1e-3    # [rad], for encoders without counts
_CORRELATED = 10.0      # windows that share one error of the model
_LASTING = 100.0        # windows that share what no law of the torsion tells
_WORST = 1e4            # misfit that a single window may show
_PATIENCE = 1.0         # over which misfits are averaged [s]
_FITTING = 5.0          # misfit up to which errors are as large as their tolerances say
_GOES_ON = 0.5          # of the last half's speed: below a third a shaft stops inside this one
_LONG = 5.0             # over which misfits tell that something changed [s]
_FAR = 10.0             # tolerances of all errors, beyond which neither way corrects the other
_HOPELESS = 30.0        # beyond which there is nothing to learn
_SUDDEN = 8.0           # deviations of what is known now; healthy arms: docs/estimation.md
_FRICTION = 2.0         # times the dry friction known, that a motor may have at most
_CERTAIN = 4.0          # deviations beyond what the motor can give
_AGREED = 0.5           # time for which both must agree before they are believed again [s]
STIFFEST, SOFTEST = 2.0, 0.5    # factor of the stiffness that may be learnt
_DOUBT = 0.1            # variance added to every error per second and misfit beyond that [1/s]


@inlined
def errors_learnt(memory: Array) -> Array:
    """Return the errors found so far (ERRORS,), in units of their sigma."""
    return memory[LEARNT:_GAINED]


@compiled
def stiffness_factor(known_stiffness: float, learnt: float) -> float:
    """Return the factor of the stiffness; bounded, as no gear changes more, (eq:two-routes)."""
    return min(max(1.0 + known_stiffness * learnt, SOFTEST), STIFFEST)


@inlined
def falls_back(memory: Array) -> bool:
    """Tell whether torsion and motor are too far apart to correct each other."""
    return memory[APART] > 0.0 or memory[IMPOSSIBLE] > 0.0


@inlined
def gained(memory: Array) -> Array:
    """Return the covariance of the errors less the identity (ERRORS, ERRORS)."""
    return memory[_GAINED:MEMORY].reshape((ERRORS, ERRORS))


@compiled
def slipped(memory: Array, side: int, size: float) -> None:
    """Doubt the zero, by the slip's size in tolerances, until both ways have agreed again."""
    memory[SLIPPED], memory[SIDE] = _AGREED, side
    memory[_GAINED + ZERO * (ERRORS + 1)] += size ** 2


@compiled
def effect_variance(memory: Array, effect: Array, count: int) -> tuple[float, float]:
    """Return the variance of the first errors' effect, now and before, (eq:sigma-torque)."""
    gain, before, now = gained(memory), 0.0, 0.0
    for i in range(count):
        before += effect[i] * effect[i]
        across = 0.0                                # the covariance is symmetric
        for k in range(i):
            across += gain[i, k] * effect[k]
        now += effect[i] * (2.0 * across + gain[i, i] * effect[i])
    return max(before + now, 0.0), before


@compiled
def gather(memory: Array, difference: float, effect: Array, dt: float) -> None:
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
def restart(memory: Array, motor_angle: float, command: float) -> None:
    """Begin a window anew; what was learnt stays."""
    memory[LAST_COMMAND] = command
    memory[ELAPSED:STEADY + 1] = 0.0
    memory[_SUMS:LEARNT] = 0.0
    memory[BEGIN] = motor_angle


@compiled
def close_half(joint: Record, memory: Array, motor_angle: float, window: float, stiffness: float,
               span: float) -> None:
    """
    End half a window if its time is up, and learn from the window, (eq:window to misfit).

    `window` is the least time of a half [s], `span` the time in which what was learnt fades [s].
    """
    if memory[ELAPSED] < window or memory[SAMPLES] < _FEWEST:
        return
    time, moved = memory[ELAPSED], motor_angle - memory[BEGIN]
    sense = _sense(joint, moved)
    steady = sense != 0.0 and sense == memory[SENSE]
    memory[STEADY] = memory[STEADY] + 1.0 if steady else 0.0
    memory[SENSE] = sense
    if memory[SPAN] > 0.0:
        mean = 0.5 * (time + memory[SPAN])
        speeding = (moved / time - (memory[BEGIN] - memory[BEFORE]) / memory[SPAN]) / mean
        effect = np.empty(ERRORS)
        for i in range(ERRORS):
            effect[i] = _hat(memory, 1 + i, time) / mean
        difference = (_hat(memory, 0, time) / mean
                      + joint.ratio * joint.motor_inertia * speeding)
        noise = _noise(joint, stiffness, mean, memory[SAMPLES])
        lawless = joint.torsion.deviation ** 2
        settled = memory[STEADY] >= _SETTLED
        friction = joint.ratio * joint.coulomb_friction.level
        goes_on = abs(moved) / time > _GOES_ON * abs(memory[BEGIN] - memory[BEFORE]) / memory[SPAN]
        _hold_against(memory, difference, effect, noise + lawless, friction,
                      settled and goes_on, time)
        if settled and _teachable(memory, difference, effect, noise + lawless):
            _learn(memory, difference, effect, noise, lawless, mean, span)
    for i in range(1 + ERRORS):
        memory[_RISEN + i] = memory[_MOMENTS + i] / time
    memory[_SUMS:_RISEN] = 0.0
    memory[BEFORE], memory[BEGIN], memory[SPAN] = memory[BEGIN], motor_angle, time
    memory[ELAPSED] = memory[SAMPLES] = 0.0


@inlined
def _sense(joint: Record, moved: float) -> float:
    least = max(_COUNTS * joint.coarse_quantisation.motor_step, _LEAST_MOTION)
    return 0.0 if abs(moved) < least else np.sign(moved)


@inlined
def _hat(memory: Array, place: int, time: float) -> float:
    """Return an integral over the whole window: the risen half, and this one as it falls."""
    return memory[_RISEN + place] + memory[_SUMS + place] - memory[_MOMENTS + place] / time


@inlined
def _noise(joint: Record, stiffness: float, time: float, samples: float) -> float:
    """Return the variance of a window's difference from counts and noise alone, (eq:misfit)."""
    motor = joint.coarse_quantisation.motor_step ** 2 / 12.0 + joint.motor_encoder.noise ** 2
    link = joint.coarse_quantisation.link_step ** 2 / 12.0 + joint.link_encoder.noise ** 2
    turned = 6.0 * (joint.ratio * joint.motor_inertia / time ** 2) ** 2 * motor
    return turned + stiffness ** 2 * (motor / joint.ratio ** 2 + link) / samples


@compiled
def _hold_against(memory: Array, difference: float, effect: Array, unshared: float,
                  friction: float, settled: bool, time: float) -> None:
    """
    Judge by one window whether torsion and motor can both be right.

    `unshared` is the variance of what is none of the errors [N^2*m^2], `friction` the dry friction
    known [N*m at the link], which is taken for unknown here: only what a motor cannot give, with
    no friction or twice as much, is impossible. Standing still it holds either way.
    """
    alone, before = _alone(memory, difference, effect, unshared)
    slack = friction * (_FRICTION - 1.0 if settled else _FRICTION + 1.0)
    excess = abs(alone) - slack - _CERTAIN * np.sqrt(before)
    memory[EXCESS] = max(excess, 0.0)
    memory[IMPOSSIBLE] = _AGREED if excess > 0.0 else max(memory[IMPOSSIBLE] - time, 0.0)
    if not settled:
        return
    far = alone ** 2 > _FAR ** 2 * before
    memory[APART] = _AGREED if far else max(memory[APART] - time, 0.0)
    likely = effect @ (effect + gained(memory) @ effect) + unshared
    misfit = difference ** 2 / likely
    sudden = (misfit > _SUDDEN ** 2 * max(_usual(memory), 1.0)
              and difference ** 2 > _CERTAIN ** 2 * before)
    memory[CHANGED] = _AGREED if sudden else max(memory[CHANGED] - time, 0.0)
    if misfit <= 1.0:
        memory[SLIPPED] = max(memory[SLIPPED] - time, 0.0)
    if np.isfinite(misfit):
        memory[MISFIT] += _share(time, _PATIENCE) * (min(misfit, _WORST) - memory[MISFIT])
        memory[LASTING] += _share(time, _LONG) * (min(misfit, _WORST) - memory[LASTING])
        memory[HEARD] += time
        memory[DIFFERENCE] += _share(time, _PATIENCE) * (difference - memory[DIFFERENCE])


@inlined
def _share(time: float, patience: float) -> float:
    return 1.0 - np.exp(-time / patience)


@inlined
def _usual(memory: Array) -> float:
    """Return the misfit over the last seconds, however short they were."""
    if memory[HEARD] == 0.0:
        return 0.0
    return memory[LASTING] / (1.0 - np.exp(-memory[HEARD] / _LONG))


@compiled
def usual_misfit(memory: Array) -> float:
    """Return squared differences over those that tolerances allow, mean of the last seconds."""
    return _usual(memory)


@inlined
def _alone(memory: Array, difference: float, effect: Array,
           unshared: float) -> tuple[float, float]:
    """Return a difference [N*m] and its variance as before anything was learnt."""
    return (difference + np.dot(effect, errors_learnt(memory)),
            np.dot(effect, effect) + unshared)


@inlined
def _teachable(memory: Array, difference: float, effect: Array, unshared: float) -> bool:
    """Tell whether errors of the size of tolerances may be behind a difference."""
    alone, before = _alone(memory, difference, effect, unshared)
    return memory[EXCESS] == 0.0 and alone ** 2 < _HOPELESS ** 2 * before


@compiled
def _learn(memory: Array, difference: float, effect: Array, noise: float, lawless: float,
           time: float, span: float) -> None:
    """
    Renew errors and covariance from one window, a step of a Kalman filter, (eq:learning, misfit).

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
    for i in range(ERRORS):
        gain[i, i] += _DOUBT * max(memory[MISFIT] - _FITTING, 0.0) * time
    variance = expected + (_CORRELATED * noise + _LASTING * lawless) * max(memory[MISFIT], 1.0)
    change = renew(learnt, gain, spread, difference, variance)
    for i in range(ERRORS):
        memory[_MOMENTS] -= memory[_MOMENTS + 1 + i] * change[i]
