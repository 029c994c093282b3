"""
Estimate a mass at the tip that the model does not know, from what moves the links.

The momentum that torque does not explain is that of a payload or of an inertia within its
tolerance, or a torque that is off. It is taken in windows that rise and fall by straight lines,
against which the change of a momentum is a difference of two means.
"""

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.compiled import compiled, inlined, Record
from hda_arm_sim.foundation.rigid import Inertia
import numpy as np

from .compiled_settings import Model
from .learning import fade, renew
from .momentum import expected_rate, LinkMotion, momentum

# What is distinguished, per unit or sigma: the mass, p1 to p3, an offset of either torque.
MASS, INERTIA, OFFSET = 0, 1, 4
ERRORS = 6  # (layout)
_COLUMNS = 5            # what is observed, and what mass and p1 to p3 would do (layout)
_BOTH = 2 * _COLUMNS    # on both joints

# Memory.
ELAPSED, SAMPLES, SPAN, SINCE, MISFIT = range(5)
_MOMENTA = 5                            # sums over the present half of the window (layout)
_LAST = _MOMENTA + _BOTH                # means over the last half
_RATES = _LAST + _BOTH                  # as the momenta: sums, sums weighed by time, risen half
_LATER = _RATES + _BOTH
_RISEN = _LATER + _BOTH
LEARNT = _RISEN + _BOTH
_GAINED = LEARNT + ERRORS
MEMORY = _GAINED + ERRORS * ERRORS

# Choices unless stated otherwise.
HEAVIEST = 5.0          # one sigma of a mass nobody knows [kg]
_OFFSET = 0.05          # of a torque, one sigma [N*m]
_NOISE = 0.02           # of a window's torque [N*m]
_HALF = 0.05            # half a window [s]
_FEWEST = 5             # samples in it
_CORRELATED = 10.0      # windows that share one error
_PATIENCE = 2.0         # over which misfits are averaged [s]


@compiled
def mass(memory: Array) -> tuple[float, float]:
    """Return the mass beyond the model's and its standard deviation [kg]."""
    return (HEAVIEST * memory[LEARNT + MASS],
            HEAVIEST * np.sqrt(max(1.0 + memory[_GAINED], 0.0)))


@compiled
def gather(memory: Array, model: Model, at: LinkMotion, seen: tuple[float, float],
           rates: tuple[float, float], dt: float) -> None:
    """Add a sample: momenta `seen` of known links, and expected `rates`, (eq:momenta)."""
    body, joints = model.record.body, model.record.joints.shape[0]
    memory[ELAPSED] += dt
    memory[SAMPLES] += 1.0
    memory[SINCE] += dt
    for column in range(_COLUMNS):
        if column > 0:
            part = _part(model.inertia, body.links, column - 1, model.settings.inertia_tolerance)
            seen = momentum(part, joints, at)
            rates = expected_rate(part, body, joints, at, (0.0, 0.0))
        for j in range(2):
            place = 2 * column + j
            memory[_MOMENTA + place] += seen[j] * dt
            memory[_RATES + place] += rates[j] * dt
            memory[_LATER + place] += rates[j] * dt * memory[ELAPSED]
    if memory[ELAPSED] >= _HALF and memory[SAMPLES] >= _FEWEST:
        _close(memory, joints, model.settings.span)


@compiled
def restart(memory: Array) -> None:
    """Begin a window anew; what was learnt stays."""
    memory[:SINCE] = 0.0
    memory[_MOMENTA:LEARNT] = 0.0


@inlined
def _part(inertia: Inertia, links: Record, error: int, tolerance: float) -> Inertia:
    """Return the inertia that one error adds: that of a mass at the tip, or of one of p1 to p3."""
    c, length1, length2 = inertia.coupled, links.length1, links.length2
    if error == MASS:
        return Inertia(HEAVIEST * (length1 ** 2 + length2 ** 2), HEAVIEST * length2 ** 2,
                       HEAVIEST * length1 * length2, HEAVIEST * length1, HEAVIEST * length2, c)
    p1 = tolerance * inertia.p1 if error == INERTIA else 0.0
    p2 = tolerance * inertia.p2 if error == INERTIA + 1 else 0.0
    p3 = tolerance * inertia.p3 if error == INERTIA + 2 else 0.0
    return Inertia(p1, p2, p3, 0.0, 0.0, c)


@inlined
def _close(memory: Array, joints: int, span: float) -> None:
    """End half a window, and learn from the window that it completes."""
    time = memory[ELAPSED]
    if memory[SPAN] > 0.0:
        for j in range(joints):
            _learn(memory, j, time, span)
    for place in range(_BOTH):
        memory[_LAST + place] = memory[_MOMENTA + place] / time
        memory[_RISEN + place] = memory[_LATER + place] / time
    memory[_MOMENTA:_LAST] = 0.0
    memory[_RATES:_RISEN] = 0.0
    memory[SPAN] = time
    memory[ELAPSED] = memory[SAMPLES] = 0.0


@inlined
def _unmoved(memory: Array, place: int, time: float) -> float:
    """Return the mean torque that changes a momentum beyond its rate [N*m], (eq:momenta)."""
    change = memory[_MOMENTA + place] / time - memory[_LAST + place]
    expected = memory[_RISEN + place] + memory[_RATES + place] - memory[_LATER + place] / time
    return (change - expected) / (0.5 * (time + memory[SPAN]))


@compiled
def _learn(memory: Array, j: int, time: float, span: float) -> None:
    """Renew the errors from one joint's window, (eq:payload-fit)."""
    learnt, gain = memory[LEARNT:_GAINED], memory[_GAINED:MEMORY].reshape((ERRORS, ERRORS))
    fade(learnt, gain, np.exp(-memory[SINCE] / span))
    memory[SINCE] = 0.0
    effect = np.zeros(ERRORS)
    for error in range(OFFSET):
        effect[error] = -_unmoved(memory, 2 * (1 + error) + j, time)
    effect[OFFSET + j] = _OFFSET
    difference = _unmoved(memory, j, time) - np.dot(effect, learnt)
    spread = effect + gain @ effect
    expected, noise = effect @ spread, _NOISE ** 2
    if not np.isfinite(difference * expected):
        return
    share = 1.0 - np.exp(-time / _PATIENCE)
    memory[MISFIT] += share * (min(difference ** 2 / (expected + noise), 1e4) - memory[MISFIT])
    renew(learnt, gain, spread, difference,
          expected + _CORRELATED * noise * max(memory[MISFIT], 1.0))
