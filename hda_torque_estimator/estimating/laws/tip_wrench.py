"""
The wrench on the tip of a chain from its external joint torques (docs/model.md#estimator).

Six joints and more determine force and moment. Fewer determine the force, and the push is taken
for one without a moment, as on two links. What the pose hides cannot be observed: it is NaN.
"""

from hda_arm_sim.foundation import chain
from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.compiled import compiled, inlined
from hda_arm_sim.foundation.vectors import rotation
import numpy as np

from .layout import (BASE_COVARIANCE, BASE_WRENCH, BASE_X, CONDITIONING, SINGULAR,
                     TOOL_COVARIANCE, TOOL_WRENCH, TOOL_X, WRENCH_COVARIANCE)

AXES = 6
# Choices unless stated otherwise.
_LIKELY = (1000.0, 1000.0, 1000.0, 300.0, 300.0, 300.0)     # more than arms stand [N, N*m]
_OBSERVABLE = 0.1  # of that, a deviation from which on a component is as good as unknown


@compiled
def tip_wrench(c: Array, torque: Array, precision: Array, tip: Array) -> None:
    """
    Fill the wrench ON the tip by weighted least squares, tau = J^T F, (eq:tip-wrench).

    `torque` (n,) are the external torques [N*m] and `precision` (n, n) their inverse covariance,
    at the frames placed. What was likely before, a wrench up to what arms stand, keeps a hidden
    component finite until it is reported as NaN.
    """
    known = AXES if len(torque) >= AXES else AXES // 2
    jacobian = np.empty((AXES, len(torque)))
    chain.tip_jacobian(c, jacobian)
    observable = np.ascontiguousarray(jacobian[:known])
    weighed = observable @ precision
    normal, right = weighed @ observable.T, weighed @ torque
    for a in range(known):
        normal[a, a] += 1.0 / _LIKELY[a] ** 2
    tip[BASE_WRENCH:] = np.nan
    tip[TOOL_COVARIANCE:TOOL_COVARIANCE + 8] = np.nan
    if not np.isfinite(right).all():
        tip[SINGULAR] = tip[CONDITIONING] = np.nan
        tip[BASE_X:BASE_X + 2] = tip[TOOL_X:TOOL_X + 2] = np.nan
        return
    covariance = np.linalg.inv(normal).astype(np.float64)
    wrench = covariance @ right
    _write_observable(wrench, covariance, tip[BASE_WRENCH:])
    spread = tip[WRENCH_COVARIANCE:].reshape((AXES, AXES))
    for a in range(known):
        for b in range(known):
            if np.isfinite(tip[BASE_WRENCH + a] + tip[BASE_WRENCH + b]):
                spread[a, b] = covariance[a, b]
    turn = _to_tool(c, known)
    _write_observable(turn @ wrench, turn @ covariance @ turn.T, tip[TOOL_WRENCH:])
    hidden = not np.isfinite(tip[BASE_WRENCH:BASE_WRENCH + known]).all()
    tip[SINGULAR], tip[CONDITIONING] = 1.0 if hidden else 0.0, conditioning(jacobian)
    for a in range(2):
        tip[BASE_X + a], tip[TOOL_X + a] = tip[BASE_WRENCH + a], tip[TOOL_WRENCH + a]
        for b in range(2):
            tip[BASE_COVARIANCE + 2 * a + b] = spread[a, b]


@inlined
def _write_observable(wrench: Array, covariance: Array, written: Array) -> None:
    """Fill the components that are known well enough; others stay NaN."""
    for a in range(len(wrench)):
        if covariance[a, a] < (_OBSERVABLE * _LIKELY[a]) ** 2:
            written[a] = wrench[a]


@inlined
def _to_tool(c: Array, known: int) -> Array:
    """Return what turns force, or force and moment, into the tool frame (known, known)."""
    frame = rotation(c, c.shape[0] - 1, chain.FRAME)
    turn = np.zeros((known, known))
    for a in range(3):
        for b in range(3):
            turn[b, a] = frame[a][b]
            if known == AXES:
                turn[3 + b, 3 + a] = frame[a][b]
    return turn


@inlined
def conditioning(jacobian: Array) -> float:
    """Return smallest over largest singular value of the tip's velocities (6, n), 0 below 3."""
    if jacobian.shape[1] < 3:
        return 0.0
    sliding = np.ascontiguousarray(jacobian[:3])
    values = np.linalg.eigvalsh(sliding @ sliding.T)
    return np.sqrt(max(values[0], 0.0) / values[2])
