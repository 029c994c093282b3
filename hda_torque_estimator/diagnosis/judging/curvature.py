"""
Whether a wave over the link's angle was seen to bend: a straight part of it is no wave.

Over one radian a disc off its centre can stand in for any error that grows with the angle. Under
one load it can stand in for any law of the torsion, as the torque follows the angle as well. What
shows a disc is what it reads beside the best straight line and the best law of the torque. That
must show in the balances. Where an error of scale explains as much but for such a bend, the disc
is told together with that: either is what there is.
"""

from hda_arm_sim.model.effects import Effect
from hda_arm_sim.model.kernel import LINK_ANGLE
import numpy as np
from numpy.typing import NDArray

from .search import SearchResult
from .verdict import lead_of
from ..balances.coordinates import coordinates_of
from ..fitting.fit import Fit, Fitter
from ..fitting.hypotheses import HYPOTHESES
from ..fitting.nuisance import Zero
from ...least_squares.term import Term
from ...significance import CERTAIN

Array = NDArray[np.float64]
# Numerics; choices unless stated otherwise.
_LAWS = (1, 2, 3, 5)    # powers of the torque that laws of a torsion may have (choice)


def straight(fitter: Fitter, found: SearchResult) -> tuple[Term, ...]:
    """Return the discs of link encoders that were not seen to bend, nor look like a scale."""
    fit, reasons = found.last, found.reasons()
    return tuple(term for term in fit.accepted if HYPOTHESES[term.name].bends
                 and _bend(fitter, fit, term, term.effect) < CERTAIN
                 and lead_of(reasons[term.place], term) >= 1.0)


def _bend(fitter: Fitter, fit: Fit, term: Term, disc: Effect) -> float:
    """Return the score of what a disc reads beside the link's angle and laws of the torque."""
    place, torsion = fitter.own_channels(term.joint)[:2]
    shows = place if fitter.is_unloaded(term.joint) else torsion
    valid = fitter.valid(fit.balance)
    motion = fitter.balancer.motion(fitter.on(fit.terms))
    angle = motion.state[::fitter.balancer.every, place, LINK_ANGLE]
    others = fitter.on(fitter.terms_without(fit, term))
    torque = coordinates_of(fitter.balancer, others)['joint_torque'][:, place]
    error, seen = disc(angle=angle), valid[:, shows]
    known = np.stack([np.ones_like(angle), angle, *(torque ** power for power in _LAWS)], axis=1)
    known /= np.maximum(np.abs(known[seen]).max(axis=0, initial=0.0), 1e-300)
    apart = error - known @ np.linalg.lstsq(known[seen], error[seen], rcond=None)[0]
    zero, = (other for other in fit.nuisance
             if isinstance(other, Zero) and other.joint == term.joint)
    shown = fit.columns[:, :, fit.own(zero)][:, :, 0] * apart[:, None]
    return float(fitter.effective * np.where(valid, shown ** 2 / fit.variance, 0.0).sum())
