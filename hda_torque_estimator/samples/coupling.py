"""
What kind of coupling a slope of motor over link angle is: the right one, or a wrong convention.

Compiled, and with running sums, so that the live estimator asks the same as the commands do.
"""

import math

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.compiled import compiled, inlined, Record
from hda_arm_sim.model.effect_loops import record_of
from hda_arm_sim.model.effects.catalogue import known_as
from hda_arm_sim.model.encoders import counts_of
import numpy as np

# Kinds of a coupling, negative with one sign flipped.
RIGHT, FLIPPED, AT_LINK, MOTOR_DEGREES, LINK_DEGREES, OTHER = 0, -1, 2, 3, 4, 5

# Choices unless stated otherwise.
TRAVEL = 0.02           # of the link, from which anything can be judged (choice) [rad]
# (source: a gear of N teeth pairs turns N or N + 1 to 1)
WHOLE = 0.5             # teeth: gears of one size have N or N + 1 to 1, so half a tooth is between
# (measured: a disc of a real arm made 3e-3)
DISC = 5e-3             # slope that a disc off its axis makes
# (source: data sheets of magnetic encoders of 12 bits, INL of 0.5 degrees at most)
COARSE = 6.0            # counts by which a coarse encoder may be bent along its turn
NEAR = 0.1              # relative, within which a slope is one of the named conventions
SOFTEST = 0.02          # torsion of a joint whose law is valid without end (choice) [rad]

# Choices unless stated otherwise.
WORST = 3.0             # slope of a torsion of either sign on an even travel, over twist / span
# Link travel from which the torsion of a whole recording follows the weight, and after which a
# running stretch begins anew (choice) [rad].
STRETCH = 0.3

# Memory: sums over a stretch from its first angles on, and the kind that was found.
(BEGUN, FIRST_MOTOR, FIRST_LINK, COUNT, SUM_MOTOR, SUM_LINK, SUM_LINK_2, SUM_BOTH,
 LOW_MOTOR, HIGH_MOTOR, LOW_LINK, HIGH_LINK, KIND) = range(13)
MEMORY = 13  # (layout)
_disc_of = record_of(known_as('eccentricity'))


@compiled
def twist_of(valid_torsion: float) -> float:
    """Return the torsion that may bend a slope: half the law's range to either side [rad]."""
    return min(valid_torsion, SOFTEST)


@compiled
def bend_over(twist: float, span: float) -> float:
    """Return how far, over the ratio, a torsion [rad] bends the slope of an even travel [rad]."""
    return twist * (WORST if span < STRETCH else 1.0) / span


@compiled
def disc_of(joint: Record) -> float:
    """Return the slope that a disc makes: by what is known of it, and by what coarse ones may."""
    own = _disc_of(joint)
    return (own.amplitude_1 + 2.0 * own.amplitude_2
            + COARSE * counts_of(joint).link_step)


@compiled
def kind_of(slope: float, span: float, ratio: float, bend: float) -> int:
    """Return the kind of a slope from `span` of travel [rad] at the link, bent by torsion."""
    if span < TRAVEL:
        return RIGHT
    allowed = min(max(WHOLE / ratio, DISC), NEAR) + bend
    if abs(slope / ratio - 1.0) <= allowed:
        return RIGHT
    sign, size = (1 if slope > 0.0 else -1), abs(slope)
    if abs(size / ratio - 1.0) <= max(NEAR, bend):
        return FLIPPED if sign < 0 else OTHER
    degree = math.pi / 180.0
    for kind, expected in ((AT_LINK, 1.0), (MOTOR_DEGREES, ratio / degree),
                           (LINK_DEGREES, ratio * degree)):
        if abs(size / expected - 1.0) <= NEAR + bend:
            return sign * kind
    return OTHER


@inlined
def restart(memory: Array) -> None:
    """Begin a stretch anew; what was found of the last one stays."""
    memory[BEGUN] = 0.0


@compiled
def add(memory: Array, motor: float, link: float, ratio: float, twist: float,
        disc: float = 0.0) -> float:
    """
    Add the angles of a sample [rad] to a stretch; returns the kind of coupling by now.

    `disc` is the slope that the disc of the link encoder makes.
    """
    if memory[BEGUN] == 0.0:
        memory[:KIND] = 0.0
        memory[BEGUN], memory[FIRST_MOTOR], memory[FIRST_LINK] = 1.0, motor, link
    x, y = link - memory[FIRST_LINK], motor - memory[FIRST_MOTOR]
    memory[COUNT] += 1.0
    memory[SUM_MOTOR] += y
    memory[SUM_LINK] += x
    memory[SUM_LINK_2] += x * x
    memory[SUM_BOTH] += x * y
    memory[LOW_MOTOR], memory[HIGH_MOTOR] = min(memory[LOW_MOTOR], y), max(memory[HIGH_MOTOR], y)
    memory[LOW_LINK], memory[HIGH_LINK] = min(memory[LOW_LINK], x), max(memory[HIGH_LINK], x)
    span = max(memory[HIGH_LINK] - memory[LOW_LINK],
               (memory[HIGH_MOTOR] - memory[LOW_MOTOR]) / ratio)
    if span > max(TRAVEL, 2.0 * WORST * twist):
        n = memory[COUNT]
        square = memory[SUM_LINK_2] - memory[SUM_LINK] ** 2 / n
        both = memory[SUM_BOTH] - memory[SUM_LINK] * memory[SUM_MOTOR] / n
        square = max(square, 1e-12 * (ratio * span) ** 2 * n, 1e-300)
        # Cauchy and Schwarz: no torsion within +-twist bends the slope of these samples further,
        # also where the joint rested for most of the stretch.
        bend = twist / np.sqrt(square / n) + disc
        memory[KIND] = kind_of(both / square, span, ratio, bend)
        if span > STRETCH:
            restart(memory)
    return memory[KIND]
