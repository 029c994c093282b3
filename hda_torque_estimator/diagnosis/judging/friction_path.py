"""
Friction that builds up over a path after a link turns round: other forms of a dry one.

A law of friction that is dry changes its sign at once. A seal or a preloaded bearing bends first,
over a path that nobody states. So the forms of dry friction are those of some paths (eq:built-up).
The longest is what goes as far from the dry law as published laws do, so no path is chosen.
A friction beside the torsion states its path, and other forms of it bend over half and twice that.
Many simulations let dry friction set in over a speed, which the same rule gives (eq:onset).
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

from hda_arm_sim.foundation.arrays import Array
from hda_arm_sim.foundation.compiled import compiled
from hda_arm_sim.model.effects.effect import Effect
from hda_arm_sim.model.kernel import LINK_ANGLE, LINK_VELOCITY, MOTOR_ANGLE
import numpy as np

from ..fitting.fit import Fit, Fitter
from ..fitting.hypotheses import HYPOTHESES
from ...least_squares.bounds import bounded
from ...least_squares.term import Term

LINK_PATH = 'link_path'         # declares that laws differ in how they build up along a link
TORSION_PATH = 'torsion_path'   # and along the torsion of a gear
ONSET = 'onset'         # and in the speed of a shaft over which they set in
# Numerics; choices unless stated otherwise.
# (source: a link that turns round takes half of the time for a quarter of the path)
_SHARES = (1.0, 0.25, 0.0625)   # of the reach of forms, which those of some paths have
# (measured: beside loops of other paths, published ones leave 0.02 of themselves at most)
_WIDTHS = (0.5, 2.0)    # of the path of a law, over which another one builds up,
_SLIDING = (0.25, 4.0)  # and over which others begin to slide
_PATHS = (1e-7, 1.0)    # between which paths are looked for [rad],
_SPEEDS = (1e-3, 1e3)   # and speeds of a shaft [rad/s],
_HALVINGS = 12          # by steps of a bisection


def built_up(fitter: Fitter, fit: Fit, term: Term, does: Array) -> Iterator[Array]:
    """Yield what a friction that `does` (m, c) so much at once does less while it builds up."""
    yield from _as_far(fitter, fit, term, does, _lacking(fitter, fit, term, does), _PATHS)


def set_in(fitter: Fitter, fit: Fit, term: Term, does: Array, speed: Array) -> Iterator[Array]:
    """Yield what a friction that `does` (m, c) so much lacks that sets in over a `speed` (m,)."""
    speed = np.abs(speed)[:, None]
    yield from _as_far(fitter, fit, term, does,
                       lambda slow: (np.tanh(speed / slow) - 1.0) * does, _SPEEDS)


def _as_far(fitter: Fitter, fit: Fit, term: Term, does: Array,
            lacks: Callable[[float], Array], between: tuple[float, float]) -> Iterator[Array]:
    """Yield what is lacking where it goes as far from what is done as published laws do."""
    valid = fitter.valid(fit.balance)
    whole = HYPOTHESES[term.name].reach * float((does ** 2).sum(where=valid))
    for share in _SHARES:
        low, high = between
        for _ in range(_HALVINGS):
            over = float(np.sqrt(low * high))
            changed = lacks(over)
            is_short = float((changed ** 2).sum(where=valid)) < share * whole
            low, high = (over, high) if is_short else (low, over)
        yield changed


def bent_over(fitter: Fitter, fit: Fit, term: Term, does: Array) -> Iterator[Array]:
    """Yield what a friction of the torsion does (m, c) that builds up over other paths."""
    arm, place = fitter.on(fit.terms), fitter.arm.labels.index(str(term.joint))
    state = fitter.balancer.motion(arm).state[:, place]
    torsion = state[:, MOTOR_ANGLE] / arm.joints[place].ratio - state[:, LINK_ANGLE]
    path = getattr(term.effect, HYPOTHESES[term.name].path)
    slow = fitter.balancer.filtered(torsion[:, None])[:, 0]     # else noise is most of the path
    for share in _WIDTHS:
        bent = _seen(fitter, fit, term, _bent(slow, share * path))
        yield _level(bent, does) * bent


def other_paths(term: Term) -> Iterator[Effect]:
    """Yield a law of friction that begins to slide over other paths: a sum of them is any loop."""
    path = HYPOTHESES[term.name].path
    for share in _SLIDING:
        numbers: dict[str, Any] = bounded(
            type(term.effect), {path: share * getattr(term.effect, path)})
        yield replace(term.effect, **numbers)


def _lacking(fitter: Fitter, fit: Fit, term: Term, does: Array) -> Callable[[float], Array]:
    """Return what tells how much less (m, c) is done, while it builds up, by the path [rad]."""
    place = fitter.arm.labels.index(str(term.joint))
    state = fitter.balancer.motion(fitter.on(fit.terms)).state[:, place]
    angle, sense = state[:, LINK_ANGLE].copy(), np.sign(state[:, LINK_VELOCITY])

    def seen(values: Array) -> Array:
        return _seen(fitter, fit, term, fitter.balancer.filtered(values[:, None])[:, 0])

    level = _level(seen(sense), does)
    return lambda path: level * seen(_bent(angle, path) - sense)


def _seen(fitter: Fitter, fit: Fit, term: Term, values: Array) -> Array:
    """Return what slow values at the balances' times (m,) do in those of a joint (m, c)."""
    made = np.zeros_like(fit.balance.residual)
    for channel in fitter.own_channels(term.joint):
        made[:, channel] = fitter.balancer.in_balance(values[:, None], channel)[:, 0]
    return np.where(fitter.valid(fit.balance), made, 0.0)


def _level(shape: Array, does: Array) -> Array:
    """Return how much (c,) of a shape (m, c) is in what a cause does."""
    return np.asarray((shape * np.where(shape == 0.0, 0.0, does)).sum(axis=0)
                      / np.maximum((shape ** 2).sum(axis=0), 1e-300))


@compiled
def _bent(angle: Array, path: float) -> Array:
    """Return how far friction has built up (k,), as a share of its level, at angles (k,)."""
    bent, now = np.zeros(angle.shape[0]), 0.0
    for k in range(1, angle.shape[0]):
        way = (angle[k] - angle[k - 1]) / path
        now = np.sign(way) + (now - np.sign(way)) * np.exp(-np.abs(way))
        bent[k] = now
    return bent
