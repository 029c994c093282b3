"""What the fusion remembers of one joint, in one array, and how it is read."""

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.compiled import compiled, inlined
import numpy as np

from .route_errors import ERRORS, TORSION_ERRORS, ZERO

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
 AGAINST, FREED,                        # time of contradiction [s]; 1 once the zero was freed
 UNEXPLAINED,                           # squared difference beyond all that is known [N^2*m^2]
 MEAN_APART, MEAN_MOTOR,                # of differences and of the motor's torque, of late [N*m]
 SCATTER, WEIGHED,                      # of the motor's samples [N^2*m^2], the time it is from [s]
 LAG,                                   # of the inertia's torque behind a change of it [N*m]
 MOTOR_ALONE,                           # 1 where that is the better single witness
 SLOW_APART, SLOW_TIME,                 # slow part of differences [N*m], the time it is from [s]
 LAST_TWIST, TWIST_CHANGE,              # last torsion and its last change [rad]
 TWIST_SCATTER, TWIST_TIME,             # of torsions [rad^2], the time it is from [s]
 READ, STEP,                            # angles of the shaft since a gap, time between them [s]
 BEHIND, WAITED,                        # of stamps behind even ones; since an angle was read [s]
 SLID, SLIDING,                         # 1 once the shaft has slid; the torque it has since [N*m]
 TAUGHT,                                # 1 once a window has taught
 CARRIED,                               # share of what no law describes, made up for
 STEPS, STEPPED,                        # usual steps of its torque [N^2*m^2], time of them [s]
 ) = range(45)
PARABOLAS, SHAFT_MOTION = 4, 45         # how the shaft moves: four of them, of 5 numbers each
SUMS = 65                               # over the present half: value and effects (layout)
MOMENTS = SUMS + 1 + ERRORS             # the same, weighed by the time in it
RISEN = MOMENTS + 1 + ERRORS            # of the last half, weighed by its rising edge
LEARNT = RISEN + 1 + ERRORS             # errors (ERRORS,) in units of their sigma
GAINED = LEARNT + ERRORS                # their covariance less the identity, by rows
MEMORY = GAINED + ERRORS * ERRORS

# Choices unless stated otherwise.
LONG = 5.0              # over which misfits show that something changed [s]
PRIOR = 0.3             # time that what was known counts for as a first scatter [s]
STIFFEST, SOFTEST = 2.0, 0.5    # factor of the stiffness that may be learnt
# (source: a hand changes a torque in tenths of a second; friction of load and gear follow that)
SLOW = 0.2              # over which readings average before they are weighed as lasting [s]
AGREED = 0.5            # time for which both must agree before they are believed again [s]
LASTS = 1.0             # time for which what no law of either way describes is one error [s]


@inlined
def errors_learnt(memory: Array) -> Array:
    """Return the errors found so far (ERRORS,), in units of their sigma."""
    return memory[LEARNT:GAINED]


@inlined
def falls_back(memory: Array) -> bool:
    """Return whether torsion and motor are too far apart to correct each other."""
    return memory[APART] > 0.0 or memory[IMPOSSIBLE] > 0.0


@inlined
def gained(memory: Array) -> Array:
    """Return the covariance of the errors less the identity (ERRORS, ERRORS)."""
    return memory[GAINED:MEMORY].reshape((ERRORS, ERRORS))


@inlined
def doubt_zero(memory: Array, variance: float) -> None:
    """Add to the variance of the torsion's zero, in squared tolerances."""
    memory[GAINED + ZERO * (ERRORS + 1)] += variance


@inlined
def shift_apart(memory: Array, change: float) -> None:
    """Take what was learnt of the difference out of its means [N*m]."""
    memory[MEAN_APART] -= change
    memory[SLOW_APART] -= change


@inlined
def carry(memory: Array, part: float) -> None:
    """Let errors of a torsion take over this part of a difference, what no law describes too."""
    memory[CARRIED] += min(max(part, 0.0), 1.0) * (1.0 - memory[CARRIED])


@inlined
def carried(memory: Array, moving: bool, dt: float) -> float:
    """Return the share of that which they still make up for, (eq:carried); it lasts at rest."""
    if moving:
        memory[CARRIED] *= 1.0 - share(dt, LASTS)
    return float(memory[CARRIED])


@compiled
def follow_apart(memory: Array, apart: float, dt: float) -> float:
    """Follow the slow part of the difference [N*m]; returns what is left of its variance."""
    part = max(share(dt, SLOW), dt / (memory[SLOW_TIME] + dt))
    memory[SLOW_TIME] += dt
    memory[SLOW_APART] += part * (apart - memory[SLOW_APART])
    return part / (2.0 - part)


@compiled
def stiffness_factor(known_stiffness: float, learnt: float) -> float:
    """Return the factor of the stiffness; bounded, as no gear changes more, (eq:two-routes)."""
    return min(max(1.0 + known_stiffness * learnt, SOFTEST), STIFFEST)


@compiled
def slipped(memory: Array, side: int, size: float) -> None:
    """Doubt the zero, by the slip's size in tolerances, until both ways have agreed again."""
    memory[SLIPPED], memory[SIDE] = AGREED, side
    doubt_zero(memory, size ** 2)


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
def errors_apart(memory: Array, effect: Array) -> tuple[float, float]:
    """
    Return the variance by errors of the difference, and how much goes with the torsion's own.

    What was learnt to be common to both ways does not distinguish them (eq:weight).
    """
    gain, both, first = gained(memory), 0.0, 0.0
    for i in range(ERRORS):
        along = effect[i] * (effect[i] + np.dot(gain[i], effect))
        both += along
        if i < TORSION_ERRORS:
            first += along
    both = max(both, 0.0)
    return both, min(max(first, 0.0), both)


@inlined
def share(time: float, patience: float) -> float:
    """Return the share of a new value in a mean over a time [s]."""
    return 1.0 - np.exp(-time / patience)


@compiled
def usual_misfit(memory: Array) -> float:
    """Return squared differences over those that tolerances allow, mean of the last seconds."""
    if memory[HEARD] == 0.0:
        return 0.0
    return memory[LASTING] / (1.0 - np.exp(-memory[HEARD] / LONG))
