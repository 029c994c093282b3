"""Give the arm its inputs as a drive does: held, and late (docs/model.md, eq:drive-chain)."""

import numpy as np

from .foundation.arrays import Array
from .foundation.chain import lent
from .foundation.compiled import borrowed, compiled, inlined, Record
from .foundation.rigid import Inertia
from .model.arm import ArmRecord
from .model.effect_loops import acting_at, record_at
from .model.effects.catalogue import sole_at
from .model.effects.place import Commanded, WIRE
from .model.integrate import advance, axes, set_input
from .model.kernel import COMMANDS, FORCES, HISTORY, SENT

NODES = 3               # start, middle and end of a step
_SAME = 1e-9            # share of a sample that is no time at all
_is_late, _wire_of, _arrived = acting_at(WIRE), record_at(WIRE), sole_at(WIRE).law_after


@inlined
def _late(joint: Record, dt: float) -> tuple[int, float]:
    """Return the whole samples of a joint's delay and the time that is left over [s]."""
    delay = _wire_of(joint).delay
    samples = min(int(delay / dt + _SAME), HISTORY - 2)
    left = delay - samples * dt
    return samples, (left if left > _SAME * dt else 0.0)


@inlined
def _hold(arm: ArmRecord, w: Array, force: Array, dt: float, elapsed: float) -> None:
    """Hold the inputs in force `elapsed` [s] after the newest command, over whole steps."""
    for j in range(arm.joints.shape[0]):
        samples, left = _late(arm.joints[j], dt)
        torque = w[j, SENT + samples]
        if left > 0.0:
            torque = _arrived(left, Commanded(torque, w[j, SENT + samples + 1], 0.0, elapsed))
        for k in range(NODES):
            w[j, COMMANDS + k] = torque
    for k in range(NODES):
        for axis in range(axes(arm)):
            w[axis, FORCES + k] = force[axis]


@compiled
def send(arm: ArmRecord, w: Array, torque: Array, force: Array, dt: float) -> None:
    """
    Send motor torques (n,) [N*m], held for the coming dt [s].

    So is what acts on the tip: a force (2,), or a wrench (6,) on a chain [N, N*m, base].
    """
    for j in range(arm.joints.shape[0]):
        if _is_late(arm.joints[j]):
            for k in range(HISTORY - 1, 0, -1):
                w[j, SENT + k] = w[j, SENT + k - 1]
        w[j, SENT] = torque[j]
    _hold(arm, w, force, dt, 0.0)
    set_input(arm, w, dt, 0.0, 0.0)


@compiled
def pass_sample(arm: ArmRecord, inertia: Inertia, w: Array, force: Array, dt: float,
                count: int) -> None:
    """Advance by one sample of dt [s] in `count` steps, cut where a late command arrives."""
    begin = 0.0
    while begin < dt:
        end = dt
        for j in range(arm.joints.shape[0]):
            left = _late(arm.joints[j], dt)[1]
            if begin < left < end:
                end = left
        if begin > 0.0 or end < dt:
            _hold(arm, w, force, dt, 0.5 * (begin + end))
        steps = max(1, int(np.ceil(count * (end - begin) / dt - _SAME)))
        for _ in range(steps):
            advance(arm, inertia, w, (end - begin) / steps)
        begin = end


@compiled
def act(arm: ArmRecord, inertia: Inertia, w: Array, torque: Array, force: Array, dt: float,
        count: int) -> None:
    """Advance the registers by one sample of dt [s] in `count` steps under held inputs."""
    arm, w, inertia = ArmRecord(borrowed(arm.joints), arm.body), borrowed(w), lent(inertia)
    send(arm, w, torque, force, dt)
    pass_sample(arm, inertia, w, force, dt, count)
