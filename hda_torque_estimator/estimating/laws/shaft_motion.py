"""
How fast a shaft speeds up, by its angle alone: a parabola that forgets (eq:parabola).

Stamps of a host say when a busy computer handed readings on, those of a drive when they were
taken. An encoder may be coarse, or its shaft quick. So parabolas are followed on two clocks, that
of the stamps and one that counts samples evenly, and each forgets soon or late. The one that has
predicted angles best is believed.
"""

from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.compiled import compiled, inlined
import numpy as np

from .fusion_memory import BEHIND, LONG, PARABOLAS, READ, SHAFT_MOTION, share, STEP, WAITED

# Memory of one parabola, behind its place.
_ANGLE, _SPEED, _SPEEDING = range(3)    # [rad], [rad/s], [rad/s^2]
_LAG, _MISSED, _SIZE = 3, 4, 5          # [rad/s^2]; mean squared miss [rad^2]

# Patience of the quicker parabolas in half windows (measured: the errors of two arms with 16384
# and 65536 counts at 1 kHz are least at 0.2 to 0.3).
_QUICKEST = 0.25
# Choices unless stated otherwise.
_LATE = 3.0             # times as patient are the others: noise is a fifteenth then
_REGULAR = 0.6          # of the time between samples, by which stamps of a host are late or early
_BURST = 0.1            # of the least patience: samples that follow in less came late in a burst


class Speeding(NamedTuple):
    """How fast a shaft speeds up."""

    now: float                  # [rad/s^2]
    lag: float                  # what that lags behind a steady change of it [rad/s^2]


@compiled
def begin_motion(memory: Array, angle: float) -> None:
    """Forget how a shaft [rad] moved; what its stamps are worth stays."""
    for place in range(SHAFT_MOTION, SHAFT_MOTION + PARABOLAS * _SIZE, _SIZE):
        memory[place + _ANGLE] = angle
        memory[place + _SPEED] = memory[place + _SPEEDING] = memory[place + _LAG] = 0.0
    memory[READ] = memory[BEHIND] = memory[WAITED] = 0.0


@compiled
def follow_motion(memory: Array, angle: float, window: float, dt: float) -> Speeding:
    """Follow a shaft's angle [rad] after a time [s] and return how fast it speeds up."""
    memory[WAITED] += dt
    if memory[WAITED] >= _BURST * _QUICKEST * window:
        _renew(memory, angle, window, memory[WAITED])
        memory[WAITED] = 0.0
    best = SHAFT_MOTION
    for place in range(SHAFT_MOTION, SHAFT_MOTION + PARABOLAS * _SIZE, _SIZE):
        if memory[place + _MISSED] < memory[best + _MISSED]:
            best = place
    return Speeding(memory[best + _SPEEDING], memory[best + _LAG])


@compiled
def jump_motion(memory: Array, change: float) -> None:
    """Let a shaft speed up by so much more at once [rad/s^2], (eq:jump)."""
    for place in range(SHAFT_MOTION, SHAFT_MOTION + PARABOLAS * _SIZE, _SIZE):
        memory[place + _SPEEDING] += change


@inlined
def _renew(memory: Array, angle: float, window: float, dt: float) -> None:
    """Let all parabolas follow an angle [rad] after a time [s]."""
    counted, quickest = _even(memory, dt), max(dt, _QUICKEST * window)
    memory[READ] += 1.0
    for k in range(PARABOLAS):
        _follow(memory, SHAFT_MOTION + k * _SIZE, angle, dt if k < PARABOLAS // 2 else counted,
                quickest * (_LATE if k % 2 else 1.0))


@inlined
def _even(memory: Array, dt: float) -> float:
    """Return the time since the last sample by a clock that counts them, lost ones as well [s]."""
    if memory[READ] == 0.0:
        memory[STEP] = dt
    part = max(share(memory[STEP], LONG), 1.0 / (memory[READ] + 1.0))
    if abs(dt - memory[STEP]) < _REGULAR * memory[STEP]:
        memory[STEP] += part * (dt - memory[STEP])
    steps = max(1.0, np.round((dt + memory[BEHIND]) / memory[STEP]))
    passed: float = steps * memory[STEP]
    memory[BEHIND] = (1.0 - share(dt, LONG)) * (memory[BEHIND] + dt - passed)
    return passed


@inlined
def _follow(memory: Array, place: int, angle: float, dt: float, patience: float) -> None:
    """Renew one parabola, (eq:parabola)."""
    last = memory[place + _SPEEDING]
    speed = memory[place + _SPEED] + last * dt
    missed = angle - memory[place + _ANGLE] - (speed - 0.5 * last * dt) * dt
    keep = np.exp(-dt / patience)
    new = 1.0 - keep
    memory[place + _ANGLE] = angle - keep ** 3 * missed
    if memory[READ] < 2.0:                          # two angles determine a speed, and no more
        memory[place + _SPEED] = missed / dt
        return
    memory[place + _SPEED] = speed + 1.5 * new ** 2 * (1.0 + keep) * missed / dt
    memory[place + _SPEEDING] = last + new ** 3 * missed / dt ** 2
    memory[place + _MISSED] += share(dt, LONG) * (missed ** 2 - memory[place + _MISSED])
    memory[place + _LAG] = 3.0 * patience * new ** 3 * missed / dt ** 3
