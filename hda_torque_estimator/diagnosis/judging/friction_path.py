"""
Friction that builds up over a path after a link turns round: other forms of a dry one.

A law of friction that is dry changes its sign at once. A seal or a preloaded bearing bends first,
over a path that nobody states. So the forms of dry friction are those of some paths (eq:built-up).
The longest is what goes as far from the dry law as published laws do, so no path is chosen.
"""

from collections.abc import Callable, Iterator

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.compiled import compiled
from hda_arm_sim.model.kernel import LINK_ANGLE, LINK_VELOCITY
import numpy as np

from ..fitting.fit import Fit, Fitter
from ..fitting.hypotheses import HYPOTHESES
from ...least_squares.term import Term

LINK_PATH = 'link_path'         # declares that laws differ in how they build up along a link
# Numerics; choices unless stated otherwise.
# (source: a link that turns round takes half of the time for a quarter of the path)
_SHARES = (1.0, 0.25, 0.0625)   # of the reach of forms, which those of some paths have
_PATHS = (1e-7, 1.0)    # between which paths are looked for [rad],
_HALVINGS = 12          # by steps of a bisection


def built_up(fitter: Fitter, fit: Fit, term: Term, does: Array) -> Iterator[Array]:
    """Yield what a friction that `does` (m, c) so much at once does less while it builds up."""
    lacks = _lacking(fitter, fit, term, does)
    valid = fitter.valid(fit.balance)
    whole = HYPOTHESES[term.name].reach * float((does ** 2).sum(where=valid))
    for share in _SHARES:
        low, high = _PATHS
        for _ in range(_HALVINGS):
            path = float(np.sqrt(low * high))
            changed = lacks(path)
            is_short = float((changed ** 2).sum(where=valid)) < share * whole
            low, high = (path, high) if is_short else (low, path)
        yield changed


def _lacking(fitter: Fitter, fit: Fit, term: Term, does: Array) -> Callable[[float], Array]:
    """Return what tells how much less (m, c) is done, while it builds up, by the path [rad]."""
    balancer, valid = fitter.balancer, fitter.valid(fit.balance)
    own, place = fitter.own_channels(term.joint), fitter.arm.labels.index(str(term.joint))
    state = balancer.motion(fitter.on(fit.terms)).state[:, place]
    angle, sense = state[:, LINK_ANGLE].copy(), np.sign(state[:, LINK_VELOCITY])

    def seen(values: Array) -> Array:
        made, slow = np.zeros_like(does), balancer.filtered(values[:, None])
        for channel in own:
            made[:, channel] = balancer.in_balance(slow, channel)[:, 0]
        return np.where(valid, made, 0.0)

    at_once = seen(sense)
    level = (at_once * np.where(valid, does, 0.0)).sum(axis=0) / np.maximum(
        (at_once ** 2).sum(axis=0), 1e-300)
    return lambda path: level * seen(_bent(angle, path) - sense)


@compiled
def _bent(angle: Array, path: float) -> Array:
    """Return how far friction has built up (k,), as a share of its level, at angles (k,)."""
    bent, now = np.zeros(angle.shape[0]), 0.0
    for k in range(1, angle.shape[0]):
        way = (angle[k] - angle[k - 1]) / path
        now = np.sign(way) + (now - np.sign(way)) * np.exp(-np.abs(way))
        bent[k] = now
    return bent
